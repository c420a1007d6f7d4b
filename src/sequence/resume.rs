//! Inspection of files that exist before a run: kept, replaced, or in the way.

use std::path::Path;

use crate::image_file::{StoredFrame, inspect_exr, inspect_png, is_empty_file};

use super::{ExistingFiles, OutputFormat, SequenceJob};

/// What a link is that leads to no file.
const BROKEN_LINK: &str = "a link to no file";

/// Decision about one existing or missing file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Decision {
    /// The file is missing or replaced.
    Render,
    /// The file is the planned one.
    Keep,
    /// Another file has the name. The text says what it is, to be read after "is".
    InTheWay(String),
}

/// Decides about the file at `path`, which is to hold a frame with `render_hash`.
pub(super) fn decide(job: &SequenceJob, path: &Path, render_hash: &str) -> Decision {
    if job.existing == ExistingFiles::Overwrite || is_empty_file(path) {
        return Decision::Render;
    }
    if !path.is_file() {
        return if path.is_symlink() { Decision::InTheWay(BROKEN_LINK.to_owned()) } else { Decision::Render };
    }
    let inspected = match job.output.format() {
        OutputFormat::Exr => inspect_exr(path),
        OutputFormat::Png => inspect_png(path),
        // It is one file, which the plan checks.
        OutputFormat::Movie(_) => return Decision::Render,
    };
    let why = match inspected {
        Ok(stored) => match mismatch(job, &stored, render_hash) {
            None => return Decision::Keep,
            Some(why) => why.to_owned(),
        },
        Err(why) => incomplete(&why),
    };
    Decision::InTheWay(why)
}

/// What the file at `path` is, where it is not a preview of the frame with `render_hash`. A preview of the same frame with
/// another tone mapping or crop is replaced silently.
pub(super) fn preview_in_the_way(job: &SequenceJob, path: &Path, render_hash: &str) -> Option<String> {
    if job.existing == ExistingFiles::Overwrite || is_empty_file(path) {
        return None;
    }
    if !path.is_file() {
        return path.is_symlink().then(|| BROKEN_LINK.to_owned());
    }
    match inspect_png(path) {
        Err(why) => Some(incomplete(&why)),
        Ok(stored) => other_render(&stored, render_hash).map(str::to_owned),
    }
}

fn incomplete(why: &str) -> String {
    format!("not a whole frame ({why})")
}

/// Why a complete file is not a render of the same scene and settings.
fn other_render(stored: &StoredFrame, render_hash: &str) -> Option<&'static str> {
    match &stored.render_hash {
        None => Some("made by another program"),
        Some(hash) if hash != render_hash => {
            Some("made from another scene, other settings or by another version")
        }
        Some(_) => None,
    }
}

/// Why a complete file is not the planned one.
fn mismatch(job: &SequenceJob, stored: &StoredFrame, render_hash: &str) -> Option<&'static str> {
    let window = job.render.window;
    let same_window = match job.output.format() {
        OutputFormat::Exr => stored.size == job.render.resolution && stored.data_window == window.into(),
        OutputFormat::Png | OutputFormat::Movie(_) => stored.size == window.size(),
    };
    let same_samples = stored.sample_range == job.render.sample_range_text();
    other_render(stored, render_hash)
        .or((!same_window).then_some("another crop of the image"))
        .or((!same_samples).then_some("made from other samples of the image"))
}
