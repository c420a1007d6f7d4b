//! Several rays for a rough mirror, coat or frosted glass (Cook, Porter, Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984).
//!
//! With glossy samples, sampled rays follow the whole lobe and the prefiltered environment is not looked up. The first rough
//! surface of a path sends that many rays, in proportion to its weight where it is seen in mirrors or through clear glass. Later
//! ones send one each: the rays from the first one average what these reflect. On the denser side of frosted volumes,
//! `frosted_glass` sends them by facets.

use super::environment_shadows::on_side;
use super::secondary_rays::ChildRay;
use super::shading::Shading;
use crate::geometry::Ray;
use crate::integrator::random::Purpose;
use crate::integrator::tracing::Tracer;
use crate::integrator::{RayKind, RayState, Seed};

impl Tracer<'_, '_> {
    /// Number of rays that follow a rough lobe of a surface; 0 where the prefiltered environment is looked up instead.
    pub(super) fn glossy_rays(&self, state: &RayState) -> u32 {
        match self.context.settings.glossy_samples {
            0 => 0,
            // A faint reflection of the surface needs fewer.
            samples if !state.is_sampled => {
                let wanted = (samples as f32 * state.weight.max_element()).ceil();
                if wanted < samples as f32 { (wanted as u32).max(1) } else { samples }
            }
            _ => 1,
        }
    }

    /// Sends sampled rays along a rough specular lobe. Returns whether it did; a mirror ray follows all other lobes.
    pub(super) fn scatter_reflection(&mut self, shading: &Shading<'_, '_>) -> bool {
        let rays = self.glossy_rays(shading.state);
        if rays == 0 || shading.bsdf.is_smooth() {
            return false;
        }
        for seed in seeds(shading.state, Purpose::Reflection, rays) {
            let u = seed.point(Purpose::Reflection);
            let sampled = shading.bsdf.sample_reflection(shading.wo, shading.terms, u);
            let Some((wi, lobe_weight)) = sampled else { continue };
            let direction = (shading.world_from_local * wi).normalize();
            let direction = on_side(direction, shading.point.geometric_normal, true);
            let weight = shading.weight_below * lobe_weight / rays as f32;
            if self.may_send(shading.state, weight) {
                let ray = Ray::new(shading.point.origin_outside(), direction);
                let channels = shading.state.channels;
                self.send(shading, ChildRay::sampled(ray, weight, RayKind::Reflection, (channels, seed)));
            }
        }
        true
    }

    /// Sends sampled rays along the lobe of a rough coat. Returns whether it did.
    pub(super) fn scatter_coat(&mut self, shading: &Shading<'_, '_>) -> bool {
        let rays = self.glossy_rays(shading.state);
        let Some(coat) = shading.coat.filter(|coat| rays > 0 && !coat.is_smooth()) else {
            return false;
        };
        for seed in seeds(shading.state, Purpose::Coat, rays) {
            let sampled = coat.sample_reflection(seed.point(Purpose::Coat));
            let Some((direction, lobe_weight)) = sampled else { continue };
            let direction = on_side(direction, shading.point.geometric_normal, true);
            let weight = shading.weight * (lobe_weight / rays as f32);
            if self.may_send(shading.state, weight) {
                let ray = Ray::new(shading.point.origin_outside(), direction);
                let channels = shading.state.channels;
                self.send(shading, ChildRay::sampled(ray, weight, RayKind::Reflection, (channels, seed)));
            }
        }
        true
    }

    /// Sends sampled rays through frosted glass. Returns whether it did.
    pub(super) fn scatter_transmission(&mut self, shading: &Shading<'_, '_>) -> bool {
        let rays = self.glossy_rays(shading.state);
        if rays == 0 || shading.bsdf.is_transmission_smooth() {
            return false;
        }
        for (channels, bsdf) in shading.transmission_lobes() {
            let weight = shading.weight_below * shading.albedos.transmission * channels.mask() / rays as f32;
            for seed in seeds(shading.state, Purpose::Refraction, rays) {
                let sampled = bsdf.sample_transmission(shading.wo, seed.point(Purpose::Refraction));
                let Some(wi) = sampled else { continue };
                let direction = (shading.world_from_local * wi).normalize();
                let direction = on_side(direction, shading.point.geometric_normal, false);
                if self.may_send(shading.state, weight) {
                    let ray = Ray::new(shading.point.origin_inside(), direction);
                    self.send(shading, ChildRay::sampled(ray, weight, RayKind::Refraction, (channels, seed)));
                }
            }
        }
        true
    }
}

/// The seeds of `rays` child rays for a purpose.
pub(super) fn seeds(state: &RayState, purpose: Purpose, rays: u32) -> impl Iterator<Item = Seed> + use<> {
    let seed = state.seed;
    (0..rays).map(move |number| seed.child(purpose, number, rays))
}
