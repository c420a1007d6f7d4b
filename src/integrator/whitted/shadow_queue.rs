//! Light that arrives unless something is in its way: found while shading, asked about in batches, added in order.

use std::time::Instant;

use glam::Vec3;

use super::wavefront::RaySignature;
use super::{Tracer, seconds_since};
use crate::geometry::Ray;
use crate::integrator::shadow::ShadowBatch;
use crate::integrator::{LightPass, MediaStack};

/// The shadow rays of a generation.
#[derive(Debug)]
pub(super) struct Shadows {
    lights: usize,
    /// By route of the surface's ray and by light: rays of one lamp start together, and what was seen along one route
    /// lies together.
    batches: Vec<ShadowBatch>,
    tasks: Vec<Task>,
}

/// Light that reaches the eye if nothing is in its way.
#[derive(Debug)]
struct Task {
    sample: u32,
    part: LightPass,
    batch: u32,
    /// Subscript of the ray in its batch.
    ray: u32,
    contribution: Vec3,
    /// The volumes that the ray starts in, as far as they are known.
    media: MediaStack,
}

impl Shadows {
    /// No rays, for so many lights.
    pub(super) fn new(lights: usize) -> Self {
        Self { lights, batches: Vec::new(), tasks: Vec::new() }
    }

    /// Adds a task behind all others.
    pub(super) fn push(
        &mut self,
        (signature, light): (RaySignature, usize),
        ray: Ray,
        (sample, part): (u32, LightPass),
        (contribution, media): (Vec3, MediaStack),
    ) {
        let batch = signature.subscript() * self.lights + light;
        if batch >= self.batches.len() {
            self.batches.resize_with(batch + 1, ShadowBatch::default);
        }
        let ray = self.batches[batch].push(ray);
        self.tasks.push(Task { sample, part, batch: batch as u32, ray, contribution, media });
    }
}

impl Tracer<'_, '_> {
    /// Adds what arrives of the light that shading found.
    pub(super) fn trace_shadows(&mut self) {
        let Shadows { batches, tasks, .. } = &mut self.shadows;

        // Solid surfaces, batch by batch
        let start = Instant::now();
        for batch in batches.iter_mut().filter(|batch| !batch.is_empty()) {
            batch.trace(self.context, &mut self.counters);
        }
        self.statistics.query_seconds += seconds_since(start);

        // See-through ones and the sums, in the order of tasks
        self.statistics.shadow_rays += tasks.len() as u64;
        for Task { sample, part, batch, ray, contribution, media } in tasks.drain(..) {
            let batch = &batches[batch as usize];
            let (left, limit_reached) = batch.transmittance(self.context, ray, media, &mut self.counters);
            self.statistics.pass_through_limit_reached += u64::from(limit_reached);
            let arriving = contribution * left;
            self.values[sample as usize].radiance += arriving;
            self.records.add(sample, part, arriving);
        }
        for batch in batches {
            batch.clear();
        }
    }
}
