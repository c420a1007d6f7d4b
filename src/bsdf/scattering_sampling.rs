//! Sampling of the lobes of [`Scattering`].
//!
//! A lobe is chosen by the luminance of its albedo, then a direction by the lobe: bounded visible normals of GGX for reflection and thin walls
//! ([`super::bounded_reflection`]); all visible normals (Heitz 2018) for volumes, whose facets reflect or refract by chance; the cosine for diffuse light; uniform directions for sheen. Densities and
//! weights are those of the whole mixture, as in multiple importance sampling with one sample (Veach, "Robust Monte Carlo Methods for
//! Light Transport Simulation", 1997, section 9.2.4). Smooth lobes are weighted by the probability of their choice.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::lobe_probabilities::LobeProbabilities;
use super::rough_transmission::refracted_at;
use super::scattering::{Scattering, TransmissionLobe};
use super::{bounded_reflection, ggx, share_below};
use crate::geometry::sin_cos_of_turn;

/// The lobe that a direction was sampled by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ScatterLobe {
    /// Specular reflection, of the coat or below it.
    SpecularReflection,
    /// Diffuse reflection or sheen.
    Diffuse,
    /// Specular transmission, of a thin wall or into a volume.
    Transmission,
    /// Diffuse transmission.
    DiffuseTransmission,
}

/// A direction sampled by [`Scattering::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterSample {
    /// Direction of the incident light, in the local shading frame.
    pub wi: Vec3,
    /// `f · |cos θ_i| / pdf`. Without η²: radiance counts as if media did not compress it.
    pub weight: Vec3,
    /// Density of the whole mixture over solid angle; 0 for smooth lobes.
    pub pdf: f32,
    /// The lobe.
    pub lobe: ScatterLobe,
    /// Whether the lobe is a mirror or clear glass.
    pub is_smooth: bool,
    /// Whether light passes in exactly its direction, `wi = -wo`.
    pub is_unbent: bool,
}

/// A direction sampled by one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LobeDirection {
    /// The only one of a smooth lobe.
    Smooth(ScatterSample),
    /// One of a rough lobe, in the local shading frame, whose weight is not known yet.
    Rough { wi: Vec3, lobe: ScatterLobe },
}

/// Directions of light that one sampled facet reflects and refracts, each with `f · |cos θ_i|` of its lobe over the density of the facet: the mean of
/// the weights is the albedo of the lobe. `None` where light is masked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FacetSample {
    /// Probability with which a ray that follows one of both is reflected.
    pub(crate) reflection_probability: f32,
    pub(crate) reflected: Option<(Vec3, Vec3)>,
    pub(crate) refracted: Option<(Vec3, Vec3)>,
}

/// The lobes that are chosen by their probability.
#[derive(Clone, Copy)]
enum LobeKind {
    Coat,
    Specular,
    Transmission,
    Diffuse,
    Sheen,
    DiffuseTransmission,
}

impl ScatterLobe {
    /// Whether the lobe sends light to the side of the view.
    pub(crate) fn is_reflective(self) -> bool {
        match self {
            Self::SpecularReflection | Self::Diffuse => true,
            Self::Transmission | Self::DiffuseTransmission => false,
        }
    }
}

impl ScatterSample {
    /// The sample in a direction with these [`Scattering::eval_and_pdf`]; `None` where its value is zero.
    pub(crate) fn of_rough(wi: Vec3, lobe: ScatterLobe, (value, pdf): (Vec3, f32)) -> Option<Self> {
        let weight = value / pdf;
        let is_lit = pdf > 0.0 && value != Vec3::ZERO;
        is_lit.then_some(Self { wi, weight, pdf, lobe, is_smooth: false, is_unbent: false })
    }
}

