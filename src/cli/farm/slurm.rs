//! Slurm: an array job, a job that merges the parts of a still after it, and a script that submits both.
//!
//! Options with paths are given by the script, because `#SBATCH` lines have no quoting for every character.

use std::fmt::Write as _;

use rayframe::regression::suite::shell_quoted;

use super::job_files::JobFile;
use super::job_plan::JobPlan;
use super::task_script::{MERGE, TASK_SCRIPT, TRANSIENT, numbered_files, run_and_wait};

/// Seconds before the time limit when a task is told to end. It needs one.
const GRACE_SECONDS: u32 = 60;

/// `task.sh`, `shot.toml`, `array.sbatch`, `submit.sh`, `tasks.txt`, and for stills `merge.sbatch`.
pub(super) fn files(plan: &JobPlan) -> Vec<JobFile> {
    let mut files = numbered_files(plan).to_vec();
    files.push(JobFile { name: "array.sbatch", content: array(plan) });
    if !plan.parts.is_empty() {
        files.push(JobFile { name: "merge.sbatch", content: merge(plan) });
    }
    files.push(JobFile { name: "submit.sh", content: submit(plan) });
    files.push(JobFile { name: "tasks.txt", content: plan.task_list() });
    files
}

fn array(plan: &JobPlan) -> String {
    let limit = plan.at_most.map_or_else(String::new, |limit| format!("%{limit}"));
    let array = format!("#SBATCH --array=0-{}{limit}\n", plan.tasks.len().saturating_sub(1));
    batch_script(plan, &plan.plain_name(100), &array, "\"$SLURM_ARRAY_TASK_ID\"")
}

fn merge(plan: &JobPlan) -> String {
    batch_script(plan, &format!("{}-merge", plan.plain_name(94)), "", MERGE)
}

fn batch_script(plan: &JobPlan, name: &str, array: &str, task: &str) -> String {
    let JobPlan { version, folder, retries, resources, .. } = plan;
    let script = shell_quoted(&format!("{folder}/{TASK_SCRIPT}"));
    let run = run_and_wait(&format!(
        "srun --ntasks=1 --cpus-per-task=\"$RAYFRAME_THREADS\" --export=ALL sh {script} {task}"
    ));
    let failures = shell_quoted(&format!("{folder}/logs/"));
    format!(
        "#!/bin/sh\n# Written by {version}. Submitted by submit.sh\n\
         #SBATCH --job-name={name}\n{array}\
         #SBATCH --ntasks=1\n\
         #SBATCH --cpus-per-task={threads}\n\
         #SBATCH --mem={memory}M\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --signal=B:TERM@{GRACE_SECONDS}\n\n\
         export RAYFRAME_THREADS=\"${{SLURM_CPUS_PER_TASK:-{threads}}}\"\n\n\
         # Preemption signals the step, and the time limit this script\n{run}\n\
         # Failures that may pass are repeated, others are not. Preemption does not count\n\
         failures={failures}\"$SLURM_JOB_ID\".failures\n\
         case $code in\n{TRANSIENT})\n    \
             [ \"$code$ended\" = 143 ] || echo \"$code\" >> \"$failures\"\n    \
             count=$(cat \"$failures\" 2>/dev/null | wc -l)\n    \
             if [ \"$count\" -le {retries} ]; then\n        \
                 scontrol requeue \"$SLURM_JOB_ID\" && sleep {GRACE_SECONDS}\n    \
             fi\n    ;;\nesac\nexit \"$code\"\n",
        threads = resources.threads,
        memory = resources.memory_mib(),
    )
}

fn submit(plan: &JobPlan) -> String {
    let at = |name: &str| shell_quoted(&format!("{}/{name}", plan.folder));
    // In names of logs % begins a field.
    let log = |fields: &str| shell_quoted(&format!("{}/logs/{fields}.log", plan.folder.replace('%', "%%")));
    let mut text = format!(
        "#!/bin/sh\n# Written by {}. Submits the job; options of sbatch may follow\nset -eu\nmkdir -p {}\n\
         job=$(sbatch --parsable --output={} \"$@\" {})\n",
        plan.version,
        at("logs"),
        log("%A_%a"),
        at("array.sbatch"),
    );
    if !plan.parts.is_empty() {
        let _ = writeln!(
            text,
            "sbatch --parsable --output={} --dependency=\"afterok:${{job%%;*}}\" --kill-on-invalid-dep=yes \"$@\" {}",
            log("%j"),
            at("merge.sbatch"),
        );
    }
    text.push_str("echo \"$job\"\n");
    text
}

#[cfg(test)]
mod tests {
    use super::super::test_plan::{plan, still};
    use super::*;

    fn content(plan: &JobPlan, name: &str) -> String {
        files(plan).into_iter().find(|file| file.name == name).unwrap().content
    }

    #[test]
    fn the_array_has_the_tasks_and_their_needs() {
        let array = content(&plan(), "array.sbatch");
        for line in [
            "#SBATCH --job-name=it-s--new",
            "#SBATCH --array=0-1%7",
            "#SBATCH --cpus-per-task=4",
            "#SBATCH --mem=300M",
            "srun --ntasks=1 --cpus-per-task=\"$RAYFRAME_THREADS\" --export=ALL sh '/jobs/two words/task.sh' \"$SLURM_ARRAY_TASK_ID\" &",
            "74|75|130|137|143)",
            "    if [ \"$count\" -le 3 ]; then",
        ] {
            assert!(array.contains(&format!("{line}\n")), "{line}\n{array}");
        }
        assert!(!array.contains("merge") && files(&plan()).iter().all(|file| file.name != "merge.sbatch"));
    }

    #[test]
    fn tiles_are_merged_after_the_array() {
        let submit = content(&still(), "submit.sh");
        assert!(submit.contains("--dependency=\"afterok:${job%%;*}\""), "{submit}");
        assert!(content(&still(), "merge.sbatch").contains("sh '/jobs/two words/task.sh' merge &"));
    }

    #[cfg(unix)]
    #[test]
    fn shells_parse_the_scripts() {
        for file in
            files(&still()).iter().filter(|file| file.name.ends_with("sh") || file.name.ends_with("sbatch"))
        {
            let checked =
                std::process::Command::new("sh").args(["-n", "-c", &file.content]).output().unwrap();
            assert!(
                checked.status.success(),
                "{}\n{}",
                file.content,
                String::from_utf8_lossy(&checked.stderr)
            );
        }
    }
}
