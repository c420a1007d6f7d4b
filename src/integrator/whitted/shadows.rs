//! Light that arrives unless something is in its way: found while shading, asked about light by light, added in order.

use std::time::Instant;

use glam::Vec3;

use super::{Tracer, seconds_since};
use crate::geometry::Ray;
use crate::integrator::MediaStack;
use crate::integrator::shadow::ShadowBatch;

/// The shadow rays of a generation.
#[derive(Debug)]
pub(super) struct Shadows {
    /// By light, because rays of one lamp start together.
    batches: Vec<ShadowBatch>,
    tasks: Vec<Task>,
}

/// Light that reaches the eye if nothing is in its way.
#[derive(Debug)]
struct Task {
    sample: u32,
    light: u32,
    /// Subscript of the ray among those of the light.
    ray: u32,
    contribution: Vec3,
    /// The volumes that the ray starts in, as far as they are known.
    media: MediaStack,
}

impl Shadows {
    /// Room for the rays of so many lights.
    pub(super) fn new(lights: usize) -> Self {
        let mut batches = Vec::new();
        batches.resize_with(lights, ShadowBatch::default);
        Self { batches, tasks: Vec::new() }
    }

    /// Adds a task behind all others.
    pub(super) fn push(
        &mut self,
        light: usize,
        ray: Ray,
        sample: u32,
        (contribution, media): (Vec3, MediaStack),
    ) {
        let ray = self.batches[light].push(ray);
        self.tasks.push(Task { sample, light: light as u32, ray, contribution, media });
    }
}

impl Tracer<'_, '_> {
    /// Adds what arrives of the light that shading found.
    pub(super) fn trace_shadows(&mut self) {
        let Shadows { batches, tasks } = &mut self.shadows;

        // Solid surfaces, light by light
        let start = Instant::now();
        for batch in batches.iter_mut() {
            batch.trace(self.world, &mut self.counters);
        }
        self.statistics.query_seconds += seconds_since(start);

        // See-through ones and the sums, in the order of tasks
        self.statistics.shadow_rays += tasks.len() as u64;
        for Task { sample, light, ray, contribution, media } in tasks.drain(..) {
            let batch = &batches[light as usize];
            let (left, limit_reached) = batch.transmittance(self.world, ray, media, &mut self.counters);
            self.statistics.pass_through_limit_reached += u64::from(limit_reached);
            self.values[sample as usize].radiance += contribution * left;
        }
        for batch in batches {
            batch.clear();
        }
    }
}
