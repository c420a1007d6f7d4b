//! Checks of the pixels of an environment image.

use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, Result};

/// Limit of the pixels of an environment image: 16384x8192.
const MAX_PIXELS: u64 = 1 << 27;

/// Limit of a channel's radiance: far above any light, far below the overflow of sums.
const MAX_RADIANCE: f32 = 1e30;

/// Pixels that a task checks.
const PIXELS_PER_TASK: usize = 1 << 14;

/// Refuses images that are empty, too large, or not as large as their pixels.
pub(super) fn check_size(path: &Path, (width, height): (u32, u32), pixels: usize) -> Result<()> {
    let expected = u64::from(width) * u64::from(height);
    if expected == 0 {
        return Err(Error::invalid(path, "", "the environment image is empty"));
    }
    if expected > MAX_PIXELS {
        return Err(Error::refused(
            path,
            "",
            format!(
                "the environment image has {width}x{height} pixels, more than the limit of {MAX_PIXELS}; make it smaller"
            ),
        ));
    }
    if pixels as u64 != expected {
        return Err(Error::invalid(
            path,
            "",
            format!("the environment image should have {width}x{height} pixels but has {pixels}"),
        ));
    }
    Ok(())
}

/// Refuses values that are not finite or too large, and makes others at least 0.
pub(super) fn check_values(path: &Path, width: u32, pixels: &mut [[f32; 3]]) -> Result<()> {
    let is_refused = |pixel: &[f32; 3]| pixel.iter().any(|value| !value.is_finite() || *value > MAX_RADIANCE);
    let chunks = pixels.par_chunks_mut(PIXELS_PER_TASK).enumerate();
    let refused = chunks.filter_map(|(chunk, pixels)| {
        if let Some(index) = pixels.iter().position(is_refused) {
            return Some(chunk * PIXELS_PER_TASK + index);
        }
        for pixel in pixels {
            // −0 becomes 0 as well.
            *pixel = pixel.map(|value| if value > 0.0 { value } else { 0.0 });
        }
        None
    });
    if let Some(index) = refused.min() {
        let (column, row) = (index % width as usize, index / width as usize);
        let message = format!(
            "pixel ({column}, {row}) of the environment image is {:?}; values must be finite and at most {MAX_RADIANCE:e}",
            pixels[index]
        );
        return Err(Error::invalid(path, "", message));
    }
    Ok(())
}
