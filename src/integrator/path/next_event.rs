//! Next-event estimation: shadow rays from a surface of a path to sampled points of lights.

use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

use super::dimensions::Decision;
use super::emissive_triangles::EmitterSample;
use super::mis::power_heuristic;
use super::path_block::PathBlock;
use super::shaded_point::ShadedPoint;
use crate::geometry::{ActiveLanes, DirectionSample, LANES, Ray, Vec3Lanes, vectorized};
use crate::integrator::clamp::clamped;
use crate::integrator::lights::{Incidence, LightSample, PreparedLight};
use crate::integrator::media::SurfaceMedia;
use crate::integrator::tracing::{ShadowRay, Tracer};
use crate::integrator::{GlassShadows, LightPass};

/// The samples of one kind of light for the surfaces of a block, with what these scatter of it; `None` where that is no light, and empty for all without
/// lights of the kind.
type ScatteredSamples<T> = ArrayVec<Option<(T, ScatteredLight)>, LANES>;

/// See [`crate::bsdf::Scattering::eval_and_pdf`].
#[derive(Clone, Copy)]
struct ScatteredLight {
    value: Vec3,
    pdf: f32,
}

impl Tracer<'_, '_> {
    /// Queues one shadow ray to each kind of light, for each surface of a block. `positions` are those of its points.
    pub(super) fn queue_lights(
        &mut self,
        surfaces: &[ShadedPoint<'_, '_>],
        block: &mut PathBlock,
        positions: &Vec3Lanes,
    ) {
        let lamp_points = self.lamp_points(surfaces);
        self.choose_lamps((surfaces, &lamp_points), block, positions);
        let to_environment = self.sample_environment(surfaces, block);
        let to_emitters = self.sample_emitters(surfaces, block);
        // Surface by surface, since one sample may see several: it sums their light in this order, whatever else is in the block.
        for (index, surface) in surfaces.iter().enumerate() {
            self.queue_lamp((surface, lamp_points[index]), block.chosen(surface.lane));
            if let Some(Some((sample, scattered))) = to_environment.get(index) {
                self.queue_environment(surface, *sample, *scattered);
            }
            if let Some(Some((sample, scattered))) = to_emitters.get(index) {
                self.queue_emitter(surface, sample, *scattered);
            }
        }
    }

    /// The sample points of each surface on the lights that rays cannot hit; zero where no light has more than one point.
    fn lamp_points(&self, surfaces: &[ShadedPoint<'_, '_>]) -> ArrayVec<Vec2, LANES> {
        let is_sized = self.context.lights.iter().any(PreparedLight::is_sized);
        let point = |surface: &ShadedPoint<'_, '_>| {
            if is_sized { surface.samples.point(Decision::LightPoint) } else { Vec2::ZERO }
        };
        surfaces.iter().map(point).collect()
    }

    /// Chooses one of the lights that rays cannot hit for each surface, by the light that it would scatter without occlusion.
    fn choose_lamps(
        &self,
        (surfaces, lamp_points): (&[ShadedPoint<'_, '_>], &[Vec2]),
        block: &mut PathBlock,
        positions: &Vec3Lanes,
    ) {
        let context = self.context;
        for surface in surfaces {
            let u = if context.lights.is_empty() { 0.0 } else { surface.samples.number(Decision::Light) };
            block.begin_choices(surface, u);
        }
        let level = context.view.bvh.simd_level();
        let is_straight = context.settings.glass_shadows == GlassShadows::Straight;
        let passes_straight =
            |surface: &ShadedPoint<'_, '_>, wi| is_straight && surface.has_passed_straight(wi);
        for (index, light) in (0..).zip(&context.lights) {
            let in_lanes = block.is_in_lanes();
            let incidences = &mut block.incidences;
            if light.is_sized() || !in_lanes {
                for (surface, u_point) in surfaces.iter().zip(lamp_points) {
                    let sample = light.sample(surface.point.position, *u_point);
                    incidences.set(surface.lane, sample.map_or(Incidence::NONE, LightSample::incidence));
                }
            } else {
                vectorized!(level, light.incidences(positions, incidences));
            }
            block.choose((level, index), surfaces, passes_straight);
        }
    }

    fn queue_lamp(&mut self, (shaded, u_point): (&ShadedPoint<'_, '_>, Vec2), chosen: Option<(usize, Vec3)>) {
        let Some((light, contribution)) = chosen else { return };
        let position = shaded.point.position;
        let Some(sample) = self.context.lights[light].sample(position, u_point) else { return };
        let (end, media) = shaded.lamp_shadow_end(sample.wi, sample.span(position));
        let media = SurfaceMedia::of_lamp(sample.is_distant(), media);
        self.push_shadow(shaded, (light, LightPass::Direct), (sample.shadow_ray(end), media), contribution);
    }

