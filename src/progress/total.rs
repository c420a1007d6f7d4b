//! Result of a run over several scenes, clips or cameras: one line for people, one object for programs.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use rayframe::count_text::counted;
use rayframe::settings::ProgressStyle;

use super::eta::duration_text;
use super::json::print_json;
use super::openjd::print_openjd_total;
use super::percent_path::add_percent_path;
use super::plain::and_count;
use super::print::print_note;
use super::reported::RESUMABLE;

const SCHEMA: u32 = 1;

/// Counts of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Total {
    /// Scenes that were named.
    pub(crate) scenes: usize,
    /// Scenes whose frames all exist.
    pub(crate) complete_scenes: usize,
    /// Scenes that could not be rendered at all, each with the exit code and the message.
    pub(crate) failed_scenes: Vec<(PathBuf, u8, String)>,
    /// Written frames.
    pub(crate) written: usize,
    /// Kept frames.
    pub(crate) kept: usize,
    /// Failed frames.
    pub(crate) failed: usize,
    /// Whether the run was cancelled.
    pub(crate) is_interrupted: bool,
    /// Wall-clock seconds.
    pub(crate) seconds: f64,
}

impl Total {
    /// Prints it in one of the styles.
    pub(crate) fn print(&self, style: ProgressStyle) {
        match style {
            ProgressStyle::Json => print_json(&self.json()),
            ProgressStyle::OpenJd => print_openjd_total(&self.text(), self.is_complete()),
            ProgressStyle::None => {}
            _ => print_note(&self.text()),
        }
    }

    fn is_complete(&self) -> bool {
        self.complete_scenes == self.scenes
    }

    /// `55 scenes: 60 frames written, 3 kept in 41.2 s`, `53 of 55 scenes complete: …`.
    fn text(&self) -> String {
        let scenes = if self.is_complete() {
            counted(self.scenes, "scene")
        } else {
            format!("{} of {} complete", self.complete_scenes, counted(self.scenes, "scene"))
        };
        let stopped = if self.is_interrupted { format!("; {RESUMABLE}") } else { String::new() };
        format!(
            "{scenes}: {} written{}{} in {}{stopped}",
            counted(self.written, "frame"),
            and_count(self.kept, "kept"),
            and_count(self.failed, "failed"),
            duration_text(self.seconds),
        )
    }

    fn json(&self) -> Value {
        let failed =
            self.failed_scenes.iter().map(|(scene, code, message)| failure_json(scene, *code, message));
        json!({
            "schema": SCHEMA,
            "event": "total",
            "scenes": self.scenes,
            "complete_scenes": self.complete_scenes,
            "failed_scenes": failed.collect::<Vec<_>>(),
            "written": self.written,
            "kept": self.kept,
            "failed": self.failed,
            "interrupted": self.is_interrupted,
            "seconds": self.seconds,
        })
    }
}

/// Prints that a scene cannot be rendered, for programs.
pub(crate) fn print_scene_failure(style: ProgressStyle, scene: &Path, code: u8, message: &str) {
    if style == ProgressStyle::Json {
        let mut line = failure_json(scene, code, message);
        line["schema"] = json!(SCHEMA);
        line["event"] = json!("scene_failed");
        print_json(&line);
    }
}

fn failure_json(scene: &Path, code: u8, message: &str) -> Value {
    let mut failure = json!({"scene": scene.to_string_lossy(), "code": code, "message": message});
    add_percent_path(&mut failure, "scene_percent", scene);
    failure
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_counts_scenes_and_frames() {
        let total = Total { scenes: 2, complete_scenes: 2, written: 1, seconds: 4.2, ..Total::default() };
        assert_eq!(total.text(), "2 scenes: 1 frame written in 4.2 s");
        let failed_scenes = vec![("b.glb".into(), 65, "empty".to_owned())];
        let total = Total { complete_scenes: 1, kept: 3, failed: 1, failed_scenes, ..total };
        assert_eq!(total.text(), "1 of 2 scenes complete: 1 frame written, 3 kept, 1 failed in 4.2 s");
    }

    #[cfg(unix)]
    #[test]
    fn scenes_that_fail_are_named_without_loss() {
        use std::os::unix::ffi::OsStrExt as _;
        let scene = PathBuf::from(std::ffi::OsStr::from_bytes(b"a\xff.glb"));
        let total = Total { failed_scenes: vec![(scene, 65, "empty".to_owned())], ..Total::default() };
        assert_eq!(total.json()["failed_scenes"][0]["scene_percent"], "a%FF%2Eglb");
        assert_eq!(failure_json(Path::new("a.glb"), 65, "empty").get("scene_percent"), None);
    }
}
