//! All lobes of a surface towards one view, for path tracing: their values, densities and samples.
//!
//! The lobes are those of [`Bsdf`] under a [`Coat`]: coat over sheen over specular, diffuse and transmitted light. Diffuse lobes are
//! scaled by what the whole specular lobe leaves towards the viewer, so that the values of all lobes integrate to their [`Albedos`]. Light
//! through the rough surface of a volume is a lobe, too ([`super::rough_transmission`]).
//!
//! Smooth lobes have no density. They are sampled on their own ([`super::scattering_sampling`]).

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::coat_lobe::{CoatLobe, OrientedCoat};
use super::lobe_probabilities::LobeProbabilities;
use super::multiple_scattering::Compensation;
use super::rough_transmission::{self, RefractingFacet};
use super::rough_volume_albedo;
use super::smooth_lobes::SmoothLobes;
use super::thin_film::FilmReflectances;
use super::{AlbedoTerms, Albedos, Bsdf, anisotropic_albedo, fresnel, ggx, isotropic_albedo, share_below};
use crate::color::luminance;
use crate::geometry::normalized_or;

/// Density of directions that are uniform over a hemisphere.
const UNIFORM: f32 = 0.5 * FRAC_1_PI;

/// The lobes of a surface at one point towards one view.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    pub(super) bsdf: Bsdf,
    pub(super) wo: Vec3,
    pub(super) film: Option<FilmReflectances>,
    pub(super) compensation: Compensation,
    /// Below the coat.
    pub(super) albedos: Albedos,
    /// Share of the light below sheen and coat that leaves the surface.
    pub(super) below: f32,
    pub(super) coat: Option<CoatLobe>,
    pub(super) transmission: TransmissionLobe,
    pub(super) probabilities: LobeProbabilities,
}

/// How light is transmitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TransmissionLobe {
    None,
    /// In one direction. Thin walls and equal media leave it unbent.
    Smooth {
        wi: Vec3,
        is_unbent: bool,
    },
    /// A thin wall transmits as it would reflect; `scale` multiplies the lobe.
    Thin {
        scale: Vec3,
    },
    /// Facets refract; `scale` multiplies what they transmit.
    Refracted {
        scale: Vec3,
    },
}

impl Scattering {
    /// The lobes of `bsdf` towards `wo`, in the local shading frame, below a coat with its own frame.
    #[inline]
    pub fn new(bsdf: Bsdf, wo: Vec3, coat: Option<OrientedCoat>) -> Self {
        Self::by(bsdf, wo, coat, || bsdf.albedo_terms(wo))
    }

    /// The same without a coat, with the terms of [`Bsdf::albedo_terms`].
    pub(crate) fn by_terms(bsdf: Bsdf, wo: Vec3, terms: AlbedoTerms) -> Self {
        Self::by(bsdf, wo, None, || terms)
    }

    #[inline(always)]
    fn by(bsdf: Bsdf, wo: Vec3, coat: Option<OrientedCoat>, terms: impl Fn() -> AlbedoTerms) -> Self {
        let terms = bsdf.scattering_terms(wo, terms);
        let coat = coat.map(|coat| CoatLobe::new(coat, wo));
        let mut scattering = Self::reflecting(bsdf, wo, terms, coat);
        if wo.z > 0.0 {
            scattering.transmission = scattering.transmission_lobe(terms);
            scattering.probabilities = scattering.lobe_probabilities();
        }
        scattering
    }

    /// [`Scattering::new`] for lobes without layers and transmission, by [`Bsdf::scattering_terms`]. For loops over lanes.
    #[inline(always)]
    pub(super) fn opaque(bsdf: Bsdf, wo: Vec3, terms: AlbedoTerms) -> Self {
        let scattering = Self::reflecting(bsdf, wo, terms, None);
        let probabilities = scattering.lobe_probabilities();
        let none = LobeProbabilities::default();
        Self { probabilities: if wo.z > 0.0 { probabilities } else { none }, ..scattering }
    }

    /// The lobes but for transmission and probabilities.
    #[inline(always)]
    fn reflecting(bsdf: Bsdf, wo: Vec3, terms: AlbedoTerms, coat: Option<CoatLobe>) -> Self {
        let film = bsdf.film_reflectances(wo.z);
        let below_coat = coat.map_or(1.0, |lobe| lobe.coat.transmittance(lobe.wo.z));
        Self {
            bsdf,
            wo,
            film,
            compensation: bsdf.compensation(film.as_ref(), terms),
            albedos: bsdf.facet_albedos(wo, terms) * below_coat,
            below: below_coat * bsdf.sheen.map_or(1.0, |sheen| sheen.below(wo.z)),
            coat,
            transmission: TransmissionLobe::None,
            probabilities: LobeProbabilities::default(),
        }
    }

