//! The shell script that runs one task, the same for all engines. It ends as the render ends: it becomes its process.

use std::fmt::Write as _;

use rayframe::regression::suite::shell_quoted;

use super::asset_folders::AssetFolder;
use super::job_files::JobFile;
use super::job_plan::{JobPlan, Task};

/// Name of the script.
pub(super) const TASK_SCRIPT: &str = "task.sh";
/// Name of the shot file.
pub(super) const SHOT_FILE: &str = "shot.toml";
/// Name of the task that merges the parts of a still.
pub(super) const MERGE: &str = "merge";
/// Exit codes of failures that may pass, and of processes that were ended: 137 is what SIGKILL leaves.
pub(super) const TRANSIENT: &str = "74|75|130|137|143";

/// Which tasks a script knows, and how it reports.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScriptForm<'a> {
    /// First arguments that select a task.
    pub(super) keys: &'a [String],
    /// The tasks.
    pub(super) tasks: &'a [Task],
    /// Value of `--progress`.
    pub(super) progress: &'a str,
}

/// The script and the shot file of a job whose tasks are counted from 0.
pub(super) fn numbered_files(plan: &JobPlan) -> [JobFile; 2] {
    let keys: Vec<String> = (0..plan.tasks.len()).map(|index| index.to_string()).collect();
    let form = ScriptForm { keys: &keys, tasks: &plan.tasks, progress: "plain" };
    [
        JobFile { name: TASK_SCRIPT, content: script(plan, form) },
        JobFile { name: SHOT_FILE, content: plan.shot_file.clone() },
    ]
}

/// `task.sh TASK [SHOT_FILE]`.
pub(super) fn script(plan: &JobPlan, form: ScriptForm<'_>) -> String {
    let JobPlan { version, pin, output_name, .. } = plan;
    let mut text = format!(
        "#!/bin/sh\n# Written by {version}. One task of a job: task.sh TASK [SHOT_FILE]\nset -u\n{}",
        variables(plan)
    );
    text.push_str("\n# The version that the job was written for\n");
    text.push_str(
        "version=$(\"$rayframe\" --version) || fail 66 \"$rayframe cannot be started on this worker; set RAYFRAME to it, or write the job with --program\"\n",
    );
    let _ = writeln!(
        text,
        "[ \"$version\" = {} ] || fail 65 \"the job was written for {version}, and this worker has $version\"",
        shell_quoted(version)
    );

    text.push_str("\n# Options of the task\ncase ${1-} in\n");
    for (key, task) in form.keys.iter().zip(form.tasks) {
        let options: Vec<String> = task.options.iter().map(|option| shell_quoted(option)).collect();
        let output = shell_quoted(&task.output_name);
        let _ =
            writeln!(text, "{}) set -- {} -o \"$pattern\"/{output} ;;", shell_quoted(key), options.join(" "));
    }
    if !plan.parts.is_empty() {
        let _ = writeln!(text, "{MERGE}) {} ;;", merge_command(plan));
    }
    text.push_str("*) fail 2 \"the job has no task ${1-}\" ;;\nesac\n");

    let mut files: String = plan.asset_folders.iter().map(AssetFolder::shell_option).collect();
    if plan.oidn.is_some() {
        files.push_str(" --oidn \"$oidn\"");
    }
    text.push_str("\n# The scene and the settings that the job was written for\n");
    let _ = writeln!(
        text,
        "plan=$(\"$rayframe\" render \"$scene\" --config \"$shot\"{files} --frames={} -o \"$pattern\"/{} --resume --dry-run --quiet --progress json) || exit $?",
        pin.frame,
        shell_quoted(output_name)
    );
    let _ = writeln!(
        text,
        "case $plan in\n*'\"render_hash\":\"{}\"'*) ;;\n*) fail 65 \"the scene or a file that it names has changed since the job was written\" ;;\nesac",
        pin.render_hash
    );

    let cache = plan.asset_cache.as_ref();
    let cache = cache.map_or_else(String::new, |(_, bytes)| {
        format!(" --asset-cache \"$cache\" --asset-cache-size {bytes}")
    });
    let _ = writeln!(
        text,
        "\n# Finished frames are kept, so that a repeated task continues\nexec \"$rayframe\" render \"$scene\" --config \"$shot\"{files} \"$@\" --resume --threads \"$threads\" --max-memory {}{cache} --progress {}",
        plan.resources.limit_bytes, form.progress
    );
    text
}

