//! Frosted glass. Without glossy samples, one sampled ray follows the transmitted lobe. From the
//! denser side of volumes, rays follow facets, which reflect and refract; those of glossy samples do, too.
//!
//! So what stands behind the glass is seen, blurred and bent by both of its surfaces; a lookup knows only one of them. Where the ray reaches the environment
//! it finds the prefiltered lobe, which has no noise.

use glam::{Vec2, Vec3};

use super::environment::transmitted_lobe;
use super::environment_shadows::on_side;
use super::glossy::seeds;
use super::secondary_rays::ChildRay;
use super::shading::Shading;
use super::traced_share::{PREFILTERED_ROUGHNESS, traced_share};
use crate::bsdf::{AlbedoTerms, Bsdf, FacetSample, Scattering};
use crate::geometry::{Ray, smoothstep};
use crate::integrator::prefiltered_lobe::PrefilteredLobe;
use crate::integrator::random::Purpose;
use crate::integrator::tracing::Tracer;
use crate::integrator::{ColorChannels, RayKind, RayState, Seed};

/// The deepest bounce at which a facet sends a reflected and a refracted ray; deeper ones send either.
const MAX_SPLIT_DEPTH: u32 = 1;

/// Between these roughnesses the share of facets rises from 0 to 1. Below, mirror rays may follow the reflected lobe.
const FACET_ROUGHNESS: [f32; 2] = [PREFILTERED_ROUGHNESS, 0.8];

/// The lobes of one or of all colour channels.
struct FacetLobes<'b> {
    channels: ColorChannels,
    bsdf: &'b Bsdf,
    scattering: Scattering,
}

/// A sampled facet: its point, the number that decides between reflection and refraction, and the share of the light that it stands for.
#[derive(Clone, Copy)]
struct FacetPoint {
    u: Vec2,
    u_facet: f32,
    share: f32,
    seed: Seed,
}

impl Tracer<'_, '_> {
    /// Whether sampled rays follow the transmitted lobe of a surface. The deepest surfaces look the environment up.
    pub(super) fn follows_transmission(&self, bsdf: &Bsdf, state: &RayState) -> bool {
        let is_wide = traced_share(bsdf.widest_transmission_roughness()) < 1.0;
        is_wide && state.depth < self.context.settings.max_depth && self.context.follows_frosted_glass()
    }

