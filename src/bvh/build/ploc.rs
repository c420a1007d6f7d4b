//! PLOC builder: agglomerative clustering bottom-up, under a top split by the surface area heuristic.
//!
//! Clusters merge with their nearest neighbours in Morton order ([`super::clusters`]). Departure: the top levels of PLOC are of
//! uneven quality, so merging ends at [`TOP`] clusters, and the surface area heuristic splits those ([`super::sweep`]).
//!
//! Chunks of the Morton order are merged first, each in cache and in parallel, then their remaining clusters together. The
//! chunks do not depend on the number of threads, so neither does the tree.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::binary_tree::{BinaryTree, LEAF_RANGE, LEAF_SIZE, Pair, Subtree};
use super::clusters::{Clusters, NodeSink};
use super::morton::MortonOrder;
use super::sweep::Sweep;
use crate::bvh::references::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

/// References per chunk.
const CHUNK: usize = 1 << 13;
/// Factor by which a chunk's clusters are reduced.
const CHUNK_REDUCTION: usize = 16;
/// Maximum of clusters that a chunk leaves.
const CLUSTERS_PER_CHUNK: usize = CHUNK / CHUNK_REDUCTION;
/// Clusters that the surface area heuristic splits.
const TOP: usize = 512;

/// Scratch memory of the builder.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// Clusters of the chunk of each thread.
    chunks: Vec<Mutex<Clusters>>,
    /// Remaining clusters, [`CLUSTERS_PER_CHUNK`] entries per chunk.
    left: Vec<Subtree>,
    /// Remaining clusters of all chunks.
    joint: Clusters,
    sweep: Sweep,
}

/// Fills `tree` with a tree over `references` in `order`; areas are of boxes multiplied by `scale`.
pub(crate) fn build(
    tree: &mut BinaryTree,
    order: &MortonOrder,
    references: &[Reference],
    scratch: &mut Scratch,
    scale: f32,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    let count = order.len();
    let chunks = count.div_ceil(CHUNK);
    scratch.chunks.resize_with(rayon::current_num_threads().max(scratch.chunks.len()), Mutex::default);
    scratch.left.resize(chunks * CLUSTERS_PER_CHUNK, Subtree::leaf(Aabb::EMPTY, 0));
    tree.reset(count + chunks * CLUSTERS_PER_CHUNK, count);
    let (chunk_nodes, joint_nodes) = tree.nodes.split_at_mut(count);

    // Merge within chunks.
    let input = ChunkInput { order, references, clusters: &scratch.chunks, scale };
    let merged: Vec<(usize, f64)> = chunk_nodes
        .par_chunks_mut(CHUNK)
        .zip(tree.triangle_ids.par_chunks_mut(CHUNK))
        .zip(scratch.left.par_chunks_mut(CLUSTERS_PER_CHUNK))
        .enumerate()
        .map(|(chunk, ((nodes, triangle_ids), left))| {
            cancel.check()?;
            Ok(input.merge(chunk * CHUNK, nodes, triangle_ids, left))
        })
        .collect::<Result<_, _>>()?;

    // Merge the remaining clusters of all chunks, and split the top.
    let mut all = Vec::with_capacity(merged.iter().map(|(count, _)| count).sum());
    for (left, &(count, _)) in scratch.left.chunks(CLUSTERS_PER_CHUNK).zip(&merged) {
        all.extend_from_slice(&left[..count]);
    }
    cancel.check()?;
    let Scratch { joint, sweep, .. } = scratch;
    joint.fill(all.into_iter());
    let area_sum = merged.iter().map(|(_, area_sum)| area_sum).sum();
    let mut sink = NodeSink { nodes: joint_nodes, first: count, area_sum, scale };
    joint.merge_down_to(TOP, &mut sink);
    tree.root = sweep.build(joint.iter(), &mut sink);
    tree.area_sum = sink.area_sum;
    Ok(())
}

/// Inputs of the merging within chunks.
struct ChunkInput<'a> {
    order: &'a MortonOrder,
    references: &'a [Reference],
    /// Scratch memory of each thread.
    clusters: &'a [Mutex<Clusters>],
    scale: f32,
}

impl ChunkInput<'_> {
    fn reference(&self, position: usize) -> &Reference {
        &self.references[self.order.index(position) as usize]
    }

    /// Merges the chunk that starts at position `first`. Fills its `nodes` and `triangle_ids`, and `left` with the remaining
    /// clusters; returns their number and the sum of the nodes' areas.
    fn merge(
        &self,
        first: usize,
        nodes: &mut [Pair],
        triangle_ids: &mut [u32],
        left: &mut [Subtree],
    ) -> (usize, f64) {
        let thread = rayon::current_thread_index().unwrap_or(0) % self.clusters.len();
        let mut clusters = self.clusters[thread].lock().unwrap_or_else(PoisonError::into_inner);
        let positions = first..first + nodes.len();
        clusters.fill(positions.map(|position| Subtree::leaf(self.reference(position).bounds, position)));
        let mut sink = NodeSink { nodes: &mut *nodes, first, area_sum: 0.0, scale: self.scale };
        let target = clusters.len() / CHUNK_REDUCTION;
        clusters.merge_down_to(target, &mut sink);
        let area_sum = sink.area_sum;

        // Store triangles in the order of the leaves.
        let mut layout = LeafLayout {
            nodes,
            first,
            triangle_ids,
            filled: 0,
            triangle_at: |position| self.reference(position).triangle_id,
        };
        for (to, from) in left.iter_mut().zip(clusters.iter()) {
            *to = Subtree { child: layout.arrange(from.child, from.count), ..from };
        }
        (clusters.len(), area_sum)
    }
}

/// Layout of a chunk's triangles, such that each leaf has consecutive positions.
struct LeafLayout<'a, F> {
    nodes: &'a mut [Pair],
    /// Index of the first node, which is also the first position.
    first: usize,
    triangle_ids: &'a mut [u32],
    /// Number of filled positions.
    filled: usize,
    /// Triangle index at a position of the Morton order.
    triangle_at: F,
}

impl<F: Fn(usize) -> u32> LeafLayout<'_, F> {
    /// Fills the next positions with the triangles of a subtree; returns its new child word.
    fn arrange(&mut self, child: u32, count: u32) -> u32 {
        let start = self.filled;
        if count > LEAF_SIZE {
            let node = child as usize - self.first;
            let Pair { children: [left, right], counts, .. } = self.nodes[node];
            self.nodes[node].children = [self.arrange(left, counts[0]), self.arrange(right, counts[1])];
            return child;
        }
        self.append(child);
        (self.first + start) as u32 | LEAF_RANGE
    }

    /// Fills the next positions with the triangles of a subtree that becomes a leaf.
    fn append(&mut self, child: u32) {
        if child & LEAF_RANGE == 0 {
            let [left, right] = self.nodes[child as usize - self.first].children;
            self.append(left);
            self.append(right);
        } else {
            self.triangle_ids[self.filled] = (self.triangle_at)((child & !LEAF_RANGE) as usize);
            self.filled += 1;
        }
    }
}
