//! The order in which the hits of a wavefront are shaded: by material, those that a block shades as a whole first.
//!
//! The order of a sample's own hits depends on nothing but these hits, so that its sum is the same in every batch.

use crate::integrator::surface_hit::SurfaceHit;

/// Bits of a key for the index of a hit; the remaining ones hold the material.
const INDEX_BITS: u32 = 32;
const INDEX: u64 = (1 << INDEX_BITS) - 1;
const MAX_MATERIAL: u32 = (1 << 31) - 1;

/// Hits sorted for shading. Keeps its memory.
#[derive(Debug, Default)]
pub(super) struct ShadingOrder {
    /// Bits of the run's key above the index of the hit.
    keys: Vec<u64>,
    sorted: Vec<SurfaceHit>,
}

/// What the hits of a run have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RunKey {
    /// Whether the hits are shaded by their points, which a block computes: those of paths and of glossy samples, and of Whitted's tree all but those
    /// on a plain material in vacuum.
    pub(super) needs_points: bool,
    /// Index of the material.
    pub(super) material: u32,
}

impl RunKey {
    fn bits(self) -> u64 {
        u64::from(self.needs_points) << 63 | u64::from(self.material) << INDEX_BITS
    }

    fn of_bits(bits: u64) -> Self {
        Self { needs_points: bits >> 63 == 1, material: (bits >> INDEX_BITS) as u32 & MAX_MATERIAL }
    }
}

impl ShadingOrder {
    /// Sorts `hits` by their keys; hits of equal keys keep their order.
    pub(super) fn sort(&mut self, hits: &[SurfaceHit], key: impl Fn(&SurfaceHit) -> RunKey) {
        self.keys.clear();
        self.keys.extend(hits.iter().zip(0_u64..).map(|(hit, index)| key(hit).bits() | index));
        self.keys.sort_unstable();
        self.sorted.clear();
        self.sorted.extend(self.keys.iter().map(|key| hits[(key & INDEX) as usize]));
    }

    /// The sorted hits, run by run.
    pub(super) fn runs(&self) -> impl Iterator<Item = (RunKey, &[SurfaceHit])> {
        let mut rest = self.sorted.as_slice();
        self.keys.chunk_by(|a, b| a & !INDEX == b & !INDEX).map(move |keys| {
            let (hits, after) = rest.split_at(keys.len());
            rest = after;
            (RunKey::of_bits(keys[0]), hits)
        })
    }
}
