//! Transparent surfaces along a path.

use super::dimensions::Decision;
use crate::integrator::Integrator;
use crate::integrator::RayState;
use crate::integrator::tracing::Tracer;

impl Tracer<'_, '_> {
    /// The share of a ray that stays at a surface with coverage `alpha`. A path goes on along one ray, so beyond its first surface it stays at a
    /// surface or passes it. `passes` counts the decisions of the ray.
    pub(in crate::integrator) fn covered_share(&self, state: &RayState, alpha: f32, passes: &mut u32) -> f32 {
        let is_whole = alpha >= 1.0 || state.depth == 0;
        if is_whole || self.context.settings.integrator == Integrator::Whitted {
            return alpha;
        }
        let dimension = Decision::Coverage.dimension(state.depth) + (*passes << 16);
        *passes += 1;
        let u = self.sequences[state.sample as usize].number(dimension);
        if u < alpha { 1.0 } else { 0.0 }
    }
}
