//! The transmission side of a surface: the volumes there, and the surfaces that touch it.

use super::tracer::Tracer;
use crate::bvh::{Hit, HitOrder, TriangleFlags};
use crate::geometry::{Facing, Ray};
use crate::integrator::{ColorChannels, IntegratorContext, MediaStack, Medium, RayState};
use crate::interaction::{MaterialSample, SurfacePoint, alpha_at, catches_shadows};

/// The transmission side of a surface.
pub(super) struct TransmissionSide {
    /// The volumes there.
    pub(super) media: MediaStack,
    /// A surface that bounds no volume and touches this one.
    pub(super) touching: Option<Hit>,
}

impl Tracer<'_, '_> {
    /// The transmission side of a surface that transmits light. A refracted ray starts beyond every face that touches this one,
    /// so all of their volumes are entered or left here, up to the first surface that bounds none.
    pub(super) fn transmission_side(
        &mut self,
        state: &RayState,
        point: &SurfacePoint<'_>,
        material: &MaterialSample,
    ) -> TransmissionSide {
        let view = self.context.view;
        let mut side = TransmissionSide { media: state.media.clone(), touching: None };
        let medium = self.context.interiors.medium(point.instance);
        if let Some(medium) = medium {
            side.media.cross(medium, point.facing);
        } else if material.transmission == 0.0 {
            return side;
        }
        // The probe runs from the start of mirror rays to that of refraction rays.
        let start = point.origin_outside();
        let probe = Ray { t_max: 1.0, ..Ray::new(start, point.origin_inside() - start) };
        let is_surface = |hit: &Hit| alpha_at(view, hit) > 0.0 && !catches_shadows(view, hit);
        let touching = &mut self.touching;
        touching.clear();
        let collect = |hit: &Hit| {
            if is_surface(hit) {
                touching.add(0, hit);
            }
            false
        };
        if view.bvh.occluded(&probe, collect, &mut self.counters) || touching.is_overfull() {
            // Opaque surfaces are not collected: one query for each surface.
            let next =
                |after| view.bvh.closest_hit_of_any_side(&probe, after, is_surface, &mut self.counters);
            cross_touching(self.context, &mut side, point, next);
        } else {
            touching.sort(|_| true);
            cross_touching(self.context, &mut side, point, touching.along(0));
        }
        side
    }
}

/// Enters or leaves the volumes of the surfaces that touch at `point`, up to the first surface that bounds none. `next` returns
/// the next surface of the probe after a given hit.
fn cross_touching(
    context: &IntegratorContext<'_>,
    side: &mut TransmissionSide,
    point: &SurfacePoint<'_>,
    mut next: impl FnMut(Option<HitOrder>) -> Option<Hit>,
) {
    let frame = context.view.frame;
    let mut after = None;
    while let Some(hit) = next(after) {
        after = Some(hit.order());
        let instance = frame.instance(hit.triangle);
        // The surface itself, or a neighbouring triangle where the point lies just beyond its edge
        if std::ptr::eq(instance, point.instance) && hit.facing == point.facing {
            continue;
        }
        let flags = frame.flags[hit.triangle as usize];
        match context.interiors.medium(instance) {
            Some(medium) => side.media.cross(medium, hit.facing),
            None if hit.facing == Facing::Back && flags.has(TriangleFlags::SINGLE_SIDED) => {}
            None => {
                side.touching = Some(Hit { t: 0.0, ..hit });
                break;
            }
        }
    }
}

/// Index of refraction on the viewer's side. The back face of a volume is seen from within, even where the surface is not
/// closed and the ray never entered it.
pub(super) fn ior_outside(
    state: &RayState,
    own_medium: Option<Medium>,
    facing: Facing,
    channels: ColorChannels,
) -> f32 {
    match own_medium {
        Some(medium) if facing == Facing::Back && !state.media.holds(medium.volume) => {
            medium.ior_of(channels)
        }
        _ => state.media.ior(channels),
    }
}

/// Index of refraction on the transmission side: that of the medium there, or the material's own for thin walls and opaque
/// surfaces.
pub(super) fn ior_transmission_side(
    material: &MaterialSample,
    media: &MediaStack,
    channels: ColorChannels,
) -> f32 {
    if material.thin { material.ior } else { media.ior(channels) }
}
