//! The specular lobes of [`Scattering`] alone, as its facets reflect and refract light.

use glam::Vec3;

use super::rough_transmission::{RefractingFacet, refracting_facet};
use super::scattering::{Scattering, TransmissionLobe};
use super::share_below;
use crate::geometry::normalized_or;

impl Scattering {
    /// Value and density of [`Scattering::sample_both_at_facet`], as far as the lobe that has `wi` on its side is rough: f · |cos θ_i| of that lobe, over
    /// the facets that reflect or refract light from there.
    pub(super) fn by_facets(&self, wi: Vec3) -> (Vec3, f32) {
        if wi.z > 0.0 {
            let Self { bsdf, wo, .. } = self;
            let half = normalized_or(*wo + wi, Vec3::Z);
            let facet_cosine = wo.dot(half);
            let factor = self.reflected_at(facet_cosine);
            let reflects = self.reflection_probability(factor, facet_cosine);
            return (
                factor * (bsdf.lobe.eval(*wo, wi, half) * wi.z),
                reflects * bsdf.lobe.reflection_pdf(*wo, half),
            );
        }
        match self.transmission {
            TransmissionLobe::Refracted { scale } => self.refracted_by_facets(wi, scale),
            _ => (Vec3::ZERO, 0.0),
        }
    }

    /// The same for light that facets refract; `scale` is that of the lobe.
    #[inline(always)]
    pub(super) fn refracted_by_facets(&self, wi: Vec3, scale: Vec3) -> (Vec3, f32) {
        let Self { bsdf, wo, .. } = self;
        let relative_ior = bsdf.dielectric.relative_ior;
        let facet = refracting_facet(&bsdf.lobe, (*wo, wi), relative_ior);
        let Some(RefractingFacet { facet_cosine, pdf, .. }) = facet else { return (Vec3::ZERO, 0.0) };
        let transmitted = share_below(self.facet_reflectances(facet_cosine).0);
        let refracts = 1.0 - self.reflection_probability(self.reflected_at(facet_cosine), facet_cosine);
        (scale * (transmitted * bsdf.lobe.masking(wi) * pdf), refracts * pdf)
    }
}
