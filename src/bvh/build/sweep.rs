//! Top of a clustered tree: clusters split top down at the lowest surface area heuristic cost.
//!
//! Source: the sweep over all planes between sorted centres is Wald and Havran, "On Building Fast kd-Trees for Ray
//! Tracing, and On Doing That in O(N log N)", RT 2006, for boxes as in Wald, "On Fast Construction of SAH-Based Bounding
//! Volume Hierarchies", RT 2007. Each axis is sorted once, and the orders are partitioned with the clusters.

use std::ops::Range;

use super::binary_tree::Subtree;
use super::clusters::NodeSink;
use crate::bvh::box_area::scaled_half_area;
use crate::geometry::Aabb;

/// Depth below which clusters are split in the middle at any cost.
const MAX_GREEDY_DEPTH: u32 = 32;

/// Factor below which a lower cost is more than a rounding difference.
const NOTABLY_LESS: f32 = 1.0 - 1.0 / (1 << 14) as f32;

/// Scratch memory of the sweep.
#[derive(Debug, Default)]
pub(crate) struct Sweep {
    clusters: Vec<Subtree>,
    /// Clusters in the order of their centres, by axis.
    orders: [Vec<u32>; 3],
    /// Cost of each plane.
    costs: Vec<f32>,
    is_left: Vec<bool>,
    moved: Vec<u32>,
}

/// Split plane: number of clusters on its left, in the order of an axis.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    left: usize,
}

/// Clusters on one side of a plane.
struct Side {
    bounds: Aabb,
    count: f32,
}

impl Default for Side {
    fn default() -> Self {
        Self { bounds: Aabb::EMPTY, count: 0.0 }
    }
}

impl Side {
    /// Adds a cluster; returns the cost of the side.
    fn cost_with(&mut self, cluster: &Subtree, scale: f32) -> f32 {
        self.bounds = self.bounds.union(cluster.bounds);
        self.count += 1.0;
        scaled_half_area(&self.bounds, scale) * self.count
    }
}

impl Sweep {
    /// Builds the tree of `clusters`; `None` without clusters.
    pub(crate) fn build(
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
        self.costs.resize(count, 0.0);
        self.is_left.resize(count, false);
        (count > 0).then(|| self.split(0, count, 0, sink))
    }

    /// Builds the tree of the clusters from `first` up to `end` in the orders.
    fn split(&mut self, first: usize, end: usize, depth: u32, sink: &mut NodeSink) -> Subtree {
        if end - first == 1 {
            return self.clusters[self.orders[0][first] as usize];
        }
        let plane = if depth < MAX_GREEDY_DEPTH {
            self.cheapest(first, end, sink.scale)
        } else {
            Plane { axis: 0, left: (end - first) / 2 }
        };
        self.partition(first, end, plane);
        let left = self.split(first, first + plane.left, depth + 1, sink);
        let right = self.split(first + plane.left, end, depth + 1, sink);
        sink.join(&left, &right)
    }

    /// Plane of lowest cost: area times clusters, summed over both sides. Counting clusters rather than references makes rays
    /// visit fewer nodes. If costs are equal, as with identical boxes, the plane is in the middle.
    fn cheapest(&mut self, first: usize, end: usize, scale: f32) -> Plane {
        let count = end - first;
        let mut best = (f32::INFINITY, Plane { axis: 0, left: count / 2 });
        for axis in 0..3 {
            self.compute_costs(&(first..end), axis, scale);
            for left in std::iter::once(count / 2).chain(1..count) {
                if self.costs[left] < best.0 * NOTABLY_LESS {
                    best = (self.costs[left], Plane { axis, left });
                }
            }
        }
        best.1
    }

    /// Computes the costs of all planes of an axis.
    fn compute_costs(&mut self, range: &Range<usize>, axis: usize, scale: f32) {
        let order = &self.orders[axis][range.clone()];
        let mut side = Side::default();
        for i in (1..order.len()).rev() {
            self.costs[i] = side.cost_with(&self.clusters[order[i] as usize], scale);
        }
        let mut side = Side::default();
        for i in 1..order.len() {
            self.costs[i] += side.cost_with(&self.clusters[order[i - 1] as usize], scale);
        }
    }

    /// Moves the clusters left of a plane to the front, in all orders.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build::binary_tree::Pair;
    use glam::Vec3;

    /// Tree over boxes at given corners, and its nodes.
    fn built(corners: &[Vec3], size: f32) -> (Option<Subtree>, Vec<Pair>) {
        let mut nodes = vec![[0; _]; corners.len()];
        let mut sink = NodeSink { nodes: &mut nodes, first: 0, area_sum: 0.0, scale: 1.0 };
        let leaf = |(position, &min)| Subtree::leaf(Aabb { min, max: min + Vec3::splat(size) }, position);
        let root = Sweep::default().build(corners.iter().enumerate().map(leaf), &mut sink);
        (root, nodes.iter().map(Pair::unpacked).collect())
    }

    #[test]
    fn two_groups_are_separated() {
        // Three cubes near the origin and two far along z, in mixed order.
        let corners = [0.0, 100.0, 2.0, 101.5, 4.0].map(|z| Vec3::Z * z);
        let (root, nodes) = built(&corners, 1.0);
        let root = root.unwrap();
        assert_eq!((root.count, root.bounds.max.z), (5, 102.5));
        let pair = &nodes[root.child as usize];
        assert_eq!(pair.counts, [3, 2]);
        assert_eq!((pair.bounds[0].max.z, pair.bounds[1].min.z), (5.0, 100.0));
    }

    #[test]
    fn none_one_and_identical_clusters() {
        assert_eq!(built(&[], 1.0).0, None);
        assert_eq!(built(&[Vec3::ONE], 1.0).0.unwrap().height, 0);
        for size in [0.0, 1.0, f32::INFINITY] {
            assert_eq!(built(&[Vec3::ONE; 512], size).0.unwrap().height, 9);
        }
    }

    #[test]
    fn depth_of_a_chain_is_bounded() {
        let corners: Vec<Vec3> = (0..512).map(|i| Vec3::X * libm::powf(1.15, i as f32)).collect();
        let (root, _) = built(&corners, 1.0e-3);
        assert!(root.unwrap().height <= MAX_GREEDY_DEPTH + 9);
    }
}
