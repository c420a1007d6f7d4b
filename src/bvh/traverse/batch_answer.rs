//! Answers to the queries of a batch: closest hits and occlusion, each by packets and by single rays.

use fearless_simd::{Level, Simd};

use super::any_hit::AnyHit;
use super::closest_hit::ClosestHit;
use super::frustum::Frustum;
use super::packet::Packet;
use super::packet_query::{PacketAnyHit, PacketClosestHit, PacketRays};
use super::packet_walk::{PacketWalk, Refine};
use super::single::traverse;
use super::visitor::{Filter, LeafIntersector};
use crate::bvh::hit::Hit;
use crate::bvh::statistics::TraversalCounters;

/// Packets from one point that spread less than this per unit of depth test boxes at leaves only.
const NARROW_SPREAD: f32 = 0.06;

/// Answer to a query for one ray of a batch; the default one is that of a ray without hits.
pub(super) trait BatchAnswer: Copy + Default {
    /// Traces one ray.
    fn of_ray(
        level: Level,
        leaves: &LeafIntersector,
        filter: Filter,
        counters: &mut TraversalCounters,
    ) -> Self;

    /// Traces the rays of a packet; false where they do not share a depth axis and its sense.
    fn of_packet<S: Simd>(
        simd: S,
        packet: &mut Packet,
        rays: PacketRays,
        answers: &mut [Self],
        counters: &mut TraversalCounters,
    ) -> bool;
}

/// The closest visible hit.
impl BatchAnswer for Option<Hit> {
    #[inline(always)]
    fn of_ray(
        level: Level,
        leaves: &LeafIntersector,
        filter: Filter,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        let mut closest = ClosestHit::<true>::new(leaves.ray, None, filter);
        traverse(level, leaves, &mut closest, counters);
        closest.finish(leaves)
    }

    #[inline(always)]
    fn of_packet<S: Simd>(
        simd: S,
        packet: &mut Packet,
        rays: PacketRays,
        hits: &mut [Option<Hit>],
        counters: &mut TraversalCounters,
    ) -> bool {
        let Some(frustum) = fill(simd, packet, &rays) else { return false };
        let is_narrow = frustum.has_one_origin() && frustum.spread() < NARROW_SPREAD;
        let refine = if is_narrow { Refine::Leaves } else { Refine::Nodes };
        let mut closest = PacketClosestHit(rays);
        PacketWalk { tree: rays.tree, frustum, refine }.traverse(simd, packet, &mut closest, counters);
        closest.finish(simd, packet, hits);
        true
    }
}

/// Whether the ray hits anything.
impl BatchAnswer for bool {
    #[inline(always)]
    fn of_ray(
        level: Level,
        leaves: &LeafIntersector,
        filter: Filter,
        counters: &mut TraversalCounters,
    ) -> bool {
        let mut any = AnyHit::new(leaves.ray, filter);
        traverse(level, leaves, &mut any, counters);
        any.found
    }

    #[inline(always)]
    fn of_packet<S: Simd>(
        simd: S,
        packet: &mut Packet,
        rays: PacketRays,
        occluded: &mut [bool],
        counters: &mut TraversalCounters,
    ) -> bool {
        let Some(frustum) = fill(simd, packet, &rays) else { return false };
        let mut any = PacketAnyHit::new(rays);
        PacketWalk { tree: rays.tree, frustum, refine: Refine::Nodes }
            .traverse(simd, packet, &mut any, counters);
        for (i, occluded) in occluded.iter_mut().enumerate() {
            *occluded = any.is_occluded(i);
        }
        true
    }
}

/// Fills the packet with rays that share a depth axis and its sense, and bounds them.
#[inline(always)]
fn fill<S: Simd>(simd: S, packet: &mut Packet, rays: &PacketRays) -> Option<Frustum> {
    packet.fill(simd, rays.rays).then(|| Frustum::around(simd, packet))
}
