//! Light of the environment that its occluders reflect: one bounce along the shadow rays that they stop.
//!
//! The closest opaque surface along a stopped ray is taken to be flat, a metal or diffuse, of its base colour. It receives the environment's irradiance and its own
//! lights, as far as two shadow rays let them through: one to one of these lights, one along a direction from which the rest comes. Where
//! the latter is stopped, too, it receives what was estimated for an unknown occluder of the looked-up light, but no more than that light or than where it is not. What transparent surfaces before it
//! absorb is lost.

use std::f32::consts::FRAC_1_PI;
use std::time::Instant;

use glam::Vec3;

use super::environment_shadows::on_side;
use super::occluder_buffers::{LitOccluder, OccluderBuffers, OccluderTask, StoppedTask};
use super::occluder_surface::{OccluderSurface, ReflectedKey};
use crate::bvh::{Hit, TriangleFlags};
use crate::geometry::{Facing, Ray};
use crate::integrator::glass_passage::GlassPassage;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::shadow::stops_light;
use crate::integrator::tracing::{ShadowTask, Tracer, seconds_since};
use crate::interaction::{SurfacePoint, transmits_at};

/// What stops a shadow ray.
struct FoundOccluder<'o> {
    ray: &'o Ray,
    hit: &'o Hit,
    /// Share of its light that transparent surfaces before it let through.
    transmittance: Vec3,
}

impl Tracer<'_, '_> {
    /// Adds the light that the occluders of lookups reflect, after their shadow rays were traced.
    pub(in crate::integrator) fn add_occluder_light(&mut self) {
        if self.whitted.occluders.queued.is_empty() {
            return;
        }
        let mut buffers = std::mem::take(&mut self.whitted.occluders);
        self.find_occluders(&mut buffers);
        self.light_occluders(&mut buffers);
        self.whitted.occluders = buffers;
    }

    /// Finds what stops the rays of all tasks.
    fn find_occluders(&mut self, buffers: &mut OccluderBuffers) {
        let OccluderBuffers { queued, rays, tasks, occluders, .. } = buffers;
        rays.clear();
        tasks.clear();
        let queue = &self.shadows;
        let context = self.context;
        for task in queued.drain(..) {
            let ShadowTask { sample, batch, ray, .. } = queue.tasks[task.task as usize];
            let Some(stopped) = queue.batches[batch as usize].occluded_ray(ray) else { continue };
            let sequence = &self.sequences[sample as usize];
            let keys = self.whitted.lookup_keys.get(sequence.seed(), task.lookup as usize, task.ray);
            let light = sequence.number_by(&keys[1]) / context.bounce_share;
            if light < 1.0 {
                rays.push(*stopped);
                tasks.push(StoppedTask { task, light, direction: sequence.point_and_random_by(&keys[0]) });
            }
        }
        // Shadow rays are stopped by either side, so batches, which pass the back of single-sided surfaces, would miss occluders.
        let stops = |hit: &Hit| stops_light(context, hit, GlassPassage::Straight);
        let (bvh, counters) = (context.view.bvh, &mut self.counters);
        let start = Instant::now();
        occluders.clear();
        occluders.extend(rays.iter().map(|ray| bvh.closest_hit_of_any_side(ray, None, stops, counters)));
        self.statistics.query_seconds += seconds_since(start);
        self.statistics.shadow_rays += rays.len() as u64;
    }

    /// Finds the transparent surfaces before all occluders, where there may be any.
    fn trace_segments(&mut self, buffers: &mut OccluderBuffers) {
        let OccluderBuffers { rays, tasks, occluders, segments, .. } = buffers;
        segments.clear();
        if !self.context.may_dim_light {
            return;
        }
        for ((ray, hit), stopped) in rays.iter().zip(&*occluders).zip(&*tasks) {
            let ShadowTask { batch, ray: index, .. } = self.shadows.tasks[stopped.task.task as usize];
            let media = self.shadows.batches[batch as usize].media(index).clone();
            // Hits at the end are ignored.
            let end = hit.as_ref().map_or(ray.t_min, |hit| hit.t);
            segments.push(Ray { t_max: end, ..*ray }, media);
        }
        let start = Instant::now();
        segments.trace(self.context, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);
        self.statistics.shadow_rays += occluders.iter().flatten().count() as u64;
    }

