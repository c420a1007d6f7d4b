//! A surface that a ray of a wavefront sees.

use super::LightPass;
use super::wavefront::{RaySlot, Wavefront};
use crate::bvh::Hit;
use crate::interaction::RayHit;

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
    /// How many surfaces that touch it gave way to it.
    pub(super) replaced: u8,
}

impl SurfaceHit {
    /// The hit with its ray.
    #[inline(always)]
    pub(super) fn ray_hit<'h>(&'h self, wavefront: &'h Wavefront) -> RayHit<'h> {
        let (ray, state) = wavefront.ray(self.slot);
        RayHit { ray, differential: &state.differential, hit: &self.hit }
    }
}
