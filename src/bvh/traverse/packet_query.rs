//! Closest-hit and any-hit queries of a packet.

use fearless_simd::{Simd, f32x16, prelude::*, u32x16};

use super::exact_hits::ExactHits;
use super::packet::{LANES, Packet, VECTORS};
use super::packet_walk::{PacketCandidate, PacketVisitor, lane_mask};
use super::visitor::{BatchFilter, LEAST_LOWER, LeafIntersector, TriangleSlot};
use crate::bvh::hit::Hit;
use crate::bvh::triangle_flags::TriangleFlags;
use crate::bvh::wide_tree::{Tag, WideTree};
use crate::geometry::{Facing, Ray};

/// Exact hits of at least so many rays with one triangle are computed together.
const MIN_TOGETHER: u32 = 2;

/// Rays of a packet with their tree and filter.
#[derive(Clone, Copy)]
pub(super) struct PacketRays<'a> {
    /// Tree that is traversed.
    pub(super) tree: &'a WideTree,
    /// The rays.
    pub(super) rays: &'a [Ray],
    /// Indices of binned rays, which the filter gets; otherwise it gets indices in `rays`.
    pub(super) indices: Option<&'a [u8]>,
    /// Accepts or rejects hits with filtered triangles, and of occlusion queries those with transmissive ones.
    pub(super) filter: BatchFilter<'a>,
}

/// Finds the closest visible hit of each ray, as [`crate::bvh::Bvh::closest_hit`] does.
pub(super) struct PacketClosestHit<'a>(pub(super) PacketRays<'a>);

/// Finds whether each ray hits anything, as [`crate::bvh::Bvh::occluded`] does.
pub(super) struct PacketAnyHit<'a> {
    /// The rays.
    pub(super) rays: PacketRays<'a>,
    /// Rays with a hit, by vector.
    found: [u32; VECTORS],
}

impl<'a> PacketRays<'a> {
    #[inline(always)]
    fn leaves(&self, ray: usize) -> LeafIntersector<'a> {
        LeafIntersector { tree: self.tree, ray: &self.rays[ray] }
    }

    /// Whether the filter accepts a hit.
    fn passes_filter(&self, ray: usize, hit: &Hit) -> bool {
        let index = self.indices.map_or(ray, |indices| usize::from(indices[ray]));
        (self.filter)(index, hit)
    }
}

impl PacketClosestHit<'_> {
    /// Writes the closest hits of all rays.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&self, simd: S, packet: &Packet, hits: &mut [Option<Hit>]) {
        for (v, hits) in hits.chunks_mut(LANES).enumerate() {
            let exact = ExactHits::new(simd, self.0.tree, packet, v);
            for (i, hit) in hits.iter_mut().enumerate() {
                *hit = exact.hit(i);
            }
        }
    }

    /// Computes the exact hits of a ray's closest triangle so far and of another one; whether the other one is closer.
    #[inline(never)]
    fn compare_exactly(&self, packet: &mut Packet, ray: usize, slot: TriangleSlot, tag: Tag) -> bool {
        let Some(hit) = self.0.leaves(ray).intersect(slot) else { return false };
        let (v, i) = (ray / LANES, ray % LANES);
        let best = packet.slot(v, i).map(|slot| self.0.leaves(ray).intersect_conservative(slot));
        if best.is_some_and(|best| best.order() <= hit.order()) {
            return false;
        }
        let flags = tag.flags();
        if flags.has(TriangleFlags::SINGLE_SIDED) && hit.facing == Facing::Back {
            return false;
        }
        if flags.has(TriangleFlags::FILTERED) && !self.0.passes_filter(ray, &hit) {
            return false;
        }
        (packet.leaf[v][i], packet.lane[v][i]) = (slot.leaf.word(), slot.lane);
        (packet.near[v][i], packet.far[v][i]) = (hit.t, hit.t);
        true
    }
}

