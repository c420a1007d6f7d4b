//! A folder with a scene, runs of the program in it, and the files they leave.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

/// A temporary folder with a scene in `scene/`.
pub(crate) struct Stage {
    pub(crate) folder: tempfile::TempDir,
}

/// Exit code and standard error stream of a run.
pub(crate) struct Finished {
    pub(crate) code: Option<i32>,
    pub(crate) stderr: String,
}

impl Stage {
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    pub(crate) fn new(name: &str, content: impl AsRef<[u8]>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("scene")).unwrap();
        std::fs::write(folder.path().join("scene").join(name), content).unwrap();
        Self { folder }
    }

    pub(crate) fn with(document: &Value) -> Self {
        Self::new("bad.gltf", document.to_string())
    }

    /// Sorted paths of all files and folders below the stage.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    pub(crate) fn everything(&self) -> Vec<PathBuf> {
        let mut found = vec![self.folder.path().to_owned()];
        let mut next = 0;
        while let Some(path) = found.get(next) {
            if path.is_dir() && !path.is_symlink() {
                let entries: Vec<_> =
                    std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect();
                found.extend(entries);
            }
            next += 1;
        }
        found.sort();
        found
    }

    /// Renders `scene/NAME` with `-q` in the folder of the stage, at 8x6 pixels unless `options` have `-r`.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    pub(crate) fn render(&self, name: &str, options: &[&str]) -> Finished {
        let size = if options.contains(&"-r") { &[][..] } else { &["-r", "8x6"] };
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .current_dir(self.folder.path())
            .args(["render", &format!("scene/{name}"), "--samples", "1", "-q"])
            .args(size)
            .args(options)
            .output()
            .unwrap();
        assert!(output.stdout.is_empty());
        Finished { code: output.status.code(), stderr: String::from_utf8_lossy(&output.stderr).into_owned() }
    }

    /// Asserts that the run fails with `code`, in one line that contains all `words`, and changes no file.
    pub(crate) fn assert_fails_with(&self, name: &str, options: &[&str], (code, words): (i32, &[&str])) {
        let before = self.everything();
        let run = self.render(name, options);
        let said = &run.stderr;
        assert_eq!(run.code, Some(code), "{options:?}: {said}");
        let (errors, others): (Vec<&str>, Vec<&str>) =
            said.lines().partition(|line| line.starts_with("rayframe: error: "));
        assert_eq!(errors.len(), 1, "{options:?}: {said}");
        assert!(others.iter().all(|line| line.starts_with("rayframe: warning: ")), "{options:?}: {said}");
        for word in words {
            assert!(errors[0].contains(word), "\"{word}\" is not in: {said}");
        }
        assert_eq!(self.everything(), before, "{options:?}: {said}");
    }

    pub(crate) fn assert_fails(&self, name: &str, expected: (i32, &[&str])) {
        self.assert_fails_with(name, &["-o", "out/a.exr"], expected);
    }
}
