//! Bands of rows, in which a frame is rendered that does not fit into memory at once.
//!
//! A band is a crop of the frame, whose pixels do not depend on the others. The scene is posed and its BVH built once; a band is traced,
//! encoded and written to the frame's temporary file before the next one. The files have the bytes of a frame that is rendered at once.

use crate::film::PixelWindow;
use crate::output::{ExrBandFiles, ExrOutput};
use crate::render::TILE_SIZE;

use super::{OutputFormat, SequenceJob};

/// The change of settings that allows bands, where one rules them out in `job`.
pub(super) fn change_for_bands(job: &SequenceJob) -> Option<&'static str> {
    let outputs = &job.sequence_outputs;
    let makes_sheet = outputs.contact_sheet.is_some() || outputs.is_on_common_sheet;
    let settings = [
        (job.output.format() != OutputFormat::Exr, "with EXR files as `output`"),
        (job.preview, "without `preview`"),
        (outputs.movie.is_some(), "without `movie`"),
        (makes_sheet, "without `contact_sheet`"),
        (outputs.shows_frames, "without `show`"),
        (job.denoiser.is_some(), "without `denoise`"),
        (job.plates.is_some(), "without a plate as `background`"),
        (job.checkpoint, "without `checkpoint`"),
        (job.render.path.time_limit_seconds.is_some(), "without `time_limit`"),
    ];
    settings.into_iter().find(|(is_set, _)| *is_set).map(|(_, change)| change)
}

/// The lowest band that a window can have.
pub fn lowest_band(window: PixelWindow, exr: &ExrOutput) -> PixelWindow {
    rows_of(window, least_rows(exr))
}

/// Rows of the lowest band: whole tiles, and whole chunks of all files.
pub(super) fn least_rows(exr: &ExrOutput) -> u32 {
    ExrBandFiles::rows_of_chunks(exr).max(TILE_SIZE)
}

/// The first `rows` of a window.
pub(super) fn rows_of(window: PixelWindow, rows: u32) -> PixelWindow {
    PixelWindow { y1: window.y0.saturating_add(rows).min(window.y1), ..window }
}

/// The bands of a window, from top to bottom.
pub(super) fn bands(window: PixelWindow, rows: u32) -> impl Iterator<Item = PixelWindow> {
    let starts = (window.y0..window.y1).step_by(rows.max(1) as usize);
    starts.map(move |y0| rows_of(PixelWindow { y0, ..window }, rows))
}
