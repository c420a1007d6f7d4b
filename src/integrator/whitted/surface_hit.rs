//! A surface that a ray of a wavefront sees.

use super::wavefront::{RaySlot, Wavefront};
use crate::bvh::Hit;
use crate::integrator::LightPass;
use crate::interaction::RayHit;

/// A surface that a ray sees, to be shaded.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct SurfaceHit {
    /// The ray.
    pub(in crate::integrator) slot: RaySlot,
    pub(in crate::integrator) hit: Hit,
    /// Share of the ray: what transparent surfaces in front of the hit leave, times the coverage of the hit itself.
    pub(in crate::integrator) share: f32,
    /// The light pass of everything that leaves the surface; `None` where the surface is the first one that the camera sees.
    pub(in crate::integrator) light_pass: Option<LightPass>,
}

impl SurfaceHit {
    /// The hit with its ray.
    #[inline(always)]
    pub(in crate::integrator) fn ray_hit<'h>(&'h self, wavefront: &'h Wavefront) -> RayHit<'h> {
        let (ray, state) = wavefront.ray(self.slot);
        RayHit { ray, differential: &state.differential, hit: &self.hit }
    }
}
