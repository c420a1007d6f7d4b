//! Karras' radix tree with clustering (H-PLOC): the tree of all builders but the reference implementation, [`crate::bvh::reference::karras`].
//!
//! Source: Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler, "H-PLOC: Hierarchical Parallel Locally-Ordered Clustering for
//! Bounding Volume Hierarchy Construction", PACMCGIT 7(3), 2024. Every node of the radix tree over sorted Morton codes (Karras
//! 2012) passes the clusters of both its children on to its parent. If they are more than a threshold, nearest ones are
//! merged first ([`super::clusters`]). With a threshold of one cluster every node joins its two children: the result is Karras'
//! tree. Departures:
//!
//! * The radix tree is not stored. Its nodes are visited bottom-up where adjacent codes differ ([`super::ranges`]), in one order
//!   for any number of threads; the paper's counters of visits give the same sets of clusters.
//! * Thresholds grow with the number of references ([`super::clustering`]), and the surface area heuristic splits the clusters of the
//!   root ([`super::sweep`]): the top levels of clustering are of uneven quality.
//!
//! Ranges of the radix tree are tasks. They do not depend on the number of threads, so neither does the tree.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::binary_tree::BinaryTree;
use super::cluster_scan::{self, TaskClusters};
use super::clustering::{Built, Input, Output};
use super::clusters::{Clusters, NodeSink};
use super::radix_scan;
use super::ranges::{Range, Ranges, tasks};
use super::sweep::Sweep;
use crate::cancel::Cancelled;

/// Smallest number of references per task.
const MIN_TASK: usize = 1 << 11;
/// Number of tasks for large inputs.
const TASKS: usize = 32;

/// Scratch memory kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// That of each thread.
    tasks: Vec<Mutex<TaskClusters>>,
    top: Clusters,
    sweep: Sweep,
}

