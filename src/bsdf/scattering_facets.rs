//! The specular lobes of [`Scattering`] alone, as its facets reflect and refract light.

use glam::Vec3;

use super::rough_transmission::{RefractingFacet, refracting_facet};
use super::scattering::{Scattering, TransmissionLobe};
use super::share_below;
use crate::geometry::normalized_or;

impl Scattering {
    /// f · |cos θ_i| of the specular lobe alone, for light from the side of the view, and the density of a facet that reflects it.
    #[inline(always)]
    pub(super) fn reflected_by_facets(&self, wi: Vec3) -> (Vec3, f32) {
        let Self { bsdf, wo, .. } = self;
        let half = normalized_or(*wo + wi, Vec3::Z);
        let facet_cosine = wo.dot(half);
        let factor = self.reflected_at(facet_cosine);
        let reflects = self.reflection_probability(factor, facet_cosine);
        (factor * (bsdf.lobe.eval(*wo, wi, half) * wi.z), reflects * bsdf.lobe.reflection_pdf(*wo, half))
    }

    /// The same for light from the other side, which facets refract; `scale` is that of the lobe.
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

    /// f · |cos θ_i| of a rough specular lobe and of the lobe that its facets refract, and the density of [`Scattering::sample_facet`].
    pub(super) fn by_facets(&self, wi: Vec3) -> (Vec3, f32) {
        match self.transmission {
            _ if wi.z > 0.0 => self.reflected_by_facets(wi),
            TransmissionLobe::Refracted { scale } => self.refracted_by_facets(wi, scale),
            _ => (Vec3::ZERO, 0.0),
        }
    }
}
