//! Several rays for a rough mirror or frosted glass (Cook 1984), where they are asked for: they follow the lobe, and nothing is
//! left to the lookup of the environment.
//!
//! The first surface of a path sends as many rays as are asked for, later ones one each: what is seen in a rough mirror is
//! averaged by the rays that came from there.

use super::Tracer;
use super::shading::{Child, Shading};
use crate::geometry::Ray;
use crate::integrator::random::Purpose;
use crate::integrator::{RayKind, RayState, Seed};

impl Tracer<'_, '_> {
    /// How many rays follow a rough lobe of a surface that `path` meets; 0 where rough lobes are looked up instead.
    fn rays_a_lobe(&self, state: &RayState) -> u32 {
        match self.context.settings.glossy_samples {
            0 => 0,
            samples if state.depth == 0 => samples,
            _ => 1,
        }
    }

    /// Follows the specular lobe; whether it is rough and rays are asked for.
    pub(super) fn scatter_reflection(&mut self, shading: &Shading<'_, '_>) -> bool {
        let rays = self.rays_a_lobe(shading.state);
        if rays == 0 || shading.bsdf.is_smooth() {
            return false;
        }
        for seed in seeds(shading.state, Purpose::Reflection, rays) {
            let drawn = shading.bsdf.sample_reflection(shading.wo, seed.point(Purpose::Reflection));
            let Some((wi, share)) = drawn else { continue };
            let direction = (shading.world_from_local * wi).normalize();
            let weight = shading.weight_below * share / rays as f32;
            if direction.dot(shading.point.geometric_normal) > 0.0 && self.may_send(shading.state, weight) {
                let ray = Ray::new(shading.point.origin_outside(), direction);
                let channels = shading.state.channels;
                self.send(shading, Child { ray, weight, kind: RayKind::Reflection, channels, seed });
            }
        }
        true
    }

    /// Follows the coat's lobe; whether it is rough and rays are asked for.
    pub(super) fn scatter_coat(&mut self, shading: &Shading<'_, '_>) -> bool {
        let rays = self.rays_a_lobe(shading.state);
        let Some(coat) = shading.coat.as_ref().filter(|coat| rays > 0 && !coat.is_smooth()) else {
            return false;
        };
        for seed in seeds(shading.state, Purpose::Coat, rays) {
            let Some((direction, share)) = coat.sample_reflection(seed.point(Purpose::Coat)) else {
                continue;
            };
            let weight = shading.weight * (share / rays as f32);
            if direction.dot(shading.point.geometric_normal) > 0.0 && self.may_send(shading.state, weight) {
                let ray = Ray::new(shading.point.origin_outside(), direction);
                let channels = shading.state.channels;
                self.send(shading, Child { ray, weight, kind: RayKind::Reflection, channels, seed });
            }
        }
        true
    }

    /// Follows the lobe of frosted glass; whether it is rough and rays are asked for.
    pub(super) fn scatter_transmission(&mut self, shading: &Shading<'_, '_>) -> bool {
        let rays = self.rays_a_lobe(shading.state);
        if rays == 0 || shading.bsdf.is_smooth_through() {
            return false;
        }
        for (channels, bsdf) in shading.transmission_lobes() {
            let weight = shading.weight_below * shading.albedos.transmission * channels.mask() / rays as f32;
            for seed in seeds(shading.state, Purpose::Refraction, rays) {
                let drawn = bsdf.sample_transmission(shading.wo, seed.point(Purpose::Refraction));
                let Some(wi) = drawn else { continue };
                let direction = (shading.world_from_local * wi).normalize();
                if direction.dot(shading.point.geometric_normal) < 0.0 && self.may_send(shading.state, weight)
                {
                    let ray = Ray::new(shading.point.origin_inside(), direction);
                    self.send(shading, Child { ray, weight, kind: RayKind::Refraction, channels, seed });
                }
            }
        }
        true
    }
}

/// The seeds of a path's children for a purpose.
fn seeds(state: &RayState, purpose: Purpose, rays: u32) -> impl Iterator<Item = Seed> + use<> {
    let seed = state.seed;
    (0..rays).map(move |number| seed.child(purpose, number, rays))
}
