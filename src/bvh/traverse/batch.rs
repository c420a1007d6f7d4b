//! Queries of batches of rays, as packets where rays are coherent.
//!
//! A batch is cut into packets of up to [`PACKET_SIZE`] consecutive rays. A packet whose rays share one depth axis and its sense
//! is traversed at once ([`super::packet_walk`]). The rays of any other packet are sorted by direction ([`RayBins`]), and coherent
//! bins are tried as packets. What remains is traced ray by ray ([`super::single`]).

use std::ops::Range;

use fearless_simd::{Level, Simd};

use super::any_hit::AnyHit;
use super::closest_hit::ClosestHit;
use super::frustum::Frustum;
use super::packet::{MIN_PACKET, PACKET_SIZE, Packet};
use super::packet_query::{PacketAnyHit, PacketClosestHit, PacketRays};
use super::packet_walk::{PacketWalk, Refine};
use super::ray_bins::{RayBins, SortedRays, differ};
use super::single::traverse;
use super::visitor::{BatchFilter, LeafIntersector};
use crate::bvh::hit::Hit;
use crate::bvh::statistics::TraversalCounters;
use crate::bvh::wide_tree::{Leaf, WideTree};
use crate::geometry::Ray;

/// Runs a task at the levels for which packets are compiled: those with eight lanes or more, or with many registers. False at
/// other levels, where single rays are as fast.
macro_rules! packet_dispatch {
    ($level:expr, $simd:ident => $task:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512($simd) => $crate::geometry::compiled_for!($simd, $task),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2($simd) => $crate::geometry::compiled_for!($simd, $task),
            #[cfg(target_arch = "aarch64")]
            Level::Neon($simd) => $crate::geometry::compiled_for!($simd, $task),
            _ => false,
        }
    };
}

/// Packets from one point that spread less than this per unit of depth test boxes at leaves only.
const NARROW_SPREAD: f32 = 0.06;
/// Indices of the rays of a packet in their order.
const IN_ORDER: [u8; PACKET_SIZE] = in_order();

const fn in_order() -> [u8; PACKET_SIZE] {
    let mut indices = [0; PACKET_SIZE];
    let mut i = 0;
    while i < PACKET_SIZE {
        indices[i] = i as u8;
        i += 1;
    }
    indices
}

/// Batch of rays for one tree.
#[derive(Clone, Copy)]
pub(crate) struct Batch<'a> {
    /// Instruction set.
    pub(crate) level: Level,
    /// Tree that is traversed.
    pub(crate) tree: &'a WideTree,
    /// The rays.
    pub(crate) rays: &'a [Ray],
    /// Accepts or rejects hits with filtered triangles.
    pub(crate) filter: BatchFilter<'a>,
}

/// Up to [`PACKET_SIZE`] consecutive rays of a batch.
struct Part<'a> {
    /// Batch of these rays alone.
    batch: Batch<'a>,
    /// Index of the first ray in the whole batch.
    first: usize,
}

impl Batch<'_> {
    /// Finds the closest visible hit of each ray.
    pub(crate) fn closest_hits(self, hits: &mut [Option<Hit>], counters: &mut TraversalCounters) {
        let mut packet = Packet::EMPTY;
        for (part, hits) in self.parts().zip(hits.chunks_mut(PACKET_SIZE)) {
            if !differ(part.batch.rays) && part.closest_hits_of_packet(&mut packet, None, hits, counters) {
                continue;
            }
            let bins = RayBins::new(part.batch.rays);
            if !bins.has_packets() {
                part.closest_hits_one_by_one(&IN_ORDER, hits, counters);
                continue;
            }
            let bins = bins.sorted();
            let mut sorted = [None; PACKET_SIZE];
            for (range, is_coherent) in bins.bins() {
                let (bin, indices) = part.bin(&bins, range);
                let sorted = &mut sorted[..indices.len()];
                let is_done =
                    is_coherent && bin.closest_hits_of_packet(&mut packet, Some(indices), sorted, counters);
                if !is_done {
                    bin.closest_hits_one_by_one(indices, sorted, counters);
                }
                for (&index, hit) in indices.iter().zip(sorted) {
                    hits[usize::from(index)] = *hit;
                }
            }
        }
    }

    /// Finds which rays hit anything.
    pub(crate) fn occluded_rays(self, occluded: &mut [bool], counters: &mut TraversalCounters) {
        let mut packet = Packet::EMPTY;
        for (part, occluded) in self.parts().zip(occluded.chunks_mut(PACKET_SIZE)) {
            if !differ(part.batch.rays) && part.occlusion_of_packet(&mut packet, None, occluded, counters) {
                continue;
            }
            let bins = RayBins::new(part.batch.rays);
            if !bins.has_packets() {
                part.occlusion_one_by_one(&IN_ORDER, occluded, counters);
                continue;
            }
            let bins = bins.sorted();
            let mut sorted = [false; PACKET_SIZE];
            for (range, is_coherent) in bins.bins() {
                let (bin, indices) = part.bin(&bins, range);
                let sorted = &mut sorted[..indices.len()];
                let is_done =
                    is_coherent && bin.occlusion_of_packet(&mut packet, Some(indices), sorted, counters);
                if !is_done {
                    bin.occlusion_one_by_one(indices, sorted, counters);
                }
                for (&index, is_occluded) in indices.iter().zip(sorted) {
                    occluded[usize::from(index)] = *is_occluded;
                }
            }
        }
    }
}

