//! Whitted's recursive ray tracer (Whitted 1980, "An Improved Illumination Model for Shaded Display"), breadth first.
//!
//! A batch of samples is traced in generations: the closest hits of all rays → shading → all shadow rays → child rays with
//! their weights, which are the next generation. Every sample sums weight · radiance in generation order, and within one
//! in the order of its own rays, so that a sample's value does not depend on what else is in the batch.
//!
//! The hierarchy is asked in batches of one kind: closest hits by how rays came about, shadow rays by light, too. Neighbours in
//! a batch are neighbours on screen as far as the camera rays were.
//!
//! There is no hidden ambient term and nothing is random. What is left open by the material model is settled here:
//! smooth lobes are followed by mirror and refraction rays, rough ones look the environment up, and in between the two
//! are blended by roughness.

mod catcher;
mod coat;
mod environment;
mod glossy;
mod sample_aovs;
mod shading;
mod shadow_queue;
mod surface_hits;
mod transmission_side;
mod wavefront;

use std::time::Instant;

use glam::Vec3;

use super::shadow::ShadowBatch;
use super::transparent_hits::TransparentHits;
use super::{IntegratorContext, IntegratorStatistics, LightPass, LightPasses, RayState};
use crate::bvh::TraversalCounters;
use crate::geometry::Ray;

use sample_aovs::Records;
use shadow_queue::Shadows;
use surface_hits::SurfaceHit;
use wavefront::{RaySignature, Wavefront};

pub use sample_aovs::{InstanceCoverage, SampleAovFlags};

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

/// Traces batches of samples, one after the other in the same memory.
#[derive(Debug)]
pub struct Tracer<'w, 'a> {
    context: &'w IntegratorContext<'a>,
    values: Vec<SampleValue>,
    /// What is traced next.
    wavefront: Wavefront,
    children: Wavefront,
    surface_hits: Vec<SurfaceHit>,
    shadows: Shadows,
    /// The shadow rays of one point of a shadow catcher.
    caught: ShadowBatch,
    /// Surfaces that touch one that is being shaded.
    touching: TransparentHits,
    records: Records,
    counters: TraversalCounters,
    statistics: IntegratorStatistics,
}

impl<'w, 'a> Tracer<'w, 'a> {
    /// A tracer without rays.
    pub fn new(context: &'w IntegratorContext<'a>) -> Self {
        Self {
            context,
            values: Vec::new(),
            wavefront: Wavefront::default(),
            children: Wavefront::default(),
            surface_hits: Vec::new(),
            shadows: Shadows::new(context.lights.len()),
            caught: ShadowBatch::default(),
            touching: TransparentHits::default(),
            records: Records::default(),
            counters: TraversalCounters::default(),
            statistics: IntegratorStatistics::default(),
        }
    }

    /// The same tracer, which also records where light comes from or what is seen.
    #[must_use]
    pub fn recording(self, what: SampleAovFlags) -> Self {
        Self { records: Records::new(what), ..self }
    }

    /// The light of each sample of the last batch by parts; empty unless it is recorded.
    pub fn light_passes(&self) -> &[LightPasses] {
        self.records.light()
    }

    /// What the camera rays of the last batch saw, ray by ray in the order in which they were added; empty unless it is
    /// recorded.
    pub fn covers(&self) -> &[InstanceCoverage] {
        self.records.covers()
    }

    /// Adds a camera ray to the next batch; `path.sample` is a subscript of the result. Neighbours on screen should be
    /// neighbours in the batch.
    pub fn push(&mut self, ray: Ray, state: RayState) {
        self.wavefront.push(RaySignature::CAMERA, ray, state);
    }

    /// Traces the rays that were added, and all that follow from them, for `samples` values.
    pub fn trace(&mut self, samples: usize) -> &[SampleValue] {
        self.values.clear();
        self.values.resize(samples, SampleValue::default());
        self.records.clear(samples);
        let mut wavefront = std::mem::take(&mut self.wavefront);
        while !wavefront.is_empty() {
            self.find_surface_hits(&mut wavefront);
            self.shade_surface_hits(&wavefront);
            self.trace_shadows();
            wavefront.clear();
            std::mem::swap(&mut wavefront, &mut self.children);
        }
        self.wavefront = wavefront;
        &self.values
    }

    /// What all batches since the last call did.
    pub fn take_statistics(&mut self) -> IntegratorStatistics {
        let TraversalCounters { nodes, triangles, .. } = std::mem::take(&mut self.counters);
        IntegratorStatistics { nodes, triangles, ..std::mem::take(&mut self.statistics) }
    }

    fn add(&mut self, sample: u32, part: LightPass, radiance: Vec3) {
        self.values[sample as usize].radiance += radiance;
        self.records.add(sample, part, radiance);
    }
}

fn seconds_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64()
}

#[cfg(test)]
pub(super) mod tests;
