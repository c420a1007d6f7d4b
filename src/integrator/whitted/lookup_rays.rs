//! Directions of the first shadow rays of lookups, for the surfaces of a block together.

use arrayvec::ArrayVec;
use glam::Vec3;

use super::WhittedBuffers;
use super::environment_lookup::LookupLobe;
use super::environment_shadows::number_of;
use super::opaque_block::{BLOCK_LOOKUPS, OpaqueBlock};
use super::sampled_lookups::LobeLanes;
use crate::geometry::{ActiveLanes, LANES, Vec3Lanes};
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::tracing::Tracer;
use crate::integrator::wavefront::Wavefront;

/// Directions of a block's lookups, surface by surface; `None` where a lookup sends no ray.
pub(super) type LookupDirections = [[Option<Vec3>; BLOCK_LOOKUPS]; LANES];

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
            let mut lobes = LobeLanes::default();
            for (lane, queued) in together.iter().enumerate() {
                let slot = hits[queued.surface].slot;
                let sequence = &self.sequences[wavefront.ray(slot).1.sample as usize];
                let number = number_of(slot.signature, queued.index);
                let [keys, _] = self.whitted.lookup_keys.get(sequence.seed(), number, 0);
                sampled.sequences.set(lane, sequence, &keys);
                lobes.set(lane, &queued.lobe);
            }
            let lanes = ActiveLanes::first(together.len());
            sampled.sample(self.context, directions, lanes, &lobes);
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
        let lobes = LobeLanes { axes: *normals, diffuse: block_lookups.diffuse(), ..LobeLanes::default() };
        sampled.sample(self.context, directions, lanes, &lobes);
    }
}
