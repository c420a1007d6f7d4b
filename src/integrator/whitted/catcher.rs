//! Shadow catchers: surfaces of which only the shadows on them are seen, to be laid over a picture.
//!
//! Their opacity is the share of direct light that something stands in the way of, by luminance, and their colour is black.
//! It is known before what lies behind is followed, so its shadow rays are asked at once instead of with those of the
//! generation. Light from the environment is not blocked by anything, so it is not counted. Catchers stand in nobody's way.

use super::Tracer;
use crate::bvh::Hit;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::integrator::{MediaStack, RayState};
use crate::interaction::{RayDifferential, SurfacePoint};

impl Tracer<'_, '_> {
    /// The share of direct light that does not arrive where `ray` meets a shadow catcher; none where no light shines.
    pub(super) fn caught_shadow(&mut self, ray: &Ray, state: &RayState, hit: &Hit) -> f32 {
        let context = self.context;
        let point = SurfacePoint::new(context.view, ray, hit, &RayDifferential::ZERO);
        let mut caught = std::mem::take(&mut self.caught);
        caught.clear();
        let mut lit = Vec::new();
        for (subscript, light) in context.lights.iter().enumerate() {
            let Some(incidence) = light.incidence(point.position) else { continue };
            let cosine = incidence.wi.dot(point.shading_normal);
            if cosine > 0.0 {
                let end = point.shadow_end_outside(light.shadow_span(point.position));
                let shadow_ray = light.shadow_ray(end, state.seed, subscript);
                lit.push((caught.push(shadow_ray), incidence.irradiance * cosine));
            }
        }
        caught.trace(context, &mut self.counters);
        self.statistics.shadow_rays += lit.len() as u64;
        let (mut all, mut arriving) = (0.0, 0.0);
        for (index, irradiance) in lit {
            let (left, limit_reached) =
                caught.transmittance(context, index, MediaStack::default(), &mut self.counters);
            self.statistics.pass_through_limit_reached += u64::from(limit_reached);
            all += luminance(irradiance);
            arriving += luminance(irradiance * left);
        }
        self.caught = caught;
        if all > 0.0 { (1.0 - arriving / all).clamp(0.0, 1.0) } else { 0.0 }
    }
}
