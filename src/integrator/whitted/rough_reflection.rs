//! Rough reflection without an environment. There is no light to look up, so one sampled ray follows a bright lobe: rough metals would be black but for highlights.

use glam::Vec3;

use super::environment_shadows::on_side;
use super::reflected_lobe::ReflectedLobe;
use super::secondary_rays::ChildRay;
use super::shading::Arrival;
use crate::geometry::{Ray, smoothstep};
use crate::integrator::RayKind;
use crate::integrator::random::Purpose;
use crate::integrator::tracing::Tracer;

/// Between these albedos of a lobe the followed share rises from 0 to 1. Dielectrics reflect less, but at grazing angles and totally.
const FOLLOWED_ALBEDO: [f32; 2] = [0.3, 0.5];

impl Tracer<'_, '_> {
    /// Share of a specular lobe that a sampled ray follows instead of a mirror ray, by the share that the latter has where lobes are looked up.
    pub(super) fn followed_reflection(&self, albedo: Vec3, traced_share: f32) -> f32 {
        if traced_share == 1.0 || !self.context.follows_rough_reflection() {
            return 0.0;
        }
        smoothstep(FOLLOWED_ALBEDO, albedo.max_element())
    }

    /// Sends the sampled ray. `weight` multiplies the radiance that the lobe reflects.
    pub(super) fn follow_reflection(
        &mut self,
        arrival: &Arrival<'_, '_>,
        lobe: &ReflectedLobe<'_>,
        weight: Vec3,
    ) {
        let Arrival { signature, state, point, .. } = *arrival;
        if !self.may_send(state, weight * lobe.albedo) {
            return;
        }
        let u = self.point_of_reflection(signature, state);
        let Some((wi, lobe_weight)) = lobe.bsdf.sample_reflection(lobe.wo, lobe.terms, u) else { return };
        let direction = on_side((lobe.world_from_local * wi).normalize(), point.geometric_normal, true);
        let ray = Ray::new(point.origin_outside(), direction);
        let seed = state.seed.child(Purpose::Reflection, 0, 1);
        let child = ChildRay::sampled(ray, weight * lobe_weight, RayKind::Reflection, (state.channels, seed));
        self.send_reflected(arrival, child);
    }
}
