//! Clusters in Morton order, of which the last ones are merged with their nearest neighbours in rounds.
//!
//! Source: Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", TVCG
//! 2018. Among the clusters at most a radius of positions away, each cluster finds the one with the smallest common box. Pairs
//! that find each other merge. Two departures make every round merge something and bound the number of rounds:
//!
//! * Neighbours are ordered by a key. Its upper bits are those of the area; its lower five are the exclusive or of the two
//!   positions, which is the same from both. So the keys of a cluster's neighbours differ, and identical boxes merge in pairs.
//! * After two rounds that merge few clusters, as with nested boxes, one round merges all adjacent pairs.
//!
//! Sixteen clusters are processed at once. Positions count from the first cluster that takes part in a round.

use fearless_simd::{Fallback, Level, Simd, f32x16, mask32x16, prelude::*, u32x16};
use glam::Vec3;

use super::binary_tree::{PackedPair, Pair, Subtree};
use crate::bvh::box_area::scaled_half_area;
use crate::bvh::simd::dispatch_lanes;
use crate::geometry::Aabb;

/// Clusters per vector.
const LANES: usize = 16;
/// Unused entries before the first and after the last cluster, so that reads of neighbours stay in range.
const PAD: usize = 2 * LANES;
/// Maximum search radius to either side, in positions.
const MAX_RADIUS: u32 = 15;
/// Bits of a key that identify the other position; 2⁵ exceeds twice the radius.
const POSITION_MASK: u32 = (1 << 5) - 1;
/// A round that merges less than one in so many clusters is slow.
const SLOW: usize = 16;
/// Consecutive slow rounds after which a round merges all adjacent pairs.
const MAX_SLOW_ROUNDS: u32 = 2;
/// Order of lanes.
const LANE_IDS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Stack of clusters as structure of arrays.
#[derive(Debug, Default)]
pub(crate) struct Clusters {
    count: usize,
    /// Planes of the boxes: min x, y, z, max x, y, z.
    planes: [Vec<f32>; 6],
    /// Child word, number of references and height of each cluster.
    words: [Vec<u32>; 3],
    /// Lowest key of each cluster of a round.
    nearest: Vec<u32>,
}

/// Creates the subtree of two merged clusters.
pub(crate) trait Join {
    /// Subtree of both, under one node.
    fn join(&mut self, left: &Subtree, right: &Subtree) -> Subtree;
}

/// Search for the nearest neighbour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Search {
    /// Positions to either side, at most [`MAX_RADIUS`].
    pub(crate) radius: u32,
    /// Factor of lengths before areas are computed.
    pub(crate) scale: f32,
}

/// Output of the nodes of merged clusters.
pub(crate) struct NodeSink<'a> {
    /// Unfilled nodes.
    pub(crate) nodes: &'a mut [PackedPair],
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
            *node = Pair::of(left, right).packed();
            self.nodes = rest;
        }
        self.first += 1;
        self.area_sum += f64::from(scaled_half_area(&joined.bounds, self.scale));
        joined
    }
}

impl Join for NodeSink<'_> {
    #[inline(always)]
    fn join(&mut self, left: &Subtree, right: &Subtree) -> Subtree {
        self.join(left, right)
    }
}

