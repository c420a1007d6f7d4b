//! Next-event estimation: shadow rays from a surface of a path to sampled points of lights.

use glam::Vec3;

use super::dimensions::Decision;
use super::emission::clamped;
use super::mis::power_heuristic;
use super::path_block::PathBlock;
use super::shaded_point::ShadedPoint;
use crate::geometry::{ActiveLanes, LANES, Ray, Vec3Lanes, vectorized};
use crate::integrator::lights::{Incidence, LightSample};
use crate::integrator::media::SurfaceMedia;
use crate::integrator::whitted::{ShadowRay, Tracer};
use crate::integrator::{GlassShadows, LightPass, MediaStack};

impl Tracer<'_, '_> {
    /// Queues one shadow ray to each kind of light, for each surface of a block. `positions` are those of its points.
    pub(super) fn queue_lights(
        &mut self,
        surfaces: &[ShadedPoint<'_, '_>],
        block: &mut PathBlock,
        positions: &Vec3Lanes,
    ) {
        self.queue_punctual_lights(surfaces, block, positions);
        self.queue_environment(surfaces, block);
        self.queue_emitters(surfaces, block);
    }

    /// One of the lights that rays cannot hit, chosen by the light that the surface would scatter without occlusion.
    fn queue_punctual_lights(
        &mut self,
        surfaces: &[ShadedPoint<'_, '_>],
        block: &mut PathBlock,
        positions: &Vec3Lanes,
    ) {
        let context = self.context;
        if context.lights.is_empty() {
            return;
        }
        let level = context.view.bvh.simd_level();
        for surface in surfaces {
            block.begin_choices(surface, surface.samples.number(Decision::Light));
        }
        let is_straight = context.settings.glass_shadows == GlassShadows::Straight;
        let passes_straight =
            |surface: &ShadedPoint<'_, '_>, wi| is_straight && surface.has_passed_straight(wi);
        for (index, light) in (0..).zip(&context.lights) {
            let in_lanes = block.is_in_lanes();
            let incidences = &mut block.incidences;
            if light.is_sized() || !in_lanes {
                for surface in surfaces {
                    let position = surface.point.position;
                    let sample = light.sample(position, surface.samples.point(Decision::LightPoint));
                    incidences.set(surface.lane, sample.map_or(Incidence::NONE, LightSample::incidence));
                }
            } else {
                vectorized!(level, light.incidences(positions, incidences));
            }
            block.choose((level, index), surfaces, passes_straight);
        }
        for surface in surfaces {
            self.queue_punctual_light(surface, block.chosen(surface.lane));
        }
    }

    fn queue_punctual_light(&mut self, shaded: &ShadedPoint<'_, '_>, chosen: Option<(usize, Vec3)>) {
        let Some((light, contribution)) = chosen else { return };
        let position = shaded.point.position;
        let u_point = shaded.samples.point(Decision::LightPoint);
        let Some(sample) = self.context.lights[light].sample(position, u_point) else { return };
        let wi = shaded.world_from_local.transpose() * sample.wi;
        let end = shaded.shadow_start(wi, sample.span(position));
        let at = if sample.is_distant() { SurfaceMedia::AtStart } else { SurfaceMedia::AtEnd };
        let media = at(media_towards(shaded, wi));
        self.push_shadow(shaded, (light, LightPass::Direct), (sample.shadow_ray(end), media), contribution);
    }

    fn queue_environment(&mut self, surfaces: &[ShadedPoint<'_, '_>], block: &mut PathBlock) {
        let context = self.context;
        let mut samples = [None; LANES];
        // Smooth lobes find lights that rays can hit by their sampled rays alone.
        for surface in surfaces {
            if block.is_smooth(surface.lane) || !context.samples_environment(surface.visible) {
                continue;
            }
            let u = surface.samples.point(Decision::Environment);
            let Some((wi, pdf)) = context.sample_environment(surface.visible, u) else { continue };
            let Some(local) = surface.local(wi) else { continue };
            block.wi.set(surface.lane, local);
            samples[surface.lane] = Some((wi, pdf));
        }
        let active = ActiveLanes::first(LANES).filtered(|lane| samples[lane].is_some());
        if active.is_empty() {
            return;
        }
        block.scatter(context.view.bvh.simd_level(), active);
        for surface in surfaces {
            let Some((wi, pdf)) = samples[surface.lane] else { continue };
            let (local, (scattered, scattered_pdf)) =
                (block.wi.get(surface.lane), block.scattered(surface.lane));
            if scattered == Vec3::ZERO {
                continue;
            }
            let share = power_heuristic(pdf, surface.direction_pdf(wi, scattered_pdf)) / pdf;
            let ray = Ray::new(surface.shadow_start(local, Vec3::ZERO), wi);
            let media = SurfaceMedia::AtStart(media_towards(surface, local));
            let queue = context.lights.len();
            let contribution = surface.weight * scattered * share;
            self.push_shadow(surface, (queue, LightPass::Environment), (ray, media), contribution);
        }
    }

    fn queue_emitters(&mut self, surfaces: &[ShadedPoint<'_, '_>], block: &mut PathBlock) {
        let context = self.context;
        let lights = context.emissive_triangles.as_ref().filter(|lights| !lights.is_empty());
        let Some(lights) = lights else { return };
        let mut samples = [None; LANES];
        // Smooth lobes find lights that rays can hit by their sampled rays alone.
        for surface in surfaces {
            if block.is_smooth(surface.lane) {
                continue;
            }
            let u_emitter = surface.samples.number(Decision::Emitter);
            let u = surface.samples.point(Decision::EmitterPoint);
            let of = (surface.point.position, surface.light_normal());
            let Some(sample) = lights.sample_emitter(context.view, of, (u_emitter, u)) else { continue };
            let Some(local) = surface.local(sample.wi) else { continue };
            block.wi.set(surface.lane, local);
            samples[surface.lane] = Some(sample);
        }
        let active = ActiveLanes::first(LANES).filtered(|lane| samples[lane].is_some());
        if active.is_empty() {
            return;
        }
        block.scatter(context.view.bvh.simd_level(), active);
        for surface in surfaces {
            let Some(sample) = &samples[surface.lane] else { continue };
            let (local, (scattered, scattered_pdf)) =
                (block.wi.get(surface.lane), block.scattered(surface.lane));
            if scattered == Vec3::ZERO {
                continue;
            }
            let own_pdf = surface.direction_pdf(sample.wi, scattered_pdf);
            let share = power_heuristic(sample.pdf, own_pdf) / sample.pdf;
            let start = surface.shadow_start(local, Vec3::ZERO);
            let ray = Ray { t_max: 1.0, ..Ray::new(start, sample.end - start) };
            let media = SurfaceMedia::AtStart(media_towards(surface, local));
            let queue = context.lights.len() + 1;
            let contribution = surface.weight * scattered * sample.radiance * share;
            self.push_shadow(surface, (queue, LightPass::Direct), (ray, media), contribution);
        }
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