impl Input<'_> {
    /// Fills `tree` with a tree over all references.
    pub(crate) fn build(&self, tree: &mut BinaryTree, scratch: &mut Scratch) -> Result<(), Cancelled> {
        let count = self.order.len();
        let tasks = tasks(self.order, (count / TASKS).max(MIN_TASK));
        let clusters = |task: &Range| self.clustering.threshold(task.count).min(task.count);
        tree.reset(count + tasks.iter().map(clusters).sum::<usize>(), count);
        scratch.tasks.resize_with(rayon::current_num_threads().max(scratch.tasks.len()), Mutex::default);

        // Build the tasks, each in its own nodes and positions.
        let (mut nodes, top_nodes) = tree.nodes.split_at_mut(count);
        let mut triangle_ids = tree.triangle_ids.as_mut_slice();
        let mut outputs = Vec::with_capacity(tasks.len());
        for task in &tasks {
            let (own_nodes, own_ids);
            (own_nodes, nodes) = nodes.split_at_mut(task.count);
            (own_ids, triangle_ids) = triangle_ids.split_at_mut(task.count);
            outputs.push(Output { first: task.first, nodes: own_nodes, triangle_ids: own_ids });
        }
        let threads = &scratch.tasks;
        let built: Vec<Built> = outputs
            .into_par_iter()
            .map(|output| {
                self.cancel.check()?;
                if self.clustering.max_clusters == 1 {
                    return Ok(radix_scan::build(self, output));
                }
                let thread = rayon::current_thread_index().unwrap_or(0) % threads.len();
                let mut clusters = threads[thread].lock().unwrap_or_else(PoisonError::into_inner);
                Ok(cluster_scan::build(self, output, &mut clusters))
            })
            .collect::<Result<_, _>>()?;

        // Join their clusters.
        let area_sum = built.iter().map(|part| part.area_sum).sum();
        let mut sink = NodeSink { nodes: top_nodes, first: count, area_sum, scale: self.scale };
        self.cluster_tasks(&tasks, &built, &mut scratch.top, &mut sink);
        tree.root = scratch.sweep.build(scratch.top.iter(), &mut sink);
        tree.area_sum = sink.area_sum;
        Ok(())
    }

    /// Passes the clusters of the tasks up to the root.
    fn cluster_tasks(&self, tasks: &[Range], built: &[Built], top: &mut Clusters, sink: &mut NodeSink) {
        top.clear();
        let mut ranges = Ranges::new();
        for (task, part) in tasks.iter().zip(built) {
            let first = top.len();
            top.reserve(part.clusters.len());
            part.clusters.iter().for_each(|cluster| top.push(cluster));
            ranges.add(task, first, task.difference(self.order), |first, references| {
                self.limit(top, first, references, sink);
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build::binary_tree::{LEAF_RANGE, LEAF_SIZE, Pair, Subtree};
    use crate::bvh::build::clustering::Clustering;
    use crate::bvh::build::morton::tests::order_of;
    use crate::bvh::reference::hploc::{Cluster, clusters};
    use crate::bvh::reference::radix_tree::MortonKey;
    use crate::bvh::references::Reference;
    use crate::cancel::CancelFlag;
    use crate::geometry::Aabb;
    use glam::Vec3;

    /// Small thresholds, so that small inputs are clustered at several levels.
    const SMALL: Clustering =
        Clustering { radius: 3, min_clusters: 4, references_per_cluster: 20, max_clusters: 100 };

    /// Sorted codes, and boxes unrelated to them.
    fn input(n: u64, mask: u64) -> (Vec<u64>, Vec<Reference>) {
        let scrambled = |i: u64| (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 1;
        let mut codes: Vec<u64> = (0..n).map(|i| scrambled(i) & mask).collect();
        codes.sort_unstable();
        let references = (0..n)
            .map(|i| {
                let x = scrambled(i) as u32;
                let corner = Vec3::new((x % 1000) as f32, (x / 1000 % 1000) as f32, (x % 77) as f32);
                let bounds = Aabb { min: corner, max: corner + Vec3::splat((i % 5) as f32) };
                Reference { bounds, triangle_id: i as u32 }
            })
            .collect();
        (codes, references)
    }

    fn built(codes: &[u64], references: &[Reference], clustering: Clustering) -> BinaryTree {
        let mut tree = BinaryTree::default();
        let (order, cancel) = (order_of(codes), CancelFlag::new());
        let input = Input { order: &order, references, scale: 1.0, clustering, cancel: &cancel };
        input.build(&mut tree, &mut Scratch::default()).unwrap();
        tree
    }

    /// Triangles of a subtree of at most [`LEAF_SIZE`] references, sorted.
    fn triangles_of(tree: &BinaryTree, child: u32, count: u32) -> Vec<u32> {
        let mut found = if child & LEAF_RANGE != 0 {
            let first = (child & !LEAF_RANGE) as usize;
            tree.triangle_ids[first..first + count as usize].to_vec()
        } else {
            let pair = tree.node(child);
            [0, 1].map(|side| triangles_of(tree, pair.children[side], pair.counts[side])).concat()
        };
        found.sort_unstable();
        found
    }

    fn assert_equal(tree: &BinaryTree, child: u32, count: u32, expected: &Cluster) {
        assert_eq!(count as usize, expected.triangle_ids.len());
        if count <= LEAF_SIZE {
            assert_eq!(triangles_of(tree, child, count), expected.triangle_ids);
            return;
        }
        let pair = tree.node(child);
        for (side, expected) in expected.children.iter().flat_map(|pair| pair.iter()).enumerate() {
            assert_eq!(pair.bounds[side], expected.bounds);
            assert_equal(tree, pair.children[side], pair.counts[side], expected);
        }
    }

    /// Compares with the reference implementation, whose clusters the same sweep joins.
    fn check(codes: &[u64], references: &[Reference], clustering: Clustering) {
        let tree = built(codes, references, clustering);
        let keys: Vec<MortonKey> = (0..).zip(codes).map(|(index, &code)| MortonKey { code, index }).collect();
        let expected = clusters(&keys, references, &clustering, 1.0).unwrap();
        let mut nodes = vec![[0; _]; expected.len()];
        let mut sink = NodeSink { nodes: &mut nodes, first: 0, area_sum: 0.0, scale: 1.0 };
        let subtrees = expected.iter().enumerate().map(|(index, cluster)| Subtree {
            count: cluster.triangle_ids.len() as u32,
            ..Subtree::leaf(cluster.bounds, index)
        });
        let top = Sweep::default().build(subtrees, &mut sink);
        assert_eq!(tree.root.map(|root| root.count), top.map(|root| root.count));
        assert_eq!(tree.root.map(|root| root.bounds), top.map(|root| root.bounds));

        let mut todo: Vec<_> =
            tree.root.iter().zip(&top).map(|(root, top)| (root.child, root.count, top.child)).collect();
        while let Some((child, count, expected_child)) = todo.pop() {
            if expected_child & LEAF_RANGE != 0 {
                assert_equal(&tree, child, count, &expected[(expected_child & !LEAF_RANGE) as usize]);
            } else {
                let (pair, expected) = (tree.node(child), Pair::unpacked(&nodes[expected_child as usize]));
                assert_eq!((pair.bounds, pair.counts), (expected.bounds, expected.counts));
                todo.extend(
                    [0, 1].map(|side| (pair.children[side], pair.counts[side], expected.children[side])),
                );
            }
        }
        let mut triangle_ids = tree.triangle_ids;
        triangle_ids.sort_unstable();
        assert!(triangle_ids.iter().copied().eq(0..codes.len() as u32));
    }

    #[test]
    fn equals_the_reference_implementation() {
        for n in [0, 1, 2, 3, 9, 100, 6_000] {
            for mask in [!0 >> 1, 0xff, 0xff << 40, 0] {
                let (codes, references) = input(n, mask);
                for clustering in [Clustering::NONE, Clustering::MERGED, SMALL] {
                    check(&codes, &references, clustering);
                }
            }
        }
    }

    #[test]
    fn clusters_of_one_are_the_radix_tree() {
        // The same thresholds, but not known to be one everywhere.
        let general = Clustering { max_clusters: 2, ..Clustering::NONE };
        for (n, mask) in [(1, 0), (100, 0xff), (30_000, !0 >> 1)] {
            let (codes, references) = input(n, mask);
            let scanned = built(&codes, &references, Clustering::NONE);
            let clustered = built(&codes, &references, general);
            assert_eq!(scanned.area_sum, clustered.area_sum);
            assert_eq!(scanned.depth(), clustered.depth());
            check(&codes, &references, general);
        }
    }

    #[test]
    fn identical_boxes_in_one_cell_merge_in_pairs() {
        let reference = |i| Reference { bounds: Aabb { min: Vec3::ZERO, max: Vec3::ONE }, triangle_id: i };
        let references: Vec<Reference> = (0..5000).map(reference).collect();
        let tree = built(&vec![7; 5000], &references, Clustering::MERGED);
        assert!((13..=16).contains(&tree.depth()), "{}", tree.depth());
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let (codes, references) = input(50_000, !0 >> 1);
        for clustering in [Clustering::NONE, Clustering::MERGED] {
            let results = [1, 2, 3, 8].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let tree = pool.install(|| built(&codes, &references, clustering));
                (tree.nodes, tree.triangle_ids, tree.root, tree.area_sum.to_bits())
            });
            assert!(results.iter().all(|result| *result == results[0]));
        }
    }

    #[test]
    fn cost_and_depth_of_two_unit_cubes() {
        // Two leaves of area 6 under a root of 2 x 1 x 1, area 10: (10 + 6 + 6) / 10.
        let cube = |x: f32| Reference {
            bounds: Aabb { min: Vec3::X * x, max: Vec3::X * x + Vec3::ONE },
            triangle_id: x as u32,
        };
        let references = [cube(0.0), cube(1.0)];
        let measures = crate::bvh::references::measure(&references);
        for clustering in [Clustering::NONE, Clustering::MERGED] {
            let (order, cancel, scale) = (order_of(&[0, 1]), CancelFlag::new(), measures.scale());
            let input = Input { order: &order, references: &references, scale, clustering, cancel: &cancel };
            let mut tree = BinaryTree::default();
            input.build(&mut tree, &mut Scratch::default()).unwrap();
            assert_eq!(tree.depth(), 1);
            assert!((tree.sah_cost(&measures) - 2.2).abs() < 1.0e-6);
        }
    }
}