    fn sample_environment(
        &self,
        surfaces: &[ShadedPoint<'_, '_>],
        block: &mut PathBlock,
    ) -> ScatteredSamples<DirectionSample> {
        let context = self.context;
        self.scatter_samples(surfaces, block, |surface| {
            if !context.samples_environment(surface.visible) {
                return None;
            }
            let u = surface.samples.point(Decision::Environment);
            let sample = context.sample_environment(surface.visible, u)?;
            Some((sample.direction, sample))
        })
    }

    fn queue_environment(
        &mut self,
        shaded: &ShadedPoint<'_, '_>,
        sample: DirectionSample,
        scattered: ScatteredLight,
    ) {
        let DirectionSample { direction: wi, pdf } = sample;
        let share = power_heuristic(pdf, shaded.direction_pdf(wi, scattered.pdf)) / pdf;
        let ray = Ray::new(shaded.shadow_start(wi, Vec3::ZERO), wi);
        let media = SurfaceMedia::AtStart(shaded.media_towards(wi));
        let queue = self.context.lights.len();
        let contribution = shaded.weight * scattered.value * share;
        self.push_shadow(shaded, (queue, LightPass::Environment), (ray, media), contribution);
    }

    fn sample_emitters(
        &self,
        surfaces: &[ShadedPoint<'_, '_>],
        block: &mut PathBlock,
    ) -> ScatteredSamples<EmitterSample> {
        let context = self.context;
        let lights = context.emissive_triangles.as_ref().filter(|lights| !lights.is_empty());
        let Some(lights) = lights else { return ArrayVec::new() };
        self.scatter_samples(surfaces, block, |surface| {
            let u_emitter = surface.samples.number(Decision::Emitter);
            let u = surface.samples.point(Decision::EmitterPoint);
            let of = (surface.point.position, surface.light_normal());
            let sample = lights.sample_emitter(context.view, of, (u_emitter, u))?;
            Some((sample.wi, sample))
        })
    }

    fn queue_emitter(
        &mut self,
        shaded: &ShadedPoint<'_, '_>,
        sample: &EmitterSample,
        scattered: ScatteredLight,
    ) {
        let own_pdf = shaded.direction_pdf(sample.wi, scattered.pdf);
        let share = power_heuristic(sample.pdf, own_pdf) / sample.pdf;
        let start = shaded.shadow_start(sample.wi, Vec3::ZERO);
        let ray = Ray { t_max: 1.0, ..Ray::new(start, sample.end - start) };
        let media = SurfaceMedia::AtStart(shaded.media_towards(sample.wi));
        let queue = self.context.lights.len() + 1;
        let contribution = shaded.weight * scattered.value * sample.radiance * share;
        self.push_shadow(shaded, (queue, LightPass::Direct), (ray, media), contribution);
    }

    /// Samples light for each surface, and evaluates what it scatters. `sample` gives a world-space direction.
    fn scatter_samples<T: Copy>(
        &self,
        surfaces: &[ShadedPoint<'_, '_>],
        block: &mut PathBlock,
        sample: impl Fn(&ShadedPoint<'_, '_>) -> Option<(Vec3, T)>,
    ) -> ScatteredSamples<T> {
        let mut samples = ArrayVec::<Option<T>, LANES>::new();
        let mut active = ActiveLanes::default();
        for surface in surfaces {
            // Smooth lobes find these lights by their sampled rays alone.
            let sampled = if block.is_smooth(surface.lane) { None } else { sample(surface) };
            let seen = sampled.and_then(|(wi, sample)| Some((surface.local(wi)?, sample)));
            samples.push(seen.map(|(local, sample)| {
                block.wi.set(surface.lane, local);
                active = active.with(surface.lane);
                sample
            }));
        }
        if active.is_empty() {
            return ArrayVec::new();
        }
        block.scatter(self.context.view.bvh.simd_level(), active);
        let scattered = surfaces.iter().zip(samples).map(|(surface, sample)| {
            let (value, pdf) = block.scattered(surface.lane);
            let sample = sample.filter(|_| value != Vec3::ZERO)?;
            Some((sample, ScatteredLight { value, pdf }))
        });
        scattered.collect()
    }

    fn push_shadow(
        &mut self,
        shaded: &ShadedPoint<'_, '_>,
        (light, own_pass): (usize, LightPass),
        (ray, media): (Ray, SurfaceMedia),
        contribution: Vec3,
    ) {
        let clamp = self.clamp_at(shaded.state.depth, shaded.channels);
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
            for_hidden: Vec3::ZERO,
            environment_clamp: is_environment.then_some(clamp),
            media,
        });
    }
}
