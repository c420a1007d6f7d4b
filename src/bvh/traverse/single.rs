//! Traversal of the wide tree with one ray.
//!
//! Ordered traversal with an explicit stack, nearest child first: Wald, Benthin, Boulos, "Getting Rid of Packets", RT 2008. A
//! node is skipped only if its shortened entry distance is beyond the closest hit, never if it is equal: it may hold a
//! triangle of a lower index at the same distance.

use std::hint::black_box;

use fearless_simd::{Fallback, Level, Simd, f32x8, prelude::*};

use super::lane_ray::{LaneRay, is_extreme};
use super::stack::{Pending, Stack};
use super::visitor::{Candidate, LeafIntersector, TriangleSlot, Visitor};
use crate::bvh::simd::dispatch_eight_lanes;
use crate::bvh::statistics::TraversalCounters;
use crate::bvh::wide_tree::{Leaf, NO_CHILD, Triangles, WIDTH};

/// Traverses the tree of `leaves` with its ray. A single ray uses eight lanes, so AVX2 serves it best.
pub(crate) fn traverse<V: Visitor>(
    level: Level,
    leaves: &LeafIntersector,
    visitor: &mut V,
    counters: &mut TraversalCounters,
) {
    dispatch_eight_lanes!(
        level,
        simd => traverse_vectors(simd, leaves, visitor, counters),
        else traverse_scalar(leaves, visitor, counters)
    );
}

/// [`traverse`] without vectors and for any ray, compiled once for all visitors: its code is long.
#[inline(never)]
fn traverse_scalar(leaves: &LeafIntersector, visitor: &mut dyn Visitor, counters: &mut TraversalCounters) {
    traverse_lanes::<_, _, true>(Fallback::new(), leaves, visitor, counters);
}

/// [`traverse`] with vectors, which extreme rays do without.
#[inline(always)]
fn traverse_vectors<S: Simd, V: Visitor>(
    simd: S,
    leaves: &LeafIntersector,
    visitor: &mut V,
    counters: &mut TraversalCounters,
) {
    if is_extreme(leaves.ray) {
        return traverse_scalar(leaves, visitor, counters);
    }
    traverse_lanes::<_, _, false>(simd, leaves, visitor, counters);
}

#[inline(always)]
fn traverse_lanes<S: Simd, V: Visitor + ?Sized, const EXTREME: bool>(
    simd: S,
    leaves: &LeafIntersector,
    visitor: &mut V,
    counters: &mut TraversalCounters,
) {
    let tree = leaves.tree;
    // A ray with numbers that are not finite, which is extreme, hits nothing.
    let is_ray = !EXTREME || leaves.ray.direction.is_finite() && leaves.ray.origin.is_finite();
    if tree.root == NO_CHILD || !is_ray {
        return;
    }
    let ray = LaneRay::<EXTREME>::new(leaves.ray, visitor.lower());
    // The compiler would broadcast these values before the loop and spill the vectors. A load that broadcasts costs no more, and never
    // crosses a cache line.
    let slabs = black_box(&ray.slabs);
    let (mut nodes, mut triangle_tests) = (0, 0);
    let mut stack = Stack::new();
    let mut current = Pending::new(0.0, tree.root);
    loop {
        let child = current.child();
        if let Some(leaf) = Leaf::of(child) {
            let triangles = tree.triangles(leaf);
            triangle_tests += triangles.count() as u64;
            if test_leaf(simd, &ray, leaf, &triangles, leaves, visitor) {
                break;
            }
        } else {
            let node = &tree.nodes[child as usize];
            nodes += 1;
            let entered = ray.enter(simd, slabs, node, visitor.upper() * ray.scale);
            if let Some(next) = stack.push_all(visitor.is_ordered(), node, &entered) {
                current = next;
                continue;
            }
        }

        // Next entry that is not beyond the closest hit.
        let upper = visitor.upper() * ray.scale;
        let Some(pending) = stack.pop_within(upper) else { break };
        current = pending;
    }
    counters.nodes += nodes;
    counters.triangles += triangle_tests;
}

/// Passes the candidates of a leaf to the visitor; true if the traversal ends.
#[inline(always)]
fn test_leaf<S: Simd, V: Visitor + ?Sized, const EXTREME: bool>(
    simd: S,
    ray: &LaneRay<EXTREME>,
    leaf: Leaf,
    triangles: &Triangles,
    leaves: &LeafIntersector,
    visitor: &mut V,
) -> bool {
    let edges = ray.edge_functions(simd, triangles);
    let mut possible = edges.possible & ((1 << triangles.count()) - 1);
    if possible == 0 {
        return false;
    }
    let bounds = edges.distance_bounds(simd, f32x8::splat(simd, ray.depth_reciprocal));
    // Reject certain hits beyond the limits. Bounds that are not numbers reject nothing.
    let outside = bounds.near.simd_gt(visitor.upper()) | bounds.far.simd_lt(visitor.lower());
    possible &= !(edges.certain & outside.to_bitmask() as u32);
    let (near, far): ([f32; WIDTH], [f32; WIDTH]) = (bounds.near.into(), bounds.far.into());
    let back = edges.back();
    while possible != 0 {
        let lane = possible.trailing_zeros() as usize & (WIDTH - 1);
        possible &= possible - 1;
        let candidate = Candidate {
            slot: TriangleSlot { leaf, lane: lane as u32 },
            tag: triangles.tag(lane),
            is_certain: edges.certain >> lane & 1 != 0,
            is_back: back >> lane & 1 != 0,
            near: near[lane],
            far: far[lane],
        };
        if visitor.test(&candidate, leaves) {
            return true;
        }
    }
    false
}
