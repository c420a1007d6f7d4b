//! Traversal of the wide tree with a packet of rays at once.
//!
//! The frustum tests a node's children once for all rays. Each vector of rays tests a box only at leaves, or with
//! [`Refine::Nodes`] at inner nodes too. A triangle is tested against a vector of rays at once. The hit of a ray does not
//! depend on the other rays of the packet: as for single rays, bounds of the distance or the definition of a hit decide.

use fearless_simd::{Simd, f32x8, f32x16, mask32x16, prelude::*};
use glam::Vec3;

use super::edge_functions::{DistanceBounds, EdgeFunctions};
use super::frustum::{ENTRY_SLACK, EnteredBoxes, Frustum, Planes, Sense};
use super::packet::{LANES, Packet, VECTORS};
use super::visitor::TriangleSlot;
use crate::bvh::statistics::TraversalCounters;
use crate::bvh::wide_tree::{Leaf, Tag, Triangles, WIDTH, WideNode, WideTree};

/// Entries of the fixed array of the stack.
const SHALLOW: usize = 128;

/// Nodes whose boxes are tested by vectors of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refine {
    /// Leaves only: for narrow packets, whose rays enter about the same nodes.
    Leaves,
    /// Leaves and inner nodes.
    Nodes,
}

/// Triangle that rays of one vector may hit.
pub(super) struct PacketCandidate<S: Simd> {
    /// Vector of the packet.
    pub(super) vector: usize,
    /// Slot of the triangle.
    pub(super) slot: TriangleSlot,
    /// Index and flags of the triangle.
    pub(super) tag: Tag,
    /// Rays that may hit it.
    pub(super) possible: u32,
    /// Rays that certainly hit it, but for the limits of `t`.
    pub(super) certain: u32,
    /// Of the certain rays: those that hit the back.
    pub(super) back: u32,
    /// Of the certain rays: bounds of `t`.
    pub(super) bounds: DistanceBounds<f32x16<S>>,
}

/// Receives the triangles that the rays of a packet may hit.
pub(super) trait PacketVisitor {
    /// Tests a candidate, updates the limits of the packet's rays, and returns whether any changed.
    fn test<S: Simd>(&mut self, simd: S, packet: &mut Packet, candidate: &PacketCandidate<S>) -> bool;
}

/// Traversal of one packet.
pub(super) struct PacketWalk<'a> {
    /// Tree whose root is a node.
    pub(super) tree: &'a WideTree,
    /// Bounds of the packet's rays.
    pub(super) frustum: Frustum,
    /// Nodes whose boxes are tested by vectors of rays.
    pub(super) refine: Refine,
}

/// Leaf that some rays of the packet enter.
struct EnteredLeaf {
    leaf: Leaf,
    /// Rays that enter it, by vector.
    live: [u32; VECTORS],
    /// Largest distance at which any ray still looks for hits.
    upper: f32,
}

/// Child of a node on the stack.
#[derive(Clone, Copy)]
struct Pending {
    distance: f32,
    /// Index of the parent, shifted left by three bits, and lane of the child there.
    child: u32,
    /// Vectors that enter the parent, one bit each.
    vectors: u32,
}

/// Traversal stack, nearest entry on top. A fixed array covers ordinary trees; deeper trees continue on the heap.
struct Stack {
    shallow: [Pending; SHALLOW],
    len: usize,
    deep: Vec<Pending>,
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        let none = Pending { distance: 0.0, child: 0, vectors: 0 };
        Self { shallow: [none; SHALLOW], len: 0, deep: Vec::new() }
    }

    /// Pushes the entered children of a node, nearest last.
    #[inline(always)]
    fn push_all(&mut self, node: u32, entered: &EnteredBoxes, vectors: u32) {
        let mut mask = entered.mask;
        let first = self.len;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            let distance = entered.distances[lane];
            let pending = Pending { distance, child: node << 3 | lane as u32, vectors };
            if self.len == SHALLOW {
                self.deep.push(pending);
                continue;
            }
            let mut position = self.len;
            while position > first && self.shallow[position - 1].distance < distance {
                self.shallow[position] = self.shallow[position - 1];
                position -= 1;
            }
            self.shallow[position] = pending;
            self.len += 1;
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Pending> {
        if let Some(pending) = self.deep.pop() {
            return Some(pending);
        }
        self.len = self.len.checked_sub(1)?;
        Some(self.shallow[self.len & (SHALLOW - 1)])
    }
}

