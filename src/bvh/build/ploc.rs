//! A tree from merging neighbours upward, under a top divided downward.
//!
//! Source: the merging is PLOC ([`super::clusters`]). Its own top levels depend on chance, so that merging ends at some hundred
//! clusters, and the surface area heuristic divides those ([`super::sweep`]).
//!
//! Chunks of the Morton order merge by themselves at first, in cache and in parallel, and what is left of them together. The
//! chunks are the same for any number of threads, and so is the tree.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::binary_tree::{BinaryTree, LEAF_RANGE, LEAF_SIZE, Pair, Subtree};
use super::clusters::{Clusters, NodeSink};
use super::morton::MortonOrder;
use super::sweep::Sweep;
use crate::bvh::references::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

/// References that merge by themselves.
const CHUNK: usize = 1 << 13;
/// Until so many times fewer clusters are left.
const CHUNK_REDUCTION: usize = 16;
/// Most clusters that a chunk leaves.
const LEFT_OF_CHUNK: usize = CHUNK / CHUNK_REDUCTION;
/// Clusters that the heuristic divides.
const TOP: usize = 512;

/// Memory of the builder.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// One for each thread.
    chunks: Vec<Mutex<Clusters>>,
    /// What chunks leave, [`LEFT_OF_CHUNK`] places each.
    left: Vec<Subtree>,
    joint: Clusters,
    sweep: Sweep,
}

/// Fills `tree` with a tree over `references` in `order`; areas are of boxes multiplied by `scale`.
pub(crate) fn build(
    tree: &mut BinaryTree,
    order: &MortonOrder,
    references: &[Reference],
    scratch: &mut Scratch,
    (scale, cancel): (f32, &CancelFlag),
) -> Result<(), Cancelled> {
    let count = order.len();
    let chunks = count.div_ceil(CHUNK);
    let Scratch { chunks: clusters, left, joint, sweep } = scratch;
    clusters.resize_with(rayon::current_num_threads().max(clusters.len()), Mutex::default);
    left.resize(chunks * LEFT_OF_CHUNK, Subtree::leaf(Aabb::EMPTY, 0));
    tree.reset(count + chunks * LEFT_OF_CHUNK, count);
    let (chunk_nodes, joint_nodes) = tree.nodes.split_at_mut(count);

    // Chunks by themselves.
    let merged: Vec<(usize, f64)> = chunk_nodes
        .par_chunks_mut(CHUNK)
        .zip(tree.triangle_ids.par_chunks_mut(CHUNK))
        .zip(left.par_chunks_mut(LEFT_OF_CHUNK))
        .enumerate()
        .map(|(chunk, ((nodes, triangle_ids), left))| {
            cancel.check()?;
            let first = chunk * CHUNK;
            let thread = rayon::current_thread_index().unwrap_or(0) % clusters.len();
            let mut clusters = clusters[thread].lock().unwrap_or_else(PoisonError::into_inner);
            let reference = |place: usize| &references[order.index(place) as usize];
            let places = first..first + nodes.len();
            clusters.fill(places.map(|place| Subtree::leaf(reference(place).bounds, place)));
            let mut sink = NodeSink { nodes: &mut *nodes, first, area_sum: 0.0, scale };
            let target = clusters.len() / CHUNK_REDUCTION;
            clusters.merge_down_to(target, &mut sink);
            let area_sum = sink.area_sum;

            // Triangles in the order of the leaves.
            let mut rows = Rows {
                nodes,
                first,
                triangle_ids,
                filled: 0,
                triangle_at: |place| reference(place).triangle_id,
            };
            for (to, from) in left.iter_mut().zip(clusters.iter()) {
                *to = Subtree { child: rows.arrange(from.child, from.count), ..from };
            }
            Ok((clusters.len(), area_sum))
        })
        .collect::<Result<_, _>>()?;

    // What is left of them together, then the top.
    let mut all = Vec::with_capacity(merged.iter().map(|(count, _)| count).sum());
    for (left, &(count, _)) in left.chunks(LEFT_OF_CHUNK).zip(&merged) {
        all.extend_from_slice(&left[..count]);
    }
    cancel.check()?;
    joint.fill(all.into_iter());
    let area_sum = merged.iter().map(|(_, area_sum)| area_sum).sum();
    let mut sink = NodeSink { nodes: joint_nodes, first: count, area_sum, scale };
    joint.merge_down_to(TOP, &mut sink);
    tree.root = sweep.build(joint.iter(), &mut sink);
    tree.area_sum = sink.area_sum;
    Ok(())
}

/// A chunk's triangles, laid out so that each leaf's stand in a row.
struct Rows<'a, F> {
    nodes: &'a mut [Pair],
    /// Index of the first node, and first place.
    first: usize,
    triangle_ids: &'a mut [u32],
    /// How many places are filled.
    filled: usize,
    /// The triangle that a place of the Morton order has.
    triangle_at: F,
}

impl<F: Fn(usize) -> u32> Rows<'_, F> {
    /// Fills the next places with the triangles of a subtree; gives its new child word.
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

    /// Fills the next places with the triangles of a small subtree.
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
