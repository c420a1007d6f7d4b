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
    /// Directions of the lobes that were given in lanes.
    directions: Vec3Lanes,
    /// Those of diffuse lobes.
    diffuse: ActiveLanes,
    /// Those of glossy lobes.
    glossy: ActiveLanes,
}

/// Lobes of lookups.
#[derive(Debug, Default)]
pub(super) struct LobeLanes {
    /// Normals of diffuse lobes, too.
    pub(super) axes: Vec3Lanes,
    /// Roughness of glossy lobes.
    pub(super) roughness: F32Lanes,
    pub(super) diffuse: ActiveLanes,
    pub(super) glossy: ActiveLanes,
}

impl LobeLanes {
    /// Adds the lobe of a lane that has none.
    pub(super) fn set(&mut self, lane: usize, lobe: &LookupLobe) {
        self.axes.set(lane, lobe.middle());
        match lobe {
            LookupLobe::Diffuse { .. } => self.diffuse = self.diffuse.with(lane),
            LookupLobe::Glossy(lobe) => {
                self.roughness[lane] = lobe.roughness;
                self.glossy = self.glossy.with(lane);
            }
        }
    }
}

impl SampledLookups {
    /// Samples lookups whose sequences are set. Those that have other lobes than the expected `lobes` get directions one by one.
    pub(super) fn sample(
        &mut self,
        context: &IntegratorContext<'_>,
        directions: &EnvironmentDirections,
        lanes: ActiveLanes,
        lobes: &LobeLanes,
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
        [self.diffuse, self.glossy] =
            [lobes.diffuse, lobes.glossy].map(|of_kind| self.traced.filtered(|lane| of_kind.contains(lane)));
        let axes = |lanes| LookupLanes { level, directions: &lobes.axes, lanes };
        if !self.diffuse.is_empty() {
            directions.diffuse_lanes(&axes(self.diffuse), (points, randoms), &mut self.directions);
        }
        // Keeps other lanes.
        if !self.glossy.is_empty() {
            let sampled = (&*points, &*randoms);
            directions.glossy_lanes(&axes(self.glossy), &lobes.roughness, sampled, &mut self.directions);
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
        self.traced.contains(lane).then(|| {
            // The lobe may be another one than was expected.
            let in_lanes = match lobe {
                LookupLobe::Diffuse { .. } => self.diffuse,
                LookupLobe::Glossy(_) => self.glossy,
            };
            if in_lanes.contains(lane) {
                self.directions.get(lane)
            } else {
                lobe.sample(directions, (self.points.get(lane), self.randoms[lane]))
            }
        })
    }
}

/// The sample point of the first ray of a lookup, where the lookup sends one: its first coordinate is below 1 for a share of the points,
/// which are as well distributed as all.
#[inline(always)]
pub(super) fn traced_point(u: Vec2, traced_share: f32) -> Vec2 {
    Vec2::new(u.x / traced_share, u.y)
}
