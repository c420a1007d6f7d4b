//! Surface points at hits, where secondary rays start.

use glam::Vec3;
use rayframe::bvh::Hit;
use rayframe::geometry::{Ray, Triangle};

/// Offset of ray origins from the surface, in units of the largest coordinate or distance.
const OFFSET: f32 = 3.0e-5;

/// Point slightly off a triangle, on the side of the incoming ray.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Offset position.
    pub position: Vec3,
    /// Unit vector towards the side of the ray.
    pub normal: Vec3,
}

impl Surface {
    /// Surface point of `hit` of `ray`.
    pub fn new(triangles: &[Triangle], ray: &Ray, hit: &Hit) -> Self {
        let triangle = &triangles[hit.triangle as usize];
        let front = triangle.scaled_normal().normalize_or_zero();
        let normal = if front.dot(ray.direction) > 0.0 { -front } else { front };
        let [a, b, c] = triangle.vertices;
        let on_plane = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        let largest = on_plane.abs().max_element().max(hit.t);
        Self { position: on_plane + normal * (OFFSET * largest), normal }
    }
}
