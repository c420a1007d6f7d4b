//! Walking the wide tree with a tile of rays at once.
//!
//! A node is tested once for all rays, by their frustum; only at leaves, or with [`Refine::Nodes`] at inner nodes too, does
//! each vector of rays test the box. A triangle is tested for a vector of rays at once. What rays find does not depend on
//! their company: it is settled as for single rays, by sure bounds of the distance or by the definition of a hit.

use fearless_simd::{Simd, f32x8, f32x16, mask32x16, prelude::*};

use super::edges::{Distances, Edges};
use super::frustum::{ENTRY_SLACK, Planes, Reached};
use super::tile::{LANES, Tile, VECTORS};
use crate::bvh::TraversalCounters;
use crate::bvh::query::Place;
use crate::bvh::wide::{Leaf, Tag, Triangles, WIDTH, WideNode, WideTree};
use glam::Vec3;

/// Entries that need no heap.
const SHALLOW: usize = 128;

/// Where vectors of rays test boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refine {
    /// At leaves: for narrow tiles, which meet about the same nodes.
    Leaves,
    /// At inner nodes too.
    Nodes,
}

/// A triangle as one vector of rays sees it.
pub(super) struct Sighting<S: Simd> {
    /// Which vector of the tile.
    pub(super) vector: usize,
    /// Which triangle.
    pub(super) place: Place,
    /// Id and flags.
    pub(super) tag: Tag,
    /// Rays that may meet it.
    pub(super) possible: u32,
    /// Rays that surely do, but for their limits.
    pub(super) sure: u32,
    /// Of these: rays that meet its back.
    pub(super) back: u32,
    /// Of these: where.
    pub(super) distances: Distances<f32x16<S>>,
}

/// Takes what the rays of a tile meet.
pub(super) trait TileVisitor {
    /// Takes a triangle; updates the limits of the tile's rays and returns whether any changed.
    fn sight<S: Simd>(&mut self, simd: S, tile: &mut Tile, sighting: &Sighting<S>) -> bool;
}

/// A child that waits: its parent's index and its lane there.
#[derive(Clone, Copy)]
struct Pending {
    distance: f32,
    child: u32,
    /// Vectors that enter the parent, one bit each.
    vectors: u32,
}

