//! Files that are there before a run: kept, replaced, or in the way.

use std::path::Path;

use crate::image_file::{StoredFrame, inspect_exr, inspect_png};

use super::{OutputFormat, SequenceJob};

/// What becomes of files that are there already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExistingFiles {
    /// Whole frames made from the same things are kept; any other file is an error.
    #[default]
    Protect,
    /// Whole frames made from the same things are kept, others are replaced.
    Resume,
    /// All are replaced.
    Overwrite,
}

/// What is to be done about one frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Decision {
    /// Render it.
    Render,
    /// The file is as it should be.
    Keep,
    /// Another file has the name; why it is not the frame.
    InTheWay(String),
}

/// Decides about the file `path` that should hold a frame with `render_hash`.
pub(super) fn decide(job: &SequenceJob, path: &Path, render_hash: &str) -> Decision {
    if job.existing == ExistingFiles::Overwrite || !path.is_file() {
        return Decision::Render;
    }
    let inspected = match job.output.format() {
        OutputFormat::Exr => inspect_exr(path),
        OutputFormat::Png => inspect_png(path),
    };
    let why = match inspected {
        Ok(stored) => match difference(job, &stored, render_hash) {
            None => return Decision::Keep,
            Some(why) => why.to_owned(),
        },
        Err(why) => not_whole(&why),
    };
    Decision::InTheWay(why)
}

/// Why the file `path`, which is about to become the preview of a frame with `render_hash`, is something else.
///
/// A preview of the same frame in another look or crop is not.
pub(super) fn preview_in_the_way(job: &SequenceJob, path: &Path, render_hash: &str) -> Option<String> {
    if job.existing == ExistingFiles::Overwrite || !path.is_file() {
        return None;
    }
    match inspect_png(path) {
        Err(why) => Some(not_whole(&why)),
        Ok(stored) => other_origin(&stored, render_hash).map(str::to_owned),
    }
}

fn not_whole(why: &str) -> String {
    format!("not a whole frame ({why})")
}

/// Why a whole file was made from something else.
fn other_origin(stored: &StoredFrame, render_hash: &str) -> Option<&'static str> {
    match &stored.render_hash {
        None => Some("made by another program"),
        Some(hash) if hash != render_hash => {
            Some("made from another scene, other settings or by another version")
        }
        Some(_) => None,
    }
}

/// Why a whole file is not the frame that is asked for.
fn difference(job: &SequenceJob, stored: &StoredFrame, render_hash: &str) -> Option<&'static str> {
    let window = job.render.window;
    let same_window = match job.output.format() {
        OutputFormat::Exr => stored.size == job.render.resolution && stored.data_window == window.into(),
        OutputFormat::Png => stored.size == (window.width(), window.height()),
    };
    other_origin(stored, render_hash).or((!same_window).then_some("another crop of the picture"))
}