    /// f · |cos θ_i| of all lobes but the smooth ones.
    ///
    /// The coat counts wherever light is above it and above the geometric surface, by the cosine to its own normal. Below a coat the other lobes count where
    /// their normal and the geometric one agree about the side of `wi`; without one that is left to the caller.
    pub fn eval(&self, wi: Vec3) -> Vec3 {
        self.values(wi, SmoothLobes::Without).0
    }

    /// The same with smooth reflection and smooth thin walls evaluated with α = 0.002, for lights that rays cannot hit.
    pub fn eval_with_smooth(&self, wi: Vec3) -> Vec3 {
        self.values(wi, SmoothLobes::Sharpest).0
    }

    /// f · |cos θ_i| of diffuse transmission alone, for light from the other side.
    pub fn eval_diffuse_transmission(&self, wi: Vec3) -> Vec3 {
        self.albedos.diffuse_transmission * ((-wi.z).max(0.0) * FRAC_1_PI)
    }

    /// Density over solid angle with which [`Scattering::sample`] samples `wi`; smooth lobes have none.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        self.eval_and_pdf(wi).1
    }

    /// [`Scattering::eval`] and [`Scattering::pdf`] at once, since they share terms.
    pub fn eval_and_pdf(&self, wi: Vec3) -> (Vec3, f32) {
        self.values(wi, SmoothLobes::Without)
    }

    /// Whether all lobes are smooth: then no direction has a density.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        let LobeProbabilities { coat, specular, transmission, diffuse, sheen, diffuse_transmission } =
            self.probabilities;
        diffuse + sheen + diffuse_transmission == 0.0
            && (coat == 0.0 || self.coat.is_none_or(|lobe| lobe.coat.is_smooth()))
            && (specular == 0.0 || self.bsdf.lobe.is_smooth())
            && (transmission == 0.0 || matches!(self.transmission, TransmissionLobe::Smooth { .. }))
    }

    /// The albedo of what passes a clear thin wall unbent; `None` for any other surface.
    pub(crate) fn clear_wall_transmittance(&self) -> Option<Vec3> {
        let is_clear = self.bsdf.thin && matches!(self.transmission, TransmissionLobe::Smooth { .. });
        is_clear.then_some(self.albedos.transmission)
    }

    /// Probability with which [`Scattering::sample`] samples the diffuse lobe.
    pub fn diffuse_probability(&self) -> f32 {
        self.probabilities.diffuse
    }

    /// Directional albedos of the lobes below the coat, dimmed by it.
    pub fn albedos(&self) -> Albedos {
        self.albedos
    }

    /// Share of uniform light that the coat reflects. It dims what lies below, emission included, by the same share.
    #[inline(always)]
    pub fn coat_albedo(&self) -> f32 {
        self.coat.map_or(0.0, |lobe| lobe.albedo)
    }

    fn transmission_lobe(&mut self, terms: AlbedoTerms) -> TransmissionLobe {
        let Self { bsdf, wo, albedos, .. } = *self;
        if albedos.transmission == Vec3::ZERO {
            return TransmissionLobe::None;
        }
        if bsdf.thin {
            return if bsdf.is_transmission_smooth() {
                TransmissionLobe::Smooth { wi: -wo, is_unbent: true }
            } else {
                TransmissionLobe::Thin { scale: albedos.transmission / bsdf.transmission_lobe_total(wo) }
            };
        }
        let relative_ior = bsdf.dielectric.relative_ior;
        if bsdf.is_refraction_smooth() {
            return match bsdf.refract(wo) {
                Some(_) if relative_ior == 1.0 => TransmissionLobe::Smooth { wi: -wo, is_unbent: true },
                Some(wi) => TransmissionLobe::Smooth { wi, is_unbent: false },
                None => {
                    self.conserve(bsdf.lobe_albedos(wo, terms).0 / self.compensation.dielectric, 0.0);
                    TransmissionLobe::None
                }
            };
        }
        self.refracted_lobe(terms)
    }

    /// The lobe of facets that refract; reflection shares its compensation.
    fn refracted_lobe(&mut self, terms: AlbedoTerms) -> TransmissionLobe {
        let Self { bsdf, wo, .. } = *self;
        let reflected = bsdf.lobe_albedos(wo, terms).0 / self.compensation.dielectric;
        let relative_ior = bsdf.dielectric.relative_ior;
        // Tables know the exact curve alone.
        let transmitted = if self.film.is_none() && !bsdf.dielectric.is_nearly_exact() {
            let passes = |facet_cosine: f32| share_below(bsdf.dielectric.reflectance(facet_cosine));
            rough_volume_albedo::transmitted(&bsdf.lobe, wo, relative_ior, passes)
        } else {
            let both = rough_volume_albedo::reflected_and_transmitted(&bsdf.lobe, wo, relative_ior);
            // Films change what facets transmit by the share that the whole lobe leaves.
            let (bare, covered) = (terms.total - terms.exact, terms.total - reflected.max_element());
            let share = if bare > 1e-3 { (covered / bare).clamp(0.0, 1.0 / bare) } else { 1.0 };
            positive(both - terms.exact) * share
        };
        TransmissionLobe::Refracted { scale: self.conserve(reflected, transmitted) }
    }

    /// Gives what single scattering loses back to both lobes of a volume, in proportion: facets reflect and transmit these shares. Returns the
    /// scale of transmitted light.
    fn conserve(&mut self, reflected: Vec3, transmitted: f32) -> Vec3 {
        let bsdf = self.bsdf;
        let conserving = 1.0 / (reflected.max_element() + transmitted);
        // The dielectric is a mix of a transmitting and an opaque one.
        let factor = self.compensation.dielectric.lerp(Vec3::splat(conserving), bsdf.transmission);
        let dielectric = (1.0 - bsdf.metallic) * self.below;
        self.albedos.specular += reflected * (factor - self.compensation.dielectric) * dielectric;
        self.compensation.dielectric = factor;
        let scale = bsdf.base_color * (bsdf.transmission * conserving * dielectric);
        self.albedos.transmission = scale * transmitted;
        scale
    }

    #[inline(always)]
    fn lobe_probabilities(&self) -> LobeProbabilities {
        let Albedos { specular, diffuse, transmission, diffuse_transmission, sheen } = self.albedos;
        let transmitted =
            if self.transmission == TransmissionLobe::None { 0.0 } else { luminance(transmission) };
        let facet_decides = matches!(self.transmission, TransmissionLobe::Refracted { .. });
        LobeProbabilities {
            coat: self.coat_albedo(),
            specular: luminance(specular) + if facet_decides { transmitted } else { 0.0 },
            transmission: if facet_decides { 0.0 } else { transmitted },
            diffuse: luminance(diffuse),
            sheen: luminance(sheen),
            diffuse_transmission: luminance(diffuse_transmission),
        }
        .normalized()
    }

    /// f · |cos θ_i| and the density.
    fn values(&self, wi: Vec3, smooth: SmoothLobes) -> (Vec3, f32) {
        if self.wo.z <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        // No sampled ray follows the light of lamps, so that the shading normal alone decides where no light passes the surface.
        let is_opaque =
            self.transmission == TransmissionLobe::None && self.albedos.diffuse_transmission == Vec3::ZERO;
        let is_lamp_on_opaque = smooth == SmoothLobes::Sharpest && is_opaque;
        let agrees = is_lamp_on_opaque || self.coat.is_none_or(|coat| coat.is_above(wi) == (wi.z > 0.0));
        let (value, pdf) = if wi.z > 0.0 && agrees {
            self.reflected(wi, smooth)
        } else if wi.z < 0.0 && agrees {
            self.transmitted(wi, smooth)
        } else {
            (Vec3::ZERO, 0.0)
        };
        let (by_coat, coat_pdf) = self.coated(wi, smooth);
        (value + by_coat, pdf + coat_pdf)
    }

    fn coated(&self, wi: Vec3, smooth: SmoothLobes) -> (f32, f32) {
        let Some(coat) = &self.coat else { return (0.0, 0.0) };
        let (value, pdf) = coat.eval_and_pdf(wi, smooth);
        (value, self.probabilities.coat * pdf)
    }

    /// For light from the side of the view.
    #[inline(always)]
    pub(super) fn reflected(&self, wi: Vec3, smooth: SmoothLobes) -> (Vec3, f32) {
        let Self { bsdf, wo, albedos, probabilities, .. } = self;
        let mut value = albedos.diffuse * (wi.z * FRAC_1_PI);
        let mut pdf = probabilities.diffuse * wi.z * FRAC_1_PI + probabilities.sheen * UNIFORM;
        if let Some(sheen) = &bsdf.sheen {
            value += sheen.eval(*wo, wi) * (wi.z * self.below_coat());
        }
        let is_smooth = bsdf.lobe.is_smooth();
        if !is_smooth || smooth == SmoothLobes::Sharpest {
            let half = normalized_or(*wo + wi, Vec3::Z);
            let facet_cosine = wo.dot(half);
            let factor = self.reflected_at(facet_cosine);
            value += factor * (bsdf.lobe.eval(*wo, wi, half) * wi.z);
            if !is_smooth {
                let reflects = self.reflection_probability(factor, facet_cosine);
                pdf += probabilities.specular * reflects * self.specular_pdf(half);
            }
        }
        (value, pdf)
    }

    /// For light from the other side.
    fn transmitted(&self, wi: Vec3, smooth: SmoothLobes) -> (Vec3, f32) {
        let Self { bsdf, wo, albedos, probabilities, .. } = self;
        let mut value = albedos.diffuse_transmission * (-wi.z * FRAC_1_PI);
        let mut pdf = probabilities.diffuse_transmission * -wi.z * FRAC_1_PI;
        let lobe = &bsdf.transmission_lobe;
        // A thin wall transmits as it would reflect the mirrored direction.
        let mirrored = Vec3::new(wi.x, wi.y, -wi.z);
        let half = normalized_or(*wo + mirrored, Vec3::Z);
        match self.transmission {
            TransmissionLobe::Smooth { .. } if bsdf.thin && smooth == SmoothLobes::Sharpest => {
                value += albedos.transmission * (lobe.eval(*wo, mirrored, half) * mirrored.z);
            }
            TransmissionLobe::None | TransmissionLobe::Smooth { .. } => {}
            TransmissionLobe::Thin { scale } => {
                value += scale * (lobe.eval(*wo, mirrored, half) * mirrored.z);
                pdf += probabilities.transmission * lobe.reflected_pdf(*wo, half);
            }
            TransmissionLobe::Refracted { scale } => {
                let relative_ior = bsdf.dielectric.relative_ior;
                let facet = rough_transmission::refracting_facet(&bsdf.lobe, (*wo, wi), relative_ior);
                if let Some(RefractingFacet { facet_cosine, pdf: refracted_pdf, .. }) = facet {
                    let transmitted = share_below(self.facet_reflectances(facet_cosine).0);
                    value += scale * (transmitted * bsdf.lobe.masking(wi) * refracted_pdf);
                    let factor = self.reflected_at(facet_cosine);
                    let refracts = 1.0 - self.reflection_probability(factor, facet_cosine);
                    pdf += probabilities.specular * refracts * refracted_pdf;
                }
            }
        }
        (value, pdf)
    }

    /// Fresnel factors of the dielectric and of the metal at a facet.
    #[inline(always)]
    pub(super) fn facet_reflectances(&self, facet_cosine: f32) -> (Vec3, Vec3) {
        self.bsdf.reflectances(self.film.as_ref(), facet_cosine)
    }

    /// Factor of the specular lobe at a facet.
    #[inline(always)]
    pub(super) fn reflected_at(&self, facet_cosine: f32) -> Vec3 {
        let reflectances = self.facet_reflectances(facet_cosine);
        self.bsdf.specular_factor(reflectances, &self.compensation) * self.below
    }

    /// Probability that a sampled facet reflects instead of refracting; `factor` is [`Scattering::reflected_at`] it.
    #[inline(always)]
    pub(super) fn reflection_probability(&self, factor: Vec3, facet_cosine: f32) -> f32 {
        let TransmissionLobe::Refracted { scale } = self.transmission else { return 1.0 };
        let transmitted = luminance(scale) * share_below(self.facet_reflectances(facet_cosine).0);
        let reflected = luminance(factor);
        if transmitted > 0.0 { reflected / (reflected + transmitted) } else { 1.0 }
    }

    #[inline(always)]
    fn below_coat(&self) -> f32 {
        self.coat.map_or(1.0, |lobe| 1.0 - lobe.albedo)
    }
}

