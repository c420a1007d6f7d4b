//! GNU parallel: the list of tasks, and a script that runs them and repeats what may pass.
//!
//! The script runs in the folder of the job, so that no path stands on a command line that parallel reads.

use std::fmt::Write as _;

use rayframe::regression::suite::shell_quoted;

use super::job_files::JobFile;
use super::job_plan::JobPlan;
use super::task_script::{MERGE, TASK_SCRIPT, TRANSIENT, numbered_files};

/// `task.sh`, `shot.toml`, `tasks`, `run.sh` and `tasks.txt`.
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
         # JOBS is the number of tasks at a time. Run again, it renders what is missing. Ends with the worst code of the tasks\nset -u\n\
         command -v parallel > /dev/null || {{ echo 'GNU parallel is not installed' >&2; exit 127; }}\n\
         cd {} || exit 66\n\
         jobs=${{JOBS:-$(($(nproc) / {threads}))}}\n[ \"$jobs\" -ge 1 ] || jobs=1\n{most}",
        shell_quoted(folder),
        threads = resources.threads,
    );
    // Columns 7 and 8 of the log are exit code and signal.
    let transient = format!("^({TRANSIENT})$");
    let _ = write!(
        text,
        "\n# Tasks keep frames that are there, so a new run begins with all of them. Repeats of it leave out what cannot pass\n\
         rm -f joblog\nattempt=0\nwhile :; do\n    \
         parallel --will-cite --joblog joblog --resume --jobs \"$jobs\" \"$@\" sh ./{TASK_SCRIPT} {{}} < tasks\n    \
         code=$?\n    [ -f joblog ] || exit \"$code\"\n    \
         [ \"$attempt\" -lt {retries} ] || break\n    attempt=$((attempt + 1))\n    \
         awk -F '\\t' 'NR > 1 && ($7 ~ /{transient}/ || $8 != 0) {{ found = 1 }} END {{ exit !found }}' joblog || break\n    \
         awk -F '\\t' 'NR == 1 || $7 !~ /{transient}/ && $8 == 0' joblog > joblog.kept && mv joblog.kept joblog\ndone\n\
         awk -F '\\t' 'NR > 1 {{ code = $8 != 0 ? 128 + $8 : $7; if (code > worst) worst = code }} END {{ exit worst }}' joblog || exit $?\n\
         # All tasks may end well and parallel not, as where it is stopped\n\
         [ \"$code\" -eq 0 ] || exit \"$code\"\n",
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
            "rm -f joblog",
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
