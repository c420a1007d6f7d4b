//! Sets of rays of one kind.

use glam::Vec3;
use rayframe::geometry::Ray;

/// Query of a set of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// Closest hit.
    Closest,
    /// Whether anything is hit.
    Occluded,
}

/// Rays of one kind.
pub struct RaySet {
    /// `primary`, `shadow`, `reflect` or `diffuse`.
    pub name: &'static str,
    /// Query of the rays.
    pub query: Query,
    /// Rays for single-ray traces.
    pub rays: Vec<Ray>,
    /// Rays for batches where they differ: shadow rays from the light.
    pub from_light: Option<Vec<Ray>>,
}

impl RaySet {
    /// Set of rays for closest hits.
    pub fn closest(name: &'static str, rays: Vec<Ray>) -> Self {
        Self { name, query: Query::Closest, rays, from_light: None }
    }

    /// Set of shadow rays from surfaces to `light`.
    pub fn shadow(rays: Vec<Ray>, light: Vec3) -> Self {
        let from_light = rays.iter().map(|ray| reversed(ray, light)).collect();
        Self { name: "shadow", query: Query::Occluded, rays, from_light: Some(from_light) }
    }

    /// Rays for batches.
    pub fn batched(&self) -> &[Ray] {
        self.from_light.as_ref().unwrap_or(&self.rays)
    }
}

/// The same segment starting at the light, as the integrator traces shadow rays.
///
/// With `p` the origin, `d = |light − p|` and a unit direction, `ray` covers distances (0, m) from `p`, where `m = t_max`.
/// The point at distance `s` from `p` has parameter `1 − s/d` on the ray from the light to `p`, whose direction has
/// length `d`. So (0, m) becomes (1 − m/d, 1); with the files' `m = 0.9999 d` that is (10⁻⁴, 1).
fn reversed(ray: &Ray, light: Vec3) -> Ray {
    let direction = ray.origin - light;
    let distance = direction.length();
    let t_min = 1.0 - ray.t_max / distance;
    Ray { origin: light, direction, t_min: if t_min > 0.0 { t_min } else { 0.0 }, t_max: 1.0 }
}
