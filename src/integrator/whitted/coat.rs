//! The clear coat of a shaded surface: it reflects by its own lobe and dims everything below.

use glam::{Mat3, Vec2, Vec3};

use super::traced_share::traced_share;
use crate::bsdf::Coat;
use crate::integrator::local_frame::{local_frame, mirror_direction};
use crate::integrator::prefiltered_lobe::PrefilteredLobe;
use crate::interaction::{ClearCoatSample, SurfacePoint};

/// A coat seen by one ray, with its own shading frame.
pub(super) struct CoatShading {
    coat: Coat,
    world_from_local: Mat3,
    wo: Vec3,
    geometric_normal: Vec3,
    /// Directional albedo of the coat.
    pub(super) albedo: f32,
    /// Share of the light from below the coat that passes it.
    pub(super) transmittance: f32,
    /// Direction of the coat's mirror ray.
    pub(super) mirrored: Vec3,
    /// The lobe that is looked up for the coat's.
    pub(super) looked_up: PrefilteredLobe,
    /// Share of the coat's lobe that rays follow.
    pub(super) traced_share: f32,
    pub(super) roughness: f32,
}

impl CoatShading {
    /// The coat at a point. Where `is_traced` is set, rays follow the whole lobe.
    pub(super) fn new(sample: &ClearCoatSample, point: &SurfacePoint<'_>, is_traced: bool) -> Self {
        let coat = Coat::new(sample.factor, sample.roughness);
        let world_from_local = local_frame(sample.normal);
        let wo = world_from_local.transpose() * point.wo;
        let mirrored = mirror_direction(point.wo, sample.normal);
        Self {
            coat,
            world_from_local,
            wo,
            geometric_normal: point.geometric_normal,
            albedo: coat.albedo(wo.z),
            transmittance: coat.transmittance(wo.z),
            mirrored,
            looked_up: PrefilteredLobe::new(mirrored, sample.normal, wo.z, sample.roughness),
            traced_share: if is_traced { 1.0 } else { traced_share(sample.roughness) },
            roughness: sample.roughness,
        }
    }

    /// Whether the coat is a mirror.
    pub(super) fn is_smooth(&self) -> bool {
        self.coat.is_smooth()
    }

    /// Samples a reflected world-space direction and its weight.
    pub(super) fn sample_reflection(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (wi, weight) = self.coat.sample_reflection(self.wo, u)?;
        Some(((self.world_from_local * wi).normalize(), weight))
    }

    /// f · cos θ_i of the coat for light from the world-space direction `wi`.
    pub(super) fn scattered(&self, wi: Vec3) -> f32 {
        if wi.dot(self.geometric_normal) <= 0.0 {
            return 0.0;
        }
        let wi = self.world_from_local.transpose() * wi;
        self.coat.eval(self.wo, wi) * wi.z
    }
}
