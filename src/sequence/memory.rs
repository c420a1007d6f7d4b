//! Estimates of the memory of a run, before anything is allocated.
//!
//! A run needs most while it imports the scene or while it renders. The estimate is the larger of the two and what the program itself
//! takes; what an automatic camera needs in between is checked apart. `tests/oracles/memory_estimates.py` compares estimates with the
//! resident sizes of renders. They differ by up to a third: the system's allocator keeps some of what is freed, and nobody knows before
//! how well a file compresses.

mod pixels;
mod surfaces;

use std::path::Path;

use glam::Vec3;

use crate::bvh::{BuildSettings, MAX_TRIANGLES, Refit, Split};
use crate::error::{Error, Result, over_limit};
use crate::film::{PixelWindow, SumFlags};
use crate::framing::kept_bytes;
use crate::integrator::Integrator;
use crate::integrator::path::most_photon_bytes;
use crate::render::{PathFrame, tile_count};
use crate::scene::{Material, Scene, SelectedCamera, Selection};

pub use pixels::PixelMemory;
use pixels::further_sum_bytes;
use surfaces::{Motion, PosedCounts, bytes_a_part};

use super::SequenceJob;
use super::bands::{change_for_bands, least_rows, rows_of};
use super::job::triangle_count;

/// What helps besides more memory where an image needs too much.
const SMALLER_IMAGE: Option<&str> = Some("render a smaller image");
/// The program and its tables before the first frame.
const BYTES_OF_PROCESS: u128 = 13_400_000;
/// A tile that a thread traces: its samples, rays and hits.
const BYTES_A_TILE: u128 = 700_000;
/// The same where surfaces transmit light, so that rays branch.
const BYTES_A_BRANCHING_TILE: u128 = 2_500_000;
/// The shadow rays of a tile: at most so many to each light, and no more than the queue holds. The bytes of a tile cover those of few lights.
const RAYS_TO_A_LIGHT: u128 = 1024;
const MOST_SHADOW_RAYS: u128 = 1 << 16;
const BYTES_A_SHADOW_RAY: u128 = 120;
/// A light in a block of hits, and the batch of its shadow rays.
const BYTES_A_TILE_LIGHT: u128 = 1_500;
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

/// Upper estimate of the bytes that `job` needs without splits where its frames are rendered at once. Splits get what is left.
pub fn estimated_bytes(job: &SequenceJob) -> u128 {
    bytes_with_pixels(job, job.render.window, job.write_behind && job.frames.len() > 1)
}

/// The same where the pixels of `window` are in memory, those of a frame or a band of it; `has_next` where the next ones are, too.
fn bytes_with_pixels(job: &SequenceJob, window: PixelWindow, has_next: bool) -> u128 {
    let rendering = u128::from(job.scene.memory.kept_bytes) + frame_bytes(job, window, has_next);
    BYTES_OF_PROCESS + rendering.max(job.scene.memory.import_bytes.into())
}

/// Bytes that `job` needs where the sums of a frame take `pixel_bytes` a pixel in its checkpoint; `None` where [`estimated_bytes`] covers them.
pub(super) fn bytes_with_stored_sums(job: &SequenceJob, pixel_bytes: u64) -> Option<u128> {
    let window = job.render.window;
    let pixels = u128::from(window.width()) * u128::from(window.height());
    let further = pixels * further_sum_bytes(sum_flags(job).unwrap_or_default(), pixel_bytes.into());
    (further > 0).then(|| estimated_bytes(job) + further)
}

