//! What rendering will need, estimated before anything is allocated.

use std::path::Path;

use crate::bvh::{MAX_TRIANGLES, Split};
use crate::error::{Error, Result, over_limit};
use crate::film::{AovFlags, CoverageSample, LightPasses, PixelCenterSample, PixelWindow};
use crate::output::ExrOutput;

use super::job::triangle_count;
use super::{SequenceJob, Shutter};

/// A pixel: a film that is traced and its tiles (16 bytes each); a film that is written (16), its halves before and after
/// compression (8 each), its preview before and after (4 each).
const BYTES_A_PIXEL: u128 = 72;
/// A film more, where a frame is the mean of several times.
const BYTES_A_TIME_PIXEL: u128 = 16;
/// Surfaces that cover a pixel: most are covered by one or two, edges and leaves by more.
const SHARES_A_PIXEL: usize = 4;
/// A posed triangle in this frame and in the last one: corners, flags and attributes; and what refitting keeps of its leaf.
const BYTES_A_TRIANGLE: u128 = 2 * 40 + 100 + 30;
/// A posed triangle in the frames before and after, where motion is recorded.
const BYTES_A_MOVING_TRIANGLE: u128 = 2 * (40 + 50);
/// A reference: box, code, index, sorting scratch, its share of the binary and the wide tree.
const BYTES_A_REFERENCE: u128 = 120;

/// Bytes that the frames of `job` need beyond the scene itself, on the high side.
fn estimated_bytes(job: &SequenceJob) -> u128 {
    let triangles = u128::from(triangle_count(&job.scene, &job.selection.roots));
    let references_a_triangle = match job.build.split {
        Split::Off => 1.0,
        Split::Auto | Split::Area(_) => job.build.reference_budget.clamp(1.0, 64.0),
    };
    let references = (triangles as f64 * f64::from(references_a_triangle)) as u128;
    let moves = if job.exr.aov_flags().centers { BYTES_A_MOVING_TRIANGLE } else { 0 };
    picture_bytes(job.render.window, job.shutter, &job.exr)
        + triangles * (BYTES_A_TRIANGLE + moves)
        + references * BYTES_A_REFERENCE
}

fn picture_bytes(window: PixelWindow, shutter: Shutter, exr: &ExrOutput) -> u128 {
    let aovs = exr.aov_flags();
    // Channels of layers besides colour, before and after packing.
    let channels = 2 * u128::from(exr.bytes_a_pixel() - ExrOutput::default().bytes_a_pixel());
    // The film that is traced, its tiles, and the film that is written.
    let mut bytes_a_pixel = BYTES_A_PIXEL + 3 * aov_bytes(aovs) + channels;
    if shutter.time_samples > 1 {
        bytes_a_pixel += BYTES_A_TIME_PIXEL + aov_bytes(AovFlags { centers: false, ..aovs });
    }
    u128::from(window.width()) * u128::from(window.height()) * bytes_a_pixel
}

/// Of the layers of one pixel of a film.
fn aov_bytes(aovs: AovFlags) -> u128 {
    let mut bytes = 0;
    if aovs.light {
        bytes += size_of::<LightPasses>();
    }
    if aovs.centers {
        bytes += size_of::<PixelCenterSample>();
    }
    if aovs.coverage {
        bytes += size_of::<CoverageSample>() + SHARES_A_PIXEL * size_of::<(u32, f32)>();
    }
    bytes as u128
}

/// Refuses pictures whose pixels alone need more memory than there may be; nothing of the scene need be known.
///
/// # Errors
/// [`Error::Refused`] in the name of `scene`.
pub fn check_picture(
    scene: &Path,
    window: PixelWindow,
    shutter: Shutter,
    exr: &ExrOutput,
    max_memory_bytes: u64,
) -> Result<()> {
    let needed = picture_bytes(window, shutter, exr);
    if needed <= u128::from(max_memory_bytes) {
        return Ok(());
    }
    let (width, height) = (window.width(), window.height());
    let size = over_limit(needed, max_memory_bytes.into());
    let message =
        format!("{width}x{height} pixels need about {size}; ask for a smaller picture or raise --max-memory");
    Err(Error::refused(scene, "", message))
}

/// Refuses a job that needs more memory than it may have, or more triangles than ids.
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
            "{width}x{height} pixels and {triangles} triangles need about {}; ask for a smaller picture or --split off, or \
             raise --max-memory",
            over_limit(needed, job.max_memory_bytes.into())
        ));
    }
    Ok(())
}
