//! Statistics of a render.

use crate::integrator::IntegratorStatistics;

/// Statistics of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStatistics {
    /// Rays, nodes, triangles and dropped weight.
    pub integrator: IntegratorStatistics,
    /// Pixels that were infinite or not a number, and were set to black.
    pub non_finite_pixels: u64,
    /// Seconds of tracing and shading.
    pub trace_seconds: f64,
}

impl RenderStatistics {
    /// Adds another shutter sample of the same frame.
    pub fn add(&mut self, other: &Self) {
        self.integrator.add(&other.integrator);
        self.non_finite_pixels += other.non_finite_pixels;
        self.trace_seconds += other.trace_seconds;
    }
}
