//! Transmission through the rough surface of a volume.
//!
//! Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007, equations 16, 17 and 21, with the masking of
//! each side on its own. Each facet transmits what it does not reflect. There is no factor η²: radiance counts as it does along the
//! refracted rays of smooth surfaces. What single scattering loses is given back to both lobes in proportion, as in Turquin,
//! "Practical Multiple Scattering Compensation for Microfacet Models", 2019; [`super::rough_volume_albedo`] tabulates it.

use glam::Vec3;

use super::specular_lobe::SpecularLobe;
use crate::geometry::normalized_or;

/// A direction through the surface with the facet that bends light there.
#[derive(Clone, Copy, Debug)]
pub(super) struct RefractingFacet {
    /// Cosine between view and facet; positive.
    pub(super) facet_cosine: f32,
    /// Density of the refracted direction where the facet is sampled by its visibility.
    pub(super) pdf: f32,
}

/// The facet that refracts between `wo`, above the surface, and `wi`, below it; `None` if there is none that both see.
pub(super) fn refracting_facet(
    lobe: &SpecularLobe,
    (wo, wi): (Vec3, Vec3),
    relative_ior: f32,
) -> Option<RefractingFacet> {
    let half = normalized_or(wo + wi * relative_ior, Vec3::Z);
    let half = if half.z < 0.0 { -half } else { half };
    let (facet_cosine, beyond) = (wo.dot(half), wi.dot(half));
    if facet_cosine <= 0.0 || beyond >= 0.0 {
        return None;
    }
    // Density of visible normals, times dω_h / dω_i
    let length = facet_cosine + relative_ior * beyond;
    let jacobian = relative_ior * relative_ior * -beyond / (length * length);
    let pdf = lobe.visible_normal_pdf(wo, half) * jacobian;
    (pdf > 0.0 && pdf < f32::INFINITY).then_some(RefractingFacet { facet_cosine, pdf })
}

/// The direction refracted at a facet; `None` where it reflects totally or the direction is not below the surface.
pub(super) fn refracted_at(half: Vec3, wo: Vec3, relative_ior: f32) -> Option<Vec3> {
    let facet_cosine = wo.dot(half);
    let bend = 1.0 / relative_ior;
    let cosine_squared = 1.0 - bend * bend * (1.0 - facet_cosine * facet_cosine);
    if facet_cosine <= 0.0 || cosine_squared <= 0.0 {
        return None;
    }
    let wi = half * (bend * facet_cosine - cosine_squared.sqrt()) - wo * bend;
    (wi.z < 0.0).then(|| wi.normalize())
}