/// Names and numbers that the environment may replace, as on machines where the storage is mounted elsewhere.
fn variables(plan: &JobPlan) -> String {
    let shot = format!("{}/{SHOT_FILE}", plan.folder);
    let mut more: String = plan.asset_folders.iter().map(AssetFolder::shell_lines).collect();
    if let Some(oidn) = &plan.oidn {
        let _ = writeln!(more, "oidn=${{RAYFRAME_OIDN:-{}}}", shell_quoted(oidn));
    }
    if let Some((folder, _)) = &plan.asset_cache {
        let _ = writeln!(more, "cache=${{RAYFRAME_ASSET_CACHE:-{}}}", shell_quoted(folder));
    }
    format!(
        "rayframe=${{RAYFRAME:-{}}}\nshot=${{2:-{}}}\nscene=${{RAYFRAME_SCENE:-{}}}\noutput=${{RAYFRAME_OUTPUT_FOLDER:-{}}}\n\
         threads=${{RAYFRAME_THREADS:-{}}}\n\
         # In patterns %, # and {{ have a meaning, and the folder is none\n\
         pattern=$(printf '%s.' \"$output\" | sed 's/[%#{{]/%&/g')\npattern=${{pattern%.}}\n\
         {more}\
         fail() {{\n    printf 'rayframe: error: %s\\n' \"$2\" >&2\n    exit \"$1\"\n}}\n",
        shell_quoted(&plan.program),
        shell_quoted(&shot),
        shell_quoted(&plan.scene),
        shell_quoted(&plan.output_folder),
        plan.resources.threads,
    )
}

/// Joins the parts, and removes none.
fn merge_command(plan: &JobPlan) -> String {
    let parts: Vec<String> =
        plan.parts.iter().map(|part| format!("\"$output\"/{}", shell_quoted(part))).collect();
    // Tasks of whole frames replace older ones, too.
    let overwrite = if plan.replaces_output { " --overwrite" } else { "" };
    format!(
        "exec \"$rayframe\" merge {} -o \"$pattern\"/{}{overwrite} --threads \"$threads\" --max-memory {}",
        parts.join(" "),
        shell_quoted(&plan.output_name),
        plan.resources.merge_limit_bytes()
    )
}

/// Lines that run `command` beside the shell and pass signals on to it. Its exit code is then in `code`.
pub(super) fn run_and_wait(command: &str) -> String {
    format!(
        "ended=\n{command} &\ntask=$!\ntrap 'ended=1; kill -TERM \"$task\" 2>/dev/null' TERM INT\nwait \"$task\"\ncode=$?\n\
         # A signal ends the wait, and not the task\n[ -z \"$ended\" ] || {{\n    wait \"$task\"\n    code=$?\n}}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::super::test_plan::{plan, still};
    use super::*;

    #[test]
    fn scripts_hold_each_task_once_and_pin_the_job() {
        let [script, shot] = numbered_files(&plan());
        assert_eq!(shot.content, plan().shot_file);
        for line in [
            "'0') set -- '--frames=1-2' -o \"$pattern\"/'a.####.exr' ;;",
            "'1') set -- '--frames=3' -o \"$pattern\"/'a.####.exr' ;;",
            "[ \"$version\" = 'rayframe 0.1.0' ]",
            "*'\"render_hash\":\"00ff\"'*) ;;",
            "scene=${RAYFRAME_SCENE:-'/shots/it'\\''s \"new\"\n.glb'}",
        ] {
            assert_eq!(script.content.matches(line).count(), 1, "{line}\n{}", script.content);
        }
        assert!(!script.content.contains("merge"));
    }

    #[test]
    fn stills_have_a_task_that_merges_their_parts() {
        let [script, _] = numbered_files(&still());
        let merge = "merge) exec \"$rayframe\" merge \"$output\"/'parts/s.0000.exr' \"$output\"/'parts/s.0001.exr' -o \"$pattern\"/'s.exr'";
        assert!(script.content.contains(merge), "{}", script.content);
    }

    #[cfg(unix)]
    #[test]
    fn shells_parse_the_scripts() {
        for plan in [plan(), still()] {
            let [script, _] = numbered_files(&plan);
            for text in [script.content, run_and_wait("sleep 0")] {
                let checked = std::process::Command::new("sh").args(["-n", "-c", &text]).output().unwrap();
                assert!(checked.status.success(), "{text}\n{}", String::from_utf8_lossy(&checked.stderr));
            }
        }
    }
}
