//! Queue of shadow rays: filled while surfaces are shaded, traced in batches.

use glam::Vec3;

use super::wavefront::RaySignature;
use crate::geometry::Ray;
use crate::integrator::shadow::ShadowBatch;
use crate::integrator::{LightPass, MediaStack};

/// The shadow rays of a wavefront.
#[derive(Debug)]
pub(super) struct ShadowQueue {
    lights: usize,
    /// One batch for each signature of the shaded ray and each light. The rays of one light start together, and surfaces
    /// that were seen along one signature lie together.
    pub(super) batches: Vec<ShadowBatch>,
    /// In the order in which they were added.
    pub(super) tasks: Vec<ShadowTask>,
}

/// Light that reaches the camera unless its shadow ray is occluded.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowTask {
    pub(super) sample: u32,
    pub(super) light_pass: LightPass,
    /// Index of the batch that holds the ray.
    pub(super) batch: u32,
    /// Index of the ray in its batch.
    pub(super) ray: u32,
    /// Radiance of the sample without occlusion.
    pub(super) contribution: Vec3,
}

/// A shadow ray and the light that it decides about.
pub(super) struct ShadowRay {
    /// Signature of the shaded ray.
    pub(super) signature: RaySignature,
    /// Index of the light.
    pub(super) light: usize,
    pub(super) ray: Ray,
    pub(super) sample: u32,
    pub(super) light_pass: LightPass,
    pub(super) contribution: Vec3,
    /// The volumes in which the ray starts, as far as they are known.
    pub(super) media: MediaStack,
}

impl ShadowQueue {
    /// An empty queue for `lights` lights.
    pub(super) fn new(lights: usize) -> Self {
        Self { lights, batches: Vec::new(), tasks: Vec::new() }
    }

    /// Adds a ray after all others.
    #[inline]
    pub(super) fn push(&mut self, shadow: ShadowRay) {
        let ShadowRay { signature, light, ray, sample, light_pass, contribution, media } = shadow;
        let batch = signature.index() * self.lights + light;
        if batch >= self.batches.len() {
            self.batches.resize_with(batch + 1, ShadowBatch::default);
        }
        let ray = self.batches[batch].push(ray, media);
        self.tasks.push(ShadowTask { sample, light_pass, batch: batch as u32, ray, contribution });
    }
}
