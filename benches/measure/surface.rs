//! Where rays meet triangles, for the rays that go on from there.

use glam::Vec3;
use rayframe::bvh::Hit;
use rayframe::geometry::{Ray, Triangle};

/// How far rays start off a surface, in units of its largest coordinate or distance.
const OFFSET: f32 = 3.0e-5;

/// A point just off a triangle, on the side that a ray came from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub(crate) position: Vec3,
    /// Unit vector towards the side of the ray.
    pub(crate) normal: Vec3,
}

impl Surface {
    /// The point that `hit` of `ray` is at.
    pub(crate) fn new(triangles: &[Triangle], ray: &Ray, hit: &Hit) -> Self {
        let triangle = &triangles[hit.triangle as usize];
        let front = triangle.scaled_normal().normalize_or_zero();
        let normal = if front.dot(ray.direction) > 0.0 { -front } else { front };
        let [a, b, c] = triangle.vertices;
        let on_plane = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        let largest = on_plane.abs().max_element().max(hit.t);
        Self { position: on_plane + normal * (OFFSET * largest), normal }
    }
}
