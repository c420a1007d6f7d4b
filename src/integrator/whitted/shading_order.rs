//! The order in which the hits of a wavefront are shaded: by material, those that a block shades as a whole first.
//!
//! The order of a sample's own hits depends on nothing but these hits, so that its sum is the same in every batch.

use super::surface_hit::SurfaceHit;

/// Hits sorted for shading. Keeps its memory.
#[derive(Debug, Default)]
pub(super) struct ShadingOrder {
    /// Key of the run and index of the hit.
    keys: Vec<(RunKey, u32)>,
    sorted: Vec<SurfaceHit>,
}

/// What the hits of a run have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RunKey {
    /// Whether the whole shading is left to each hit.
    pub(super) is_layered: bool,
    /// Index of the material.
    pub(super) material: u32,
}

impl ShadingOrder {
    /// Sorts `hits` by their keys; hits of equal keys keep their order.
    pub(super) fn sort(&mut self, hits: &[SurfaceHit], key: impl Fn(&SurfaceHit) -> RunKey) {
        self.keys.clear();
        self.keys.extend(hits.iter().zip(0..).map(|(hit, index)| (key(hit), index)));
        self.keys.sort_unstable();
        self.sorted.clear();
        self.sorted.extend(self.keys.iter().map(|&(_, index)| hits[index as usize]));
    }

    /// The sorted hits, run by run.
    pub(super) fn runs(&self) -> impl Iterator<Item = (RunKey, &[SurfaceHit])> {
        let mut rest = self.sorted.as_slice();
        self.keys.chunk_by(|a, b| a.0 == b.0).map(move |keys| {
            let (hits, after) = rest.split_at(keys.len());
            rest = after;
            (keys[0].0, hits)
        })
    }
}
