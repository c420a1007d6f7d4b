//! GNU parallel: the list of tasks, and a script that runs them and repeats what may pass.
//!
//! The script runs in the folder of the job, so that no path stands on a command line that parallel reads.

use std::fmt::Write as _;

use super::job_files::JobFile;
use super::job_plan::JobPlan;
use super::shell::quoted;
use super::task_script::{MERGE, TASK_SCRIPT, TRANSIENT, numbered_files};

/// `task.sh`, `shot.toml`, `tasks` and `run.sh`.
pub(super) fn files(plan: &JobPlan) -> Vec<JobFile> {
    let mut files = numbered_files(plan).to_vec();
    let numbers: Vec<String> = (0..plan.tasks.len()).map(|index| index.to_string()).collect();
    files.push(JobFile { name: "tasks", content: numbers.join("\n") + "\n" });
    files.push(JobFile { name: "run.sh", content: run(plan) });
    files.push(JobFile { name: "tasks.txt", content: plan.task_list() });
    files
}

fn run(plan: &JobPlan) -> String {
    let JobPlan { version, folder, retries, resources, at_most, .. } = plan;
    let most = at_most.map_or_else(String::new, |most| format!("[ \"$jobs\" -le {most} ] || jobs={most}\n"));
    let mut text = format!(
        "#!/bin/sh\n# Written by {version}. Runs the job; options of parallel may follow, such as --sshloginfile\n\
         # JOBS is the number of tasks at a time. Run again, it repeats only what failed\nset -u\n\
         cd {} || exit 66\n\
         jobs=${{JOBS:-$(($(nproc) / {threads}))}}\n[ \"$jobs\" -ge 1 ] || jobs=1\n{most}",
        quoted(folder),
        threads = resources.threads,
    );
    // Columns 7 and 8 of the log are exit code and signal.
    let transient = format!("^({TRANSIENT})$");
    let _ = write!(
        text,
        "\n# Tasks that are in the log with 0, or with a failure that repeats itself, are not run again\n\
         keep() {{\n    [ -f joblog ] || return 0\n    \
         awk -F '\\t' 'NR == 1 || $7 !~ /{transient}/ && $8 == 0' joblog > joblog.kept && mv joblog.kept joblog\n}}\n\
         attempt=0\nwhile :; do\n    keep\n    \
         parallel --will-cite --joblog joblog --resume --jobs \"$jobs\" \"$@\" sh ./{TASK_SCRIPT} {{}} < tasks\n    \
         code=$?\n    [ \"$attempt\" -lt {retries} ] || break\n    attempt=$((attempt + 1))\n    \
         awk -F '\\t' 'NR > 1 && ($7 ~ /{transient}/ || $8 != 0) {{ found = 1 }} END {{ exit !found }}' joblog || break\ndone\n\
         [ \"$code\" -eq 0 ] || exit \"$code\"\n\
         # Parallel counts the failures of this run, and the log those of all\n\
         awk -F '\\t' 'NR > 1 && $7 != 0 {{ worst = $7 }} END {{ exit worst }}' joblog || exit $?\n",
    );
    if !plan.parts.is_empty() {
        let _ = writeln!(text, "exec sh ./{TASK_SCRIPT} {MERGE}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::test_plan::{plan, still};
    use super::*;

    #[test]
    fn the_list_has_each_task_and_the_script_the_policy() {
        let files = files(&plan());
        let content = |name: &str| &files.iter().find(|file| file.name == name).unwrap().content;
        assert_eq!(content("tasks"), "0\n1\n");
        assert_eq!(content("tasks.txt"), "0\t1-2\n1\t3\n");
        let run = content("run.sh");
        for part in [
            "cd '/jobs/two words' ||",
            "nproc) / 4",
            "jobs=7",
            "/^(74|75|130|137|143)$/",
            "--joblog joblog --resume",
        ] {
            assert!(run.contains(part), "{part}\n{run}");
        }
        assert!(!run.contains("task.sh merge"));
    }

    #[cfg(unix)]
    #[test]
    fn shells_parse_the_script() {
        let run = run(&still());
        let checked = std::process::Command::new("sh").args(["-n", "-c", &run]).output().unwrap();
        assert!(checked.status.success() && run.ends_with("exec sh ./task.sh merge\n"), "{run}");
    }
}
