//! Surfaces that exchange light.

use glam::{Vec2, Vec3};

use crate::bvh::{Hit, TraversalCounters, TriangleFlags};
use crate::geometry::{Facing, Ray};
use crate::integrator::local_frame::local_frame;
use crate::integrator::random::{hash, r2_moved};
use crate::integrator::unit_interval;
use crate::integrator::walls::is_wall;
use crate::interaction::{BlurredMaterial, SurfacePoint, transmits_at};
use crate::scene::KeyLight;
use crate::scene_view::SceneView;

/// A surface that hides the environment: flat, and diffuse or unlit.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct Wall {
    /// Walls of different numbers send different rays.
    pub(in crate::integrator) number: u32,
    /// Rays from here start outside of the surface.
    pub(in crate::integrator) origin: Vec3,
    /// On the side that was hit.
    pub(in crate::integrator) normal: Vec3,
    pub(in crate::integrator) albedo: Vec3,
    /// Radiance without any light: that of unlit materials.
    pub(in crate::integrator) emitted: Vec3,
    /// Irradiance by the peaks and the key light of the environment.
    pub(in crate::integrator) irradiance_by_lights: Vec3,
}

impl Wall {
    /// The wall that a ray hits, if any, in the light of the environment's own `lights`. The back of a single-sided surface is black.
    pub(in crate::integrator) fn along(
        view: SceneView<'_>,
        lights: &[KeyLight],
        (number, ray): (u32, &Ray),
    ) -> Option<Self> {
        let hides = |hit: &Hit| hides(view, hit);
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
        let flags = view.frame.flags[hit.triangle as usize];
        let is_back = hit.facing == Facing::Back && flags.has(TriangleFlags::SINGLE_SIDED);
        let (albedo, emitted) = match (is_back, material.unlit) {
            (true, _) => (Vec3::ZERO, Vec3::ZERO),
            (false, true) => (Vec3::ZERO, color),
            (false, false) => (color.min(Vec3::ONE), Vec3::ZERO),
        };
        Some(Self { number, origin, normal, albedo, emitted, irradiance_by_lights })
    }

    /// `count` rays from the wall, by the cosine. Those with other `bits` are others.
    pub(in crate::integrator) fn cosine_rays(&self, bits: u32, count: u32) -> impl Iterator<Item = Ray> {
        let bits = hash(bits);
        let first = Vec2::new(unit_interval(bits), unit_interval(hash(bits)));
        let (origin, world_from_local) = (self.origin, local_frame(self.normal));
        (0..count).map(move |ray| {
            Ray::new(origin, world_from_local * crate::bsdf::cosine_direction(r2_moved(first, ray)))
        })
    }
}

/// Whether a ray reaches the environment, past glass and surfaces that are more than half transparent.
pub(in crate::integrator) fn is_open(view: SceneView<'_>, ray: &Ray) -> bool {
    let hides = |hit: &Hit| hides(view, hit);
    !view.bvh.occluded(ray, hides, &mut TraversalCounters::default())
}

/// Whether a surface hides what is behind it: also that of a material that is glass elsewhere.
fn hides(view: SceneView<'_>, hit: &Hit) -> bool {
    is_wall(view, hit, |_| transmits_at(view, hit))
}
