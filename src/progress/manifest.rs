//! Manifest file with the result of each frame, for render farms and scripts: `--manifest`.
//!
//! It exists before the first frame, is replaced atomically as frames end, and holds nothing that differs between two equal
//! runs. `schema/manifest.schema.json` describes it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

use rayframe::error::Result;
use rayframe::image_file::write_atomically;
use rayframe::output::SOFTWARE;
use rayframe::sequence::{FrameReport, Plan, PlannedFrame, SequenceEvent, SequenceJob, hex};
use rayframe::shot::RenderJob;

use super::percent_path::add_percent_path;

const SCHEMA: u32 = 1;
/// Shortest time between two updates, so that long manifests do not delay short frames.
const INTERVAL: Duration = Duration::from_secs(1);

/// Manifest of one run.
#[derive(Debug)]
pub(crate) struct Manifest<'a> {
    path: &'a Path,
    job: &'a SequenceJob,
    clip: Option<&'a str>,
    camera: Option<&'a str>,
    plan: &'a Plan,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Results of ended frames, merged over their planned entries.
    ended: BTreeMap<i64, Value>,
    updated: Option<Instant>,
}

impl<'a> Manifest<'a> {
    /// Manifest of a run of `plan`, to be written to `path`.
    pub(crate) fn new(path: &'a Path, job: &'a RenderJob, plan: &'a Plan) -> Self {
        let (clip, camera) = (job.outline.clip.as_deref(), job.outline.camera.as_deref());
        Self { path, job: &job.sequence, clip, camera, plan, state: Mutex::default() }
    }

    /// Records an event and updates the file, unless it was updated a moment ago. Errors are reported at the end of the run by
    /// [`Self::write`].
    pub(crate) fn tell(&self, event: SequenceEvent<'_>) {
        let ended = match event {
            SequenceEvent::Started { .. } => None,
            SequenceEvent::FrameKept(frame) => Some((frame.frame, kept(frame))),
            SequenceEvent::FrameWritten(report) => Some((report.frame, self.written(report))),
            SequenceEvent::FrameFailed(frame, error) => {
                let error = json!({"code": error.exit_code(), "message": error.to_string()});
                Some((frame.frame, json!({"status": "failed", "error": error})))
            }
            _ => return,
        };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.ended.extend(ended);
        if state.updated.is_none_or(|updated| updated.elapsed() >= INTERVAL) {
            let _ = self.write_state(&state);
            state.updated = Some(Instant::now());
        }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Those of [`write_atomically`].
    pub(crate) fn write(&self) -> Result<()> {
        self.write_state(&self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn write_state(&self, state: &State) -> Result<()> {
        let frames: Vec<_> = self.plan.frames.iter().map(|frame| frame_json(frame, state)).collect();
        let exists = |frame: &Value| frame["status"] == "written" || frame["status"] == "kept";
        let (job, window) = (self.job, self.job.render.window);
        let mut manifest = json!({
            "schema": SCHEMA,
            "software": SOFTWARE,
            "scene": job.scene.path.to_string_lossy(),
            "resolution": [job.render.resolution.0, job.render.resolution.1],
            "crop": [window.x0, window.y0, window.x1, window.y1],
            "fps": job.rate.to_string(),
            "complete": frames.iter().all(exists),
            "frames": frames,
        });
        for (key, name) in [("clip", self.clip), ("camera", self.camera)] {
            if let Some(name) = name {
                manifest[key] = json!(name);
            }
        }
        write_atomically(self.path, format!("{manifest:#}\n").as_bytes())
    }

    fn written(&self, report: &FrameReport) -> Value {
        let mut files = vec![file_json(&report.path, Some((&report.sha256, report.bytes)))];
        let aovs = report.aov_files.iter();
        files.extend(aovs.map(|aov| file_json(&aov.path, Some((&aov.sha256, aov.bytes)))));
        let planned = self.plan.frames.iter().find(|planned| planned.frame == report.frame);
        files.extend(planned.and_then(|planned| planned.preview_path.as_ref()).map(file_on_disk));
        json!({"status": "written", "files": files})
    }
}

/// Entry of a kept frame, with its files on disk.
fn kept(frame: &PlannedFrame) -> Value {
    let paths = std::iter::once(&frame.path).chain(&frame.aov_paths).chain(&frame.preview_path);
    json!({"status": "kept", "files": paths.map(file_on_disk).collect::<Vec<_>>()})
}

fn frame_json(frame: &PlannedFrame, state: &State) -> Value {
    let mut entry = json!({
        "frame": frame.frame,
        "time_seconds": frame.time_seconds,
        "render_hash": frame.render_hash,
        "status": "not_rendered",
        "files": [],
    });
    for (key, value) in state.ended.get(&frame.frame).and_then(Value::as_object).into_iter().flatten() {
        entry[key] = value.clone();
    }
    entry
}

fn file_on_disk(path: &PathBuf) -> Value {
    let content = std::fs::read(path).ok();
    let facts = content.map(|content| (hex(&Sha256::digest(&content)), content.len()));
    file_json(path, facts.as_ref().map(|(sha256, bytes)| (sha256.as_str(), *bytes)))
}

/// Entry of a file, with its hash and length unless it could not be read.
fn file_json(path: &Path, facts: Option<(&str, usize)>) -> Value {
    let mut file = json!({
        "path": path.to_string_lossy(),
        "sha256": facts.map(|(sha256, _)| sha256),
        "bytes": facts.map(|(_, bytes)| bytes),
    });
    add_percent_path(&mut file, "path_percent", path);
    file
}
