//! Clustering of a task: a range of the radix tree, from its references to the clusters that it passes on.
//!
//! Clusters of at most [`LEAF_SIZE`] references get no node. Their positions are linked to a ring, and become consecutive ones when
//! the cluster becomes a leaf.

use super::binary_tree::{LEAF_RANGE, LEAF_SIZE, Pair, Subtree};
use super::clustering::{Built, Input, Output};
use super::clusters::{Clusters, Join};
use super::ranges::{Range, Ranges};
use crate::bvh::box_area::scaled_half_area;

/// References fetched together, so that their cache misses overlap.
const BATCH: usize = 128;

/// Scratch memory of a task.
#[derive(Debug, Default)]
pub(crate) struct TaskClusters {
    clusters: Clusters,
    rings: Vec<Link>,
}

/// Position of a reference, counted from the first of the task.
#[derive(Clone, Copy, Debug, Default)]
struct Link {
    /// Next position of the ring.
    next: u32,
    triangle_id: u32,
}

/// Sink of the nodes and leaves of a task.
struct TaskSink<'a> {
    output: Output<'a>,
    rings: &'a mut [Link],
    /// Number of nodes so far.
    nodes: usize,
    /// Number of filled positions.
    filled: usize,
    area_sum: f64,
    scale: f32,
}

/// Builds the clusters of a task.
pub(crate) fn build(input: &Input, output: Output, scratch: &mut TaskClusters) -> Built {
    let TaskClusters { clusters, rings } = scratch;
    let (first, count) = (output.first, output.nodes.len());
    clusters.clear();
    rings.resize(count, Link::default());
    let mut sink = TaskSink { output, rings, nodes: 0, filled: 0, area_sum: 0.0, scale: input.scale };
    let mut ranges = Ranges::new();
    let mut differences = [u64::MAX; BATCH];
    for start in (0..count).step_by(BATCH) {
        let size = BATCH.min(count - start);
        clusters.reserve(size);

        // Short loops keep many reads in flight.
        let links = sink.rings[start..start + size].iter_mut();
        for (local, link) in (start..).zip(links) {
            let triangle_id = input.reference(first + local).triangle_id;
            *link = Link { next: local as u32, triangle_id };
        }
        for (local, difference) in (start..start + size).zip(&mut differences) {
            // After the last one all ranges are complete.
            *difference = if local + 1 == count { u64::MAX } else { input.order.difference(first + local) };
        }
        for (local, &difference) in (start..start + size).zip(&differences) {
            let cluster = clusters.len();
            clusters.push(&Subtree::leaf(input.reference(first + local).bounds, local));
            ranges.add(&Range { first: local, count: 1 }, cluster, difference, |first, references| {
                input.limit(clusters, first, references, &mut sink);
            });
        }
    }
    let clusters = clusters.iter().map(|cluster| Subtree { child: sink.word(&cluster), ..cluster }).collect();
    Built { clusters, area_sum: sink.area_sum }
}

impl TaskSink<'_> {
    /// Child word of a cluster under a node or passed on. A small cluster becomes a leaf.
    #[inline(always)]
    fn word(&mut self, cluster: &Subtree) -> u32 {
        if cluster.count > LEAF_SIZE {
            return cluster.child;
        }
        let start = self.filled;
        let mut at = cluster.child & !LEAF_RANGE;
        for _ in 0..cluster.count {
            at = self.rings[at as usize].next;
            self.output.triangle_ids[self.filled] = self.rings[at as usize].triangle_id;
            self.filled += 1;
        }
        (self.output.first + start) as u32 | LEAF_RANGE
    }
}

impl Join for TaskSink<'_> {
    #[inline(always)]
    fn join(&mut self, left: &Subtree, right: &Subtree) -> Subtree {
        let child = if left.count + right.count <= LEAF_SIZE {
            // The word names the last position of the ring. Exchanging the next ones of two rings makes one of both.
            let [a, b] = [left, right].map(|side| (side.child & !LEAF_RANGE) as usize);
            let next = self.rings[a].next;
            self.rings[a].next = self.rings[b].next;
            self.rings[b].next = next;
            right.child
        } else {
            let children = [self.word(left), self.word(right)];
            let node = self.nodes;
            self.nodes += 1;
            self.output.nodes[node] = Pair { children, ..Pair::of(left, right) }.packed();
            (self.output.first + node) as u32
        };
        let joined = left.joined(right, child);
        self.area_sum += f64::from(scaled_half_area(&joined.bounds, self.scale));
        joined
    }
}
