//! Directions of the first shadow rays of lookups, for the surfaces of a block together.

use arrayvec::ArrayVec;
use glam::Vec3;

use super::WhittedBuffers;
use super::environment_lookup::LookupLobe;
use super::environment_shadows::{number_of, traced_point};
use super::opaque_block::OpaqueBlock;
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec2Lanes, Vec3Lanes, vectorized};
use crate::integrator::IntegratorContext;
use crate::integrator::environment_directions::EnvironmentDirections;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::tracing::Tracer;
use crate::integrator::wavefront::Wavefront;
use crate::integrator::zsobol::SequenceLanes;
use crate::scene::LookupLanes;

/// Lookups of a surface of a block.
pub(super) const BLOCK_LOOKUPS: usize = 2;

/// Directions of a block's lookups, surface by surface; `None` where a lookup sends no ray.
pub(super) type LookupDirections = [[Option<Vec3>; BLOCK_LOOKUPS]; LANES];

/// Lookups that are sampled together. Keeps its memory from block to block.
#[derive(Debug, Default)]
pub(super) struct SampledLookups {
    sequences: SequenceLanes,
    points: Vec2Lanes,
    randoms: F32Lanes,
    /// Those that were sampled.
    lanes: ActiveLanes,
    /// Those that send rays.
    traced: ActiveLanes,
    /// Directions of diffuse lobes.
    directions: Vec3Lanes,
    /// Those that have one.
    diffuse: ActiveLanes,
}

/// A lookup of a surface of a block.
#[derive(Clone, Copy)]
struct BlockLookup {
    surface: usize,
    lookup: usize,
    /// Its number among those of the surface that look something up.
    index: usize,
    lobe: LookupLobe,
}

impl Tracer<'_, '_> {
    /// The directions of the lookups of a block of opaque surfaces.
    pub(super) fn lookup_directions(
        &mut self,
        block: &OpaqueBlock<'_>,
        wavefront: &Wavefront,
        hits: &[SurfaceHit],
    ) -> LookupDirections {
        let mut found = LookupDirections::default();
        let Some(directions) = &self.context.environment_directions else { return found };
        let mut queued: ArrayVec<BlockLookup, { LANES * BLOCK_LOOKUPS }> = ArrayVec::new();
        for surface in 0..hits.len() {
            let normal = block.surfaces.normals().get(surface);
            let lookups = (0..BLOCK_LOOKUPS).filter(|&lookup| block.reflected.looks_up(surface, lookup));
            queued.extend(lookups.enumerate().map(|(index, lookup)| {
                let lobe = block.reflected.looked_up_lobe(surface, lookup, normal);
                BlockLookup { surface, lookup, index, lobe }
            }));
        }
        for together in queued.chunks(LANES) {
            let sampled = &mut self.whitted.sampled_lookups;
            let (mut normals, mut diffuse) = (Vec3Lanes::default(), ActiveLanes::default());
            for (lane, queued) in together.iter().enumerate() {
                let slot = hits[queued.surface].slot;
                let sequence = &self.sequences[wavefront.ray(slot).1.sample as usize];
                let number = number_of(slot.signature, queued.index);
                let [keys, _] = self.whitted.lookup_keys.get(sequence.seed(), number, 0);
                sampled.sequences.set(lane, sequence, &keys);
                if let LookupLobe::Diffuse { normal } = queued.lobe {
                    normals.set(lane, normal);
                    diffuse = diffuse.with(lane);
                }
            }
            let lanes = ActiveLanes::first(together.len());
            sampled.sample(self.context, directions, lanes, (&normals, diffuse));
            for (lane, BlockLookup { surface, lookup, lobe, .. }) in together.iter().enumerate() {
                found[*surface][*lookup] = sampled.direction(lane, directions, lobe);
            }
        }
        found
    }

    /// Samples the first lookups of surfaces that are shaded one by one, those with index 0, after [`BlockLookups::fill`]. Blocks for which that
    /// found nothing are left out: most surfaces look up nothing.
    pub(super) fn sample_first_lookups(
        &mut self,
        wavefront: &Wavefront,
        hits: &[SurfaceHit],
        normals: &Vec3Lanes,
    ) {
        let WhittedBuffers { sampled_lookups: sampled, block_lookups, lookup_keys, .. } = &mut self.whitted;
        sampled.lanes = ActiveLanes::default();
        let Some(directions) = &self.context.environment_directions else { return };
        if block_lookups.is_empty() {
            return;
        }
        for (lane, SurfaceHit { slot, .. }) in hits.iter().enumerate() {
            let sequence = &self.sequences[wavefront.ray(*slot).1.sample as usize];
            let [keys, _] = lookup_keys.get(sequence.seed(), number_of(slot.signature, 0), 0);
            sampled.sequences.set(lane, sequence, &keys);
        }
        let lanes = ActiveLanes::first(hits.len());
        sampled.sample(self.context, directions, lanes, (normals, block_lookups.diffuse()));
    }
}

impl SampledLookups {
    /// Samples lookups whose sequences are set. Those in `diffuse` may be of the diffuse lobe around their normal.
    fn sample(
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
