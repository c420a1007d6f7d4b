//! What lies on the other side of a surface: the volumes there, and what touches it.

use super::Tracer;
use crate::bvh::{Hit, HitOrder, TriangleFlags};
use crate::geometry::{Facing, Ray};
use crate::integrator::{ColorChannels, IntegratorContext, MediaStack, Medium, RayState};
use crate::interaction::{MaterialSample, SurfacePoint, alpha_at, catches_shadows};

impl Tracer<'_, '_> {
    /// What lies behind a surface that lets light through. A refracted ray starts beyond every face that touches this one,
    /// so all of their volumes are crossed here, up to the first surface that is none.
    pub(super) fn behind(
        &mut self,
        state: &RayState,
        point: &SurfacePoint<'_>,
        material: &MaterialSample,
    ) -> TransmissionSide {
        let view = self.context.view;
        let mut behind = TransmissionSide { media: state.media.clone(), touching: None };
        let medium = self.context.interiors.medium(point.instance);
        if let Some(medium) = medium {
            behind.media.cross(medium, point.facing);
        } else if material.transmission == 0.0 {
            return behind;
        }
        // From the start of mirrored rays to that of refracted ones.
        let start = point.origin_outside();
        let probe = Ray { t_max: 1.0, ..Ray::new(start, point.origin_inside() - start) };
        let there = |hit: &Hit| alpha_at(view, hit) > 0.0 && !catches_shadows(view, hit);
        let (bvh, touching) = (self.context.view.bvh, &mut self.touching);
        touching.clear();
        let collect = |hit: &Hit| {
            if there(hit) {
                touching.add(0, hit);
            }
            false
        };
        if bvh.occluded(&probe, collect, &mut self.counters) || touching.is_overfull() {
            // Solid surfaces were not collected: one query for each.
            let one = |after| bvh.closest_surface(&probe, after, there, &mut self.counters);
            cross_touching(self.context, &mut behind, point, one);
        } else {
            touching.sort(|_| true);
            cross_touching(self.context, &mut behind, point, touching.along(0));
        }
        behind
    }
}

/// Crosses the volumes that touch at `point` behind its own, up to the first surface that is none. `next` gives the
/// surfaces between the two sides.
fn cross_touching(
    context: &IntegratorContext<'_>,
    behind: &mut TransmissionSide,
    point: &SurfacePoint<'_>,
    mut next: impl FnMut(Option<HitOrder>) -> Option<Hit>,
) {
    let frame = context.view.frame;
    let mut after = None;
    while let Some(hit) = next(after) {
        after = Some(hit.order());
        let instance = frame.instance(hit.triangle);
        // This surface itself, or a neighbour beside whose edge the point lies.
        if std::ptr::eq(instance, point.instance) && hit.facing == point.facing {
            continue;
        }
        let flags = frame.flags[hit.triangle as usize];
        match context.interiors.medium(instance) {
            Some(medium) => behind.media.cross(medium, hit.facing),
            None if hit.facing == Facing::Back && flags.has(TriangleFlags::SINGLE_SIDED) => {}
            None => {
                behind.touching = Some(Hit { t: 0.0, ..hit });
                break;
            }
        }
    }
}

/// What lies behind a surface.
pub(super) struct TransmissionSide {
    /// The volumes there.
    pub(super) media: MediaStack,
    /// A surface that bounds no volume and touches this one.
    pub(super) touching: Option<Hit>,
}

/// Index of refraction on the viewer's side. A back face of a volume is seen from within, even where the surface is not
/// closed and the ray never entered.
pub(super) fn ior_before(
    state: &RayState,
    inside: Option<Medium>,
    facing: Facing,
    channels: ColorChannels,
) -> f32 {
    match inside {
        Some(medium) if facing == Facing::Back && !state.media.holds(medium.volume) => {
            medium.ior_of(channels)
        }
        _ => state.media.ior(channels),
    }
}

/// Index of refraction behind the surface: what fills the space there, or for walls and solids the material's own.
pub(super) fn ior_behind(
    material: &MaterialSample,
    media_behind: &MediaStack,
    channels: ColorChannels,
) -> f32 {
    if material.thin { material.ior } else { media_behind.ior(channels) }
}