/// Bytes that the frames need besides the scene.
fn frame_bytes(job: &SequenceJob, window: PixelWindow, has_next: bool) -> u128 {
    let counts = PosedCounts::of(&job.scene, &job.selection.roots);
    let pixels = u128::from(window.width()) * u128::from(window.height());
    let plate =
        job.plates.as_ref().map_or(0, |plates| plates.working_bytes(window) + pixels * BYTES_A_PLATE_PIXEL);
    let preview = if job.preview { pixels * BYTES_A_PREVIEW_PIXEL } else { 0 };
    let image = PixelMemory {
        window,
        shutter: job.shutter,
        filter: job.render.filter,
        exr: &job.exr,
        sums: sum_flags(job),
        stores_sums: job.checkpoint || job.render.path.sample_range.is_some(),
        is_denoised: job.denoiser.is_some(),
    };
    image.bytes(has_next)
        + preview
        + plate
        + tile_bytes(job, window, counts.lights.into())
        + environment_bytes(job)
        + photon_bytes(job)
        + counts.frame_bytes(job.build.builder, motion(job))
}

/// The sums of paths that a job records.
fn sum_flags(job: &SequenceJob) -> Option<SumFlags> {
    PathFrame::sum_flags(job.render.integrator, &job.render.path, job.render.aovs)
}

/// What poses the surfaces of a job anew.
fn motion(job: &SequenceJob) -> Motion {
    let BuildSettings { refit, split, .. } = job.build;
    Motion {
        moves: job.poses_again(),
        is_recorded: job.exr.aov_flags().centers,
        follows_parts: matches!(refit, Refit::UpTo(_)) && split != Split::Off,
    }
}

/// Bytes of the tiles that are traced at a time, of a scene with so many punctual lights.
fn tile_bytes(job: &SequenceJob, window: PixelWindow, lights: u128) -> u128 {
    let tiles = tile_count(window).min(rayon::current_num_threads());
    let bytes = if job.scene.materials.iter().any(Material::transmits) {
        BYTES_A_BRANCHING_TILE
    } else {
        BYTES_A_TILE
    };
    // Paths choose among lights.
    let shadow_bytes = match job.render.integrator {
        Integrator::Whitted => {
            let rays = (lights * RAYS_TO_A_LIGHT).min(MOST_SHADOW_RAYS);
            rays * BYTES_A_SHADOW_RAY + lights * BYTES_A_TILE_LIGHT
        }
        Integrator::Path => 0,
    };
    tiles as u128 * bytes.max(shadow_bytes)
}

/// Bytes of the photons that guide paths.
fn photon_bytes(job: &SequenceJob) -> u128 {
    let shines = |material: &Material| material.emissive != Vec3::ZERO;
    let emits = job.render.integrator == Integrator::Path && job.scene.materials.iter().any(shines);
    let samples = job.render.adaptive.map_or(job.render.samples, |adaptive| adaptive.max_samples);
    if emits { most_photon_bytes(samples) as u128 } else { 0 }
}

/// Bytes of environment images.
fn environment_bytes(job: &SequenceJob) -> u128 {
    let pixels = job.environment.pixel_count() as u128;
    let prefiltered = (pixels * BYTES_A_PREFILTERED_PIXEL).min(MOST_PREFILTERED_BYTES);
    prefiltered + pixels * BYTES_AN_ENVIRONMENT_PIXEL
}

/// Rows of the bands of a job that has the scene, the program and one band at a time in its memory. `None` where even the lowest band is
/// too large.
fn band_rows(job: &SequenceJob) -> Option<u32> {
    let lowest = least_rows(&job.exr);
    let bytes = |rows: u32| frame_bytes(job, rows_of(job.render.window, rows), false);
    let memory = job.scene.memory;
    let others =
        BYTES_OF_PROCESS + (u128::from(memory.kept_bytes) + bytes(0)).max(memory.import_bytes.into());
    let free = u128::from(job.max_memory_bytes).checked_sub(others)?;
    let each = bytes(lowest).saturating_sub(bytes(0)).max(1);
    // Higher bands gain little; splits may take the rest.
    let count = if each > free / 2 { free / each } else { free / 2 / each };
    let rows = u32::try_from(count).unwrap_or(u32::MAX).saturating_mul(lowest);
    (rows > 0).then(|| rows.min(job.render.window.height().next_multiple_of(lowest)))
}

