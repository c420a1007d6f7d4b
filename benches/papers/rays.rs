//! Rays of an image: one through the centre of each pixel, and the shadow and mirror rays of their hits.

use glam::Vec3;

use rayframe::geometry::{Ray, Triangle};

use super::hierarchy::Closest;
use super::scenes::View;

/// Part of its length by which a secondary ray starts above its surface.
const OFFSET: f32 = 1.0e-4;

/// Camera rays of a square image, row by row.
pub(crate) fn primary(view: &View, size: u32) -> Vec<Ray> {
    let forward = (view.target - view.eye).normalize();
    let right = forward.cross(view.up).normalize();
    let up = right.cross(forward);
    let half = libm::tanf(view.degrees.to_radians() * 0.5);
    let at = |pixel: u32| (2.0 * (pixel as f32 + 0.5) / size as f32 - 1.0) * half;
    let ray = |index: u32| {
        Ray::new(view.eye, (forward + right * at(index % size) - up * at(index / size)).normalize())
    };
    (0..size * size).map(ray).collect()
}

/// A ray to the lamp and a mirror ray for each hit.
pub(crate) fn secondary(rays: &[Ray], hits: &[Closest], triangles: &[Triangle], lamp: Vec3) -> Vec<Ray> {
    let mut secondary = Vec::new();
    for (ray, hit) in rays.iter().zip(hits) {
        let Some((t, id)) = *hit else { continue };
        let normal = triangles[id as usize].scaled_normal().normalize_or(Vec3::Y);
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let point = ray.at(t) + normal * (OFFSET * t);
        secondary.push(Ray { t_max: 1.0, ..Ray::new(point, lamp - point) });
        secondary.push(Ray::new(point, ray.direction - normal * (2.0 * normal.dot(ray.direction))));
    }
    secondary.retain(|ray| ray.direction.length_squared() > 0.0);
    secondary
}
