//! `rayframe test`, `accept`, `reject` and `review`.

mod approvals;
mod archives;
mod causes;
mod content;
mod coverage;
mod failures;
mod forms;
mod kept_files;
mod kept_inputs;
mod killed;
mod rendered;
mod shards;
mod summaries;
mod unchanged;
mod verdicts;
mod views;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A suite of small images in a temporary folder.
struct Stage(tempfile::TempDir);

/// Exit code and output of a command; `text` holds both streams.
#[derive(Debug)]
struct Ran {
    code: Option<i32>,
    text: String,
    stdout: String,
}

const SUITE: &str = "[test]\npreset = 'visual'\n[shot]\nresolution = [48, 27]\nsamples = 1\nframes = 0\n";

impl Stage {
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn new(suite: &str) -> Self {
        let stage = Self(tempfile::tempdir().unwrap());
        stage.write("suite.toml", suite);
        stage
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    /// Copies a scene of the repository with all `from` in its text replaced by `to`.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn scene(&self, name: &str, scene: &str, from: &str, to: &str) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let text = std::fs::read_to_string(path).unwrap();
        assert!(from.is_empty() || text.contains(from), "{scene} has no {from}");
        let text = if from.is_empty() { text } else { text.replace(from, to) };
        self.write(name, &text);
    }

    /// Runs the program in the folder of the suite without `CI` set.
    fn run(&self, arguments: &[&str]) -> Ran {
        self.run_with(arguments, "", None)
    }

    /// Runs the program with `answers` on the standard input and `CI` set to a value.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn run_with(&self, arguments: &[&str], answers: &str, ci: Option<&str>) -> Ran {
        use std::io::Write as _;
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        command.args(arguments).current_dir(self.0.path()).env_remove("CI");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        if let Some(value) = ci {
            command.env("CI", value);
        }
        let mut child = command.spawn().unwrap();
        // A program that asks nothing does not read its input; the write then fails.
        let _ = child.stdin.take().unwrap().write_all(answers.as_bytes());
        let Output { status, stdout, stderr } = child.wait_with_output().unwrap();
        let [stdout, stderr] = [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        Ran { code: status.code(), text: format!("{stdout}{stderr}"), stdout }
    }

    /// A suite whose images are accepted.
    fn accepted(suite: &str, scenes: &[(&str, &str)]) -> Self {
        let stage = Self::new(suite);
        for (name, scene) in scenes {
            stage.scene(name, scene, "", "");
        }
        stage.run(&["test"]).ends(1, &["no reference"]);
        stage.run(&["accept"]).ends(0, &["added"]);
        stage.run(&["test"]).ends(0, &["identical, 0 changed within limits, 0 failed"]);
        stage
    }

    /// Sorted names of all files of the references.
    fn references(&self) -> Vec<String> {
        let mut names = Vec::new();
        collect(&self.path("references"), "", &mut names);
        names.sort();
        names
    }
}

impl Ran {
    /// Asserts the exit code and that all words were printed.
    #[track_caller]
    fn ends(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.text);
        for word in words {
            assert!(self.text.contains(word), "no \"{word}\" in\n{}", self.text);
        }
    }
}

fn collect(folder: &Path, prefix: &str, names: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{name}/"), names);
        } else {
            names.push(name);
        }
    }
}
