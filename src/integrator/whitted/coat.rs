//! The clear coat of a surface, seen by one ray: it reflects by itself and dims everything below it.

use glam::{Mat3, Vec2, Vec3};

use super::shading::{local_frame, mirror_direction, traced_share};
use crate::bsdf::Coat;
use crate::interaction::{ClearCoatSample, SurfacePoint};

/// A coat with its place.
pub(super) struct Coated {
    coat: Coat,
    world_from_local: Mat3,
    wo: Vec3,
    geometric_normal: Vec3,
    /// Mean of what the coat sends of uniform light.
    pub(super) albedo: f32,
    /// Share of what lies below that shows.
    pub(super) transmittance: f32,
    /// Where the coat's mirror ray goes.
    pub(super) mirrored: Vec3,
    /// Share of the coat's lobe that rays follow.
    pub(super) traced_share: f32,
    pub(super) roughness: f32,
}

impl Coated {
    /// `follows_rays` leaves nothing to lookups of the environment.
    pub(super) fn new(sample: &ClearCoatSample, point: &SurfacePoint<'_>, follows_rays: bool) -> Self {
        let coat = Coat::new(sample.factor, sample.roughness);
        let world_from_local = local_frame(sample.normal);
        let wo = world_from_local.transpose() * point.wo;
        Self {
            coat,
            world_from_local,
            wo,
            geometric_normal: point.geometric_normal,
            albedo: coat.albedo(wo.z),
            transmittance: coat.transmittance(wo.z),
            mirrored: mirror_direction(point.wo, sample.normal),
            traced_share: if follows_rays { 1.0 } else { traced_share(sample.roughness) },
            roughness: sample.roughness,
        }
    }

    /// Whether the coat is a mirror.
    pub(super) fn is_smooth(&self) -> bool {
        self.coat.is_smooth()
    }

    /// A direction in the world that the coat reflects, and what it counts for.
    pub(super) fn sample_reflection(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (wi, share) = self.coat.sample_reflection(self.wo, u)?;
        Some(((self.world_from_local * wi).normalize(), share))
    }

    /// Scattered radiance by irradiance, cosine included, of light from `wi` in the world.
    pub(super) fn scattered(&self, wi: Vec3) -> f32 {
        if wi.dot(self.geometric_normal) <= 0.0 {
            return 0.0;
        }
        let wi = self.world_from_local.transpose() * wi;
        self.coat.eval(self.wo, wi) * wi.z
    }
}
