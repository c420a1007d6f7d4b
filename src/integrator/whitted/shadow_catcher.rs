//! Shadow catchers: invisible surfaces that show the shadows on them, to be composited over another image.
//!
//! The opacity of a catcher is the occluded share of its direct light, by luminance; its colour is black. The opacity must be known
//! before the ray goes on beyond the catcher, so its shadow rays are traced at once and not with those of the wavefront.
//! Light of the environment is never occluded and does not count. Catchers occlude nothing.

use super::tracer::Tracer;
use crate::bvh::Hit;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::integrator::{MediaStack, RayState};
use crate::interaction::{RayDifferential, SurfacePoint};

impl Tracer<'_, '_> {
    /// The share of direct light that is occluded where `ray` hits a shadow catcher; 0 where no light shines.
    pub(super) fn caught_shadow(&mut self, ray: &Ray, state: &RayState, hit: &Hit) -> f32 {
        let context = self.context;
        let point = SurfacePoint::new(context.view, ray, hit, &RayDifferential::ZERO);
        let mut batch = std::mem::take(&mut self.catcher_shadows);
        batch.clear();
        let mut lit = Vec::new();
        for (index, light) in context.lights.iter().enumerate() {
            let Some(incidence) = light.incidence(point.position) else { continue };
            let cosine = incidence.wi.dot(point.shading_normal);
            if cosine > 0.0 {
                let end = point.shadow_end_outside(light.shadow_span(point.position));
                let shadow_ray = light.shadow_ray(end, state.seed, index);
                lit.push((batch.push(shadow_ray), incidence.irradiance * cosine));
            }
        }
        batch.trace(context, &mut self.counters);
        self.statistics.shadow_rays += lit.len() as u64;
        let (mut all, mut arriving) = (0.0, 0.0);
        for (index, irradiance) in lit {
            let shadow = batch.transmittance(context, index, MediaStack::default(), &mut self.counters);
            self.statistics.transparency_limit_reached += u64::from(shadow.limit_reached);
            all += luminance(irradiance);
            arriving += luminance(irradiance * shadow.transmittance);
        }
        self.catcher_shadows = batch;
        if all > 0.0 { (1.0 - arriving / all).clamp(0.0, 1.0) } else { 0.0 }
    }
}