impl Bsdf {
    /// The albedo terms of [`Scattering`]: those of a mirror where the specular lobe is smooth, so that its weights are exact, and else `rough`.
    #[inline(always)]
    pub(super) fn scattering_terms(&self, wo: Vec3, rough: impl Fn() -> AlbedoTerms) -> AlbedoTerms {
        if self.lobe.is_smooth() { self.mirror_terms(wo) } else { rough() }
    }

    /// The albedo terms of a mirror.
    #[inline(always)]
    fn mirror_terms(&self, wo: Vec3) -> AlbedoTerms {
        let schlick = fresnel::schlick_weight(wo.z);
        AlbedoTerms { total: 1.0, schlick, exact: fresnel::exact(wo.z, self.dielectric.relative_ior) }
    }

    /// Albedo of the transmission lobe of a thin wall for F = 1.
    fn transmission_lobe_total(&self, wo: Vec3) -> f32 {
        match self.transmission_lobe.anisotropic {
            Some(ggx) => anisotropic_albedo::schlick_terms(ggx, wo).total,
            None => isotropic_albedo::total(wo.z, self.transmission_lobe.roughness),
        }
    }

    /// Whether facets of a volume hardly change the refracted direction: they are smooth or bend too little.
    pub(crate) fn is_refraction_smooth(&self) -> bool {
        let bent = super::transmission_roughness_scale(self.dielectric.relative_ior);
        let roughness = bent * self.lobe.widest_roughness();
        self.lobe.is_smooth() || roughness * roughness <= ggx::MIN_ALPHA
    }
}

fn positive(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests;
