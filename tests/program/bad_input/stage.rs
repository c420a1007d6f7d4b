//! Runs of the program in a folder of their own, and what they may leave there.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

/// A folder with a scene in it, and the program run there.
pub(crate) struct Stage {
    pub(crate) folder: tempfile::TempDir,
}

/// How a run ended and what it said on the standard error stream.
pub(crate) struct Ending {
    pub(crate) code: Option<i32>,
    pub(crate) said: String,
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

    /// Every file and folder below the stage.
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

    /// Renders `scene/NAME` quietly, 8x6 pixels unless `options` ask for others; the stage is the current folder.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    pub(crate) fn render(&self, name: &str, options: &[&str]) -> Ending {
        let size = if options.contains(&"-r") { &[][..] } else { &["-r", "8x6"] };
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .current_dir(self.folder.path())
            .args(["render", &format!("scene/{name}"), "--samples", "1", "-q"])
            .args(size)
            .args(options)
            .output()
            .unwrap();
        assert!(output.stdout.is_empty());
        Ending { code: output.status.code(), said: String::from_utf8_lossy(&output.stderr).into_owned() }
    }

    /// The run fails with `code` in one line that holds `words`, and changes nothing on disk.
    pub(crate) fn assert_fails_with(&self, name: &str, options: &[&str], (code, words): (i32, &[&str])) {
        let before = self.everything();
        let ending = self.render(name, options);
        let Ending { said, .. } = &ending;
        assert_eq!(ending.code, Some(code), "{options:?}: {said}");
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