impl Scattering {
    /// Samples `wi` with a density close to `f · |cos θ_i|`. `u_lobe` and `u` are uniform in the unit interval and square. `None` where
    /// nothing is scattered or the sample is masked; its value is zero.
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Option<ScatterSample> {
        match self.sample_direction(u_lobe, u)? {
            LobeDirection::Smooth(sample) => Some(sample),
            LobeDirection::Rough { wi, lobe } => ScatterSample::of_rough(wi, lobe, self.eval_and_pdf(wi)),
        }
    }

    /// The direction of [`Scattering::sample`].
    pub(crate) fn sample_direction(&self, u_lobe: f32, u: Vec2) -> Option<LobeDirection> {
        self.direction_by(u_lobe, u)
    }

    /// The same, for lobes of which some are known to be absent where it is compiled.
    #[inline(always)]
    pub(super) fn direction_by(&self, u_lobe: f32, u: Vec2) -> Option<LobeDirection> {
        let smooth = |wi, weight, lobe| Some(LobeDirection::Smooth(smooth_sample(wi, weight, lobe)));
        let Chosen { choice, probability, rest } = self.choose(u_lobe)?;
        let (wi, lobe) = match choice {
            LobeKind::Coat => {
                let lobe = self.coat?;
                let local_from_coat = lobe.coat_from_local.transpose();
                if lobe.coat.is_smooth() {
                    let wi = local_from_coat * mirrored_at_normal(lobe.wo);
                    let weight = Vec3::splat(lobe.albedo / probability);
                    return smooth(wi, weight, ScatterLobe::SpecularReflection);
                }
                let alpha = Vec2::splat(lobe.coat.alpha);
                let wi = bounded_reflection::reflected(lobe.wo, alpha, ggx::disk_point(u))?;
                (local_from_coat * wi, ScatterLobe::SpecularReflection)
            }
            LobeKind::Specular if self.bsdf.lobe.is_smooth() => {
                let weight = self.albedos.specular / probability;
                return smooth(mirrored_at_normal(self.wo), weight, ScatterLobe::SpecularReflection);
            }
            LobeKind::Specular => self.sample_facet(rest, u)?,
            LobeKind::Transmission => {
                if let TransmissionLobe::Smooth { wi, is_unbent } = self.transmission {
                    let weight = self.albedos.transmission / probability;
                    let sample = smooth_sample(wi, weight, ScatterLobe::Transmission);
                    return Some(LobeDirection::Smooth(ScatterSample { is_unbent, ..sample }));
                }
                let wi = self.bsdf.transmission_lobe.reflected(self.wo, ggx::disk_point(u))?;
                (Vec3::new(wi.x, wi.y, -wi.z), ScatterLobe::Transmission)
            }
            LobeKind::Diffuse => (cosine_direction(u), ScatterLobe::Diffuse),
            LobeKind::Sheen => (uniform_direction(u), ScatterLobe::Diffuse),
            LobeKind::DiffuseTransmission => (-cosine_direction(u), ScatterLobe::DiffuseTransmission),
        };
        Some(LobeDirection::Rough { wi, lobe })
    }

    /// Samples a facet of a volume's surface, and both directions in which it sends light. [`super::Bsdf::is_refraction_smooth`] is false there.
    pub(crate) fn sample_both_at_facet(&self, u: Vec2) -> FacetSample {
        let Self { bsdf, wo, .. } = self;
        if wo.z <= 0.0 {
            return FacetSample::default();
        }
        let lobe = &bsdf.lobe;
        let half = lobe.visible_normal(*wo, ggx::disk_point(u));
        let facet_cosine = wo.dot(half);
        let factor = self.reflected_at(facet_cosine);
        let reflected = reflected_at(half, *wo).and_then(|wi| {
            let pdf = lobe.reflection_pdf(*wo, half);
            (pdf > 0.0).then(|| (wi, factor * (lobe.eval(*wo, wi, half) * wi.z / pdf)))
        });
        let refracted = match self.transmission {
            TransmissionLobe::Refracted { scale } => refracted_at(half, *wo, bsdf.dielectric.relative_ior)
                .map(|wi| {
                    let transmitted = share_below(self.facet_reflectances(facet_cosine).0);
                    (wi, scale * (transmitted * lobe.masking(wi)))
                }),
            _ => None,
        };
        let reflection_probability = self.reflection_probability(factor, facet_cosine);
        FacetSample { reflection_probability, reflected, refracted }
    }

