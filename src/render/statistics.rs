//! Statistics of a render.

use serde::{Deserialize, Serialize};

use crate::integrator::IntegratorStatistics;

/// Statistics of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RenderStatistics {
    /// Rays, nodes, triangles and dropped weight.
    pub integrator: IntegratorStatistics,
    /// Pixels that were infinite or not a number, and were set to black.
    pub non_finite_pixels: u64,
    /// Samples of paths that were infinite or not a number, and are left out.
    pub non_finite_samples: u64,
    /// Seconds of tracing and shading.
    pub trace_seconds: f64,
}

impl RenderStatistics {
    /// Adds another part of the same frame: a tile, a pass or a shutter sample.
    pub fn add(&mut self, other: &Self) {
        self.integrator.add(&other.integrator);
        self.non_finite_pixels += other.non_finite_pixels;
        self.non_finite_samples += other.non_finite_samples;
        self.trace_seconds += other.trace_seconds;
    }
}
