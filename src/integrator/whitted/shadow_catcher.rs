//! Shadow catchers: invisible surfaces that show the shadows on them, to be composited over another image.
//!
//! The opacity of a catcher is the occluded share of its direct light, by luminance; its colour is black. The opacity must be known
//! before the ray goes on beyond the catcher, so its shadow rays are traced at once and not with those of the wavefront.
//! Light of the environment counts where shadow rays find what occludes it. Catchers occlude nothing.

use glam::Vec3;

use super::tracer::Tracer;
use crate::bvh::Hit;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::integrator::random::Purpose;
use crate::integrator::{EnvSamples, MediaStack, RayState, Seed};
use crate::interaction::{RayDifferential, SurfacePoint};

/// A point that receives light.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Receiver {
    pub(in crate::integrator) position: Vec3,
    /// Unit normal on the lit side.
    pub(in crate::integrator) normal: Vec3,
    pub(in crate::integrator) seed: Seed,
}

impl Tracer<'_, '_> {
    /// The share of direct light that is occluded where `ray` hits a shadow catcher; 0 where no light shines.
    pub(super) fn caught_shadow(&mut self, ray: &Ray, state: &RayState, hit: &Hit) -> f32 {
        let point = SurfacePoint::new(self.context.view, ray, hit, &RayDifferential::ZERO);
        let receiver = Receiver { position: point.position, normal: point.shading_normal, seed: state.seed };
        let (all, arriving) = self.direct_light_on(&receiver, |span| point.shadow_end_outside(span));
        if all > 0.0 { (1.0 - arriving / all).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Luminance of the direct light on a point, unoccluded and as it arrives. `shadow_end` returns the end of a shadow ray by its span.
    pub(super) fn direct_light_on(
        &mut self,
        receiver: &Receiver,
        shadow_end: impl Fn(Vec3) -> Vec3,
    ) -> (f32, f32) {
        let context = self.context;
        let mut batch = std::mem::take(&mut self.catcher_shadows);
        batch.clear();
        let mut lit = Vec::new();
        for (index, light) in context.lights.iter().enumerate() {
            let Some(incidence) = light.incidence(receiver.position) else { continue };
            let cosine = incidence.wi.dot(receiver.normal);
            if cosine > 0.0 {
                let end = shadow_end(incidence.span);
                let shadow_ray = light.shadow_ray(end, receiver.seed, index);
                let ray = batch.push(shadow_ray, MediaStack::default());
                lit.push((ray, incidence.irradiance * cosine));
            }
        }
        let (rays, share) = match context.settings.env_samples {
            EnvSamples::Fixed(rays) if context.environment_directions.is_some() => (rays, 1.0 / rays as f32),
            _ => (1, context.occluded_share),
        };
        for number in 0..rays {
            if let Some(wi) = self.light_direction(receiver, number) {
                let ray = batch.push(Ray::new(shadow_end(Vec3::ZERO), wi), MediaStack::default());
                lit.push((ray, context.view.environment.irradiance(receiver.normal) * share));
            }
        }
        batch.trace(context, &mut self.counters);
        self.statistics.shadow_rays += lit.len() as u64;
        let (mut all, mut arriving) = (0.0, 0.0);
        for (index, irradiance) in lit {
            let shadow = batch.transmittance(context, index, &mut self.counters);
            self.statistics.transparency_limit_reached += u64::from(shadow.limit_reached);
            all += luminance(irradiance);
            arriving += luminance(irradiance * shadow.transmittance);
        }
        self.catcher_shadows = batch;
        (all, arriving)
    }

    /// A direction from which light of the environment reaches a receiver, for the shadow ray of this number.
    fn light_direction(&self, receiver: &Receiver, number: u32) -> Option<Vec3> {
        let Some(directions) = &self.context.environment_directions else {
            return self.environment_direction(receiver);
        };
        let purpose =
            |dimension: u32| Purpose::Light(self.context.lights.len() as u32 + 2 * number + dimension);
        let u_choice = receiver.seed.point(purpose(1)).x;
        directions.diffuse(receiver.normal, receiver.seed.point(purpose(0)), u_choice)
    }
}
