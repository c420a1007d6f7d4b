//! Stored frames as display images, for previews, movies and contact sheets of finished frames.

use std::borrow::Cow;
use std::path::Path;

use crate::error::{Error, Result};
use crate::image::{Image, Plate};
use crate::image_file::{DisplayImage, decode_exr, decode_exr_rgba};
use crate::output::{PreviewLook, SCENE_CHANNELS, display_image};

use super::{PlannedFrame, SequenceJob};

/// Tone-maps a frame's EXR file.
///
/// # Errors
/// Those of reading the file and the frame's plate.
pub(super) fn display_exr(
    job: &SequenceJob,
    planned: &PlannedFrame,
    look: PreviewLook,
) -> Result<DisplayImage> {
    let path = &planned.path;
    let bytes = std::fs::read(path).map_err(Error::missing(path))?;
    let plate = match &job.plates {
        Some(plates) => Some(plates.plate(planned.frame, job.render.resolution, job.render.window)?),
        None => None,
    };
    // The colours are those over the plate, which is not to be tone-mapped.
    if let Some(plate) = plate.filter(|plate| plate.is_display_referred) {
        let image = decode_exr(path, &bytes, job.max_memory_bytes)?;
        return over_plate(path, &image, &plate, look);
    }
    let image = decode_exr_rgba(path, &bytes, job.max_memory_bytes)?;
    Ok(display_image(image.size, &image.pixels, None, look))
}

fn over_plate(path: &Path, image: &Image, plate: &Plate, look: PreviewLook) -> Result<DisplayImage> {
    let floats = |name: &str| image.channel(name).and_then(|channel| channel.samples.floats());
    let channels: Option<Vec<Cow<'_, [f32]>>> = SCENE_CHANNELS.into_iter().map(floats).collect();
    let Some([r, g, b, a]) = channels.as_deref() else {
        return Err(Error::invalid(path, "", "lacks the channels of the scene without its plate"));
    };
    if r.len() != plate.pixels.len() {
        return Err(Error::invalid(path, "", "holds other pixels than the frame"));
    }
    let pixels: Vec<_> = (0..r.len()).map(|at| [r[at], g[at], b[at], a[at]]).collect();
    Ok(display_image(image.size(), &pixels, Some(plate), look))
}
