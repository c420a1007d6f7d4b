//! Surface areas of scaled boxes.

use crate::geometry::Aabb;

/// Half the surface area of a box whose edges are multiplied by `scale`, so that it neither overflows nor underflows.
#[inline(always)]
pub(super) fn scaled_half_area(bounds: &Aabb, scale: f32) -> f32 {
    let e = bounds.extent() * scale;
    e.x * e.y + e.y * e.z + e.z * e.x
}
