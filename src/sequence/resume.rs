//! Inspection of files that exist before a run: kept, replaced, or in the way.

use std::path::{Path, PathBuf};

use crate::image_file::{
    StoredFrame, damaged_other_image, inspect_exr, inspect_png, is_empty_file, may_be_damaged_exr,
    may_be_damaged_png, other_image,
};

use super::{ExistingFiles, OutputFormat, SequenceJob};

/// An existing file that the run replaces by other content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReplacedFile {
    /// Path of the file.
    pub path: PathBuf,
    /// What it is now, to be read after "is".
    pub why: String,
    /// Whether it is a link or no frame of this program, such as its contact sheets. [`ExistingFiles::Resume`] replaces none of these.
    pub is_foreign: bool,
}

/// Decision about one existing or missing file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Decision {
    /// The file is missing or replaced.
    Render,
    /// The file is the planned one.
    Keep,
    /// Another file has the name.
    InTheWay(Obstacle),
}

/// A file that is not the planned one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Obstacle {
    /// See [`ReplacedFile::why`].
    why: String,
    /// See [`ReplacedFile::is_foreign`].
    is_foreign: bool,
}

impl Obstacle {
    fn own(why: &str) -> Self {
        Self { why: why.to_owned(), is_foreign: false }
    }

    fn foreign(why: &str) -> Self {
        Self { why: why.to_owned(), is_foreign: true }
    }

    /// A file at `path` that `inspected` says is no whole frame.
    fn incomplete(path: &Path, inspected: &str, may_be_own: bool) -> Self {
        match damaged_other_image(path) {
            Some(other) => Self::foreign(&format!("{other} ({inspected})")),
            None => Self { why: format!("not a whole frame ({inspected})"), is_foreign: !may_be_own },
        }
    }

    /// The same, where a link to another place is replaced as little as a file of another program.
    fn or_link(self, path: &Path) -> Self {
        if path.is_symlink() {
            Self { why: format!("a link to a file that is {}", self.why), is_foreign: true }
        } else {
            self
        }
    }

    pub(super) fn at(self, path: &Path) -> ReplacedFile {
        ReplacedFile { path: path.to_owned(), why: self.why, is_foreign: self.is_foreign }
    }
}

/// What a path leads to that is no file.
fn without_file(path: &Path) -> Option<Obstacle> {
    path.is_symlink().then(|| Obstacle::foreign("a link to no file"))
}

/// Decides about the file at `path`, which is to hold a frame with `render_hash`.
pub(super) fn decide(job: &SequenceJob, path: &Path, render_hash: &str) -> Decision {
    if job.existing == ExistingFiles::Overwrite || is_empty_file(path) {
        return Decision::Render;
    }
    if !path.is_file() {
        return without_file(path).map_or(Decision::Render, Decision::InTheWay);
    }
    let (inspected, may_be_own): (_, fn(&Path) -> bool) = match job.output.format() {
        OutputFormat::Exr => (inspect_exr(path), may_be_damaged_exr),
        OutputFormat::Png => (inspect_png(path), may_be_damaged_png),
        // It is one file, which the plan checks.
        OutputFormat::Movie(_) => return Decision::Render,
    };
    let obstacle = match inspected {
        Ok(stored) => match mismatch(job, &stored, render_hash) {
            None => return Decision::Keep,
            Some(obstacle) => obstacle,
        },
        Err(why) => Obstacle::incomplete(path, &why, may_be_own(path)),
    };
    Decision::InTheWay(obstacle.or_link(path))
}

/// What is at `path`, where it is not a preview of the frame with `render_hash`. A preview of the same frame with
/// another tone mapping or crop is replaced silently.
pub(super) fn preview_in_the_way(job: &SequenceJob, path: &Path, render_hash: &str) -> Option<Obstacle> {
    if job.existing == ExistingFiles::Overwrite || is_empty_file(path) {
        return None;
    }
    if !path.is_file() {
        return without_file(path);
    }
    let obstacle = match inspect_png(path) {
        Err(why) => Obstacle::incomplete(path, &why, may_be_damaged_png(path)),
        Ok(stored) => other_render(&stored, render_hash)?,
    };
    Some(obstacle.or_link(path))
}

/// Why a complete file is not a render of the same scene and settings.
fn other_render(stored: &StoredFrame, render_hash: &str) -> Option<Obstacle> {
    match &stored.render_hash {
        None => Some(Obstacle::foreign("made by another program")),
        Some(hash) if hash == render_hash => None,
        Some(hash) => Some(other_image(hash).map_or_else(
            || Obstacle::own("made from another scene, other settings or by another version"),
            Obstacle::foreign,
        )),
    }
}

/// Why a complete file is not the planned one.
fn mismatch(job: &SequenceJob, stored: &StoredFrame, render_hash: &str) -> Option<Obstacle> {
    let window = job.render.window;
    let same_window = match job.output.format() {
        OutputFormat::Exr => stored.size == job.render.resolution && stored.data_window == window.into(),
        OutputFormat::Png | OutputFormat::Movie(_) => stored.size == window.size(),
    };
    let same_samples = stored.sample_range == job.render.sample_range_text();
    other_render(stored, render_hash)
        .or_else(|| (!same_window).then(|| Obstacle::own("another crop of the image")))
        .or_else(|| (!same_samples).then(|| Obstacle::own("made from other samples of the image")))
}
