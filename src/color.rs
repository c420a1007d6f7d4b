//! Linear Rec.709 colour.

use glam::Vec3;

/// Maps scene-linear colour to display-linear colour in the unit cube.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// The default.
    #[default]
    Standard,
}

impl ToneCurve {
    /// Display-linear colour.
    pub fn apply(self, linear: Vec3) -> Vec3 {
        linear / (Vec3::ONE + linear)
    }
}

/// Relative luminance.
pub fn luminance(linear: Vec3) -> f32 {
    linear.x * 0.2126 + linear.y * 0.7152 + linear.z * 0.0722
}

/// The sRGB transfer curve, from linear to encoded, both 0 to 1.
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055
    }
}
