//! Hit of a ray with a triangle, and the total order of hits along a ray.

use crate::geometry::{Facing, TriangleHit};

/// Intersection of a ray with one triangle of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// Index of the triangle in the frame.
    pub triangle: u32,
    /// Barycentric weight of the second vertex.
    pub u: f32,
    /// Barycentric weight of the third vertex.
    pub v: f32,
    /// The side of the triangle that the ray hits.
    pub facing: Facing,
}

/// Sort key of hits along a ray: by `t`, then by triangle index.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct HitOrder {
    /// Ray parameter.
    pub t: f32,
    /// Index of the triangle in the frame.
    pub triangle: u32,
}

impl Hit {
    /// Adds the triangle's index to its intersection.
    #[inline(always)]
    pub(super) fn of(hit: TriangleHit, triangle: u32) -> Self {
        Self { t: hit.t, triangle, u: hit.u, v: hit.v, facing: hit.facing }
    }

    /// Sort key of this hit.
    pub fn order(&self) -> HitOrder {
        HitOrder { t: self.t, triangle: self.triangle }
    }
}
