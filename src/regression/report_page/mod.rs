//! One HTML file that shows what a run of comparisons found. It holds everything it needs and asks no network.
//!
//! A [`ReportPage`] is plain data; [`write_report`] makes the file of it. Pictures are kept as [`EncodedImage`]s, small enough for
//! many of them to wait in memory. The files in `page` are the page's own: its elements, its looks and its script by subject.

mod data;
mod encoded_image;
mod html;
mod image_budget;
mod page_images;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::{Comparison, Limits};
use crate::error::{Error, Result};
use crate::image_file::{probe_folder, write_atomically};

pub use encoded_image::EncodedImage;
pub use image_budget::ImageBudget;
pub use page_images::IMAGE_BUDGET_BYTES;

/// What all pages begin with.
const GENERATOR: &str = "<meta name=\"generator\" content=\"rayframe\">";

/// What the page shows.
#[derive(Clone, Debug, Default)]
pub struct ReportPage {
    /// What was compared: the suite's folder, or the two sides of a comparison.
    pub title: String,
    /// The command that made the page, to be typed again.
    pub command: String,
    /// How each folder of shots did.
    pub folders: Vec<FolderSummary>,
    /// Shots with a failure, in the order of their names.
    pub shots: Vec<ReportedShot>,
    /// The whole command that takes the exported `approvals.json`, as it is to be typed. Where there is one, failures have tick boxes;
    /// empty where nothing can be approved.
    pub accept_command: String,
    /// What shows a frame whose pictures had no room, by the frame's name; those that are not here show no command.
    pub frame_commands: BTreeMap<String, FrameCommands>,
}

/// Commands, as they are to be typed, that show one frame of a shot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameCommands {
    /// Makes a page of this frame alone, for frames that others left no room.
    pub alone: Option<String>,
    /// Writes its heat map as a picture, for frames that are too large for any page.
    pub heat_map: Option<String>,
}

/// How the shots of a folder did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FolderSummary {
    /// The folder below the suite's; empty for the suite's own.
    pub name: String,
    /// Pictures that are as their references.
    pub passed: usize,
    /// Pictures that are not, that have no reference, or that could not be made; and references without a shot.
    pub failed: usize,
    /// Seconds that rendering and comparing took.
    pub seconds: f64,
}

/// A shot with a failure.
#[derive(Clone, Debug)]
pub struct ReportedShot {
    /// Its name, such as `light/point`.
    pub name: String,
    /// The preset's name, or several words where a shot has limits of its own.
    pub preset: String,
    /// What passes.
    pub limits: Limits,
    /// All its frames in their order; those that pass have numbers for the graph and no pictures.
    pub frames: Vec<ReportedFrame>,
    /// Commands for this shot, each with what it is for: `("Render again", "rayframe render …")`.
    pub commands: Vec<(String, String)>,
}

/// One picture of a shot.
#[derive(Clone, Debug)]
pub struct ReportedFrame {
    /// The name of its reference without the ending: `light/point`, `light/point.0012`.
    pub name: String,
    /// The frame's number, if the shot has several.
    pub frame: Option<i64>,
    /// What was found.
    pub status: FrameStatus,
    /// What is wrong, one line each.
    pub messages: Vec<String>,
    /// All measures; `None` where there was nothing to compare. Its `flip_map` is used for the heat map.
    pub comparison: Option<Comparison>,
    /// The reference, if there is one.
    pub expected: Option<EncodedImage>,
    /// What was rendered, if it was.
    pub actual: Option<EncodedImage>,
    /// The hash of the pixels of `actual`, which an approval names.
    pub actual_hash: Option<String>,
}

/// What was found about a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameStatus {
    /// It is as its reference.
    Passed,
    /// It is not.
    Different,
    /// It has no reference yet.
    Missing,
    /// There is a reference that no shot asks for; an approval removes it.
    Orphaned,
    /// It could not be rendered, or cannot be accepted as it is.
    Broken,
}

/// Makes sure that a page can be written to `path`; folders are created.
///
/// # Errors
/// [`Error::CannotCreate`] when it cannot, or when something that is not such a page has the name.
pub fn check_report_place(path: &Path) -> Result<()> {
    if let Ok(text) = std::fs::read(path)
        && !text.windows(GENERATOR.len()).take(4096).any(|part| part == GENERATOR.as_bytes())
    {
        let message = "is there already and no report; name another folder".to_owned();
        return Err(Error::CannotCreate { path: path.to_owned(), message });
    }
    probe_folder(path)
}

/// Writes the page to `path`; folders are created. Equal data give equal bytes. Pictures beyond [`IMAGE_BUDGET_BYTES`] are left out,
/// and the page says so.
///
/// # Errors
/// [`crate::error::Error::CannotCreate`] or [`crate::error::Error::WriteFailed`].
pub fn write_report(page: &ReportPage, path: &Path) -> Result<()> {
    let text = html::html(page, IMAGE_BUDGET_BYTES)?;
    probe_folder(path)?;
    write_atomically(path, text.as_bytes())
}
