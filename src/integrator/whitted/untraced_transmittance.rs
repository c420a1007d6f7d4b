//! What a volume absorbs of looked-up light that no shadow ray follows out of it.

use std::time::Instant;

use glam::Vec3;

use super::environment_shadows::{EnvironmentLookup, on_side};
use super::tracer::{Tracer, seconds_since};
use crate::bvh::Hit;
use crate::geometry::{Facing, Ray};
use crate::integrator::MediaStack;
use crate::interaction::SurfacePoint;

impl Tracer<'_, '_> {
    /// Transmittance of `media`, which fill the side of a lookup, along the middle of its lobe: up to where that leaves the volume or meets an
    /// opaque surface. Most lookups are outside of volumes and need no query.
    pub(super) fn untraced_transmittance(
        &mut self,
        point: &SurfacePoint<'_>,
        lookup: &EnvironmentLookup,
        media: &MediaStack,
    ) -> Vec3 {
        let Some(medium) = media.current().filter(|medium| medium.extinction != Vec3::ZERO) else {
            return Vec3::ONE;
        };
        let origin = if lookup.is_outside { point.origin_outside() } else { point.origin_inside() };
        let direction = on_side(lookup.lobe.middle(), point.geometric_normal, lookup.is_outside);
        let (view, interiors) = (self.context.view, &self.context.interiors);
        let leaves = |hit: &Hit| {
            let of_hit = interiors.medium(view.frame.instance(hit.triangle));
            hit.facing == Facing::Back && of_hit.is_some_and(|of_hit| of_hit.volume == medium.volume)
        };
        let start = Instant::now();
        let ray = Ray::new(origin, direction);
        let end = view.bvh.closest_hit_of_any_side(&ray, None, leaves, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);
        // A ray that leaves the scene without leaving the volume is in it for ever.
        medium.transmittance(end.map_or(f32::INFINITY, |hit| hit.t))
    }
}
