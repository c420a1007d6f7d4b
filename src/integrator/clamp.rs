//! Limit of light that bounces.

use glam::Vec3;

/// Light whose largest component is `limit` at most.
pub(super) fn clamped(radiance: Vec3, limit: f32) -> Vec3 {
    let largest = radiance.max_element();
    if largest > limit && largest < f32::INFINITY { radiance * (limit / largest) } else { radiance }
}
