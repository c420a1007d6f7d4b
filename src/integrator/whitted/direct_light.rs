//! Light of punctual lights and of the environment's key light, behind shadow rays.

use glam::Vec3;

use super::frosted_glass::UnbentLightLobes;
use super::lamps_through_glass::TransmittedLampLight;
use super::shading::Shading;
use crate::integrator::least_weights::MIN_SCATTERED;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::tracing::{ShadowRay, Tracer};

impl Tracer<'_, '_> {
    /// Queues a shadow ray for each light that a surface scatters towards the viewer.
    pub(super) fn queue_direct_light(&mut self, shading: &Shading<'_, '_>) {
        let context = self.context;
        let (mut unbent_light, mut transmitted) = (None, None);
        for (index, light) in context.lights.iter().enumerate() {
            let incidence = self.whitted.block_incidences[index].get(shading.index);
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
                self.shadows.push(ShadowRay {
                    signature: shading.signature,
                    light: index,
                    ray: light.shadow_ray(end, shading.state.seed, index),
                    sample: shading.state.sample,
                    light_pass: shading.light_pass.unwrap_or(light.light_pass()),
                    contribution,
                    for_hidden: Vec3::ZERO,
                    environment_clamp: None,
                    media: SurfaceMedia::of_lamp(is_distant, media.clone()),
                });
            }
        }
    }
}