    /// Sends one sampled ray along each transmitted lobe.
    pub(super) fn sample_frosted_glass(&mut self, shading: &Shading<'_, '_>) {
        let share = 1.0 - shading.facet_share;
        if share == 0.0 {
            return;
        }
        for (index, (channels, bsdf)) in shading.transmission_lobes().enumerate() {
            let weight = shading.weight_below * shading.albedos.transmission * channels.mask() * share;
            if !self.may_send(shading.state, weight) {
                continue;
            }
            let (u, _) = self.point_of_frosted_glass(shading, index);
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

    /// Share of the light of sampled rays that is sent by facets instead: by a sampled facet, which reflects and refracts it, on the denser side of a
    /// frosted volume. What facets reflect stays in the volume until it leaves.
    ///
    /// Smoother surfaces are left to lookups, which lose little of the light and have no noise.
    pub(super) fn facet_share(&self, shading: &Shading<'_, '_>) -> f32 {
        let is_glossy = self.context.settings.glossy_samples > 0;
        let is_followed = is_glossy || shading.follows_transmission;
        let is_rough = || shading.transmission_lobes().all(|(_, bsdf)| !bsdf.is_refraction_smooth());
        if !is_followed || !shading.is_on_denser_side() || !is_rough() {
            return 0.0;
        }
        let is_looked_up = !is_glossy && !self.context.follows_rough_reflection();
        if is_looked_up { smoothstep(FACET_ROUGHNESS, shading.bsdf.widest_roughness()) } else { 1.0 }
    }

    /// Sends the rays of [`Tracer::facet_share`] for each transmitted lobe: one sampled ray, or glossy samples.
    pub(super) fn follow_facets(&mut self, shading: &Shading<'_, '_>) {
        let rays = self.glossy_rays(shading.state);
        let share = shading.facet_share / rays.max(1) as f32;
        for (index, (channels, bsdf)) in shading.transmission_lobes().enumerate() {
            let scattering = if shading.dispersed.is_none() {
                *shading.scattering()
            } else {
                Scattering::new(*bsdf, shading.wo, None)
            };
            let lobes = FacetLobes { channels, bsdf, scattering };
            if rays == 0 {
                let (u, u_facet) = self.point_of_frosted_glass(shading, index);
                let seed = shading.state.seed.child(Purpose::Refraction, 0, 1);
                self.follow_facet(shading, &lobes, FacetPoint { u, u_facet, share, seed });
            }
            for seed in seeds(shading.state, Purpose::Refraction, rays) {
                let (u, u_facet) = (seed.point(Purpose::Refraction), seed.random(Purpose::Facet));
                self.follow_facet(shading, &lobes, FacetPoint { u, u_facet, share, seed });
            }
        }
    }

    /// Sends the rays of one facet.
    fn follow_facet(&mut self, shading: &Shading<'_, '_>, lobes: &FacetLobes<'_>, point: FacetPoint) {
        let FacetPoint { u, u_facet, share, seed } = point;
        let FacetSample { reflection_probability, reflected, refracted } =
            lobes.scattering.sample_both_at_facet(u);
        let mut send = |kind, sampled: Option<(Vec3, Vec3)>, probability: f32, seed| {
            let Some((wi, lobe_weight)) = sampled else { return };
            let weight = shading.weight_below * lobe_weight * lobes.channels.mask() * (share / probability);
            if self.may_send(shading.state, weight) {
                self.send_from_facet(shading, lobes, (kind, wi), (weight, seed));
            }
        };
        if shading.state.depth <= MAX_SPLIT_DEPTH {
            send(RayKind::Reflection, reflected, 1.0, seed.child(Purpose::Reflection, 0, 1));
            send(RayKind::Refraction, refracted, 1.0, seed);
        } else if u_facet < reflection_probability {
            send(RayKind::Reflection, reflected, reflection_probability, seed);
        } else {
            send(RayKind::Refraction, refracted, 1.0 - reflection_probability, seed);
        }
    }

    /// Sends a ray in the local direction `wi`.
    fn send_from_facet(
        &mut self,
        shading: &Shading<'_, '_>,
        lobes: &FacetLobes<'_>,
        (kind, wi): (RayKind, Vec3),
        (weight, seed): (Vec3, Seed),
    ) {
        let (point, is_refracted) = (shading.point, kind == RayKind::Refraction);
        let origin = if is_refracted { point.origin_inside() } else { point.origin_outside() };
        let direction = (shading.world_from_local * wi).normalize();
        let direction = on_side(direction, point.geometric_normal, !is_refracted);
        // With glossy samples the environment is seen in the sampled direction.
        let is_looked_up = is_refracted && self.context.settings.glossy_samples == 0;
        let environment_lobe = is_looked_up.then(|| {
            // Where the smooth surface would reflect totally, it is seen around that direction: small bright lights would be specks.
            let around = PrefilteredLobe { direction, roughness: 0.5 * shading.material.roughness };
            refracted_lobe(shading, lobes.bsdf).unwrap_or(around)
        });
        let ray = Ray::new(origin, direction);
        let child = ChildRay::sampled(ray, weight, kind, (lobes.channels, seed));
        self.send(shading, ChildRay { environment_lobe, ..child });
    }
}

/// The lobes that scatter the light of lamps on frosted glass, seen from within a volume.
///
/// Such light arrives unbent, but from lamps within the volume. Between the media in the other order it is reflected as on the same path outside, and nowhere totally.
pub(super) struct UnbentLightLobes {
    bsdf: Bsdf,
    terms: AlbedoTerms,
}

impl UnbentLightLobes {
    /// The lobes, and their share; `None` on other surfaces.
    pub(super) fn of(shading: &Shading<'_, '_>) -> Option<(Self, f32)> {
        let share = 1.0 - shading.traced_share_transmitted;
        if !shading.is_on_denser_side() || !shading.follows_transmission || share == 0.0 {
            return None;
        }
        let [outside, inside] = shading.iors;
        let bsdf = Bsdf::new(shading.material, inside, outside);
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
