//! Queue of shadow rays: filled while surfaces are shaded, traced in batches.

use glam::Vec3;

use crate::geometry::Ray;
use crate::integrator::LightPass;
use crate::integrator::glass_passage::GlassPassage;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::shadow::ShadowBatch;
use crate::integrator::wavefront::RaySignature;

/// Tasks of one queue, unless a single sample has more. They take about 8 MB with their rays.
const MOST_TASKS: usize = 1 << 16;

/// Kinds of shadow rays up to which there are batches for each signature. More make many batches, of few rays each.
const MOST_KINDS_BY_SIGNATURE: usize = 64;

/// The shadow rays of a wavefront, or of some of its samples where all would be too many.
#[derive(Debug)]
pub(in crate::integrator) struct ShadowQueue {
    /// How light passes glass, for each kind of shadow ray.
    passages: Vec<GlassPassage>,
    /// Tasks that are queued together: [`MOST_TASKS`].
    pub(super) most_tasks: usize,
    /// One batch for each signature of the shaded ray and each light. The rays of one light start together, and surfaces
    /// that were seen along one signature lie together.
    pub(in crate::integrator) batches: Vec<ShadowBatch>,
    /// In the order in which they were added.
    pub(in crate::integrator) tasks: Vec<ShadowTask>,
}

/// Light that reaches the camera unless its shadow ray is occluded.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct ShadowTask {
    pub(in crate::integrator) sample: u32,
    pub(in crate::integrator) light_pass: LightPass,
    /// Index of the batch that holds the ray.
    pub(in crate::integrator) batch: u32,
    /// Index of the ray in its batch.
    pub(in crate::integrator) ray: u32,
    /// Radiance of the sample without occlusion.
    pub(in crate::integrator) contribution: Vec3,
    /// See [`ShadowRay::for_hidden`].
    pub(in crate::integrator) for_hidden: Vec3,
    /// See [`ShadowRay::environment_clamp`].
    pub(in crate::integrator) environment_clamp: Option<f32>,
}

/// A shadow ray and the light that it decides about.
pub(in crate::integrator) struct ShadowRay {
    /// Signature of the shaded ray.
    pub(in crate::integrator) signature: RaySignature,
    /// Index of the light, or of the kind of lights that follows these: [`crate::integrator::IntegratorContext::shadow_passages`].
    pub(in crate::integrator) light: usize,
    pub(in crate::integrator) ray: Ray,
    pub(in crate::integrator) sample: u32,
    pub(in crate::integrator) light_pass: LightPass,
    pub(in crate::integrator) contribution: Vec3,
    /// What was added for what may hide the light of the ray. It is taken away again as far as something tints the ray without hiding it.
    pub(in crate::integrator) for_hidden: Vec3,
    /// Where the contribution lacks the factor of the environment's radiance along the ray, which only rays that arrive look up: the
    /// largest component of the product.
    pub(in crate::integrator) environment_clamp: Option<f32>,
    pub(in crate::integrator) media: SurfaceMedia,
}

impl ShadowQueue {
    /// An empty queue for kinds of shadow rays with these passages.
    pub(in crate::integrator) fn new(passages: Vec<GlassPassage>) -> Self {
        Self { passages, most_tasks: MOST_TASKS, batches: Vec::new(), tasks: Vec::new() }
    }

    /// Adds a ray after all others. Returns the index of its task.
    #[inline(always)]
    pub(in crate::integrator) fn push(&mut self, shadow: ShadowRay) -> u32 {
        let ShadowRay {
            signature,
            light,
            ray,
            sample,
            light_pass,
            contribution,
            for_hidden,
            environment_clamp,
            media,
        } = shadow;
        let kinds = self.passages.len();
        let group = if kinds > MOST_KINDS_BY_SIGNATURE { 0 } else { signature.index() };
        let batch = group * kinds + light;
        if batch >= self.batches.len() {
            self.add_batches(batch);
        }
        let ray = self.batches[batch].push(ray, media);
        let batch = batch as u32;
        self.tasks.push(ShadowTask {
            sample,
            light_pass,
            batch,
            ray,
            contribution,
            for_hidden,
            environment_clamp,
        });
        self.tasks.len() as u32 - 1
    }

    /// Adds batches up to the one with this index.
    #[cold]
    fn add_batches(&mut self, last: usize) {
        for index in self.batches.len()..=last {
            self.batches.push(ShadowBatch::new(self.passages[index % self.passages.len()]));
        }
    }
}
