//! A surface that a ray of a wavefront sees.

use super::wavefront::RaySlot;
use crate::bvh::Hit;
use crate::integrator::LightPass;

/// A surface that a ray sees, to be shaded.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceHit {
    /// The ray.
    pub(super) slot: RaySlot,
    pub(super) hit: Hit,
    /// Share of the ray: what transparent surfaces in front of the hit leave, times the coverage of the hit itself.
    pub(super) share: f32,
    /// The light pass of everything that leaves the surface; `None` where the surface is the first one that the camera sees.
    pub(super) light_pass: Option<LightPass>,
}
