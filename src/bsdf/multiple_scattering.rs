//! Compensation of the light that facets reflect more than once.
//!
//! Source: Turquin, "Practical Multiple Scattering Compensation for Microfacet Models", 2019: a lobe of single scattering, times
//! 1 + F0 (1/E − 1) with its albedo E for F = 1. A white lobe then reflects everything. From the denser side of a boundary the lobe's
//! mean F takes the place of F0, so that total reflection loses nothing, either.
//!
//! The factor depends on the view alone: a compensated lobe is not reciprocal.

use glam::Vec3;

use super::isotropic_albedo::{AlbedoTerms, schlick_terms};

/// Factors of a specular lobe; at least 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Compensation {
    pub(super) dielectric: Vec3,
    pub(super) metal: Vec3,
}

impl Compensation {
    /// The factors by F0 of both parts and the lobe's albedo for F = 1.
    #[inline(always)]
    pub(super) fn new((dielectric, metal): (Vec3, Vec3), total: f32) -> Self {
        let lost = if total > 0.0 { 1.0 / total - 1.0 } else { 0.0 };
        let factor = |f0: Vec3| f0.map(|f0| 1.0 + lost * if f0 < 1.0 { f0 } else { 1.0 });
        Self { dielectric: factor(dielectric), metal: factor(metal) }
    }
}

/// Directional albedo of a metal of this colour and roughness, seen at `cos_o` from the normal.
pub(crate) fn metallic_albedo(color: Vec3, cos_o: f32, roughness: f32) -> Vec3 {
    let AlbedoTerms { total, schlick, .. } = schlick_terms(cos_o, roughness);
    let Compensation { metal, .. } = Compensation::new((Vec3::ZERO, color), total);
    metal * single_scattering(color, total, schlick)
}

/// Albedo of a metal without what its facets reflect more than once, by [`AlbedoTerms`].
#[inline(always)]
pub(super) fn single_scattering(color: Vec3, total: f32, schlick: f32) -> Vec3 {
    color * total + (Vec3::ONE - color) * schlick
}