    /// Samples a facet that the view sees; where the lobe transmits, too, `u_facet` decides between both.
    #[inline(always)]
    fn sample_facet(&self, u_facet: f32, u: Vec2) -> Option<(Vec3, ScatterLobe)> {
        let Self { bsdf, wo, .. } = self;
        if !matches!(self.transmission, TransmissionLobe::Refracted { .. }) {
            let wi = bsdf.lobe.reflected(*wo, ggx::disk_point(u))?;
            return Some((wi, ScatterLobe::SpecularReflection));
        }
        let half = bsdf.lobe.visible_normal(*wo, ggx::disk_point(u));
        let facet_cosine = wo.dot(half);
        if u_facet < self.reflection_probability(self.reflected_at(facet_cosine), facet_cosine) {
            return Some((reflected_at(half, *wo)?, ScatterLobe::SpecularReflection));
        }
        let wi = refracted_at(half, *wo, bsdf.dielectric.relative_ior)?;
        Some((wi, ScatterLobe::Transmission))
    }

    /// Density of the directions that sampled facets reflect, by their half vector.
    #[inline(always)]
    pub(super) fn specular_pdf(&self, half: Vec3) -> f32 {
        let lobe = &self.bsdf.lobe;
        // Facets that may also refract are sampled by all visible normals.
        match self.transmission {
            TransmissionLobe::Refracted { .. } => lobe.reflection_pdf(self.wo, half),
            _ => lobe.reflected_pdf(self.wo, half),
        }
    }

    #[inline(always)]
    fn choose(&self, u_lobe: f32) -> Option<Chosen> {
        let LobeProbabilities { coat, specular, transmission, diffuse, sheen, diffuse_transmission } =
            self.probabilities;
        let lobes = [
            (LobeKind::Coat, coat),
            (LobeKind::Specular, specular),
            (LobeKind::Transmission, transmission),
            (LobeKind::Diffuse, diffuse),
            (LobeKind::Sheen, sheen),
            (LobeKind::DiffuseTransmission, diffuse_transmission),
        ];
        let mut left = u_lobe;
        let mut chosen = None;
        for (choice, probability) in lobes {
            if probability > 0.0 {
                // The last lobe takes what rounding leaves.
                chosen = Some(Chosen { choice, probability, rest: left / probability });
                if left < probability {
                    break;
                }
                left -= probability;
            }
        }
        chosen
    }
}

struct Chosen {
    choice: LobeKind,
    probability: f32,
    /// Position of the sample within the lobe, from 0 to 1.
    rest: f32,
}

fn smooth_sample(wi: Vec3, weight: Vec3, lobe: ScatterLobe) -> ScatterSample {
    ScatterSample { wi, weight, pdf: 0.0, lobe, is_smooth: true, is_unbent: false }
}

fn mirrored_at_normal(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}

/// The direction mirrored at a facet; `None` below the surface.
fn reflected_at(half: Vec3, wo: Vec3) -> Option<Vec3> {
    let wi = half * (2.0 * wo.dot(half)) - wo;
    (wi.z > 0.0).then(|| wi.normalize())
}

/// A direction with density cos θ / π.
pub(crate) fn cosine_direction(u: Vec2) -> Vec3 {
    let disk = ggx::disk_point(u);
    // 1 − |disk|² is 1 − u.x, which cannot be negative.
    Vec3::new(disk.x, disk.y, (1.0 - u.x).sqrt())
}

/// A direction with density 1 / 2π.
fn uniform_direction(u: Vec2) -> Vec3 {
    let sine = (1.0 - u.x * u.x).sqrt();
    let (sin, cos) = sin_cos_of_turn(2.0 * PI * u.y);
    Vec3::new(sine * cos, sine * sin, u.x)
}
