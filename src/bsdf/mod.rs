//! The glTF material model as lobes: how much light is scattered from one direction into another.
//!
//! Directions are unit vectors in the local shading frame, +Z along the shading normal on the side of `wo`; both
//! point away from the surface.

use glam::{Vec2, Vec3};

use crate::interaction::MaterialSample;

/// The lobes of one material at one point, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {}

/// A direction drawn by [`Bsdf::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where the light comes from.
    pub wi: Vec3,
    /// `f(wo, wi) · |cos θ_i| / pdf`.
    pub weight: Vec3,
    /// Density with respect to solid angle.
    pub pdf: f32,
}

impl Bsdf {
    /// The lobes of `material`; `ior_outside` is the index of refraction on the side of `wo`, `ior_inside` on the other.
    pub fn new(material: &MaterialSample, ior_outside: f32, ior_inside: f32) -> Self {
        let _ = (material, ior_outside, ior_inside);
        Self {}
    }

    /// f(wo, wi): scattered radiance by irradiance, without the cosine.
    pub fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let _ = (wo, wi);
        Vec3::ZERO
    }

    /// Draws `wi` with a density close to `f · |cos θ_i|`. `u_lobe` and `u` are uniform in the unit interval and square.
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let _ = (wo, u_lobe, u);
        None
    }

    /// The density with which [`Bsdf::sample`] draws `wi`.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let _ = (wo, wi);
        0.0
    }

    /// E(θ_o): share of uniform light that the specular lobe reflects; its Fresnel factor where the surface is smooth.
    pub fn specular_albedo(&self, cos_o: f32) -> Vec3 {
        let _ = cos_o;
        Vec3::ZERO
    }

    /// Share of uniform light that the diffuse lobe reflects.
    pub fn diffuse_albedo(&self, cos_o: f32) -> Vec3 {
        let _ = cos_o;
        Vec3::ZERO
    }

    /// stub
    pub fn refract(&self, wo: Vec3) -> Option<Vec3> {
        Some(-wo)
    }

    /// Share of uniform light that passes through, base colour included.
    pub fn transmission_albedo(&self, cos_o: f32) -> Vec3 {
        let _ = cos_o;
        Vec3::ZERO
    }
}
