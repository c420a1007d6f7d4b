//! Counters of an integrator.

use serde::{Deserialize, Serialize};

/// Counters of one or several batches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IntegratorStatistics {
    /// Camera rays.
    pub camera_rays: u64,
    /// Camera rays that hit anything.
    pub camera_hits: u64,
    /// Mirror rays; of paths, all reflected rays.
    pub reflection_rays: u64,
    /// Refraction rays; of paths, all transmitted rays.
    pub refraction_rays: u64,
    /// Shadow rays, and rays that find what stopped those to the environment.
    pub shadow_rays: u64,
    /// Wide nodes visited by all rays.
    pub nodes: u64,
    /// Triangles tested by all rays.
    pub triangles: u64,
    /// Sample weight that the depth limit and the weight cut-off dropped, in units of whole samples.
    pub dropped_weight: f64,
    /// Rays whose chain of transparent surfaces reached its limit.
    pub transparency_limit_reached: u64,
    /// Seconds inside the hierarchy's batch queries, summed over threads. Single rays beyond transparent surfaces and the
    /// probes of surfaces that touch glass are not counted.
    pub query_seconds: f64,
}

impl IntegratorStatistics {
    /// Adds another batch. Call in a fixed order, since two of the sums are in floating point.
    pub fn add(&mut self, other: &Self) {
        self.camera_rays += other.camera_rays;
        self.camera_hits += other.camera_hits;
        self.reflection_rays += other.reflection_rays;
        self.refraction_rays += other.refraction_rays;
        self.shadow_rays += other.shadow_rays;
        self.nodes += other.nodes;
        self.triangles += other.triangles;
        self.dropped_weight += other.dropped_weight;
        self.transparency_limit_reached += other.transparency_limit_reached;
        self.query_seconds += other.query_seconds;
    }
}