impl PacketWalk<'_> {
    /// Traverses the tree with the rays of `packet`.
    #[inline(always)]
    pub(super) fn traverse<S: Simd, V: PacketVisitor>(
        &self,
        simd: S,
        packet: &mut Packet,
        visitor: &mut V,
        counters: &mut TraversalCounters,
    ) {
        let mut upper = farthest(simd, packet);
        let mut stack = Stack::new();
        let mut node_index = self.tree.root;
        let mut vectors = (1 << packet.vectors()) - 1;
        loop {
            // Push the children of a node, nearest last.
            let node = &self.tree.nodes[node_index as usize];
            counters.nodes += 1;
            let entered = self.frustum.enter(simd, node, upper);
            stack.push_all(node_index, &entered, vectors);

            // Pop up to the next inner node.
            loop {
                let Some(pending) = stack.pop() else { return };
                if pending.distance * ENTRY_SLACK > upper {
                    continue;
                }
                let node = &self.tree.nodes[(pending.child >> 3) as usize];
                let lane = pending.child as usize & (WIDTH - 1);
                let child = node.children[lane];
                if let Some(leaf) = Leaf::of(child) {
                    let live = self.enter(simd, packet, node, lane, pending.vectors);
                    if live.iter().any(|&live| live != 0)
                        && self.test_leaf(simd, packet, &EnteredLeaf { leaf, live, upper }, visitor, counters)
                    {
                        upper = farthest(simd, packet);
                    }
                    continue;
                }
                if self.refine == Refine::Nodes {
                    let live = self.enter(simd, packet, node, lane, pending.vectors);
                    vectors = 0;
                    for (v, &live) in live.iter().enumerate() {
                        vectors |= u32::from(live != 0) << v;
                    }
                    if vectors == 0 {
                        continue;
                    }
                }
                node_index = child;
                break;
            }
        }
    }

    /// Rays of `vectors` that enter a child's box within their limits, by vector.
    #[inline(always)]
    fn enter<S: Simd>(
        &self,
        simd: S,
        packet: &Packet,
        node: &WideNode,
        lane: usize,
        vectors: u32,
    ) -> [u32; VECTORS] {
        let Frustum { padding, .. } = self.frustum;
        let low: [f32; 3] = std::array::from_fn(|axis| node.planes[axis][lane] - padding);
        let high: [f32; 3] = std::array::from_fn(|axis| node.planes[3 + axis][lane] + padding);
        let mut live = [0; VECTORS];
        for (v, live) in live.iter_mut().enumerate() {
            if vectors >> v & 1 == 0 {
                continue;
            }
            let mut entry = f32x16::load_array_ref(simd, &packet.lower[v]);
            let mut exit = f32x16::load_array_ref(simd, &packet.far[v]);
            for axis in 0..3 {
                let subtrahend = f32x16::load_array_ref(simd, &packet.origin_over_direction[axis][v]);
                let reciprocal = f32x16::load_array_ref(simd, &packet.reciprocal[axis][v]);
                let distance = |plane| distance(f32x16::splat(simd, plane), reciprocal, subtrahend);
                let (to_low, to_high) = (distance(low[axis]), distance(high[axis]));
                let (near, far) = match self.frustum.sense[axis] {
                    Sense::Rising => (to_low, to_high),
                    Sense::Falling => (to_high, to_low),
                    Sense::Mixed => (to_low.min(to_high), to_low.max(to_high)),
                };
                entry = entry.max(near);
                exit = exit.min(far);
            }
            *live = (entry * ENTRY_SLACK).simd_le(exit).to_bitmask() as u32;
        }
        live
    }

    /// Passes the candidates of a leaf to the visitor; whether the limit of any ray changed.
    #[inline(always)]
    fn test_leaf<S: Simd, V: PacketVisitor>(
        &self,
        simd: S,
        packet: &mut Packet,
        entered: &EnteredLeaf,
        visitor: &mut V,
        counters: &mut TraversalCounters,
    ) -> bool {
        let triangles = self.tree.triangles(entered.leaf);
        let planes = bounds(simd, &triangles);
        let boxes = self.frustum.enter_boxes(simd, &planes, entered.upper);
        let mut mask = boxes.mask & ((1 << triangles.count()) - 1);
        let mut changed = false;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            let corners = triangles.corners(lane);
            let tag = triangles.tag(lane);
            for (vector, &live) in entered.live.iter().enumerate() {
                if live == 0 {
                    continue;
                }
                counters.triangles += 1;
                let edges = edge_functions(simd, packet, vector, &corners);
                let possible = edges.possible & live;
                if possible == 0 {
                    continue;
                }
                let reciprocal = f32x16::load_array_ref(simd, &packet.reciprocal[packet.axes[2]][vector]);
                let candidate = PacketCandidate {
                    vector,
                    slot: TriangleSlot { leaf: entered.leaf, lane: lane as u32 },
                    tag,
                    possible,
                    certain: edges.certain & possible,
                    back: edges.back(),
                    bounds: edges.distance_bounds(simd, reciprocal),
                };
                changed |= visitor.test(simd, packet, &candidate);
            }
        }
        changed
    }
}

/// Distances to a plane: its products with the reciprocals, less those of the origins.
#[inline(always)]
#[expect(clippy::disallowed_methods, reason = "whichever way it is rounded, no box with a hit is missed")]
fn distance<S: Simd>(plane: f32x16<S>, reciprocal: f32x16<S>, subtrahend: f32x16<S>) -> f32x16<S> {
    plane.mul_sub(reciprocal, subtrahend)
}

/// Largest distance at which any ray still looks for hits.
#[inline(always)]
fn farthest<S: Simd>(simd: S, packet: &Packet) -> f32 {
    let mut largest = f32x16::load_array_ref(simd, &packet.far[0]);
    for row in &packet.far[1..packet.vectors()] {
        largest = largest.max(f32x16::load_array_ref(simd, row));
    }
    largest.reduce_max()
}

