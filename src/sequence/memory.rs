//! Estimates of the memory of a run, before anything is allocated.

use std::path::Path;

use crate::bvh::MAX_TRIANGLES;
use crate::error::{Error, Result, over_limit};
use crate::film::{
    AovFlags, CoverageSample, ExactSum, GuideSample, GuideSums, LightPasses, LightSums, NoiseSample,
    PixelCenterSample, PixelMoments, PixelSums, PixelWindow, SumFlags,
};
use crate::output::ExrOutput;
use crate::render::PathFrame;

use super::bands::{least_rows, rows_of, whole_frame_setting};
use super::job::triangle_count;
use super::{SequenceJob, Shutter};

/// The program, its tables and threads before the first frame.
const BYTES_OF_PROCESS: u128 = 14_000_000;
/// A pixel of a film, which takes tiles as they end.
const BYTES_A_FILM_PIXEL: u128 = 16;
/// A pixel of the file being written: halves before and after compression (8 bytes each).
const BYTES_A_FILE_PIXEL: u128 = 16;
/// A pixel of the preview being written, before and after compression (4 each).
const BYTES_A_PREVIEW_PIXEL: u128 = 8;
/// A pixel of the further film that sums shutter samples.
const BYTES_A_TIME_PIXEL: u128 = 16;
/// A pixel of the plates behind the film being traced and the film being written (16 each), of the latter over its plate (16), and of
/// its channels without the plate before and after compression (8 each).
const BYTES_A_PLATE_PIXEL: u128 = 64;
/// Copies of the exact sums of a frame: its own, and in checkpoints and files of sample ranges those of the frame being written, the channels
/// and the encoded file.
const SUM_COPIES: u128 = 4;
/// A pixel of denoising: guides of two films (24 each), noisy colours of two films (12), their channels (24), three images for the denoiser (12
/// each) and one of its files (12).
const BYTES_A_DENOISED_PIXEL: u128 = 2 * 24 + 2 * 12 + 24 + 3 * 12 + 12;
/// Instances that cover a pixel: most pixels have one or two, edges and foliage more.
const SHARES_A_PIXEL: usize = 4;
/// A posed triangle of this frame and of the previous one: corners, flags and attributes; and its leaf's data for refitting.
const BYTES_A_TRIANGLE: u128 = 2 * 40 + 100 + 30;
/// A posed triangle in the adjacent frames, where motion vectors are recorded.
const BYTES_A_MOVING_TRIANGLE: u128 = 2 * (40 + 50);
/// A reference: its box (32), keys and scratch of the sort (24), a node and an index of the binary tree (68), a slot (40), its share
/// of wide nodes before and after they are joined (50), lists of leaves (6).
const BYTES_A_REFERENCE: u128 = 220;
/// A reference that splitting adds: as above, and its box in the lists of parts (64).
const BYTES_A_SPLIT_REFERENCE: u128 = BYTES_A_REFERENCE + 64;

/// Upper estimate of the bytes that the frames of `job` need besides the scene, without splits: those get what is left.
fn frame_bytes(job: &SequenceJob) -> u128 {
    // A frame is traced while the one before is written.
    estimated_bytes(job, (job.render.window, job.frames.len().clamp(1, 2) as u128))
}

/// The same where `films` of the pixels of `window` are in memory at a time: those of a frame, or of a band of it.
pub(super) fn estimated_bytes(job: &SequenceJob, (window, films): (PixelWindow, u128)) -> u128 {
    let triangles = u128::from(triangle_count(&job.scene, &job.selection.roots));
    let motion = if job.exr.aov_flags().centers { BYTES_A_MOVING_TRIANGLE } else { 0 };
    let pixels = u128::from(window.width()) * u128::from(window.height());
    let plate =
        job.plates.as_ref().map_or(0, |plates| plates.working_bytes(window) + pixels * BYTES_A_PLATE_PIXEL);
    let preview = if job.preview { pixels * BYTES_A_PREVIEW_PIXEL } else { 0 };
    let sums = PathFrame::sum_flags(job.render.integrator, &job.render.path, job.render.aovs);
    BYTES_OF_PROCESS
        + pixel_bytes((window, films), job.shutter, &job.exr, sums)
        + preview
        + plate
        + triangles * (BYTES_A_TRIANGLE + motion + BYTES_A_REFERENCE)
}

/// Rows of the bands of a job that has the scene, the program and one band at a time in its memory. `None` where even the lowest band is
/// too large.
fn band_rows(job: &SequenceJob) -> Option<u32> {
    let lowest = least_rows(&job.exr);
    let bytes = |rows: u32| estimated_bytes(job, (rows_of(job.render.window, rows), 1));
    let free = u128::from(job.max_memory_bytes).checked_sub(bytes(0))?;
    let each = bytes(lowest).saturating_sub(bytes(0)).max(1);
    // Higher bands gain little; splits may take the rest.
    let count = if each > free / 2 { free / each } else { free / 2 / each };
    let rows = u32::try_from(count).unwrap_or(u32::MAX).saturating_mul(lowest);
    (rows > 0).then(|| rows.min(job.render.window.height().next_multiple_of(lowest)))
}