impl<'a> Batch<'a> {
    fn parts(self) -> impl Iterator<Item = Part<'a>> {
        let parts = self.rays.chunks(PACKET_SIZE).enumerate();
        parts.map(move |(i, rays)| Part { batch: Batch { rays, ..self }, first: i * PACKET_SIZE })
    }
}

impl<'a> Part<'a> {
    /// Rays of a bin, and their indices in this part.
    fn bin<'b>(&self, bins: &'b SortedRays, range: Range<usize>) -> (Part<'b>, &'b [u8])
    where
        'a: 'b,
    {
        let rays = &bins.rays[range.clone()];
        (Part { batch: Batch { rays, ..self.batch }, first: self.first }, &bins.indices[range])
    }

    /// Traces the rays as a packet; false where that does not pay. Binned rays come with their `indices`.
    fn closest_hits_of_packet(
        &self,
        packet: &mut Packet,
        indices: Option<&[u8]>,
        hits: &mut [Option<Hit>],
        counters: &mut TraversalCounters,
    ) -> bool {
        let Batch { level, tree, rays, filter } = self.batch;
        if !self.has_packet_size() {
            return false;
        }
        let filter = |ray: usize, hit: &Hit| filter(self.first + ray, hit);
        let mut query = PacketClosestHit(PacketRays { tree, rays, indices, filter: &filter });
        packet_dispatch!(level, simd => closest_hits(simd, packet, &mut query, hits, counters))
    }

    fn closest_hits_one_by_one(
        &self,
        indices: &[u8],
        hits: &mut [Option<Hit>],
        counters: &mut TraversalCounters,
    ) {
        for ((ray, &index), hit) in self.batch.rays.iter().zip(indices).zip(hits) {
            let filter = |hit: &Hit| (self.batch.filter)(self.first + usize::from(index), hit);
            let leaves = LeafIntersector { tree: self.batch.tree, ray };
            let mut closest = ClosestHit::<true>::new(ray, None, &filter);
            traverse(self.batch.level, &leaves, &mut closest, counters);
            *hit = closest.finish(&leaves);
        }
    }

    /// Traces the rays as a packet; false where that does not pay. Binned rays come with their `indices`.
    fn occlusion_of_packet(
        &self,
        packet: &mut Packet,
        indices: Option<&[u8]>,
        occluded: &mut [bool],
        counters: &mut TraversalCounters,
    ) -> bool {
        let Batch { level, tree, rays, filter } = self.batch;
        if !self.has_packet_size() {
            return false;
        }
        let filter = |ray: usize, hit: &Hit| filter(self.first + ray, hit);
        let mut query = PacketAnyHit::new(PacketRays { tree, rays, indices, filter: &filter });
        packet_dispatch!(level, simd => any_hits(simd, packet, &mut query, occluded, counters))
    }

    fn occlusion_one_by_one(&self, indices: &[u8], occluded: &mut [bool], counters: &mut TraversalCounters) {
        for ((ray, &index), occluded) in self.batch.rays.iter().zip(indices).zip(occluded) {
            let filter = |hit: &Hit| (self.batch.filter)(self.first + usize::from(index), hit);
            let mut any = AnyHit::new(ray, &filter);
            traverse(self.batch.level, &LeafIntersector { tree: self.batch.tree, ray }, &mut any, counters);
            *occluded = any.found;
        }
    }

    /// Whether there are enough rays, and a tree with nodes.
    fn has_packet_size(&self) -> bool {
        self.batch.rays.len() >= MIN_PACKET && Leaf::of(self.batch.tree.root).is_none()
    }
}

#[inline(always)]
fn closest_hits<S: Simd>(
    simd: S,
    packet: &mut Packet,
    query: &mut PacketClosestHit,
    hits: &mut [Option<Hit>],
    counters: &mut TraversalCounters,
) -> bool {
    let rays = query.0;
    let Some(frustum) = fill(simd, packet, &rays) else { return false };
    let is_narrow = frustum.has_one_origin() && frustum.spread() < NARROW_SPREAD;
    let refine = if is_narrow { Refine::Leaves } else { Refine::Nodes };
    PacketWalk { tree: rays.tree, frustum, refine }.traverse(simd, packet, query, counters);
    query.finish(simd, packet, hits);
    true
}

#[inline(always)]
fn any_hits<S: Simd>(
    simd: S,
    packet: &mut Packet,
    query: &mut PacketAnyHit,
    occluded: &mut [bool],
    counters: &mut TraversalCounters,
) -> bool {
    let rays = query.rays;
    let Some(frustum) = fill(simd, packet, &rays) else { return false };
    PacketWalk { tree: rays.tree, frustum, refine: Refine::Nodes }.traverse(simd, packet, query, counters);
    for (i, occluded) in occluded.iter_mut().enumerate() {
        *occluded = query.is_occluded(i);
    }
    true
}

/// Fills the packet with rays that share a depth axis and its sense, and bounds them.
#[inline(always)]
fn fill<S: Simd>(simd: S, packet: &mut Packet, rays: &PacketRays) -> Option<Frustum> {
    packet.fill(simd, rays.rays).then(|| Frustum::around(simd, packet))
}