    /// Adds the light that found occluders scatter into their lookups.
    fn light_occluders(&mut self, buffers: &mut OccluderBuffers) {
        self.trace_segments(buffers);
        let OccluderBuffers { rays, tasks, occluders, segments, shadows, lit, .. } = buffers;
        shadows.clear();
        lit.clear();
        for (index, ((ray, hit), task)) in rays.iter().zip(&*occluders).zip(&*tasks).enumerate() {
            let Some(hit) = hit else { continue };
            if !self.can_be_lit(hit) {
                self.limit_estimate(&task.task);
                continue;
            }
            let transmittance = if segments.is_empty() {
                Vec3::ONE
            } else {
                let segment = segments.transmittance(self.context, index as u32, &mut self.counters);
                self.statistics.transparency_limit_reached += u64::from(segment.limit_reached);
                segment.transmittance
            };
            let occluder = FoundOccluder { ray, hit, transmittance };
            for (occluder, to_light) in self.lit_occluder(&occluder, task).into_iter().flatten() {
                shadows.push(to_light, SurfaceMedia::default());
                lit.push(occluder);
            }
        }
        let start = Instant::now();
        shadows.trace(self.context, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);
        self.statistics.shadow_rays += lit.len() as u64;
        for (index, occluder) in lit.iter().enumerate() {
            let shadow = shadows.transmittance(self.context, index as u32, &mut self.counters);
            self.statistics.transparency_limit_reached += u64::from(shadow.limit_reached);
            let LitOccluder { sample, light_pass, open, shadowed } = *occluder;
            self.add(sample, light_pass, shadowed + (open - shadowed) * shadow.transmittance);
        }
    }

    /// Takes away what was estimated for an occluder beyond the lookup itself: a surface that faces the dark side of an environment would be brighter in its shadow
    /// than beside it.
    fn limit_estimate(&mut self, task: &OccluderTask) {
        let ShadowTask { sample, light_pass, .. } = self.shadows.tasks[task.task as usize];
        self.add(sample, light_pass, task.limited - task.reflected);
    }

    /// Whether the occluder at a hit can be lit. Others keep the estimate: the back of single-sided surfaces, which nothing sees, unlit
    /// surfaces, and glass that casts full shadows.
    fn can_be_lit(&self, hit: &Hit) -> bool {
        let frame = self.context.view.frame;
        let material = &frame.materials[frame.instance(hit.triangle).material.index()];
        let is_seen = hit.facing == Facing::Front
            || !frame.flags[hit.triangle as usize].has(TriangleFlags::SINGLE_SIDED);
        is_seen && !material.unlit && !transmits_at(self.context.view, hit)
    }

    /// The occluder of a task in the light of most of the environment and, if it faces any, in that of one of the environment's own lights; each with the
    /// ray that finds whether that light reaches it.
    fn lit_occluder(
        &self,
        &FoundOccluder { ray, hit, transmittance }: &FoundOccluder<'_>,
        stopped: &StoppedTask,
    ) -> [Option<(LitOccluder, Ray)>; 2] {
        let StoppedTask { task, light, direction } = stopped;
        let ShadowTask { sample, light_pass, .. } = self.shadows.tasks[task.task as usize];
        let context = self.context;
        let point = SurfacePoint::flat(context.view, ray, hit);
        let surface = OccluderSurface::new(context, &point, hit);
        let end = point.shadow_end_outside(Vec3::ZERO);

        let (radiance, sampled) = surface.reflected_environment(context, *light, *direction);
        let open = task.albedo * transmittance * radiance;
        let shadowed = match &context.interreflections {
            Some(light) => {
                let irradiance = light.irradiance(point.position, surface.normal);
                task.albedo * transmittance * surface.albedo() * irradiance * FRAC_1_PI
            }
            // In shadow, it is not brighter than in the open, either.
            None => (task.limited * transmittance * surface.albedo()).min(open),
        };
        let by_most = LitOccluder {
            sample,
            light_pass,
            open: open - task.reflected,
            shadowed: shadowed - task.reflected,
        };
        let by_key = ReflectedKey::new(context, &surface, *light).map(|key| {
            let open = task.albedo * transmittance * key.radiance;
            (LitOccluder { sample, light_pass, open, shadowed: Vec3::ZERO }, Ray::new(end, key.wi))
        });
        [Some((by_most, Ray::new(end, on_side(sampled, surface.normal, true)))), by_key]
    }
}
