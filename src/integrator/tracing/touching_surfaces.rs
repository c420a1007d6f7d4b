//! Finding the transmission sides of surfaces: the volumes there, and the surfaces that touch these.

use std::time::Instant;

use glam::Vec3;

use super::tracer::{Tracer, seconds_since};
use super::transmission_probes::TransmissionProbes;
use crate::bvh::{Hit, HitOrder, TriangleFlags};
use crate::geometry::{Facing, Ray};
use crate::integrator::media::MediaCache;
use crate::integrator::ray_state::{PassedSide, Touching};
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::transmission_side::TransmissionSide;
use crate::integrator::{IntegratorContext, RayState};
use crate::interaction::{MaterialSample, SurfacePoint, alpha_at, catches_shadows, is_opaque_at};
use crate::scene_view::SceneView;

/// How many surfaces give way at most, each to the next. Two that touch may both be found behind the other.
const MOST_REPLACED: u8 = 4;

impl Tracer<'_, '_> {
    /// Probes the transmission sides of a block of points, for [`Tracer::transmission_side`].
    pub(in crate::integrator) fn probe_transmission_sides(
        &mut self,
        points: &[SurfacePoint<'_>],
        materials: &[MaterialSample],
    ) {
        let TransmissionProbes { rays, of_point, is_occluded, touching } = &mut self.probes;
        rays.clear();
        of_point.clear();
        for (point, material) in points.iter().zip(materials) {
            let transmits = material.transmission > 0.0
                || material.diffuse_transmission > 0.0
                || self.context.interiors.medium(point.instance).is_some();
            of_point.push(transmits.then_some(rays.len() as u32));
            if transmits {
                let start = point.origin_outside();
                rays.push(Ray { t_max: 1.0, ..Ray::new(start, point.origin_inside() - start) });
            }
        }
        touching.clear();
        is_occluded.clear();
        is_occluded.resize(rays.len(), false);
        if rays.is_empty() {
            return;
        }
        let view = self.context.view;
        let start = Instant::now();
        let collect = |probe: usize, hit: &Hit| {
            if is_surface(view, hit) {
                touching.add(probe, hit);
            }
            false
        };
        view.bvh.occluded_rays(rays, collect, is_occluded, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);
        touching.sort(rays.len(), |probe| !is_occluded[probe]);
    }

    /// The transmission side of the point with index `index` of the probed block, for a ray with this state. A refracted ray starts beyond every face
    /// that touches this one, so all of their volumes are entered or left here, up to the first surface that bounds none.
    pub(in crate::integrator) fn transmission_side(
        &mut self,
        state: &RayState,
        (index, point): (usize, &SurfacePoint<'_>),
    ) -> TransmissionSide {
        let mut side = TransmissionSide { media: state.media.clone(), touching: None };
        let Some(probe) = self.probes.of_point[index] else { return side };
        let view = self.context.view;
        if let Some(medium) = self.context.interiors.medium(point.instance) {
            side.media.cross(medium, point.facing, &mut self.media_cache);
        }
        let TransmissionProbes { rays, is_occluded, touching, .. } = &self.probes;
        let side_and_cache = (&mut side, &mut self.media_cache);
        if is_occluded[probe as usize] || touching.is_overfull() {
            // Opaque surfaces are not collected: one query for each surface.
            let ray = &rays[probe as usize];
            let next = |after| {
                let is_surface = |hit: &Hit| is_surface(view, hit);
                view.bvh.closest_hit_of_any_side(ray, after, is_surface, &mut self.counters)
            };
            cross_touching(self.context, side_and_cache, (state, point), next);
        } else {
            cross_touching(self.context, side_and_cache, (state, point), touching.along(probe));
        }
        side
    }

    /// Replaces a surface by an opaque one that touches it from behind, which is then shaded with the same ray; returns whether there is one. Glass gives way to
    /// all of them, so that light does not leave a volume before it reaches the floor below, and any that does not shine to those that shine: shadow
    /// rays of others end before both.
    pub(in crate::integrator) fn replace_by_touching(
        &mut self,
        surface_hit: &SurfaceHit,
        material: &MaterialSample,
        side: &TransmissionSide,
    ) -> bool {
        let Some(touching) = &side.touching else { return false };
        let frame = self.context.view.frame;
        let shines =
            |hit: &Hit| frame.materials[frame.instance(hit.triangle).material.index()].emissive != Vec3::ZERO;
        let gives_way = material.transmission > 0.0 || (shines(&touching.hit) && !shines(&surface_hit.hit));
        let is_replaced = gives_way
            && surface_hit.replaced < MOST_REPLACED
            && is_opaque_at(self.context.view, &touching.hit);
        if is_replaced {
            let hit = Hit { t: surface_hit.hit.t, ..touching.hit };
            self.surface_hits.push(SurfaceHit { hit, replaced: surface_hit.replaced + 1, ..*surface_hit });
        }
        is_replaced
    }
}

fn is_surface(view: SceneView<'_>, hit: &Hit) -> bool {
    alpha_at(view, hit) > 0.0 && !catches_shadows(view, hit)
}

/// Enters or leaves the volumes of the surfaces that touch at `point`, up to the first surface that bounds none. `next` returns
/// the next surface of the probe after a given hit.
fn cross_touching(
    context: &IntegratorContext<'_>,
    (side, cache): (&mut TransmissionSide, &mut MediaCache),
    (state, point): (&RayState, &SurfacePoint<'_>),
    mut next: impl FnMut(Option<HitOrder>) -> Option<Hit>,
) {
    let frame = context.view.frame;
    let arriving = state.touching_at(point.triangle);
    let own = PassedSide { triangle: point.triangle, facing: point.facing };
    let mut crossed = Vec::new();
    let mut after = None;
    while let Some(hit) = next(after) {
        after = Some(hit.order());
        let instance = frame.instance(hit.triangle);
        // The surface itself, or a neighbouring triangle where the point lies just beyond its edge
        let is_this = |side: &PassedSide| {
            std::ptr::eq(instance, frame.instance(side.triangle)) && hit.facing == side.facing
        };
        let before = arriving.map_or(&[][..], |touching| &touching.passed);
        if is_this(&own) || before.iter().any(is_this) {
            continue;
        }
        let flags = frame.flags[hit.triangle as usize];
        match context.interiors.medium(instance) {
            Some(medium) => {
                side.media.cross(medium, hit.facing, cache);
                crossed.push(PassedSide { triangle: hit.triangle, facing: hit.facing });
            }
            None if hit.facing == Facing::Back && flags.has(TriangleFlags::SINGLE_SIDED) => {}
            None => {
                let media = arriving.map_or(&state.media, |touching| &touching.media).clone();
                let passed = before.iter().copied().chain([own]).chain(crossed).collect();
                side.touching = Some(Box::new(Touching { hit: Hit { t: 0.0, ..hit }, media, passed }));
                break;
            }
        }
    }
}
