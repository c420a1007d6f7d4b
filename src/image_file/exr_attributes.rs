//! What an EXR file says about its picture besides pixels.

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{IntegerBounds, Vec2};

use super::RgbaPixels;
use crate::color::REC709;

/// Name of the attribute that holds [`FrameAttributes::render_hash`].
pub(super) const RENDER_HASH: &str = "renderHash";

/// Facts about one frame; none may differ between two runs that make the same picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameAttributes {
    /// Program and version (`software`).
    pub software: String,
    /// What the frame was made from, hexadecimal (`renderHash`).
    pub render_hash: String,
    /// Frame number (`frame`, an int).
    pub frame: i32,
    /// Time shown (`timeSeconds`, a double).
    pub time_seconds: f64,
    /// Numerator and denominator (`framesPerSecond`, a rational).
    pub frames_per_second: (i32, u32),
    /// World to camera space; the camera looks along −Z, +Y is up (`worldToCamera`).
    ///
    /// OpenEXR multiplies row vectors from the left and stores rows; glam multiplies column vectors from the right and
    /// stores columns. The sixteen numbers are the same.
    pub world_to_camera: [f32; 16],
    /// World to the display window, (0, 0) top left and (1, 1) bottom right (`worldToNDC`), in the same order.
    pub world_to_ndc: [f32; 16],
}

impl FrameAttributes {
    pub(super) fn of_image(pixels: &RgbaPixels<'_>) -> ImageAttributes {
        let (width, height) = pixels.picture_size;
        let mut attributes =
            ImageAttributes::new(IntegerBounds::new((0, 0), (width as usize, height as usize)));
        let xy = |point: glam::Vec2| Vec2(point.x, point.y);
        attributes.chromaticities = Some(Chromaticities {
            red: xy(REC709.red),
            green: xy(REC709.green),
            blue: xy(REC709.blue),
            white: xy(REC709.white),
        });
        attributes
    }

    pub(super) fn of_layer(&self, pixels: &RgbaPixels<'_>) -> LayerAttributes {
        let mut attributes = LayerAttributes {
            layer_position: Vec2(pixels.origin.0 as i32, pixels.origin.1 as i32),
            frames_per_second: Some(self.frames_per_second),
            world_to_camera: Some(self.world_to_camera),
            world_to_normalized_device: Some(self.world_to_ndc),
            software_name: Text::new_or_none(&self.software),
            ..LayerAttributes::default()
        };
        let own = [
            ("frame", Some(AttributeValue::I32(self.frame))),
            ("timeSeconds", Some(AttributeValue::F64(self.time_seconds))),
            (RENDER_HASH, Text::new_or_none(&self.render_hash).map(AttributeValue::Text)),
        ];
        for (name, value) in own {
            if let (Some(name), Some(value)) = (Text::new_or_none(name), value) {
                attributes.other.insert(name, value);
            }
        }
        attributes
    }
}
