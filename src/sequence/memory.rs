//! Estimates of the memory of a run, before anything is allocated.
//!
//! A run needs most while it imports the scene or while it renders. The estimate is the larger of the two and what the program itself
//! takes; what an automatic camera needs in between is checked apart. `tests/oracles/memory_estimates.py` compares estimates with the
//! resident sizes of renders. They differ by up to a third: the system's allocator keeps some of what is freed, and nobody knows before
//! how well a file compresses.

mod pixels;
mod surfaces;

use std::path::Path;

use crate::bvh::MAX_TRIANGLES;
use crate::error::{Error, Result, over_limit};
use crate::frame::transmits;
use crate::framing::kept_bytes;
use crate::render::{PathFrame, tile_count};
use crate::scene::{Scene, SelectedCamera, Selection};

pub use pixels::PixelMemory;
use surfaces::{BYTES_A_SPLIT_REFERENCE, Motion, PosedCounts};

use super::SequenceJob;
use super::job::triangle_count;

/// The program and its tables before the first frame.
const BYTES_OF_PROCESS: u128 = 13_400_000;
/// A tile that a thread traces: its samples, rays and hits.
const BYTES_A_TILE: u128 = 700_000;
/// The same where surfaces transmit light, so that rays branch.
const BYTES_A_BRANCHING_TILE: u128 = 2_500_000;
/// A pixel of the preview being written, before and after compression (4 each).
const BYTES_A_PREVIEW_PIXEL: u128 = 8;
/// A pixel of the plates behind the film being traced and the film being written (16 each), of the latter over its plate (16), and of
/// its channels without the plate before and after compression (8 each).
const BYTES_A_PLATE_PIXEL: u128 = 64;
/// A pixel of an environment image: its decoded file, or its mip levels, sampling tables and the image without its peaks (24 either way).
const BYTES_AN_ENVIRONMENT_PIXEL: u128 = 24;
/// Irradiance and prefiltered images of an environment image: bytes for each of its pixels, up to their largest size.
const BYTES_A_PREFILTERED_PIXEL: u128 = 20;
const MOST_PREFILTERED_BYTES: u128 = 10_000_000;

/// Upper estimate of the bytes that `job` needs without splits: those get what is left.
fn estimated_bytes(job: &SequenceJob) -> u128 {
    let counts = PosedCounts::of(&job.scene, &job.selection.roots);
    let memory = job.scene.memory;
    let rendering = u128::from(memory.kept_bytes) + frame_bytes(job, counts);
    BYTES_OF_PROCESS + rendering.max(memory.import_bytes.into())
}

/// Bytes that the frames need besides the scene.
fn frame_bytes(job: &SequenceJob, counts: PosedCounts) -> u128 {
    let window = job.render.window;
    let pixels = u128::from(window.width()) * u128::from(window.height());
    let plate =
        job.plates.as_ref().map_or(0, |plates| plates.working_bytes(window) + pixels * BYTES_A_PLATE_PIXEL);
    let preview = if job.preview { pixels * BYTES_A_PREVIEW_PIXEL } else { 0 };
    let has_next = job.frames.len() > 1;
    let image = PixelMemory {
        window,
        shutter: job.shutter,
        exr: &job.exr,
        sums: PathFrame::sum_flags(job.render.integrator, &job.render.path, job.render.aovs),
        stores_sums: job.checkpoint || job.render.path.sample_range.is_some(),
    };
    let motion = Motion {
        moves: !job.selection.clips.is_empty() && (has_next || job.shutter.time_samples > 1),
        is_recorded: job.exr.aov_flags().centers,
    };
    image.bytes(has_next)
        + preview
        + plate
        + tile_bytes(job)
        + environment_bytes(job)
        + counts.frame_bytes(motion)
}

/// Bytes of the tiles that are traced at a time.
fn tile_bytes(job: &SequenceJob) -> u128 {
    let tiles = tile_count(job.render.window).min(rayon::current_num_threads());
    let bytes = if job.scene.materials.iter().any(transmits) { BYTES_A_BRANCHING_TILE } else { BYTES_A_TILE };
    tiles as u128 * bytes
}

/// Bytes of environment images.
fn environment_bytes(job: &SequenceJob) -> u128 {
    let pixels = job.environment.pixel_count() as u128;
    let prefiltered = (pixels * BYTES_A_PREFILTERED_PIXEL).min(MOST_PREFILTERED_BYTES);
    prefiltered + pixels * BYTES_AN_ENVIRONMENT_PIXEL
}

/// References per triangle that splitting may make: those of the job, or fewer where its memory is short.
pub(super) fn reference_budget(job: &SequenceJob) -> f32 {
    let free = u128::from(job.max_memory_bytes).saturating_sub(estimated_bytes(job));
    let triangles = triangle_count(&job.scene, &job.selection.roots).max(1);
    let affordable = 1.0 + free as f64 / (triangles as f64 * BYTES_A_SPLIT_REFERENCE as f64);
    f64::from(job.build.reference_budget).min(affordable) as f32
}

/// Refuses an image whose pixels alone need more than `max_memory_bytes`, before the scene is loaded.
///
/// # Errors
/// [`Error::Refused`], which names the file `scene`.
pub fn check_image_memory(scene: &Path, image: &PixelMemory<'_>, max_memory_bytes: u64) -> Result<()> {
    // The frames are counted when the scene is loaded.
    let needed = image.bytes(false);
    if needed <= u128::from(max_memory_bytes) {
        return Ok(());
    }
    let (width, height) = image.window.size();
    let size = over_limit(needed, max_memory_bytes.into());
    let message =
        format!("{width}x{height} pixels need about {size}; render a smaller image or raise `max_memory`");
    Err(Error::refused(scene, "", message))
}

/// Refuses a selection whose automatic camera needs more than `max_memory_bytes` to look at all poses.
///
/// # Errors
/// [`Error::Refused`], which names the file of the scene.
pub fn check_framing_memory(scene: &Scene, selection: &Selection, max_memory_bytes: u64) -> Result<()> {
    if selection.camera != SelectedCamera::Auto {
        return Ok(());
    }
    let counts = PosedCounts::of(scene, &selection.roots);
    let kept = kept_bytes(counts.triangles, !selection.clips.is_empty());
    let needed = BYTES_OF_PROCESS + u128::from(scene.memory.kept_bytes) + counts.pose_bytes() + kept;
    if needed <= u128::from(max_memory_bytes) {
        return Ok(());
    }
    let size = over_limit(needed, max_memory_bytes.into());
    let message = format!(
        "the automatic camera looks at {} triangles at many times, which needs about {size}; choose a camera or raise `max_memory`",
        counts.triangles
    );
    Err(Error::refused(&scene.path, "", message))
}

/// Refuses a job that needs more memory than its limit, or has more triangles than ids.
pub(super) fn check(job: &SequenceJob) -> Result<()> {
    let refuse = |message| Err(Error::refused(&job.scene.path, "", message));
    let triangles = triangle_count(&job.scene, &job.selection.roots);
    if triangles > MAX_TRIANGLES as u64 {
        return refuse(format!(
            "{triangles} triangles are more than the {MAX_TRIANGLES} that a scene can have"
        ));
    }
    let needed = estimated_bytes(job);
    if needed > u128::from(job.max_memory_bytes) {
        let (width, height) = job.render.resolution;
        return refuse(format!(
            "{width}x{height} pixels and {triangles} triangles need about {}; render a smaller image or raise `max_memory`",
            over_limit(needed, job.max_memory_bytes.into())
        ));
    }
    Ok(())
}
