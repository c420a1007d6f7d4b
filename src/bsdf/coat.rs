//! The clear coat: a layer of index 1.5 on top of all other lobes.
//!
//! Source: `KHR_materials_clearcoat`: coated = mix(base, lobe, share · F(n_c·v)), the base's emission included. The transmittance of
//! the coat is 1 − share · F, whatever lies below. F is the exact Fresnel curve, which runs from 0.04 to 1 like Schlick's. The lobe is
//! divided by its albedo for F = 1, so that coat and transmittance sum to 1: it keeps the light of multiple scattering.
//! Directions are local to the coat's own normal.

use glam::Vec3;

use super::ggx::MIN_ALPHA;
use super::{fresnel, ggx, isotropic_albedo};

/// Index of refraction of all coats.
const COAT_IOR: f32 = 1.5;

/// The coat at one point, seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    share: f32,
    roughness: f32,
    pub(super) alpha: f32,
}

impl Coat {
    /// A coat over `share` of the surface; `roughness` is the square root of α.
    pub fn new(share: f32, roughness: f32) -> Self {
        let roughness = roughness.clamp(0.0, 1.0);
        let alpha = roughness * roughness;
        let alpha = if alpha > MIN_ALPHA { alpha } else { MIN_ALPHA };
        Self { share: share.clamp(0.0, 1.0), roughness, alpha }
    }

    /// f(wo, wi) of the coat alone; zero for light from below it.
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let half = (wo + wi).normalize_or(Vec3::Z);
        let lobe = ggx::distribution(half, self.alpha) * ggx::visibility(wo.z, wi.z, self.alpha);
        self.lobe_scale(wo.z) * lobe
    }

    /// Share of the light from below the coat that leaves towards a view.
    pub fn transmittance(&self, cos_o: f32) -> f32 {
        1.0 - self.reflectance(cos_o)
    }

    /// Share of uniform light that the coat reflects: `share · F`.
    pub fn albedo(&self, cos_o: f32) -> f32 {
        self.reflectance(cos_o)
    }

    /// Factor of the lobe, F included, for one view.
    pub(super) fn lobe_scale(&self, cos_o: f32) -> f32 {
        self.reflectance(cos_o) / isotropic_albedo::total(cos_o, self.roughness)
    }

    pub(super) fn reflectance(&self, cos_o: f32) -> f32 {
        self.share * fresnel::exact(cos_o, COAT_IOR)
    }
}
