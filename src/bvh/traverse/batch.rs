//! Queries of batches of rays, as packets where rays are coherent.
//!
//! A batch is cut into packets of up to [`PACKET_SIZE`] consecutive rays. A packet whose rays share one depth axis and its sense
//! is traversed at once ([`super::packet_walk`]). The rays of any other packet are sorted by direction ([`RayBins`]), and coherent
//! bins are tried as packets. What remains is traced ray by ray ([`super::single`]).

use std::ops::Range;

use fearless_simd::Level;

use super::batch_answer::BatchAnswer;
use super::packet::{MIN_PACKET, PACKET_SIZE, Packet};
use super::packet_query::PacketRays;
use super::ray_bins::{RayBins, SortedRays, differ};
use super::visitor::{BatchFilter, LeafIntersector};
use crate::bvh::hit::Hit;
use crate::bvh::statistics::TraversalCounters;
use crate::bvh::wide_tree::{Leaf, WideTree};
use crate::geometry::{Ray, compiled_for};

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
    /// Accepts or rejects hits with filtered triangles, and of occlusion queries those with transmissive ones.
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
        self.trace(hits, counters);
    }

    /// Finds which rays hit anything.
    pub(crate) fn occluded_rays(self, occluded: &mut [bool], counters: &mut TraversalCounters) {
        self.trace(occluded, counters);
    }

    fn trace<A: BatchAnswer>(self, answers: &mut [A], counters: &mut TraversalCounters) {
        let mut packet = Packet::EMPTY;
        for (part, answers) in self.parts().zip(answers.chunks_mut(PACKET_SIZE)) {
            if !differ(part.batch.rays) && part.trace_packet(&mut packet, None, answers, counters) {
                continue;
            }
            let bins = RayBins::new(part.batch.rays);
            if !bins.has_packets() {
                part.trace_one_by_one(&IN_ORDER, answers, counters);
                continue;
            }
            let bins = bins.sorted();
            let mut sorted = [A::default(); PACKET_SIZE];
            for (range, is_coherent) in bins.bins() {
                let (bin, indices) = part.bin(&bins, range);
                let sorted = &mut sorted[..indices.len()];
                let is_done = is_coherent && bin.trace_packet(&mut packet, Some(indices), sorted, counters);
                if !is_done {
                    bin.trace_one_by_one(indices, sorted, counters);
                }
                for (&index, answer) in indices.iter().zip(sorted) {
                    answers[usize::from(index)] = *answer;
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
    fn trace_packet<A: BatchAnswer>(
        &self,
        packet: &mut Packet,
        indices: Option<&[u8]>,
        answers: &mut [A],
        counters: &mut TraversalCounters,
    ) -> bool {
        let Batch { level, tree, rays, filter } = self.batch;
        if !self.has_packet_size() {
            return false;
        }
        let filter = |ray: usize, hit: &Hit| filter(self.first + ray, hit);
        let rays = PacketRays { tree, rays, indices, filter: &filter };
        // Packets are compiled for levels with eight lanes or more, or with many registers. At others single rays are as fast.
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(simd) => {
                compiled_for!(simd, A::of_packet(simd, packet, rays, answers, counters))
            }
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(simd) => compiled_for!(simd, A::of_packet(simd, packet, rays, answers, counters)),
            #[cfg(target_arch = "aarch64")]
            Level::Neon(simd) => compiled_for!(simd, A::of_packet(simd, packet, rays, answers, counters)),
            _ => false,
        }
    }

    fn trace_one_by_one<A: BatchAnswer>(
        &self,
        indices: &[u8],
        answers: &mut [A],
        counters: &mut TraversalCounters,
    ) {
        let Batch { level, tree, rays, filter } = self.batch;
        for ((ray, &index), answer) in rays.iter().zip(indices).zip(answers) {
            let filter = |hit: &Hit| filter(self.first + usize::from(index), hit);
            *answer = A::of_ray(level, &LeafIntersector { tree, ray }, &filter, counters);
        }
    }

    /// Whether there are enough rays, and a tree with nodes.
    fn has_packet_size(&self) -> bool {
        self.batch.rays.len() >= MIN_PACKET && Leaf::of(self.batch.tree.root).is_none()
    }
}
