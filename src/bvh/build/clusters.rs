//! Clusters in Morton order, merged with their nearest neighbours in rounds (PLOC).
//!
//! Source: Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", TVCG
//! 2018. Among the clusters at most [`RADIUS`] positions away, each cluster finds the one with the smallest common box. Pairs
//! that find each other merge. Two departures make every round merge something and bound the number of rounds:
//!
//! * Neighbours are ordered by a key. Its upper bits are those of the area; its lower five are the exclusive or of the two
//!   positions, which is the same from both. So the keys of a cluster's neighbours differ, and identical boxes merge in pairs.
//! * After two rounds that merge few clusters, as with nested boxes, one round merges all adjacent pairs.

use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;

use super::binary_tree::{Pair, Subtree};
use crate::bvh::box_area::scaled_half_area;
use crate::geometry::Aabb;

/// Search radius to either side, in positions.
pub(crate) const RADIUS: usize = 4;
/// Bits of a key that identify the other position; 2⁵ exceeds twice the radius.
const POSITION_BITS: u32 = 5;
const POSITION_MASK: u32 = (1 << POSITION_BITS) - 1;
/// A round that merges less than one in so many clusters is slow.
const SLOW: usize = 16;
/// Consecutive slow rounds after which a round merges all adjacent pairs.
const MAX_SLOW_ROUNDS: u32 = 2;

/// Clusters in Morton order as structure of arrays, with scratch memory of the search.
#[derive(Debug, Default)]
pub(crate) struct Clusters {
    /// Planes of the boxes: min x, y, z, max x, y, z.
    planes: [Vec<f32>; 6],
    children: Vec<u32>,
    counts: Vec<u32>,
    heights: Vec<u32>,
    /// Keys of the pairs at one distance.
    keys: Vec<u32>,
    /// Lowest key of each cluster.
    nearest: Vec<u32>,
}

/// Output of the nodes of merged clusters.
pub(crate) struct NodeSink<'a> {
    /// Unfilled nodes.
    pub(crate) nodes: &'a mut [Pair],
    /// Index of the first unfilled node.
    pub(crate) first: usize,
    /// Sum of the areas of all nodes so far.
    pub(crate) area_sum: f64,
    /// Factor of lengths before areas are computed.
    pub(crate) scale: f32,
}

impl NodeSink<'_> {
    /// Joins two subtrees under a new node.
    #[inline(always)]
    pub(crate) fn join(&mut self, left: &Subtree, right: &Subtree) -> Subtree {
        let joined = left.joined(right, self.first as u32);
        if let Some((node, rest)) = std::mem::take(&mut self.nodes).split_first_mut() {
            *node = Pair::of(left, right);
            self.nodes = rest;
        }
        self.first += 1;
        self.area_sum += f64::from(scaled_half_area(&joined.bounds, self.scale));
        joined
    }
}

impl Clusters {
    /// Replaces all clusters.
    pub(crate) fn fill(&mut self, subtrees: impl ExactSizeIterator<Item = Subtree>) {
        self.resize(subtrees.len());
        for (i, subtree) in subtrees.enumerate() {
            self.put(i, &subtree);
        }
    }

    /// Number of clusters.
    pub(crate) fn len(&self) -> usize {
        self.children.len()
    }

