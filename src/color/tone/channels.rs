//! Extremes of colour channels, with a fixed order of comparisons.

use glam::Vec3;

/// `value`, or zero if it is negative or NaN.
pub(super) fn positive(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

/// The largest channel.
pub(super) fn largest(color: Vec3) -> f32 {
    let larger = if color.x > color.y { color.x } else { color.y };
    if larger > color.z { larger } else { color.z }
}

/// The smallest channel.
pub(super) fn smallest(color: Vec3) -> f32 {
    let smaller = if color.x < color.y { color.x } else { color.y };
    if smaller < color.z { smaller } else { color.z }
}