/// References per triangle that splitting may make: those of the job, or fewer where its memory is short.
pub(super) fn reference_budget(job: &SequenceJob) -> f32 {
    let limit = u128::from(job.max_memory_bytes);
    let mut needed = estimated_bytes(job);
    if needed > limit
        && let Some(rows) = band_rows(job)
    {
        needed = bytes_with_pixels(job, rows_of(job.render.window, rows), false);
    }
    let free = limit.saturating_sub(needed);
    let triangles = triangle_count(&job.scene, &job.selection.roots).max(1);
    let bytes_a_part = bytes_a_part(job.build.builder, motion(job));
    let affordable = 1.0 + free as f64 / (triangles as f64 * bytes_a_part as f64);
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
    let message = format!("{width}x{height} pixels need about {size}");
    Err(Error::over_memory(scene, "", message, SMALLER_IMAGE))
}

/// Refuses a selection whose automatic camera needs more than `max_memory_bytes` to look at all poses: those of its clips together, or of so many clips `alone`.
///
/// # Errors
/// [`Error::Refused`], which names the file of the scene.
pub fn check_framing_memory(
    scene: &Scene,
    selection: &Selection,
    alone: usize,
    max_memory_bytes: u64,
) -> Result<()> {
    if selection.camera != SelectedCamera::Auto {
        return Ok(());
    }
    let counts = PosedCounts::of(scene, &selection.roots);
    let moves = alone > 0 || !selection.clips.is_empty();
    let kept = kept_bytes(counts.triangles, alone.max(1), moves);
    let needed = BYTES_OF_PROCESS + u128::from(scene.memory.kept_bytes) + counts.pose_bytes() + kept;
    if needed <= u128::from(max_memory_bytes) {
        return Ok(());
    }
    let size = over_limit(needed, max_memory_bytes.into());
    let message = format!(
        "the automatic camera looks at {} triangles at many times, which needs about {size}",
        counts.triangles
    );
    Err(Error::over_memory(&scene.path, "", message, Some("choose a camera")))
}

/// Refuses a job that needs more memory than its limit, or has more triangles than ids. Returns the rows of bands where whole frames need
/// more, and bands do not.
pub(super) fn check(job: &SequenceJob) -> Result<Option<u32>> {
    let triangles = triangle_count(&job.scene, &job.selection.roots);
    if triangles > MAX_TRIANGLES as u64 {
        let message =
            format!("{triangles} triangles are more than the {MAX_TRIANGLES} that a scene can have");
        return Err(Error::refused(&job.scene.path, "", message));
    }
    let Err(refused) = check_whole_frames(job) else { return Ok(None) };
    match (band_rows(job), change_for_bands(job), refused) {
        (Some(rows), None, _) => Ok(Some(rows)),
        (Some(_), Some(change), Error::Refused { message, .. }) => {
            let message = format!("{message}; {change} it is rendered in bands of rows, which fit");
            Err(Error::over_memory(&job.scene.path, "", message, SMALLER_IMAGE))
        }
        (.., refused) => Err(refused),
    }
}

/// Refuses a job whose frames need more memory than its limit where they are rendered at once.
///
/// # Errors
/// [`Error::Refused`], which names the file of the scene.
pub fn check_whole_frames(job: &SequenceJob) -> Result<()> {
    let needed = estimated_bytes(job);
    if needed <= u128::from(job.max_memory_bytes) {
        return Ok(());
    }
    let triangles = triangle_count(&job.scene, &job.selection.roots);
    let (width, height) = job.render.resolution;
    let size = over_limit(needed, job.max_memory_bytes.into());
    let message = format!("{width}x{height} pixels and {triangles} triangles need about {size}");
    Err(Error::over_memory(&job.scene.path, "", message, SMALLER_IMAGE))
}
