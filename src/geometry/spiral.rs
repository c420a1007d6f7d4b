//! Directions spread evenly over the sphere.

use glam::Vec3;

/// Azimuth from one point of a spiral to the next, radians.
pub(crate) const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// Unit vector `index` of `count` along a spiral from +Y to -Y. Each stands for an equal solid angle.
pub(crate) fn spiral_direction(index: u32, count: u32) -> Vec3 {
    let height = 1.0 - (2.0 * index as f32 + 1.0) / count as f32;
    let (sin_azimuth, cos_azimuth) = libm::sincosf(index as f32 * GOLDEN_ANGLE);
    let sine = (1.0 - height * height).sqrt();
    Vec3::new(sine * cos_azimuth, height, sine * sin_azimuth)
}
