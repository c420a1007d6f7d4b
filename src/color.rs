//! color.

/// stub
pub fn srgb8_to_linear(value: u8) -> f32 {
    f32::from(value) / 255.0
}
/// stub
pub fn srgb16_to_linear(value: u16) -> f32 {
    f32::from(value) / 65535.0
}
