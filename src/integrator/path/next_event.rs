//! Next-event estimation: shadow rays from a surface of a path to sampled points of lights.

use glam::Vec3;

use super::dimensions::Decision;
use super::emission::clamped;
use super::mis::power_heuristic;
use super::shaded_point::ShadedPoint;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::integrator::lights::LightSample;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::whitted::{ShadowRay, Tracer};
use crate::integrator::{GlassShadows, LightPass, MediaStack};

impl Tracer<'_, '_> {
    /// Queues one shadow ray to each kind of light.
    pub(super) fn queue_lights(&mut self, shaded: &ShadedPoint<'_, '_>) {
        self.queue_punctual_light(shaded);
        // Smooth lobes find the other lights by their sampled rays alone.
        if !shaded.scattering.is_smooth() {
            self.queue_environment(shaded);
            self.queue_emitter(shaded);
        }
    }

    /// One of the lights that rays cannot hit, chosen by the light that the surface would scatter without occlusion.
    fn queue_punctual_light(&mut self, shaded: &ShadedPoint<'_, '_>) {
        let context = self.context;
        if context.lights.is_empty() {
            return;
        }
        let u_point = shaded.samples.point(Decision::LightPoint);
        let (mut u, mut sum) = (shaded.samples.number(Decision::Light), 0.0_f32);
        let mut chosen: Option<(usize, LightSample, Vec3, f32)> = None;
        for (index, light) in context.lights.iter().enumerate() {
            let Some(sample) = light.sample(shaded.point.position, u_point) else { continue };
            let Some(wi) = shaded.local(sample.wi) else { continue };
            let has_passed =
                shaded.has_passed_straight(wi) && context.settings.glass_shadows == GlassShadows::Straight;
            let scattered = if has_passed {
                shaded.scattering.eval_diffuse_transmission(wi)
            } else {
                shaded.scattering.eval_with_smooth(wi)
            };
            let contribution = shaded.weight * scattered * sample.irradiance;
            let importance = luminance(contribution);
            if !(importance > 0.0 && importance < f32::INFINITY) {
                continue;
            }
            // Reservoir of one, which uses the number again.
            sum += importance;
            let probability = importance / sum;
            if u < probability {
                chosen = Some((index, sample, contribution, importance));
                u /= probability;
            } else {
                u = (u - probability) / (1.0 - probability);
            }
        }
        let Some((light, sample, contribution, importance)) = chosen else { return };
        let wi = shaded.world_from_local.transpose() * sample.wi;
        let end = shaded.shadow_start(wi, sample.span(shaded.point.position));
        let at = if sample.is_distant() { SurfaceMedia::AtStart } else { SurfaceMedia::AtEnd };
        let media = at(media_towards(shaded, wi));
        self.push_shadow(
            shaded,
            (light, LightPass::Direct),
            (sample.shadow_ray(end), media),
            contribution * (sum / importance),
        );
    }

    fn queue_environment(&mut self, shaded: &ShadedPoint<'_, '_>) {
        if !self.context.samples_environment(shaded.visible) {
            return;
        }
        let u = shaded.samples.point(Decision::Environment);
        let Some((wi, pdf)) = self.context.sample_environment(shaded.visible, u) else { return };
        let Some(local) = shaded.local(wi) else { return };
        let (scattered, scattered_pdf) = shaded.scattering.eval_and_pdf(local);
        if scattered == Vec3::ZERO {
            return;
        }
        let share = power_heuristic(pdf, shaded.direction_pdf(wi, scattered_pdf)) / pdf;
        let ray = Ray::new(shaded.shadow_start(local, Vec3::ZERO), wi);
        let media = SurfaceMedia::AtStart(media_towards(shaded, local));
        let queue = self.context.lights.len();
        self.push_shadow(
            shaded,
            (queue, LightPass::Environment),
            (ray, media),
            shaded.weight * scattered * share,
        );
    }

    fn queue_emitter(&mut self, shaded: &ShadedPoint<'_, '_>) {
        let lights = self.context.emissive_triangles.as_ref().filter(|lights| !lights.is_empty());
        let Some(lights) = lights else { return };
        let u_emitter = shaded.samples.number(Decision::Emitter);
        let u = shaded.samples.point(Decision::EmitterPoint);
        let surface = (shaded.point.position, shaded.light_normal());
        let Some(sample) = lights.sample_emitter(self.context.view, surface, (u_emitter, u)) else { return };
        let Some(local) = shaded.local(sample.wi) else { return };
        let (scattered, scattered_pdf) = shaded.scattering.eval_and_pdf(local);
        if scattered == Vec3::ZERO {
            return;
        }
        let own_pdf = shaded.direction_pdf(sample.wi, scattered_pdf);
        let share = power_heuristic(sample.pdf, own_pdf) / sample.pdf;
        let start = shaded.shadow_start(local, Vec3::ZERO);
        let ray = Ray { t_max: 1.0, ..Ray::new(start, sample.end - start) };
        let media = SurfaceMedia::AtStart(media_towards(shaded, local));
        let queue = self.context.lights.len() + 1;
        self.push_shadow(
            shaded,
            (queue, LightPass::Direct),
            (ray, media),
            shaded.weight * scattered * sample.radiance * share,
        );
    }

    fn push_shadow(
        &mut self,
        shaded: &ShadedPoint<'_, '_>,
        (light, own_pass): (usize, LightPass),
        (ray, media): (Ray, SurfaceMedia),
        contribution: Vec3,
    ) {
        let clamp = self.clamp_at(shaded.state.depth);
        let is_environment = own_pass == LightPass::Environment;
        let contribution = if is_environment { contribution } else { clamped(contribution, clamp) };
        if !(contribution.max_element() > 0.0 && contribution.is_finite()) {
            return;
        }
        self.shadows.push(ShadowRay {
            signature: shaded.signature,
            light,
            ray,
            sample: shaded.state.sample,
            light_pass: shaded.light_pass.unwrap_or(own_pass),
            contribution,
            environment_clamp: is_environment.then_some(clamp),
            media,
        });
    }
}

/// The volumes on the side of a local direction.
fn media_towards(shaded: &ShadedPoint<'_, '_>, wi: Vec3) -> MediaStack {
    if wi.z > 0.0 { shaded.state.media.clone() } else { shaded.transmission_side.media.clone() }
}
