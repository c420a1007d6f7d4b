//! Anisotropic GGX: its roughness differs between two directions of the surface.
//!
//! Sources: Burley, "Physically Based Shading at Disney", 2012, appendix B.2 (D); Heitz 2014, section 5.4, and Heitz 2018, as in
//! [`super::ggx`]; `KHR_materials_anisotropy`. Directions are local: X is the direction of the larger α, +Z the normal.
//!
//! The albedo depends on four parameters, too many for a table; it is integrated for each view. At least 99 % of lobes and views are
//! within 1e-3, all within 0.02 (`bsdf::tests::quadrature`). The largest errors are those of views along almost smooth surfaces and, from
//! within a medium, at azimuths next to the direction of anisotropy.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::isotropic_albedo::AlbedoTerms;
use super::microfacets::Microfacets;
use super::{fresnel, ggx, internal_albedo};

/// Number of visible normals that represent a lobe; they sum to its albedo within about a thousandth.
const NORMALS: usize = 256;
/// Revolutions from one normal to the next along their spiral: the golden section.
const REVOLUTIONS: f32 = 0.618_034;

/// An anisotropic GGX lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AnisotropicGgx {
    /// α along X and along Y.
    pub(super) alpha: Vec2,
}

/// A direction of a lobe with its share of uniform light.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReflectedDirection {
    pub(super) wi: Vec3,
    pub(super) facet_cosine: f32,
    /// Share of uniform light, without the Fresnel factor.
    pub(super) weight: f32,
}

impl AnisotropicGgx {
    /// A lobe with the material's α along Y, and mix(α, 1, strength²) along X.
    pub(super) fn new(alpha: f32, strength: f32) -> Self {
        let share = strength * strength;
        Self { alpha: Vec2::new(alpha * (1.0 - share) + share, alpha) }
    }

    /// The same with both α scaled, down to that of a mirror.
    pub(super) fn narrowed(self, scale: f32) -> Self {
        Self { alpha: (self.alpha * scale).max(Vec2::splat(ggx::MIN_ALPHA)) }
    }

    fn scaled_by_alpha(self, direction: Vec3) -> Vec3 {
        Vec3::new(self.alpha.x * direction.x, self.alpha.y * direction.y, direction.z)
    }

    /// D(h); see [`ggx::distribution`].
    pub(super) fn distribution(self, half: Vec3) -> f32 {
        let (x, y) = (half.x / self.alpha.x, half.y / self.alpha.y);
        let slope = x * x + y * y + half.z * half.z;
        1.0 / (std::f32::consts::PI * self.alpha.x * self.alpha.y * slope * slope)
    }

    /// G2 / (4 cos θ_o cos θ_i). Both directions are above the surface.
    pub(super) fn visibility(self, wo: Vec3, wi: Vec3) -> f32 {
        0.5 / (wi.z * length(self.scaled_by_alpha(wo)) + wo.z * length(self.scaled_by_alpha(wi)))
    }

    /// See [`ggx::masking_root`].
    pub(super) fn masking_root(self, direction: Vec3) -> f32 {
        length(self.scaled_by_alpha(direction))
    }

    /// See [`ggx::reflection_pdf`].
    pub(super) fn reflection_pdf(self, wo: Vec3, half: Vec3) -> f32 {
        0.5 * self.distribution(half) / (wo.z + length(self.scaled_by_alpha(wo)))
    }

    /// See [`ggx::visible_normal`].
    pub(super) fn visible_normal(self, wo: Vec3, disk: Vec2) -> Vec3 {
        let view = self.scaled_by_alpha(wo);
        // A surface of α = 1 for the scaled view; its normals are scaled back.
        let normal = ggx::visible_normal(view.normalize(), 1.0, disk);
        self.scaled_by_alpha(normal).normalize_or(Vec3::Z)
    }

    /// The lobe towards `wo` as a fixed number of directions.
    pub(super) fn reflected(self, wo: Vec3) -> impl Iterator<Item = ReflectedDirection> + use<> {
        let root_o = length(self.scaled_by_alpha(wo));
        disk_pattern().iter().filter_map(move |(point, share)| {
            let half = self.visible_normal(wo, *point);
            let facet_cosine = wo.dot(half).clamp(0.0, 1.0);
            let wi = half * (2.0 * facet_cosine) - wo;
            if wi.z <= 0.0 {
                return None;
            }
            // G2 / G1(θ_o)
            let root_i = length(self.scaled_by_alpha(wi));
            let weight = share * wi.z * (wo.z + root_o) / (wi.z * root_o + wo.z * root_i);
            Some(ReflectedDirection { wi, facet_cosine, weight })
        })
    }

    /// The lobe's albedos for a view from above the surface.
    pub(super) fn terms(self, wo: Vec3, relative_ior: f32) -> AlbedoTerms {
        let facets = Microfacets::anisotropic(wo, self.alpha);
        let weight = fresnel::schlick_weight;
        if relative_ior < 1.0 {
            let [total, schlick] = facets.reflected(|cosine| [1.0, weight(cosine)]);
            let exact = total - internal_albedo::by_quadrature(&facets, relative_ior);
            // A difference of two quadratures may leave its range, and a limit that is not a number must not stop the program.
            let exact = if exact > 0.0 { exact } else { 0.0 };
            return AlbedoTerms { total, schlick, exact: if exact < total { exact } else { total } };
        }
        let factors = |cosine: f32| [1.0, weight(cosine), fresnel::exact(cosine, relative_ior)];
        let [total, schlick, exact] = facets.reflected(factors);
        AlbedoTerms { total, schlick, exact }
    }
}

fn length(vector: Vec3) -> f32 {
    libm::sqrtf(vector.dot(vector))
}

/// [`disk_spiral`] of a fixed number of points.
pub(super) fn disk_pattern() -> &'static [(Vec2, f32)] {
    static POINTS: OnceLock<Vec<(Vec2, f32)>> = OnceLock::new();
    POINTS.get_or_init(|| disk_spiral(NORMALS))
}

/// Points of the unit disk and their shares of it, on a spiral that is denser towards the edge, where the long tail of the lobe is.
pub(super) fn disk_spiral(count: usize) -> Vec<(Vec2, f32)> {
    let point = |index: usize| {
        // Area 1 − s² for uniform s.
        let position = index as f32 + 0.5;
        let s = position / count as f32;
        let revolutions = position * REVOLUTIONS;
        (ggx::disk_point(Vec2::new(1.0 - s * s, revolutions - revolutions.floor())), 2.0 * s / count as f32)
    };
    (0..count).map(point).collect()
}
