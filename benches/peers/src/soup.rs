//! Triangle soup: input of builders.

use rayframe::bvh::TriangleFlags;
use rayframe::geometry::Triangle;

/// Opaque, double-sided triangles.
pub struct Soup {
    /// Triangles in world space.
    pub triangles: Vec<Triangle>,
    /// Flags of each triangle.
    pub flags: Vec<TriangleFlags>,
}

impl Soup {
    /// Soup of opaque, double-sided triangles.
    pub fn new(triangles: Vec<Triangle>) -> Self {
        let flags = vec![TriangleFlags::default(); triangles.len()];
        Self { triangles, flags }
    }
}
