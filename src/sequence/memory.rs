//! What rendering will need, estimated before anything is allocated.

use crate::bvh::{MOST_TRIANGLES, Split};
use crate::error::{Error, Result, readable_bytes};
use crate::film::{CentreSample, LightParts, PixelCoverage};
use crate::output::ExrOutput;

use super::SequenceJob;
use super::job::triangle_count;

/// A pixel: a film that is traced and its tiles (16 bytes each); a film that is written (16), its halves before and after
/// compression (8 each), its preview before and after (4 each).
const BYTES_A_PIXEL: u128 = 72;
/// A film more, where a frame is the mean of several times.
const BYTES_A_TIME_PIXEL: u128 = 16;
/// Films that hold layers at a time: one traced with its tiles, one written.
const LAYERED_FILMS: u128 = 3;
/// Surfaces that share a pixel, on the high side of the mean.
const SHARES_A_PIXEL: usize = 4;
/// A posed triangle in this frame and in the last one: corners, flags and attributes; and what refitting keeps of its leaf.
const BYTES_A_TRIANGLE: u128 = 2 * 40 + 100 + 30;
/// A reference: box, code, index, sorting scratch, its share of the binary and the wide tree.
const BYTES_A_REFERENCE: u128 = 120;

/// Bytes that the frames of `job` need beyond the scene itself, on the high side.
fn estimated_bytes(job: &SequenceJob) -> u128 {
    let window = &job.render.window;
    let pixels = u128::from(window.width()) * u128::from(window.height());
    let triangles = u128::from(triangle_count(&job.scene, &job.selection.roots));
    let references_a_triangle = match job.build.split {
        Split::Off => 1.0,
        Split::Auto | Split::Area(_) => job.build.reference_budget.clamp(1.0, 64.0),
    };
    let references = (triangles as f64 * f64::from(references_a_triangle)) as u128;
    let bytes_a_pixel = BYTES_A_PIXEL + if job.shutter.time_samples > 1 { BYTES_A_TIME_PIXEL } else { 0 };
    let bytes_a_pixel = bytes_a_pixel + layer_bytes_a_pixel(job);
    pixels * bytes_a_pixel + triangles * BYTES_A_TRIANGLE + references * BYTES_A_REFERENCE
}

/// What layers besides colour take: as recorded, and their channels before and after packing.
fn layer_bytes_a_pixel(job: &SequenceJob) -> u128 {
    let request = job.exr.request();
    let share = |is_recorded: bool, bytes: usize| if is_recorded { bytes as u128 } else { 0 };
    let recorded = share(request.light, size_of::<LightParts>())
        + share(request.centres, size_of::<CentreSample>())
        + share(request.coverage, size_of::<PixelCoverage>() + SHARES_A_PIXEL * size_of::<(u32, f32)>());
    LAYERED_FILMS * recorded + 2 * u128::from(job.exr.bytes_a_pixel() - ExrOutput::default().bytes_a_pixel())
}

/// Refuses a job that needs more memory than it may have, or more triangles than ids.
pub(super) fn check(job: &SequenceJob) -> Result<()> {
    let refuse = |message| Err(Error::refused(&job.scene.path, "", message));
    let triangles = triangle_count(&job.scene, &job.selection.roots);
    if triangles > MOST_TRIANGLES as u64 {
        return refuse(format!(
            "{triangles} triangles are more than the {MOST_TRIANGLES} that a scene can have"
        ));
    }
    let needed = estimated_bytes(job);
    if needed > u128::from(job.max_memory_bytes) {
        let (width, height) = job.render.resolution;
        return refuse(format!(
            "{width}x{height} pixels and {triangles} triangles need about {}, but only {} may be used; ask for a smaller \
             picture or --split off, or raise --max-memory",
            readable_bytes(needed),
            readable_bytes(job.max_memory_bytes.into())
        ));
    }
    Ok(())
}
