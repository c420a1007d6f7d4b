//! What a volume absorbs of looked-up light that no shadow ray follows out of it.

use std::time::Instant;

use glam::Vec3;

use super::environment_lookup::EnvironmentLookup;
use super::environment_shadows::on_side;
use crate::bvh::Hit;
use crate::geometry::{Facing, Ray};
use crate::integrator::glass_passage::GlassPassage;
use crate::integrator::media::{MediaStack, Medium};
use crate::integrator::shadow::stops_light;
use crate::integrator::tracing::{Tracer, seconds_since};
use crate::interaction::SurfacePoint;

impl Tracer<'_, '_> {
    /// Transmittance of the innermost of `media`, which fill the side of a lookup, along the middle of its lobe: up to where that leaves the volume or
    /// hits an opaque surface. Where it does neither, the light is taken to come from outside, as that of shadow rays. Most lookups are outside
    /// of volumes and need no query.
    #[inline(always)]
    pub(super) fn untraced_transmittance(
        &mut self,
        point: &SurfacePoint<'_>,
        lookup: &EnvironmentLookup,
        media: &MediaStack,
    ) -> Vec3 {
        let absorbing = media.current().filter(|medium| medium.extinction != Vec3::ZERO);
        match absorbing.filter(|_| lookup.radiance != Vec3::ZERO) {
            Some(medium) => self.transmittance_to_end(point, lookup, medium),
            None => Vec3::ONE,
        }
    }

    fn transmittance_to_end(
        &mut self,
        point: &SurfacePoint<'_>,
        lookup: &EnvironmentLookup,
        medium: &Medium,
    ) -> Vec3 {
        let origin = if lookup.is_outside { point.origin_outside() } else { point.origin_inside() };
        let direction = on_side(lookup.lobe.middle(), point.geometric_normal, lookup.is_outside);
        let context = self.context;
        let ends = |hit: &Hit| {
            let of_hit = context.interiors.medium(context.view.frame.instance(hit.triangle));
            let leaves =
                hit.facing == Facing::Back && of_hit.is_some_and(|of_hit| of_hit.volume == medium.volume);
            leaves || stops_light(context, hit, GlassPassage::Straight)
        };
        let start = Instant::now();
        let ray = Ray::new(origin, direction);
        let end = context.view.bvh.closest_hit_of_any_side(&ray, None, ends, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);
        end.map_or(Vec3::ONE, |hit| medium.transmittance(hit.t))
    }
}
