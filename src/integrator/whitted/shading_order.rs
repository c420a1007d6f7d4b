//! The order in which the hits of a wavefront are shaded: opaque surfaces by material, then all others as the rays found them.
//!
//! The order of a sample's own hits depends on nothing but these hits, so that its sum is the same in every batch.

use super::surface_hit::SurfaceHit;

/// Key of hits that are not shaded in blocks.
const SINGLE: u32 = u32::MAX;

/// Hits sorted for shading. Keeps its memory.
#[derive(Debug, Default)]
pub(super) struct ShadingOrder {
    /// Index of the material, or [`SINGLE`], and index of the hit.
    keys: Vec<(u32, u32)>,
    sorted: Vec<SurfaceHit>,
}

/// Hits that are shaded together.
pub(super) struct HitRun<'o> {
    /// Index of the material where blocks shade the hits; they are shaded one by one otherwise.
    pub(super) material: Option<usize>,
    /// The hits.
    pub(super) hits: &'o [SurfaceHit],
}

impl ShadingOrder {
    /// Sorts `hits`; `block_material` is the index of a hit's material where a block may shade it.
    pub(super) fn sort(
        &mut self,
        hits: &[SurfaceHit],
        block_material: impl Fn(&SurfaceHit) -> Option<u32>,
    ) {
        self.keys.clear();
        self.keys.extend(
            hits.iter().zip(0..).map(|(hit, index)| (block_material(hit).unwrap_or(SINGLE), index)),
        );
        self.keys.sort_unstable();
        self.sorted.clear();
        self.sorted.extend(self.keys.iter().map(|&(_, index)| hits[index as usize]));
    }

    /// The sorted hits, material by material.
    pub(super) fn runs(&self) -> impl Iterator<Item = HitRun<'_>> {
        let mut rest = self.sorted.as_slice();
        self.keys.chunk_by(|a, b| a.0 == b.0).map(move |keys| {
            let (hits, after) = rest.split_at(keys.len());
            rest = after;
            HitRun { material: (keys[0].0 != SINGLE).then_some(keys[0].0 as usize), hits }
        })
    }
}