    /// All clusters.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Subtree> {
        (0..self.len()).map(|i| self.at(i))
    }

    /// Merges until at most `target` clusters are left.
    pub(crate) fn merge_down_to(&mut self, target: usize, sink: &mut NodeSink) {
        let level = Level::new();
        let mut slow_rounds = 0;
        while self.len() > target.max(1) {
            let before = self.len();
            if slow_rounds == MAX_SLOW_ROUNDS {
                self.merge_neighbours(sink);
                slow_rounds = 0;
                continue;
            }
            dispatch!(level, simd => self.find_nearest(simd, sink.scale));
            self.merge_mutual(sink);
            let is_slow = (before - self.len()) * SLOW < before;
            slow_rounds = if is_slow { slow_rounds + 1 } else { 0 };
        }
    }

    /// Finds the lowest key of each cluster.
    #[inline(always)]
    fn find_nearest<S: Simd>(&mut self, _: S, scale: f32) {
        let Self { planes, keys, nearest, .. } = self;
        let count = planes[0].len();
        nearest.clear();
        nearest.resize(count, u32::MAX);
        keys.resize(count, 0);
        for distance in 1..=RADIUS.min(count - 1) {
            let keys = &mut keys[..count - distance];
            pair_keys(planes, distance, scale, keys);
            for (nearest, &key) in nearest.iter_mut().zip(&*keys) {
                *nearest = key.min(*nearest);
            }
            for (nearest, &key) in nearest[distance..].iter_mut().zip(&*keys) {
                *nearest = key.min(*nearest);
            }
        }
    }

    /// Merges the pairs of mutual nearest neighbours.
    fn merge_mutual(&mut self, sink: &mut NodeSink) {
        let count = self.len();
        let mut kept = 0;
        for i in 0..count {
            let key = self.nearest[i];
            let other = neighbour(i, key);
            // Both ends of a pair compute the same key.
            let is_mutual = other < count && self.nearest[other] == key;
            if is_mutual && other < i {
                continue;
            }
            let subtree = if is_mutual { sink.join(&self.at(i), &self.at(other)) } else { self.at(i) };
            self.put(kept, &subtree);
            kept += 1;
        }
        self.resize(kept);
    }

    /// Merges all adjacent pairs: the first cluster with the second, the third with the fourth, and so on.
    fn merge_neighbours(&mut self, sink: &mut NodeSink) {
        let count = self.len();
        for i in 0..count / 2 {
            let joined = sink.join(&self.at(2 * i), &self.at(2 * i + 1));
            self.put(i, &joined);
        }
        if count % 2 == 1 {
            self.put(count / 2, &self.at(count - 1));
        }
        self.resize(count.div_ceil(2));
    }

    #[inline(always)]
    fn at(&self, i: usize) -> Subtree {
        let [x0, y0, z0, x1, y1, z1] = &self.planes;
        Subtree {
            bounds: Aabb { min: Vec3::new(x0[i], y0[i], z0[i]), max: Vec3::new(x1[i], y1[i], z1[i]) },
            child: self.children[i],
            count: self.counts[i],
            height: self.heights[i],
        }
    }

    #[inline(always)]
    fn put(&mut self, i: usize, subtree: &Subtree) {
        let Aabb { min, max } = subtree.bounds;
        let [x0, y0, z0, x1, y1, z1] = &mut self.planes;
        (x0[i], y0[i], z0[i]) = (min.x, min.y, min.z);
        (x1[i], y1[i], z1[i]) = (max.x, max.y, max.z);
        self.children[i] = subtree.child;
        self.counts[i] = subtree.count;
        self.heights[i] = subtree.height;
    }

    fn resize(&mut self, count: usize) {
        for plane in &mut self.planes {
            plane.resize(count, 0.0);
        }
        for words in [&mut self.children, &mut self.counts, &mut self.heights] {
            words.resize(count, 0);
        }
    }
}

/// Keys of all pairs at a `distance` of positions: area of the common box, and exclusive or of the positions.
#[inline(always)]
fn pair_keys(planes: &[Vec<f32>; 6], distance: usize, scale: f32, keys: &mut [u32]) {
    let n = keys.len();
    let [x0, y0, z0, x1, y1, z1] = planes.each_ref().map(|plane| &plane[..n]);
    let [u0, v0, w0, u1, v1, w1] = planes.each_ref().map(|plane| &plane[distance..][..n]);
    let low = |a: f32, b: f32| if a < b { a } else { b };
    let high = |a: f32, b: f32| if a > b { a } else { b };
    for i in 0..n {
        let x = (high(x1[i], u1[i]) - low(x0[i], u0[i])) * scale;
        let y = (high(y1[i], v1[i]) - low(y0[i], v0[i])) * scale;
        let z = (high(z1[i], w1[i]) - low(z0[i], w0[i])) * scale;
        let area = x * y + y * z + z * x;
        let positions = (i ^ (i + distance)) as u32 & POSITION_MASK;
        keys[i] = area.to_bits() & !POSITION_MASK | positions;
    }
}

/// Other position of a key of position `i`.
#[inline(always)]
fn neighbour(i: usize, key: u32) -> usize {
    const HALF: usize = 1 << (POSITION_BITS - 1);
    let mask = POSITION_MASK as usize;
    let low = (i ^ key as usize) & mask;
    // Distance from the position half a period before `i`.
    let ahead = low.wrapping_sub(i).wrapping_add(HALF) & mask;
    (i + ahead).wrapping_sub(HALF)
}