/// References per triangle that splitting may make: those of the job, or fewer where its memory is short.
pub(super) fn reference_budget(job: &SequenceJob) -> f32 {
    let limit = u128::from(job.max_memory_bytes);
    let mut needed = frame_bytes(job);
    if needed > limit
        && let Some(rows) = band_rows(job)
    {
        needed = estimated_bytes(job, (rows_of(job.render.window, rows), 1));
    }
    let free = limit.saturating_sub(needed);
    let triangles = triangle_count(&job.scene, &job.selection.roots).max(1);
    let affordable = 1.0 + free as f64 / (triangles as f64 * BYTES_A_SPLIT_REFERENCE as f64);
    f64::from(job.build.reference_budget).min(affordable) as f32
}

fn pixel_bytes(
    (window, films): (PixelWindow, u128),
    shutter: Shutter,
    exr: &ExrOutput,
    sums: Option<SumFlags>,
) -> u128 {
    let aovs = exr.aov_flags();
    // Channels of AOVs, before and after compression.
    let channels = 2 * u128::from(exr.bytes_a_pixel() - ExrOutput::default().bytes_a_pixel());
    let mut bytes_a_pixel = BYTES_A_FILE_PIXEL + films * (BYTES_A_FILM_PIXEL + aov_bytes(aovs)) + channels;
    if let Some(sums) = sums {
        if sums.guides {
            bytes_a_pixel += BYTES_A_DENOISED_PIXEL;
        }
        bytes_a_pixel += SUM_COPIES * sum_bytes(sums);
    } else if shutter.time_samples > 1 {
        bytes_a_pixel += BYTES_A_TIME_PIXEL + aov_bytes(AovFlags { centers: false, ..aovs });
    }
    u128::from(window.width()) * u128::from(window.height()) * bytes_a_pixel
}

/// Bytes of the AOVs of one pixel of a film.
fn aov_bytes(aovs: AovFlags) -> u128 {
    let mut bytes = 0;
    if aovs.light {
        bytes += size_of::<LightPasses>();
    }
    if aovs.noise {
        bytes += size_of::<NoiseSample>();
    }
    if aovs.guides {
        bytes += size_of::<GuideSample>();
    }
    if aovs.centers {
        bytes += size_of::<PixelCenterSample>();
    }
    if aovs.coverage {
        bytes += size_of::<CoverageSample>() + SHARES_A_PIXEL * size_of::<(u32, f32)>();
    }
    bytes as u128
}

/// Bytes of the exact sums of one pixel.
fn sum_bytes(sums: SumFlags) -> u128 {
    let mut bytes = size_of::<PixelSums>() + 1;
    if sums.moments {
        bytes += size_of::<PixelMoments>();
    }
    if sums.light {
        bytes += size_of::<LightSums>();
    }
    if sums.guides {
        bytes += size_of::<GuideSums>();
    }
    if sums.coverage {
        bytes += size_of::<Vec<(u32, ExactSum)>>() + SHARES_A_PIXEL * size_of::<(u32, ExactSum)>();
    }
    bytes as u128
}

/// Refuses an image whose pixels alone need more than `max_memory_bytes`, before the scene is loaded. `sums` are those of paths.
///
/// # Errors
/// [`Error::Refused`], which names the file `scene`.
pub fn check_image_memory(
    scene: &Path,
    window: PixelWindow,
    shutter: Shutter,
    exr: &ExrOutput,
    sums: Option<SumFlags>,
    max_memory_bytes: u64,
) -> Result<()> {
    // The frames are counted when the scene is loaded.
    let needed = pixel_bytes((window, 1), shutter, exr, sums);
    if needed <= u128::from(max_memory_bytes) {
        return Ok(());
    }
    let (width, height) = window.size();
    let size = over_limit(needed, max_memory_bytes.into());
    let message =
        format!("{width}x{height} pixels need about {size}; render a smaller image or raise `max_memory`");
    Err(Error::refused(scene, "", message))
}

/// Refuses a job that needs more memory than its limit, or has more triangles than ids. Returns the rows of bands where whole frames need
/// more, and bands do not.
pub(super) fn check(job: &SequenceJob) -> Result<Option<u32>> {
    let refuse = |message| Err(Error::refused(&job.scene.path, "", message));
    let triangles = triangle_count(&job.scene, &job.selection.roots);
    if triangles > MAX_TRIANGLES as u64 {
        return refuse(format!(
            "{triangles} triangles are more than the {MAX_TRIANGLES} that a scene can have"
        ));
    }
    let Err(refused) = check_whole_frames(job) else { return Ok(None) };
    match (band_rows(job), whole_frame_setting(job), refused) {
        (Some(rows), None, _) => Ok(Some(rows)),
        (Some(_), Some(setting), Error::Refused { message, .. }) => {
            refuse(format!("{message}; without {setting} it is rendered in bands of rows, which fit"))
        }
        (.., refused) => Err(refused),
    }
}

/// Refuses a job whose frames need more memory than its limit where they are rendered at once.
///
/// # Errors
/// [`Error::Refused`], which names the file of the scene.
pub fn check_whole_frames(job: &SequenceJob) -> Result<()> {
    let needed = frame_bytes(job);
    if needed <= u128::from(job.max_memory_bytes) {
        return Ok(());
    }
    let triangles = triangle_count(&job.scene, &job.selection.roots);
    let (width, height) = job.render.resolution;
    let size = over_limit(needed, job.max_memory_bytes.into());
    let message = format!(
        "{width}x{height} pixels and {triangles} triangles need about {size}; render a smaller image or raise `max_memory`"
    );
    Err(Error::refused(&job.scene.path, "", message))
}
