//! Light that sampled rays find: emission of surfaces, and the environment.

use glam::Vec3;

use super::mis::power_heuristic;
use crate::integrator::clamp::clamped;
use crate::integrator::last_scatter::LastScatter;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::tracing::Tracer;
use crate::integrator::{ColorChannels, LightPass, RayState};
use crate::interaction::SurfacePoint;

impl Tracer<'_, '_> {
    /// Adds the emission of a surface to a path, `weighted` as the ray that finds it.
    pub(super) fn add_path_emission(
        &mut self,
        state: &RayState,
        last: Option<&LastScatter>,
        (surface_hit, point): (&SurfaceHit, &SurfacePoint<'_>),
        weighted: Vec3,
    ) {
        if weighted == Vec3::ZERO {
            return;
        }
        let Some(lights) = &self.context.emissive_triangles else { return };
        let share = lights.emission_weight(self.context.view, &surface_hit.hit, point, last);
        let light_pass = surface_hit
            .light_pass
            .map_or(LightPass::Emission, |pass| found_by(last, pass, LightPass::Direct));
        self.add_to_path(state, last, light_pass, weighted * share);
    }

    /// Weight and light pass of the environment that a ray sees.
    pub(in crate::integrator) fn path_environment(
        &self,
        direction: Vec3,
        light_pass: Option<LightPass>,
        last: Option<&LastScatter>,
    ) -> (f32, LightPass) {
        let pdf = |last: &LastScatter| self.context.environment_pdf(last.visible, direction);
        let share = last.map_or(1.0, |last| power_heuristic(last.pdf, pdf(last)));
        let pass =
            light_pass.map_or(LightPass::Environment, |pass| found_by(last, pass, LightPass::Environment));
        (share, pass)
    }

    /// Adds radiance that a ray finds to a path, clamped where it comes from beyond the first surface: as that of the shadow rays of the
    /// surface which the ray left, whether that surface looks for it, too, as `last` does, or is smooth.
    pub(in crate::integrator) fn add_to_path(
        &mut self,
        state: &RayState,
        last: Option<&LastScatter>,
        light_pass: LightPass,
        radiance: Vec3,
    ) {
        let depth = last.map_or(state.depth.saturating_sub(1), |last| last.depth);
        let radiance = clamped(radiance, self.clamp_at(depth, state.channels));
        self.add(state.sample, light_pass, radiance);
    }

    /// The largest component of light that a ray of a path finds, or that the shadow rays of a surface do at this depth. A path of one channel
    /// stands for three.
    pub(super) fn clamp_at(&self, depth: u32, channels: ColorChannels) -> f32 {
        if depth > 0 { self.context.settings.path.clamp_indirect * channels.gain() } else { f32::INFINITY }
    }
}

/// The light pass of a light that a ray finds whose light belongs to `pass`. A light that a rough lobe of the first surface finds by its sampled
/// ray is in the pass of its shadow ray.
fn found_by(last: Option<&LastScatter>, pass: LightPass, own: LightPass) -> LightPass {
    let is_first = last.is_some_and(|last| last.depth == 0) && pass != LightPass::Transparency;
    if is_first { own } else { pass }
}
