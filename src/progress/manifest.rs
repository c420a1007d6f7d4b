//! Manifest file with the result of each frame, for render farms and scripts: `--manifest`.
//!
//! It exists before the first frame, is replaced atomically as frames end, and holds nothing that differs between two equal
//! runs. `schema/manifest.schema.json` describes it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

use rayframe::error::Result;
use rayframe::image_file::write_atomically;
use rayframe::output::SOFTWARE;
use rayframe::sequence::{FrameReport, Plan, PlannedFrame, SequenceEvent, SequenceJob, sha256_of_file};
use rayframe::shot::{RenderJob, SequenceNames};

use super::option_names::option_names;
use super::percent_path::percent_path;
use super::pretty_json::pretty_json;

const SCHEMA: u32 = 1;
/// Shortest time between two updates, so that long manifests do not delay short frames.
const INTERVAL: Duration = Duration::from_secs(1);

/// Manifest of one run.
#[derive(Debug)]
pub(crate) struct Manifest<'a> {
    path: &'a Path,
    job: &'a SequenceJob,
    names: &'a SequenceNames,
    plan: &'a Plan,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Results of ended frames.
    ended: BTreeMap<i64, EndedFrame>,
    /// Files of all frames together.
    outputs: Vec<FileEntry>,
    updated: Option<Instant>,
}

/// The file, its keys in the order of the alphabet.
#[derive(Serialize)]
struct ManifestFile<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    camera: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clip: Option<&'a str>,
    complete: bool,
    crop: [u32; 4],
    fps: String,
    frames: Vec<FrameEntry<'a>>,
    #[serde(skip_serializing_if = "<[FileEntry]>::is_empty")]
    outputs: &'a [FileEntry],
    resolution: [u32; 2],
    scene: Cow<'a, str>,
    schema: u32,
    software: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    variant: Option<&'a str>,
}

/// Entry of a frame.
#[derive(Serialize)]
struct FrameEntry<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a FrameError>,
    files: &'a [FileEntry],
    frame: i64,
    render_hash: &'a str,
    status: &'static str,
    time_seconds: f64,
}

/// Result of a frame.
#[derive(Debug)]
struct EndedFrame {
    status: &'static str,
    files: Vec<FileEntry>,
    error: Option<FrameError>,
}

#[derive(Debug, Serialize)]
struct FrameError {
    code: u8,
    message: String,
}

/// Entry of a file, with its hash and length unless it could not be read.
#[derive(Debug, Serialize)]
struct FileEntry {
    bytes: Option<u64>,
    path: String,
    /// Where the path is not Unicode.
    #[serde(skip_serializing_if = "Option::is_none")]
    path_percent: Option<String>,
    sha256: Option<String>,
}

impl<'a> Manifest<'a> {
    /// Manifest of a run of `plan`, to be written to `path`.
    pub(crate) fn new(path: &'a Path, job: &'a RenderJob, plan: &'a Plan) -> Self {
        Self { path, job: &job.sequence, names: &job.outline.names, plan, state: Mutex::default() }
    }

    /// Records an event and updates the file, unless it was updated a moment ago. Errors are reported at the end of the run by
    /// [`Self::write`].
    pub(crate) fn tell(&self, event: SequenceEvent<'_>) {
        let ended = match event {
            SequenceEvent::Started { .. } => None,
            SequenceEvent::FrameKept(frame) => Some((frame.frame, kept(frame))),
            SequenceEvent::FrameWritten(report) => Some((report.frame, self.written(report))),
            SequenceEvent::FrameFailed(frame, error) => {
                let message = option_names(&error.to_string());
                let error = FrameError { code: error.exit_code(), message };
                let ended = EndedFrame { status: "failed", files: Vec::new(), error: Some(error) };
                Some((frame.frame, ended))
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

    /// Writes the file at the end of the run. `outputs` are the movie and the contact sheet, where they were made.
    ///
    /// # Errors
    /// Those of [`write_atomically`].
    pub(crate) fn write(&self, outputs: &[PathBuf]) -> Result<()> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.outputs = outputs.iter().map(|path| FileEntry::of_disk(path)).collect();
        self.write_state(&state)
    }

    fn write_state(&self, state: &State) -> Result<()> {
        let frames: Vec<_> = self.plan.frames.iter().map(|frame| entry(frame, state)).collect();
        let (job, window) = (self.job, self.job.render.window);
        let SequenceNames { clip, camera, variant } = self.names;
        let manifest = ManifestFile {
            camera: camera.as_deref(),
            clip: clip.as_deref(),
            complete: frames.iter().all(|frame| matches!(frame.status, "written" | "kept")),
            crop: [window.x0, window.y0, window.x1, window.y1],
            fps: job.rate.to_string(),
            frames,
            outputs: &state.outputs,
            resolution: [job.render.resolution.0, job.render.resolution.1],
            scene: job.scene.path.to_string_lossy(),
            schema: SCHEMA,
            software: SOFTWARE,
            variant: variant.as_deref(),
        };
        write_atomically(self.path, &pretty_json(&manifest)?)
    }

    fn written(&self, report: &FrameReport) -> EndedFrame {
        let entry = |path, sha256: &str, bytes| FileEntry::new(path, Some((sha256.to_owned(), bytes)));
        let mut files = vec![entry(&report.path, &report.sha256, report.bytes as u64)];
        files.extend(report.aov_files.iter().map(|aov| entry(&aov.path, &aov.sha256, aov.bytes as u64)));
        let planned = self.plan.frames.iter().find(|planned| planned.frame == report.frame);
        files.extend(planned.and_then(|planned| planned.preview_path.as_deref()).map(FileEntry::of_disk));
        EndedFrame { status: "written", files, error: None }
    }
}

/// A kept frame, with its files on disk.
fn kept(frame: &PlannedFrame) -> EndedFrame {
    EndedFrame { status: "kept", files: frame.paths().map(FileEntry::of_disk).collect(), error: None }
}

/// Entry of a planned frame.
fn entry<'a>(frame: &'a PlannedFrame, state: &'a State) -> FrameEntry<'a> {
    let ended = state.ended.get(&frame.frame);
    FrameEntry {
        error: ended.and_then(|ended| ended.error.as_ref()),
        files: ended.map_or(&[], |ended| &ended.files),
        frame: frame.frame,
        render_hash: &frame.render_hash,
        status: ended.map_or("not_rendered", |ended| ended.status),
        time_seconds: frame.time_seconds,
    }
}

impl FileEntry {
    fn new(path: &Path, facts: Option<(String, u64)>) -> Self {
        let (sha256, bytes) = facts.unzip();
        Self { bytes, path: path.to_string_lossy().into_owned(), path_percent: percent_path(path), sha256 }
    }

    /// A file as it is.
    fn of_disk(path: &Path) -> Self {
        let length = || std::fs::metadata(path).ok().map(|metadata| metadata.len());
        Self::new(path, sha256_of_file(path).ok().zip(length()))
    }
}
