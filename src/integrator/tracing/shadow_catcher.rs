//! Shadow catchers: invisible surfaces that show the shadows on them, to be composited over another image.
//!
//! The opacity of a catcher is the occluded share of its direct light, by luminance, times its coverage; its colour is black. Light of the environment
//! counts where shadow rays find what occludes it. Catchers occlude nothing.

use super::receiver_shadows::ReceivedLight;
use super::receivers::Receiver;
use super::tracer::Tracer;
use crate::bvh::Hit;
use crate::integrator::wavefront::FollowedRay;
use crate::interaction::{RayDifferential, SurfacePoint};

impl<'a> Tracer<'_, 'a> {
    /// The share of direct light that is occluded where a ray hits a shadow catcher; 0 where no light shines. `received` is the light there, where it
    /// is known, and `number` that of the receiver along the ray.
    pub(super) fn caught_shadow(
        &mut self,
        followed: FollowedRay<'_>,
        hit: &Hit,
        received: Option<ReceivedLight>,
        number: u32,
    ) -> f32 {
        let ReceivedLight { unoccluded, arriving } = received.unwrap_or_else(|| {
            let (receiver, point) = self.catcher_receiver(followed, hit, number);
            self.direct_light_on(&receiver, |span| point.shadow_end_outside(span))
        });
        if unoccluded > 0.0 { (1.0 - arriving / unoccluded).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The point of a shadow catcher that a ray hits, its receiver with this number.
    pub(super) fn catcher_receiver(
        &self,
        FollowedRay { ray, state, .. }: FollowedRay<'_>,
        hit: &Hit,
        number: u32,
    ) -> (Receiver, SurfacePoint<'a>) {
        let point = SurfacePoint::new(self.context.view, ray, hit, &RayDifferential::ZERO);
        let (position, normal) = (point.position, point.shading_normal);
        let points = self.receiver_points(state, number);
        (Receiver { position, normal, seed: state.seed, points }, point)
    }
}
