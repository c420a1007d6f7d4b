//! Checks of the pixels of an environment image.

use std::path::Path;

use crate::error::{Error, Result};

/// Limit of the pixels of an environment image: 16384x8192.
const MAX_PIXELS: u64 = 1 << 27;

/// Limit of a channel's radiance: far above any light, far below the overflow of sums.
const MAX_RADIANCE: f32 = 1e30;

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
    for (index, pixel) in pixels.iter_mut().enumerate() {
        if pixel.iter().any(|value| !value.is_finite() || *value > MAX_RADIANCE) {
            let (column, row) = (index % width as usize, index / width as usize);
            return Err(Error::invalid(
                path,
                "",
                format!(
                    "pixel ({column}, {row}) of the environment image is {pixel:?}; values must be finite and at most \
                     {MAX_RADIANCE:e}"
                ),
            ));
        }
        // −0 becomes 0 as well.
        *pixel = pixel.map(|value| if value > 0.0 { value } else { 0.0 });
    }
    Ok(())
}