impl Clusters {
    /// Removes all clusters.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Number of clusters.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// All clusters.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Subtree> {
        (0..self.count).map(|i| self.at(i))
    }

    /// Allocates entries for `more` clusters.
    pub(crate) fn reserve(&mut self, more: usize) {
        let size = self.count + more + 2 * PAD;
        if self.nearest.len() < size {
            self.planes.iter_mut().for_each(|plane| plane.resize(2 * size, 0.0));
            self.words.iter_mut().for_each(|words| words.resize(2 * size, 0));
            self.nearest.resize(2 * size, 0);
        }
    }

    /// Appends a cluster, for which [`Clusters::reserve`] has allocated an entry.
    #[inline(always)]
    pub(crate) fn push(&mut self, cluster: &Subtree) {
        self.put(self.count, cluster);
        self.count += 1;
    }

    /// Merges the clusters from `first` on until at most `target` are left.
    pub(crate) fn merge_from(&mut self, first: usize, target: usize, search: Search, sink: &mut impl Join) {
        let level = Level::new();
        let mut slow_rounds = 0;
        while self.count - first > target.max(1) {
            let before = self.count - first;
            if slow_rounds == MAX_SLOW_ROUNDS {
                self.merge_neighbours(first, sink);
                slow_rounds = 0;
                continue;
            }
            dispatch_lanes!(
                level,
                simd => self.round(simd, first, search, sink),
                else self.round_scalar(first, search, sink)
            );
            let is_slow = (before - (self.count - first)) * SLOW < before;
            slow_rounds = if is_slow { slow_rounds + 1 } else { 0 };
        }
    }

    /// [`Clusters::round`] without vectors, compiled once for all sinks: its code is long.
    #[inline(never)]
    fn round_scalar(&mut self, first: usize, search: Search, sink: &mut dyn Join) {
        self.round(Fallback::new(), first, search, sink);
    }

    /// Merges all pairs of nearest neighbours.
    #[inline(always)]
    fn round<S: Simd>(&mut self, simd: S, first: usize, search: Search, sink: &mut (impl Join + ?Sized)) {
        debug_assert!(search.radius <= MAX_RADIUS);
        let count = self.count - first;
        for chunk in (0..count).step_by(LANES) {
            self.find_nearest(simd, first, chunk, search);
        }
        let mut kept = first;
        for chunk in (0..count).step_by(LANES) {
            let mask = self.merge_mutual(simd, first, chunk, search.radius, sink);
            kept = self.keep(simd, first + chunk, kept, mask);
        }
        self.count = kept;
    }

    /// Finds the lowest keys of sixteen clusters.
    #[inline(always)]
    fn find_nearest<S: Simd>(&mut self, simd: S, first: usize, chunk: usize, search: Search) {
        let count = u32x16::splat(simd, (self.count - first) as u32);
        let index = u32x16::splat(simd, chunk as u32) + u32x16::load_array(simd, LANE_IDS);
        let at = PAD + first + chunk;
        let own = self.boxes(simd, at);
        let none = u32x16::splat(simd, u32::MAX);
        let mut nearest = none;
        for distance in 1..=search.radius {
            let offset = u32x16::splat(simd, distance);
            // An index below zero wraps and is beyond the last.
            for (other, start) in
                [(index + offset, at + distance as usize), (index - offset, at - distance as usize)]
            {
                let area = half_area_of_union(&own, &self.boxes(simd, start), search.scale);
                let area: u32x16<S> = area.bitcast();
                let key = area & !POSITION_MASK | (index ^ other) & POSITION_MASK;
                nearest = nearest.min(other.simd_lt(count).select(key, none));
            }
        }
        nearest.store_slice(&mut self.nearest[PAD + chunk..][..LANES]);
    }

    /// Joins those of sixteen clusters whose nearest neighbours follow them and find them too; returns which clusters are left.
    ///
    /// The position bits of a key tell the partner among all positions within the radius, so clusters with equal keys are a pair
    /// if the bits are those of their positions.
    #[inline(always)]
    fn merge_mutual<S: Simd>(
        &mut self,
        simd: S,
        first: usize,
        chunk: usize,
        radius: u32,
        sink: &mut (impl Join + ?Sized),
    ) -> mask32x16<S> {
        let index = u32x16::splat(simd, chunk as u32) + u32x16::load_array(simd, LANE_IDS);
        let is_inside = index.simd_lt(u32x16::splat(simd, (self.count - first) as u32));
        let at = PAD + chunk;
        let key = u32x16::from_slice(simd, &self.nearest[at..][..LANES]);
        let partner = key & POSITION_MASK;
        let mut kept = is_inside;
        let mut distances = u32x16::splat(simd, 0);
        for distance in 1..=radius {
            let offset = u32x16::splat(simd, distance);
            let after = u32x16::from_slice(simd, &self.nearest[at + distance as usize..][..LANES]);
            let before = u32x16::from_slice(simd, &self.nearest[at - distance as usize..][..LANES]);
            let joins = key.simd_eq(after) & partner.simd_eq((index ^ (index + offset)) & POSITION_MASK);
            let joined = key.simd_eq(before) & partner.simd_eq((index ^ (index - offset)) & POSITION_MASK);
            distances = joins.select(offset, distances);
            kept &= !joined;
        }
        let joins = is_inside & !distances.simd_eq(u32x16::splat(simd, 0));
        let mut joins = joins.to_bitmask();
        let distances = distances.to_array();
        while joins != 0 {
            let lane = joins.trailing_zeros() as usize % LANES;
            joins &= joins - 1;
            let left = first + chunk + lane;
            let joined = sink.join(&self.at(left), &self.at(left + distances[lane] as usize));
            self.put(left, &joined);
        }
        kept
    }

    /// Moves those of sixteen clusters that are kept to `to`, which is not behind them; returns the entry after the last.
    #[inline(always)]
    fn keep<S: Simd>(&mut self, simd: S, from: usize, to: usize, kept: mask32x16<S>) -> usize {
        for plane in &mut self.planes {
            let values = f32x16::from_slice(simd, &plane[PAD + from..][..LANES]);
            simd.compress_f32x16(values, kept).store_slice(&mut plane[PAD + to..][..LANES]);
        }
        for words in &mut self.words {
            let values = u32x16::from_slice(simd, &words[PAD + from..][..LANES]);
            simd.compress_u32x16(values, kept).store_slice(&mut words[PAD + to..][..LANES]);
        }
        to + kept.to_bitmask().count_ones() as usize
    }

    /// Merges all adjacent pairs: the first cluster with the second, the third with the fourth, and so on.
    fn merge_neighbours(&mut self, first: usize, sink: &mut impl Join) {
        let count = self.count - first;
        for i in 0..count / 2 {
            let joined = sink.join(&self.at(first + 2 * i), &self.at(first + 2 * i + 1));
            self.put(first + i, &joined);
        }
        if count % 2 == 1 {
            self.put(first + count / 2, &self.at(first + count - 1));
        }
        self.count = first + count.div_ceil(2);
    }

    /// Planes of sixteen boxes.
    #[inline(always)]
    fn boxes<S: Simd>(&self, simd: S, at: usize) -> [f32x16<S>; 6] {
        self.planes.each_ref().map(|plane| f32x16::from_slice(simd, &plane[at..][..LANES]))
    }

    #[inline(always)]
    fn at(&self, i: usize) -> Subtree {
        let i = PAD + i;
        let [x0, y0, z0, x1, y1, z1] = &self.planes;
        let [child, count, height] = self.words.each_ref().map(|words| words[i]);
        Subtree {
            bounds: Aabb { min: Vec3::new(x0[i], y0[i], z0[i]), max: Vec3::new(x1[i], y1[i], z1[i]) },
            child,
            count,
            height,
        }
    }

    #[inline(always)]
    fn put(&mut self, i: usize, cluster: &Subtree) {
        let i = PAD + i;
        let Aabb { min, max } = cluster.bounds;
        let planes = [min.x, min.y, min.z, max.x, max.y, max.z];
        self.planes.iter_mut().zip(planes).for_each(|(to, from)| to[i] = from);
        let words = [cluster.child, cluster.count, cluster.height];
        self.words.iter_mut().zip(words).for_each(|(to, from)| to[i] = from);
    }
}

/// Half the area of the common boxes of two times sixteen clusters.
#[inline(always)]
fn half_area_of_union<S: Simd>(a: &[f32x16<S>; 6], b: &[f32x16<S>; 6], scale: f32) -> f32x16<S> {
    let extent = |axis: usize| (a[axis + 3].max(b[axis + 3]) - a[axis].min(b[axis])) * scale;
    let [x, y, z] = [extent(0), extent(1), extent(2)];
    x * y + y * z + z * x
}