/// What a walk has still to visit, nearest last; it grows on the heap beyond ordinary trees.
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

    /// Adds the reached children of a node, nearest last.
    #[inline(always)]
    fn push_all(&mut self, node: u32, reached: &Reached, vectors: u32) {
        let mut mask = reached.mask;
        let first = self.len;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            let distance = reached.distances[lane];
            let pending = Pending { distance, child: node << 3 | lane as u32, vectors };
            if self.len == SHALLOW {
                self.deep.push(pending);
                continue;
            }
            let mut place = self.len;
            while place > first && self.shallow[place - 1].distance < distance {
                self.shallow[place] = self.shallow[place - 1];
                place -= 1;
            }
            self.shallow[place] = pending;
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

/// Walks `tree`, whose root is a node, with the rays of `tile`.
#[inline(always)]
pub(super) fn walk<S: Simd, V: TileVisitor>(
    simd: S,
    tree: &WideTree,
    tile: &mut Tile,
    refine: Refine,
    visitor: &mut V,
    counters: &mut TraversalCounters,
) {
    let mut upper = farthest(simd, tile);
    let mut stack = Stack::new();
    let mut node_index = tree.root;
    let mut vectors = (1 << tile.vectors()) - 1;
    loop {
        // The children of a node, nearest last
        let node = &tree.nodes[node_index as usize];
        counters.nodes += 1;
        let reached = tile.frustum.enter(simd, node, upper);
        stack.push_all(node_index, &reached, vectors);

        // Up to the next inner node
        loop {
            let Some(pending) = stack.pop() else { return };
            if pending.distance * ENTRY_SLACK > upper {
                continue;
            }
            let node = &tree.nodes[(pending.child >> 3) as usize];
            let lane = pending.child as usize & (WIDTH - 1);
            let child = node.children[lane];
            if let Some(leaf) = Leaf::of(child) {
                let live = tile.enter(simd, node, lane, pending.vectors);
                if live.iter().any(|&live| live != 0)
                    && visit(simd, tree, tile, leaf, &live, visitor, upper, counters)
                {
                    upper = farthest(simd, tile);
                }
                continue;
            }
            if refine == Refine::Nodes {
                let live = tile.enter(simd, node, lane, pending.vectors);
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

/// The largest distance at which any ray still looks for hits.
#[inline(always)]
fn farthest<S: Simd>(simd: S, tile: &Tile) -> f32 {
    let mut largest = f32x16::load_array_ref(simd, &tile.far[0]);
    for row in &tile.far[1..tile.vectors()] {
        largest = largest.max(f32x16::load_array_ref(simd, row));
    }
    largest.reduce_max()
}

/// Shows the triangles of a leaf to the visitor; whether any ray's limit changed.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "an inlined part of the walk")]
fn visit<S: Simd, V: TileVisitor>(
    simd: S,
    tree: &WideTree,
    tile: &mut Tile,
    leaf: Leaf,
    live: &[u32; VECTORS],
    visitor: &mut V,
    upper: f32,
    counters: &mut TraversalCounters,
) -> bool {
    let triangles = tree.triangles(leaf);
    let planes = bounds(simd, &triangles);
    let mut mask = tile.frustum.reach(simd, &planes, upper).mask & ((1 << triangles.count()) - 1);
    let mut changed = false;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
        mask &= mask - 1;
        let corners = triangles.corners(lane);
        let tag = triangles.tag(lane);
        for (vector, &live) in live.iter().enumerate() {
            if live == 0 {
                continue;
            }
            counters.triangles += 1;
            let edges = tile.edges(simd, vector, &corners);
            let possible = edges.possible & live;
            if possible == 0 {
                continue;
            }
            let reciprocal = f32x16::load_array_ref(simd, &tile.reciprocal[tile.axes[2]][vector]);
            let sighting = Sighting {
                vector,
                place: Place { leaf, lane: lane as u32 },
                tag,
                possible,
                sure: edges.sure & possible,
                back: edges.back(),
                distances: edges.distances(simd, reciprocal),
            };
            changed |= visitor.sight(simd, tile, &sighting);
        }
    }
    changed
}

/// The boxes of a leaf's triangles; lanes beyond the last hold anything.
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

impl Tile {
    /// Which rays enter a child's box before their limits, by vector; others than `vectors` are not asked.
    #[inline(always)]
    fn enter<S: Simd>(&self, simd: S, node: &WideNode, lane: usize, vectors: u32) -> [u32; VECTORS] {
        let mut live = [0; VECTORS];
        for (v, live) in live.iter_mut().enumerate() {
            if vectors >> v & 1 == 0 {
                continue;
            }
            let mut entry = f32x16::load_array_ref(simd, &self.lower[v]);
            let mut exit = f32x16::load_array_ref(simd, &self.far[v]);
            for axis in 0..3 {
                let origin = f32x16::load_array_ref(simd, &self.origin[axis][v]);
                let reciprocal = f32x16::load_array_ref(simd, &self.reciprocal[axis][v]);
                let low = f32x16::splat(simd, node.planes[axis][lane] - self.frustum.padding);
                let high = f32x16::splat(simd, node.planes[3 + axis][lane] + self.frustum.padding);
                let to_low = (low - origin) * reciprocal;
                let to_high = (high - origin) * reciprocal;
                entry = entry.max(to_low.min(to_high));
                exit = exit.min(to_low.max(to_high));
            }
            *live = (entry * ENTRY_SLACK).simd_le(exit).to_bitmask() as u32;
        }
        live
    }

    /// The edge functions of one triangle for a vector of rays.
    #[inline(always)]
    fn edges<S: Simd>(&self, simd: S, vector: usize, corners: &[Vec3; 3]) -> Edges<f32x16<S>> {
        let [kx, ky, kz] = self.axes;
        let x = f32x16::load_array_ref(simd, &self.origin[kx][vector]);
        let y = f32x16::load_array_ref(simd, &self.origin[ky][vector]);
        let z = f32x16::load_array_ref(simd, &self.origin[kz][vector]);
        let shear_x = f32x16::load_array_ref(simd, &self.shear[0][vector]);
        let shear_y = f32x16::load_array_ref(simd, &self.shear[1][vector]);
        let mut sheared = [[f32x16::splat(simd, 0.0); 3]; 3];
        for (sheared, corner) in sheared.iter_mut().zip(corners) {
            let depth = f32x16::splat(simd, corner[kz]) - z;
            *sheared = [
                f32x16::splat(simd, corner[kx]) - x - depth * shear_x,
                f32x16::splat(simd, corner[ky]) - y - depth * shear_y,
                depth,
            ];
        }
        Edges::new(sheared)
    }
}

/// The lanes of a mask, as the vector kernels take it.
#[inline(always)]
pub(super) fn mask<S: Simd>(simd: S, bits: u32) -> mask32x16<S> {
    mask32x16::from_bitmask(simd, u64::from(bits & ((1 << LANES) - 1)))
}
