//! Size of the image.

use crate::error::{Error, Result};

use super::definitions::SettingValues;

/// Default image size, pixels.
pub(crate) const DEFAULT_RESOLUTION: (u32, u32) = (1280, 720);

impl SettingValues {
    /// Columns and rows after `scale`. One side alone takes the other from the camera.
    ///
    /// # Errors
    /// [`Error::Setting`] for a side that OpenEXR cannot store.
    pub(crate) fn image_size(&self, camera_aspect: f64) -> Result<(u32, u32)> {
        let default = (f64::from(DEFAULT_RESOLUTION.0), f64::from(DEFAULT_RESOLUTION.1));
        let sides = |(width, height)| (f64::from(width), f64::from(height));
        let (width, height) = match (self.width.map(f64::from), self.height.map(f64::from)) {
            (Some(width), Some(height)) => (width, height),
            (Some(width), None) => (width, width / camera_aspect),
            (None, Some(height)) => (height * camera_aspect, height),
            (None, None) => self.resolution.map_or(default, sides),
        };
        let scale = self.scale.unwrap_or(1.0);
        let side = |pixels: f64| {
            let pixels = (pixels * scale).round().max(1.0);
            // OpenEXR stores corners as signed 32-bit numbers.
            if pixels > f64::from(i32::MAX) {
                return Err(Error::setting("resolution", "a side has more than 2147483647 pixels"));
            }
            Ok(pixels as u32)
        };
        Ok((side(width)?, side(height)?))
    }

    /// The same where it does not depend on the camera; `None` elsewhere.
    ///
    /// # Errors
    /// Those of [`SettingValues::image_size`].
    pub(crate) fn known_image_size(&self) -> Result<Option<(u32, u32)>> {
        let is_known = self.width.is_some() == self.height.is_some();
        is_known.then(|| self.image_size(1.0)).transpose()
    }
}
