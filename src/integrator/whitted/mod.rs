//! Whitted's recursive ray tracer (Whitted 1980, "An Improved Illumination Model for Shaded Display"), breadth first.
//!
//! A batch of samples is traced in generations: the closest hits of all rays → shading → all shadow rays → child rays with
//! their weights, which are the next generation. Every sample sums weight · radiance in generation order, and within one
//! in the order of its own rays, so that a sample's value does not depend on what else is in the batch.
//!
//! There is no hidden ambient term and nothing is random. What is left open by the material model is settled here:
//! smooth lobes are followed by mirror and refraction rays, rough ones look the environment up, and in between the two
//! are blended by roughness.

mod shade;

use glam::Vec3;

use super::{IntegratorStatistics, MediaStack, PASS_THROUGH_LIMIT, PathClass, PathRay, World, shadow};
use crate::bvh::{Hit, TraversalCounters};
use crate::geometry::Ray;
use crate::interaction::alpha_at;

/// Rays whose weight is below this are black.
const LEAST_WEIGHT: f32 = 1.0 / 1024.0;

/// What one sample saw.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleValue {
    /// Radiance, multiplied by coverage.
    pub radiance: Vec3,
    /// Share of the sample that surfaces or a visible background cover.
    pub coverage: f32,
}

/// A surface that a ray sees.
struct Sight {
    /// Subscript of the ray in its generation.
    ray: usize,
    hit: Hit,
    /// Share of the ray that see-through surfaces in front and the surface's own coverage leave.
    share: f32,
}

/// Light that reaches the eye if nothing is in its way.
struct ShadowTask {
    sample: u32,
    ray: Ray,
    /// The volumes that the ray starts in, as far as they are known.
    media: MediaStack,
    contribution: Vec3,
}

/// One batch while it is traced.
struct Tracer<'w, 'a> {
    world: &'w World<'a>,
    values: Vec<SampleValue>,
    shadows: Vec<ShadowTask>,
    children: Vec<PathRay>,
    counters: TraversalCounters,
    statistics: IntegratorStatistics,
}

/// Traces camera rays; `rays[i].sample` is a subscript below `samples` of the result.
pub fn trace(
    world: &World<'_>,
    rays: Vec<PathRay>,
    samples: usize,
) -> (Vec<SampleValue>, IntegratorStatistics) {
    let mut tracer = Tracer {
        world,
        values: vec![SampleValue::default(); samples],
        shadows: Vec::new(),
        children: Vec::new(),
        counters: TraversalCounters::default(),
        statistics: IntegratorStatistics::default(),
    };
    let mut generation = rays;
    while !generation.is_empty() {
        let sights = tracer.closest_hits(&generation);
        for sight in &sights {
            tracer.shade(&generation[sight.ray], &sight.hit, sight.share);
        }
        tracer.trace_shadows();
        generation = std::mem::take(&mut tracer.children);
    }
    tracer.statistics.nodes = tracer.counters.nodes;
    tracer.statistics.triangles = tracer.counters.triangles;
    (tracer.values, tracer.statistics)
}

impl Tracer<'_, '_> {
    /// Everything that a generation sees, in the order of rays and along each ray.
    fn closest_hits(&mut self, generation: &[PathRay]) -> Vec<Sight> {
        let mut sights = Vec::with_capacity(generation.len());
        for (index, ray) in generation.iter().enumerate() {
            match ray.class {
                PathClass::Camera => self.statistics.camera_rays += 1,
                PathClass::Reflection => self.statistics.reflection_rays += 1,
                PathClass::Refraction => self.statistics.refraction_rays += 1,
            }
            self.follow(index, ray, &mut sights);
        }
        sights
    }

    /// Follows one ray through see-through surfaces up to the first solid one or out of the scene.
    fn follow(&mut self, index: usize, ray: &PathRay, sights: &mut Vec<Sight>) {
        let posed = self.world.posed;
        let mut through = 1.0_f32;
        let mut after = None;
        let mut touching = ray.touching;
        for _ in 0..PASS_THROUGH_LIMIT {
            let there = |hit: &Hit| alpha_at(posed, hit) > 0.0;
            let next = touching
                .take()
                .or_else(|| self.world.bvh.closest_hit(&ray.ray, after, there, &mut self.counters));
            let Some(hit) = next else {
                return self.escape(ray, through);
            };
            after = Some(hit.order());
            let alpha = alpha_at(posed, &hit);
            sights.push(Sight { ray: index, hit, share: through * alpha });
            through *= 1.0 - alpha;
            if ray.weight.max_element() * through < LEAST_WEIGHT {
                self.statistics.dropped_weight += f64::from(ray.weight.max_element() * through);
                return self.cover(ray, 1.0);
            }
        }
        self.statistics.pass_through_limit_reached += 1;
        self.cover(ray, 1.0);
    }

    /// What is left of a ray leaves the scene.
    fn escape(&mut self, ray: &PathRay, through: f32) {
        if ray.class == PathClass::Camera && !self.world.settings.show_background {
            return self.cover(ray, 1.0 - through);
        }
        let weight = ray.weight * ray.media.transmittance(f32::INFINITY) * through;
        self.values[ray.sample as usize].radiance +=
            weight * self.world.environment.radiance(ray.ray.direction);
        self.cover(ray, 1.0);
    }

    fn cover(&mut self, ray: &PathRay, coverage: f32) {
        if ray.class == PathClass::Camera {
            self.values[ray.sample as usize].coverage = coverage;
        }
    }

    fn trace_shadows(&mut self) {
        let mut tasks = std::mem::take(&mut self.shadows);
        for task in tasks.drain(..) {
            self.statistics.shadow_rays += 1;
            let (left, limit_reached) =
                shadow::transmittance(self.world, &task.ray, task.media, &mut self.counters);
            self.statistics.pass_through_limit_reached += u64::from(limit_reached);
            self.values[task.sample as usize].radiance += task.contribution * left;
        }
        self.shadows = tasks;
    }
}
