//! Shadow rays whose occluders are lit, and what is found of these.

use glam::{Vec2, Vec3};

use crate::bvh::Hit;
use crate::geometry::Ray;
use crate::integrator::LightPass;
use crate::integrator::shadow::ShadowBatch;

/// A shadow ray of a lookup whose occluder is lit, if there is one.
#[derive(Clone, Copy, Debug)]
pub(super) struct OccluderTask {
    /// Index of the ray's task.
    pub(super) task: u32,
    /// Number of the sample points, as for lookups.
    pub(super) lookup: u32,
    /// Number of the ray among those of its lookup.
    pub(super) ray: u32,
    /// What the lookup scatters of light of radiance 1 from everywhere: the share of it about which the ray decides.
    pub(super) albedo: Vec3,
    /// What was added for an occluder that is not known.
    pub(super) reflected: Vec3,
    /// The same, but no more than the lookup itself.
    pub(super) limited: Vec3,
}

/// Shadow rays of lookups and their occluders, for one wavefront. Keeps its memory.
#[derive(Debug, Default)]
pub(super) struct OccluderBuffers {
    /// The tasks of the queued shadow rays whose occluders are lit.
    pub(super) queued: Vec<OccluderTask>,
    /// The stopped rays.
    pub(super) rays: Vec<Ray>,
    /// Their tasks.
    pub(super) tasks: Vec<StoppedTask>,
    /// What stops them.
    pub(super) occluders: Vec<Option<Hit>>,
    /// The rays as far as their occluders, where something may dim these.
    pub(super) segments: ShadowBatch,
    /// A ray for each light of an occluder.
    pub(super) shadows: ShadowBatch,
    pub(super) lit: Vec<LitOccluder>,
}

/// The task of a stopped ray, and random numbers in [0, 1) that direct the ray to its occluder's light.
#[derive(Clone, Copy, Debug)]
pub(super) struct StoppedTask {
    pub(super) task: OccluderTask,
    /// Selects one of the environment's lights.
    pub(super) light: f32,
    /// Selects a direction, with a random number.
    pub(super) direction: (Vec2, f32),
}

/// An occluder that a lookup sees, in one light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LitOccluder {
    pub(super) sample: u32,
    pub(super) light_pass: LightPass,
    /// What is scattered towards the camera where the light reaches the occluder, and where it does not; both less what was already added.
    pub(super) open: Vec3,
    pub(super) shadowed: Vec3,
}
