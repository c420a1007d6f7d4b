//! An HTML page that shows the result of a run of comparisons, in one file that loads nothing.
//!
//! A [`ReportPage`] is plain data; [`write_report`] writes the file. Images wait in memory as
//! [`EncodedImage`](super::EncodedImage)s, within an [`ImageBudget`]. The folder `page` holds the HTML, CSS and JavaScript.

mod data;
mod html;
mod image_budget;
mod page;
mod page_images;

use std::path::Path;

use crate::error::Result;
use crate::image_file::{OutputKind, check_output, probe_folder, write_single_file};

pub use image_budget::{IMAGE_BUDGET_BYTES, ImageBudget};
pub use page::{
    AssetChanges, ChangeGroup, ChangeRow, FolderSummary, FrameCommands, NamedCommand, ReportPage,
};

/// Checks that a page can be written to `path`, and creates its folder. `overwrites` permits to replace any file.
///
/// # Errors
/// [`Error::CannotCreate`](crate::Error::CannotCreate) when the folder cannot be created, or when `path` exists and is not a report page.
pub fn check_report_place(path: &Path, overwrites: bool) -> Result<()> {
    check_output(path, OutputKind::ReportPage, overwrites)?;
    probe_folder(path)
}

/// Writes the page to `path` and creates its folder. Equal data give equal bytes. Images beyond [`IMAGE_BUDGET_BYTES`] are
/// omitted, and the page says so.
///
/// # Errors
/// [`Error::CannotCreate`](crate::Error::CannotCreate) or [`Error::WriteFailed`](crate::Error::WriteFailed).
pub fn write_report(page: &ReportPage, path: &Path) -> Result<()> {
    let text = html::html(page, IMAGE_BUDGET_BYTES)?;
    write_single_file(path, text.as_bytes())
}
