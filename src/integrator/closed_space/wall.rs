//! Surfaces around a closed space.

use glam::{Vec2, Vec3};

use crate::bvh::{Hit, TraversalCounters};
use crate::geometry::Ray;
use crate::integrator::local_frame::local_frame;
use crate::integrator::random::{hash, r2_moved};
use crate::integrator::unit_interval;
use crate::integrator::walls::is_wall;
use crate::interaction::{BlurredMaterial, SurfacePoint};
use crate::scene::KeyLight;
use crate::scene_view::SceneView;

/// A surface that hides the environment: flat, and diffuse or unlit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    /// Rays from here start outside of the surface.
    pub(super) origin: Vec3,
    /// On the side that was hit.
    pub(super) normal: Vec3,
    pub(super) albedo: Vec3,
    /// Radiance without any light: that of unlit materials.
    pub(super) emitted: Vec3,
    /// Irradiance by the peaks and the key light of the environment.
    pub(super) irradiance_by_lights: Vec3,
}

impl Wall {
    /// The wall that a ray hits, if any, in the light of the environment's own `lights`.
    pub(super) fn along(view: SceneView<'_>, lights: &[KeyLight], ray: &Ray) -> Option<Self> {
        let hides = |hit: &Hit| is_wall(view, hit, |_| true);
        let hit = view.bvh.closest_hit_of_any_side(ray, None, hides, &mut TraversalCounters::default())?;
        let point = SurfacePoint::flat(view, ray, &hit);
        let (origin, normal) = (point.origin_outside(), point.geometric_normal);
        let mut irradiance_by_lights = Vec3::ZERO;
        for light in lights {
            let cosine = light.direction_to_light.dot(normal);
            if cosine > 0.0 && is_open(view, &Ray::new(origin, light.direction_to_light)) {
                irradiance_by_lights += light.irradiance * cosine;
            }
        }
        let color = BlurredMaterial::at(view, &hit).color.max(Vec3::ZERO);
        let material = &view.frame.materials[point.instance.material.index()];
        let (albedo, emitted) =
            if material.unlit { (Vec3::ZERO, color) } else { (color.min(Vec3::ONE), Vec3::ZERO) };
        Some(Self { origin, normal, albedo, emitted, irradiance_by_lights })
    }

    /// `count` rays from the wall, by the cosine. Walls with other numbers have others.
    pub(super) fn cosine_rays(&self, number: u32, count: u32) -> impl Iterator<Item = Ray> {
        let bits = hash(number);
        let first = Vec2::new(unit_interval(bits), unit_interval(hash(bits)));
        let (origin, world_from_local) = (self.origin, local_frame(self.normal));
        (0..count).map(move |ray| {
            Ray::new(origin, world_from_local * crate::bsdf::cosine_direction(r2_moved(first, ray)))
        })
    }
}

/// Whether a ray reaches the environment, past glass and surfaces that are more than half transparent.
pub(super) fn is_open(view: SceneView<'_>, ray: &Ray) -> bool {
    let hides = |hit: &Hit| is_wall(view, hit, |_| true);
    !view.bvh.occluded(ray, hides, &mut TraversalCounters::default())
}