/// Boxes of the triangles of a leaf; lanes beyond the last are unspecified.
#[inline(always)]
fn bounds<S: Simd>(simd: S, triangles: &Triangles) -> Planes {
    let mut planes = [[0.0; WIDTH]; 6];
    for axis in 0..3 {
        let a = f32x8::load_array_ref(simd, triangles.lanes(0, axis));
        let b = f32x8::load_array_ref(simd, triangles.lanes(1, axis));
        let c = f32x8::load_array_ref(simd, triangles.lanes(2, axis));
        a.min(b).min(c).store_array(&mut planes[axis]);
        a.max(b).max(c).store_array(&mut planes[3 + axis]);
    }
    planes
}

/// Edge functions of one triangle for a vector of rays.
#[inline(always)]
fn edge_functions<S: Simd>(
    simd: S,
    packet: &Packet,
    vector: usize,
    corners: &[Vec3; 3],
) -> EdgeFunctions<f32x16<S>> {
    let [kx, ky, kz] = packet.axes;
    let x = f32x16::load_array_ref(simd, &packet.origin[kx][vector]);
    let y = f32x16::load_array_ref(simd, &packet.origin[ky][vector]);
    let z = f32x16::load_array_ref(simd, &packet.origin[kz][vector]);
    let shear_x = f32x16::load_array_ref(simd, &packet.shear[0][vector]);
    let shear_y = f32x16::load_array_ref(simd, &packet.shear[1][vector]);
    let mut sheared = [[f32x16::splat(simd, 0.0); 3]; 3];
    for (sheared, corner) in sheared.iter_mut().zip(corners) {
        let depth = f32x16::splat(simd, corner[kz]) - z;
        *sheared = [
            f32x16::splat(simd, corner[kx]) - x - depth * shear_x,
            f32x16::splat(simd, corner[ky]) - y - depth * shear_y,
            depth,
        ];
    }
    EdgeFunctions::new(sheared)
}

/// Lane mask of the lowest sixteen bits.
#[inline(always)]
pub(super) fn lane_mask<S: Simd>(simd: S, bits: u32) -> mask32x16<S> {
    mask32x16::from_bitmask(simd, u64::from(bits & ((1 << LANES) - 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entered(distances: [f32; WIDTH], mask: u32) -> EnteredBoxes {
        EnteredBoxes { mask, distances }
    }

    fn pop(stack: &mut Stack) -> Option<(f32, u32, u32)> {
        stack.pop().map(|pending| (pending.distance, pending.child, pending.vectors))
    }

    #[test]
    fn children_of_a_node_are_popped_nearest_first() {
        let mut stack = Stack::new();
        stack.push_all(3, &entered([5.0; WIDTH], 0b1), 0b1);
        stack.push_all(9, &entered([4.0, 2.0, 8.0, 1.0, 0.0, 6.0, 7.0, 3.0], 0b1110_1111), 0b101);
        let nearest_first = [(1.0, 3), (2.0, 1), (3.0, 7), (4.0, 0), (6.0, 5), (7.0, 6), (8.0, 2)];
        for (distance, lane) in nearest_first {
            assert_eq!(pop(&mut stack), Some((distance, 9 << 3 | lane, 0b101)));
        }
        assert_eq!(pop(&mut stack), Some((5.0, 3 << 3, 0b1)));
        assert_eq!(pop(&mut stack), None);
    }

    #[test]
    fn no_child_beyond_the_fixed_array_is_lost() {
        // Six children a node, so that the array ends among those of one.
        const MASK: u32 = 0b0111_1110;
        const NODES: u32 = 40;
        let distances = |node: u32| std::array::from_fn(|lane| ((lane as u32 * 5 + node) % 8) as f32);
        let mut stack = Stack::new();
        for node in 0..NODES {
            stack.push_all(node, &entered(distances(node), MASK), 1 << (node % 4));
        }
        assert_eq!((stack.len, stack.deep.len()), (SHALLOW, 6 * NODES as usize - SHALLOW));

        let mut last = (u32::MAX, f32::INFINITY);
        for node in (0..NODES).rev() {
            let mut lanes = 0;
            for _ in 0..6 {
                let (distance, child, vectors) = pop(&mut stack).unwrap();
                let lane = child & 7;
                assert_eq!((child >> 3, vectors), (node, 1 << (node % 4)));
                assert_eq!(distance, distances(node)[lane as usize]);
                lanes |= 1 << lane;
                // Nodes that fit the array have their nearest child on top.
                let is_ordered = node < SHALLOW as u32 / 6;
                assert!(!is_ordered || last.0 != node || distance >= last.1);
                last = (node, distance);
            }
            assert_eq!(lanes, MASK);
        }
        assert_eq!(pop(&mut stack), None);
        // The array is used again.
        stack.push_all(0, &entered(distances(0), MASK), 1);
        assert_eq!((stack.len, stack.deep.len()), (6, 0));
    }
}
