//! What rendering will need, estimated before anything is allocated.

use crate::bvh::{MOST_TRIANGLES, Split};
use crate::error::{Error, Result, readable_bytes};
use crate::film::{CentreSample, LayerRequest, LightParts, PixelCoverage};
use crate::output::ExrOutput;

use super::SequenceJob;
use super::job::triangle_count;

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
    let window = &job.render.window;
    let pixels = u128::from(window.width()) * u128::from(window.height());
    let triangles = u128::from(triangle_count(&job.scene, &job.selection.roots));
    let references_a_triangle = match job.build.split {
        Split::Off => 1.0,
        Split::Auto | Split::Area(_) => job.build.reference_budget.clamp(1.0, 64.0),
    };
    let references = (triangles as f64 * f64::from(references_a_triangle)) as u128;
    let layers = job.render.layers;
    // The film that is traced, its tiles, and the film that is written.
    let mut bytes_a_pixel = BYTES_A_PIXEL + 3 * layer_bytes(layers) + channel_bytes(job);
    if job.shutter.time_samples > 1 {
        bytes_a_pixel += BYTES_A_TIME_PIXEL + layer_bytes(LayerRequest { centres: false, ..layers });
    }
    let bytes_a_triangle = BYTES_A_TRIANGLE + if layers.centres { BYTES_A_MOVING_TRIANGLE } else { 0 };
    pixels * bytes_a_pixel + triangles * bytes_a_triangle + references * BYTES_A_REFERENCE
}

/// Of the layers of one pixel of a film.
fn layer_bytes(layers: LayerRequest) -> u128 {
    let mut bytes = 0;
    if layers.light {
        bytes += size_of::<LightParts>();
    }
    if layers.centres {
        bytes += size_of::<CentreSample>();
    }
    if layers.coverage {
        bytes += size_of::<PixelCoverage>() + SHARES_A_PIXEL * size_of::<(u32, f32)>();
    }
    bytes as u128
}

/// Of the channels of layers besides colour in one pixel, before and after packing.
fn channel_bytes(job: &SequenceJob) -> u128 {
    2 * u128::from(job.exr.bytes_a_pixel() - ExrOutput::default().bytes_a_pixel())
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
