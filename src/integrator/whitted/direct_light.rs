//! Light of punctual lights and of the environment's key light, behind shadow rays.

use std::time::Instant;

use glam::Vec3;

use super::frosted_glass::UnbentLightLobes;
use super::lamps_through_glass::TransmittedLampLight;
use super::least_weights::MIN_SCATTERED;
use super::shading::Shading;
use super::shadow_queue::{ShadowQueue, ShadowRay, ShadowTask};
use super::tracer::{Tracer, seconds_since};
use crate::integrator::LightPass;
use crate::integrator::clamp::clamped;
use crate::integrator::media::SurfaceMedia;

impl Tracer<'_, '_> {
    /// Queues a shadow ray for each light that a surface scatters towards the viewer.
    pub(super) fn queue_direct_light(&mut self, shading: &Shading<'_, '_>) {
        let context = self.context;
        let (mut unbent_light, mut transmitted) = (None, None);
        for (index, light) in context.lights.iter().enumerate() {
            let incidence = self.block_incidences[index].get(shading.index);
            let is_reached = incidence.irradiance.max_element() > 0.0;
            if !is_reached {
                continue;
            }
            let wi = shading.world_from_local.transpose() * incidence.wi;
            let through_glass = if wi.z < 0.0 {
                let transmitted =
                    transmitted.get_or_insert_with(|| TransmittedLampLight::of(context, shading));
                transmitted.scattered((index, light), (shading.point, &incidence), wi)
            } else {
                None
            };
            let scattered = through_glass.unwrap_or_else(|| {
                let mut scattered = shading.bsdf.eval_by(shading.wo, wi, shading.terms);
                let unbent_light = unbent_light.get_or_insert_with(|| UnbentLightLobes::of(shading));
                if let Some((lobes, share)) = unbent_light
                    && !context.is_lamp_within(index, &shading.state.media)
                {
                    scattered += (lobes.eval(shading.wo, wi) - scattered) * *share;
                }
                scattered * wi.z.abs()
            });
            let mut scattered = shading.weight_below * scattered;
            let by_coat = shading.coat.map_or(0.0, |coat| coat.scattered(incidence.wi));
            if by_coat > 0.0 {
                scattered += shading.weight * by_coat;
            }
            let contribution = scattered * incidence.irradiance;
            if scattered.max_element() > MIN_SCATTERED && contribution.max_element() > 0.0 {
                let span = incidence.span;
                let (end, media) = if wi.z > 0.0 || by_coat > 0.0 {
                    (shading.point.shadow_end_outside(span), &shading.state.media)
                } else {
                    (shading.point.shadow_end_inside(span), &shading.transmission_side.media)
                };
                let is_distant = span == Vec3::ZERO;
                let at = if is_distant { SurfaceMedia::AtStart } else { SurfaceMedia::AtEnd };
                self.shadows.push(ShadowRay {
                    signature: shading.signature,
                    light: index,
                    ray: light.shadow_ray(end, shading.state.seed, index),
                    sample: shading.state.sample,
                    light_pass: shading.light_pass.unwrap_or(LightPass::Direct),
                    contribution,
                    for_hidden: Vec3::ZERO,
                    environment_clamp: None,
                    media: at(media.clone()),
                });
            }
        }
    }

    /// Traces the queued shadow rays and adds the light that arrives.
    pub(super) fn trace_shadows(&mut self) {
        // Opaque surfaces, batch by batch
        let start = Instant::now();
        for batch in self.shadows.batches.iter_mut().filter(|batch| !batch.is_empty()) {
            batch.trace(self.context, &mut self.counters);
        }
        self.statistics.query_seconds += seconds_since(start);

        // What stopped those to the environment
        self.add_occluder_light();

        // Transparent surfaces and sums, in the order of tasks
        let ShadowQueue { batches, tasks, .. } = &mut self.shadows;
        self.statistics.shadow_rays += tasks.len() as u64;
        for task in tasks.drain(..) {
            let ShadowTask { sample, light_pass, batch, ray, contribution, for_hidden, environment_clamp } =
                task;
            let batch = &batches[batch as usize];
            let shadow = batch.transmittance(self.context, ray, &mut self.counters);
            self.statistics.transparency_limit_reached += u64::from(shadow.limit_reached);
            if for_hidden != Vec3::ZERO && shadow.hidden != Vec3::ONE {
                let absorbed = for_hidden * (Vec3::ONE - shadow.transmittance - shadow.hidden);
                self.values[sample as usize].radiance -= absorbed;
                self.aovs.add(sample, light_pass, -absorbed);
            }
            if shadow.transmittance == Vec3::ZERO {
                continue;
            }
            let mut arriving = contribution * shadow.transmittance;
            if let Some(limit) = environment_clamp {
                let radiance = self.context.view.environment.radiance(batch.direction(ray));
                arriving = clamped(arriving * radiance, limit);
            }
            self.values[sample as usize].radiance += arriving;
            self.aovs.add(sample, light_pass, arriving);
        }
        for batch in batches {
            batch.clear();
        }
    }
}
