//! The top of the tree: clusters divided where the surface area heuristic is lowest.
//!
//! Source: the sweep over all planes between sorted centres is Wald and Havran, "On Building Fast kd-Trees for Ray
//! Tracing, and On Doing That in O(N log N)", RT 2006, for boxes as in Wald, "On Fast Construction of SAH-Based Bounding
//! Volume Hierarchies", RT 2007: each axis is sorted once, and the orders are divided with the clusters.

use super::binary_tree::{Subtree, scaled_area};
use super::clusters::NodeSink;
use crate::geometry::Aabb;

/// Below this depth clusters are halved, whatever it costs.
const MOST_GREEDY_DEPTH: u32 = 32;

/// Memory of the sweep.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    clusters: Vec<Subtree>,
    /// The clusters in the order of their centres, by axis.
    orders: [Vec<u32>; 3],
    /// Cost of what lies right of a plane.
    right_costs: Vec<f32>,
    is_left: Vec<bool>,
    moved: Vec<u32>,
}

/// Where clusters are divided: how many are on the left, in the order of an axis.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    left: usize,
}

impl Sweep {
    /// Builds the tree of `clusters`, of which there is at least one.
    pub(super) fn build(
        &mut self,
        clusters: impl Iterator<Item = Subtree>,
        sink: &mut NodeSink,
    ) -> Option<Subtree> {
        self.clusters.clear();
        self.clusters.extend(clusters);
        let count = self.clusters.len();
        for (axis, order) in self.orders.iter_mut().enumerate() {
            order.clear();
            order.extend(0..count as u32);
            let center = |&i: &u32| self.clusters[i as usize].bounds.center()[axis];
            order.sort_by(|a, b| center(a).total_cmp(&center(b)));
        }
        self.right_costs.resize(count, 0.0);
        self.is_left.resize(count, false);
        (count > 0).then(|| self.divide(0, count, 0, sink))
    }

    /// Builds the tree of the clusters from `first` up to `end` in the orders.
    fn divide(&mut self, first: usize, end: usize, depth: u32, sink: &mut NodeSink) -> Subtree {
        if end - first == 1 {
            return self.clusters[self.orders[0][first] as usize];
        }
        let plane = if depth < MOST_GREEDY_DEPTH {
            self.cheapest(first, end, sink.scale)
        } else {
            Plane { axis: 0, left: (end - first) / 2 }
        };
        self.partition(first, end, plane);
        let left = self.divide(first, first + plane.left, depth + 1, sink);
        let right = self.divide(first + plane.left, end, depth + 1, sink);
        sink.join(&left, &right)
    }

    /// The plane of lowest cost: area times references, summed over both sides. Of equal ones it is the first.
    fn cheapest(&mut self, first: usize, end: usize, scale: f32) -> Plane {
        let mut best = (f32::INFINITY, Plane { axis: 0, left: (end - first) / 2 });
        for axis in 0..3 {
            let order = &self.orders[axis][first..end];
            let cluster = |i: usize| &self.clusters[order[i] as usize];
            let mut side = (Aabb::EMPTY, 0.0);
            let mut cost_with = |cluster: &Subtree| {
                side = (side.0.union(cluster.bounds), side.1 + cluster.count as f32);
                scaled_area(&side.0, scale) * side.1
            };
            for i in (1..order.len()).rev() {
                self.right_costs[i] = cost_with(cluster(i));
            }
            let mut side = (Aabb::EMPTY, 0.0);
            for i in 1..order.len() {
                let added = cluster(i - 1);
                side = (side.0.union(added.bounds), side.1 + added.count as f32);
                let cost = scaled_area(&side.0, scale) * side.1 + self.right_costs[i];
                if cost < best.0 {
                    best = (cost, Plane { axis, left: i });
                }
            }
        }
        best.1
    }

    /// Moves the clusters left of a plane before the others, in all orders.
    fn partition(&mut self, first: usize, end: usize, plane: Plane) {
        for (i, &cluster) in self.orders[plane.axis][first..end].iter().enumerate() {
            self.is_left[cluster as usize] = i < plane.left;
        }
        for (axis, order) in self.orders.iter_mut().enumerate() {
            if axis == plane.axis {
                continue;
            }
            let order = &mut order[first..end];
            self.moved.clear();
            self.moved.extend(order.iter().filter(|&&cluster| self.is_left[cluster as usize]));
            self.moved.extend(order.iter().filter(|&&cluster| !self.is_left[cluster as usize]));
            order.copy_from_slice(&self.moved);
        }
    }
}
