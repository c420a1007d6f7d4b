//! Sample points and directions of lookups of the environment, in lanes.

use glam::{Vec2, Vec3};

use super::environment_lookup::LookupLobe;
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec2Lanes, Vec3Lanes, vectorized};
use crate::integrator::IntegratorContext;
use crate::integrator::environment_directions::EnvironmentDirections;
use crate::integrator::zsobol::SequenceLanes;
use crate::scene::LookupLanes;

/// Lookups that are sampled together. Keeps its memory from block to block.
#[derive(Debug, Default)]
pub(super) struct SampledLookups {
    pub(super) sequences: SequenceLanes,
    points: Vec2Lanes,
    randoms: F32Lanes,
    /// Those that were sampled.
    pub(super) lanes: ActiveLanes,
    /// Those that send rays.
    traced: ActiveLanes,
    /// Directions of diffuse lobes.
    directions: Vec3Lanes,
    /// Those that have one.
    diffuse: ActiveLanes,
}

impl SampledLookups {
    /// Samples lookups whose sequences are set. Those in `diffuse` may be of the diffuse lobe around their normal.
    pub(super) fn sample(
        &mut self,
        context: &IntegratorContext<'_>,
        directions: &EnvironmentDirections,
        lanes: ActiveLanes,
        (normals, diffuse): (&Vec3Lanes, ActiveLanes),
    ) {
        let Self { sequences, points, randoms, .. } = self;
        let level = context.view.bvh.simd_level();
        let traced_samples = context.traced_samples;
        vectorized!(level, {
            sequences.points_and_randoms(points, randoms);
            for lane in 0..LANES {
                points.set(lane, traced_point(points.get(lane), traced_samples));
            }
        });
        self.lanes = lanes;
        self.traced = lanes.filtered(|lane| points.get(lane).x < 1.0);
        self.diffuse = self.traced.filtered(|lane| diffuse.contains(lane));
        if !self.diffuse.is_empty() {
            let normals = LookupLanes { level, directions: normals, lanes: self.diffuse };
            directions.diffuse_lanes(&normals, (points, randoms), &mut self.directions);
        }
    }

    /// Whether a lookup was sampled.
    pub(super) fn contains(&self, lane: usize) -> bool {
        self.lanes.contains(lane)
    }

    /// The direction of a lookup's first ray, where it sends one.
    pub(super) fn direction(
        &self,
        lane: usize,
        directions: &EnvironmentDirections,
        lobe: &LookupLobe,
    ) -> Option<Vec3> {
        self.traced.contains(lane).then(|| match lobe {
            LookupLobe::Diffuse { .. } if self.diffuse.contains(lane) => self.directions.get(lane),
            _ => lobe.sample(directions, (self.points.get(lane), self.randoms[lane])),
        })
    }
}

/// The sample point of the first ray of a lookup, where the lookup sends one: its first coordinate is below 1 for a share of the points,
/// which are as well distributed as all.
#[inline(always)]
pub(super) fn traced_point(u: Vec2, traced_share: f32) -> Vec2 {
    Vec2::new(u.x / traced_share, u.y)
}
