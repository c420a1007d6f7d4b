//! The sequence that progress output is about, and its position in a run of several.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::percent_path::add_percent_path;

/// A sequence, for progress output.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReportedSequence {
    /// Names of the frames, with `####` for the frame number.
    pub(crate) output: String,
    /// The scene file.
    pub(crate) scene: PathBuf,
    /// The clip, where each has a sequence.
    pub(crate) clip: Option<String>,
    /// The camera, where each has a sequence.
    pub(crate) camera: Option<String>,
    /// Its position, where it is one of several.
    pub(crate) part: Option<Part>,
}

/// Position of a sequence in a run of several, in frames.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Part {
    /// Frames of the sequences before it.
    pub(crate) before: usize,
    /// Frames of all sequences.
    pub(crate) total: usize,
}

impl ReportedSequence {
    /// `frame 7`, after the scene, the clip and the camera where the sequence is one of several.
    pub(super) fn frame_text(&self, frame: i64) -> String {
        if self.part.is_none() {
            return format!("frame {frame}");
        }
        let clip = self.clip.as_ref().map(|clip| format!(" clip \"{clip}\""));
        let camera = self.camera.as_ref().map(|camera| format!(" camera \"{camera}\""));
        let [clip, camera] = [clip, camera].map(Option::unwrap_or_default);
        format!("{}:{clip}{camera} frame {frame}", self.scene.display())
    }

    /// Frames that are done before the sequence begins, and all frames, where it has `to_render` and `kept` ones.
    pub(super) fn done_and_total(&self, to_render: usize, kept: usize) -> (usize, usize) {
        self.part.map_or((0, to_render), |part| (part.before + kept, part.total))
    }

    /// Adds scene, clip and camera to a JSON line.
    pub(super) fn add_to(&self, line: &mut Value) {
        line["scene"] = json!(self.scene.to_string_lossy());
        if let Some(clip) = &self.clip {
            line["clip"] = json!(clip);
        }
        if let Some(camera) = &self.camera {
            line["camera"] = json!(camera);
        }
        add_percent_path(line, "scene_percent", &self.scene);
    }
}