impl PacketVisitor for PacketClosestHit<'_> {
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, packet: &mut Packet, candidate: &PacketCandidate<S>) -> bool {
        let PacketCandidate { vector: v, slot, tag, .. } = *candidate;
        let flags = tag.flags();
        let (near, far) = (candidate.bounds.near, candidate.bounds.far);
        let best_near = f32x16::load_array_ref(simd, &packet.near[v]);
        let best_far = f32x16::load_array_ref(simd, &packet.far[v]);
        let lower = f32x16::load_array_ref(simd, &packet.lower[v]).max(LEAST_LOWER);

        // Certain rays that have a closer hit, start beyond the triangle, or hit an invisible back.
        let mut rejected = (near.simd_gt(best_far) | far.simd_lt(lower)).to_bitmask() as u32;
        if flags.has(TriangleFlags::SINGLE_SIDED) {
            rejected |= candidate.back;
        }
        let open = candidate.possible & !(rejected & candidate.certain);
        if open == 0 {
            return false;
        }

        // Certain rays whose closest hit so far this is.
        let is_closer = (near.simd_gt(lower) & far.simd_lt(best_near)).to_bitmask() as u32;
        let mut closer = open & candidate.certain & is_closer;
        if flags.has(TriangleFlags::FILTERED) {
            closer = 0;
        }
        if closer != 0 {
            let lanes = lane_mask(simd, closer);
            lanes.select(near, best_near).store_array(&mut packet.near[v]);
            lanes.select(far, best_far).store_array(&mut packet.far[v]);
            let leaves = u32x16::load_array_ref(simd, &packet.leaf[v]);
            let leaf = u32x16::splat(simd, slot.leaf.word());
            lanes.select(leaf, leaves).store_array(&mut packet.leaf[v]);
            let numbers = u32x16::load_array_ref(simd, &packet.lane[v]);
            let number = u32x16::splat(simd, slot.lane);
            lanes.select(number, numbers).store_array(&mut packet.lane[v]);
        }
        let mut changed = closer != 0;

        // Too close to call.
        let mut rest = open & !closer;
        while rest != 0 {
            let ray = v * LANES + (rest.trailing_zeros() as usize & (LANES - 1));
            rest &= rest - 1;
            changed |= self.compare_exactly(packet, ray, slot, tag);
        }
        changed
    }
}

impl<'a> PacketAnyHit<'a> {
    /// Query without hits.
    #[inline(always)]
    pub(super) fn new(rays: PacketRays<'a>) -> Self {
        Self { rays, found: [0; VECTORS] }
    }

    /// Whether a ray hits anything.
    #[inline(always)]
    pub(super) fn is_occluded(&self, ray: usize) -> bool {
        self.found[ray / LANES] >> (ray % LANES) & 1 != 0
    }

    /// Those of some rays of a vector, whose lines hit a triangle, for which the exact hit counts.
    #[inline(always)]
    fn hit_exactly_together<S: Simd>(
        &self,
        simd: S,
        packet: &Packet,
        vector: usize,
        (slot, tag): (TriangleSlot, Tag),
        lines: u32,
    ) -> u32 {
        let exact = ExactHits::with_triangle(simd, self.rays.tree, packet, vector, slot);
        let (mut found, mut rest) = (0, lines);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize & (LANES - 1);
            rest &= rest - 1;
            let ray = vector * LANES + lane;
            let counts = |hit: Hit| self.rays.rays[ray].contains(hit.t) && self.accepts(ray, &hit, tag);
            found |= u32::from(exact.hit(lane).is_some_and(counts)) << lane;
        }
        found
    }

    /// Whether the exact hit of a ray with a triangle counts.
    #[inline(never)]
    fn hits_exactly(&self, ray: usize, slot: TriangleSlot, tag: Tag) -> bool {
        let hit = self.rays.leaves(ray).intersect(slot);
        hit.is_some_and(|hit| self.accepts(ray, &hit, tag))
    }

    /// Whether a hit counts for the filter.
    #[inline(always)]
    fn accepts(&self, ray: usize, hit: &Hit, tag: Tag) -> bool {
        !tag.flags().is_filtered_from_any_side() || self.rays.passes_filter(ray, hit)
    }
}

impl PacketVisitor for PacketAnyHit<'_> {
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, packet: &mut Packet, candidate: &PacketCandidate<S>) -> bool {
        let PacketCandidate { vector: v, slot, tag, .. } = *candidate;
        let (near, far) = (candidate.bounds.near, candidate.bounds.far);
        let lower = f32x16::load_array_ref(simd, &packet.lower[v]).max(LEAST_LOWER);
        let upper = f32x16::load_array_ref(simd, &packet.far[v]);

        // Certain rays with the hit beyond their limits, and with the hit within them.
        let is_beyond = (near.simd_gt(upper) | far.simd_lt(lower)).to_bitmask() as u32;
        let is_within = (near.simd_gt(lower) & far.simd_lt(upper)).to_bitmask() as u32;
        let open = candidate.possible & !self.found[v] & !(is_beyond & candidate.certain);
        let is_filtered = tag.flags().is_filtered_from_any_side();
        let mut found = if is_filtered { 0 } else { open & candidate.certain & is_within };

        // Filtered, or too close to call: together, where the lines of several rays hit the triangle.
        let mut rest = open & !found;
        let together = rest & candidate.certain;
        if together.count_ones() >= MIN_TOGETHER {
            found |= self.hit_exactly_together(simd, packet, v, (slot, tag), together);
            rest &= !together;
        }

        // One by one.
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize & (LANES - 1);
            rest &= rest - 1;
            if self.hits_exactly(v * LANES + lane, slot, tag) {
                found |= 1 << lane;
            }
        }
        if found == 0 {
            return false;
        }
        // Finished rays get an empty range.
        self.found[v] |= found;
        let never = f32x16::splat(simd, f32::NEG_INFINITY);
        lane_mask(simd, found).select(never, upper).store_array(&mut packet.far[v]);
        true
    }
}
