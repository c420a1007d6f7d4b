//! Bands of rows, in which a frame is rendered that does not fit into memory at once.
//!
//! A band is a crop of the frame, whose pixels do not depend on the others. The scene is posed and its BVH built once; a band is traced,
//! encoded and written to the frame's temporary file before the next one. The files have the bytes of a frame that is rendered at once.

use crate::film::PixelWindow;
use crate::output::{ExrBandFiles, ExrOutput};

use super::memory::estimated_bytes;
use super::{OutputFormat, SequenceJob};

/// Rows that tiles are aligned to.
const ROWS_OF_TILES: u32 = 32;

/// The setting of `job` that needs whole frames in memory, and why; `None` where frames can be rendered in bands.
pub(super) fn whole_frame_setting(job: &SequenceJob) -> Option<(&'static str, &'static str)> {
    let outputs = &job.sequence_outputs;
    let settings = [
        (job.output.format() != OutputFormat::Exr, "output", "only EXR files are written in bands of rows"),
        (job.preview, "preview", "previews are made of whole frames"),
        (outputs.movie.is_some(), "movie", "movies are made of whole frames"),
        (outputs.contact_sheet.is_some(), "contact_sheet", "contact sheets are made of whole frames"),
        (outputs.is_on_common_sheet, "contact_sheet", "contact sheets are made of whole frames"),
        (outputs.shows_frames, "show", "whole frames are shown"),
        (job.denoiser.is_some(), "denoise", "whole frames are denoised"),
        (job.plates.is_some(), "background", "plates are put behind whole frames"),
        (job.checkpoint, "checkpoint", "checkpoints hold whole frames"),
        (job.render.path.time_limit_seconds.is_some(), "time_limit", "the time is that of whole frames"),
    ];
    settings.into_iter().find(|(is_set, ..)| *is_set).map(|(_, setting, why)| (setting, why))
}

/// Rows of the bands of a job that has the scene, the program and one band at a time in its memory. `None` where even the lowest band is
/// too large.
pub(super) fn band_rows(job: &SequenceJob) -> Option<u32> {
    let lowest = least_rows(&job.exr);
    let bytes = |rows: u32| estimated_bytes(job, (rows_of(job.render.window, rows), 1));
    let free = u128::from(job.max_memory_bytes).checked_sub(bytes(0))?;
    let each = bytes(lowest).saturating_sub(bytes(0)).max(1);
    // Higher bands gain little; splits may take the rest.
    let count = if each > free / 2 { free / each } else { free / 2 / each };
    let rows = u32::try_from(count).unwrap_or(u32::MAX).saturating_mul(lowest);
    (rows > 0).then(|| rows.min(job.render.window.height().next_multiple_of(lowest)))
}

/// Rows of the lowest band: whole tiles, and whole chunks of all files.
fn least_rows(exr: &ExrOutput) -> u32 {
    ExrBandFiles::rows_of_chunks(exr).max(ROWS_OF_TILES)
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
