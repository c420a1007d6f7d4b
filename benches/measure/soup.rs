//! Triangles as builders take them.

use rayframe::bvh::TriangleFlags;
use rayframe::geometry::Triangle;

/// Opaque, double-sided triangles.
pub(crate) struct Soup {
    /// World space.
    pub(crate) triangles: Vec<Triangle>,
    /// One a triangle.
    pub(crate) flags: Vec<TriangleFlags>,
}

impl Soup {
    pub(crate) fn new(triangles: Vec<Triangle>) -> Self {
        let flags = vec![TriangleFlags::default(); triangles.len()];
        Self { triangles, flags }
    }
}
