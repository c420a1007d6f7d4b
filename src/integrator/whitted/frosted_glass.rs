//! Frosted glass without glossy samples: one sampled ray follows the transmitted lobe where shadow rays decide about the environment's light.
//!
//! So what stands behind the glass is seen, blurred and bent by both of its surfaces; a lookup knows only one of them. Where the ray reaches the environment
//! it finds the prefiltered lobe, which has no noise.

use glam::Vec3;

use super::environment::transmitted_lobe;
use super::environment_shadows::on_side;
use super::prefiltered_lobe::PrefilteredLobe;
use super::secondary_rays::ChildRay;
use super::shading::Shading;
use super::traced_share::traced_share;
use super::tracer::Tracer;
use crate::bsdf::{AlbedoTerms, Bsdf};
use crate::geometry::Ray;
use crate::integrator::random::Purpose;
use crate::integrator::{RayKind, RayState};

impl Tracer<'_, '_> {
    /// Share of a transmitted lobe that a sampled ray follows: that of the environment's light that shadow rays decide about. The deepest surfaces
    /// look the environment up, as narrow lobes and glossy samples do without.
    pub(super) fn sampled_transmission_share(&self, bsdf: &Bsdf, state: &RayState) -> f32 {
        let settings = &self.context.settings;
        let is_followed = settings.glossy_samples == 0 && state.depth < settings.max_depth;
        let is_wide = traced_share(bsdf.widest_transmission_roughness()) < 1.0;
        if is_followed && is_wide { self.context.occluded_share } else { 0.0 }
    }

    /// Sends one sampled ray along each transmitted lobe.
    pub(super) fn sample_frosted_glass(&mut self, shading: &Shading<'_, '_>) {
        if shading.sampled_transmission_share == 0.0 {
            return;
        }
        let sequence = self.sequences[shading.state.sample as usize];
        for (index, (channels, bsdf)) in shading.transmission_lobes().enumerate() {
            let share = shading.sampled_transmission_share;
            let weight = shading.weight_below * shading.albedos.transmission * channels.mask() * share;
            if !self.may_send(shading.state, weight) {
                continue;
            }
            let u = self.point_of_frosted_glass(&sequence, shading.signature, index);
            let Some(wi) = bsdf.sample_transmission(shading.wo, u) else { continue };
            let direction = (shading.world_from_local * wi).normalize();
            let direction = on_side(direction, shading.point.geometric_normal, false);
            let ray = Ray::new(shading.point.origin_inside(), direction);
            let environment_lobe = refracted_lobe(shading, bsdf);
            let seed = shading.state.seed.child(Purpose::Refraction, 0, 1);
            let child = ChildRay::sampled(ray, weight, RayKind::Refraction, (channels, seed));
            self.send(shading, ChildRay { environment_lobe, ..child });
        }
    }
}

/// The lobes that scatter the light of lamps on frosted glass, seen from within a volume.
///
/// Such light arrives unbent. Between the media in the other order it is reflected as on the same path outside, and nowhere totally.
pub(super) struct UnbentLightLobes {
    bsdf: Bsdf,
    terms: AlbedoTerms,
}

impl UnbentLightLobes {
    /// The lobes, and their share; `None` on other surfaces.
    pub(super) fn of(shading: &Shading<'_, '_>) -> Option<(Self, f32)> {
        let share = shading.sampled_transmission_share * (1.0 - shading.traced_share_transmitted);
        let material = shading.material;
        let is_within = !material.thin && material.transmission > 0.0 && shading.relative_ior() < 1.0;
        if !is_within || share == 0.0 {
            return None;
        }
        let [outside, inside] = shading.iors;
        let bsdf = Bsdf::new(material, inside, outside);
        Some((Self { terms: bsdf.albedo_terms(shading.wo), bsdf }, share))
    }

    /// Value of the lobes for a local direction of light.
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.bsdf.eval_by(wo, wi, self.terms)
    }
}

/// The prefiltered lobe of light that one surface transmits.
fn refracted_lobe(shading: &Shading<'_, '_>, bsdf: &Bsdf) -> Option<PrefilteredLobe> {
    let lobe = transmitted_lobe(shading, bsdf)?;
    if shading.material.thin {
        return Some(lobe);
    }
    let cosine = lobe.direction.dot(shading.point.shading_normal).abs();
    let roughness =
        refracted_roughness(shading.material.roughness, shading.relative_ior(), [shading.wo.z, cosine]);
    Some(PrefilteredLobe { roughness, ..lobe })
}

/// Roughness of the mirror whose lobe is as wide as that of refracted light, to first order. `cosines` are those of the view and of the refracted direction.
///
/// Facets that turn by δ turn mirrored light by 2 δ, and refracted light by |cos θ / (n cos θ') − 1| δ (Snell).
fn refracted_roughness(roughness: f32, relative_ior: f32, cosines: [f32; 2]) -> f32 {
    let turned = (cosines[0] / (relative_ior * cosines[1]) - 1.0).abs();
    if turned < 2.0 { roughness * (0.5 * turned).sqrt() } else { roughness }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_blurs_less_than_reflection() {
        // Head-on, glass turns light by a third of the facets' turn on the way in, and by half of it on the way out.
        let head_on = |ior| refracted_roughness(0.6, ior, [1.0, 1.0]);
        assert!((head_on(1.5) - 0.6 * libm::sqrtf(1.0 / 6.0)).abs() < 1e-6);
        assert!((head_on(1.0 / 1.5) - 0.6 * 0.5).abs() < 1e-6);
        assert!(head_on(1.0).abs() < 1e-6);
        // Near total reflection it is spread without bound, and mirrors are the limit.
        for cosine in [1e-3, 0.0] {
            assert_eq!(refracted_roughness(0.6, 1.0 / 1.5, [0.8, cosine]), 0.6);
        }
        assert_eq!(refracted_roughness(0.6, 1.0, [0.0, 0.0]), 0.6);
    }
}
