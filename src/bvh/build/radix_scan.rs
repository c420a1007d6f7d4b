//! Karras' radix tree of a task, built with its boxes in one pass: [`super::cluster_scan`] for a threshold of one cluster.
//!
//! The pass of [`super::ranges`] keeps the one subtree of each range on its stack, so it needs neither clusters nor a search.
//! Ranges of at most [`LEAF_SIZE`] references become leaves and get no node.

use super::binary_tree::{LEAF_RANGE, LEAF_SIZE, PackedPair, Pair, Subtree};
use super::clustering::{Built, Input, Output};
use super::ranges::MAX_STACK;
use crate::bvh::box_area::scaled_half_area;
use crate::geometry::Aabb;

/// Boxes fetched together, so that their cache misses overlap.
const BATCH: usize = 128;

/// Builds the tree of a task.
pub(crate) fn build(input: &Input, output: Output) -> Built {
    let (first, last) = (output.first, output.first + output.nodes.len() - 1);
    let (root, area_sum) = scan(input, first, last, output);
    Built { clusters: vec![root], area_sum }
}

/// Builds a range from left to right.
fn scan(
    input: &Input,
    first: usize,
    last: usize,
    Output { nodes, triangle_ids, .. }: Output,
) -> (Subtree, f64) {
    let mut area_sum = 0.0;
    let mut stack = [(u64::MAX, Subtree::leaf(Aabb::EMPTY, first)); MAX_STACK];
    let mut depth = 0;
    let mut nodes = (first as u32..).zip(nodes);
    let mut fetched = [(Aabb::EMPTY, u64::MAX); BATCH];
    for batch in (first..=last).step_by(BATCH) {
        let end = (batch + BATCH - 1).min(last);
        let triangle_ids = &mut triangle_ids[batch - first..=end - first];
        // Short loops keep many reads in flight.
        for (position, triangle_id) in (batch..=end).zip(&mut *triangle_ids) {
            *triangle_id = input.reference(position).triangle_id;
        }
        for (position, (bounds, difference)) in (batch..=end).zip(&mut fetched) {
            *bounds = input.reference(position).bounds;
            // After the last one all subtrees are joined.
            *difference = if position == last { u64::MAX } else { input.order.difference(position) };
        }
        for (position, &(bounds, difference)) in (batch..=end).zip(&fetched) {
            let mut current = Subtree::leaf(bounds, position);
            while depth > 0 && stack[depth - 1].0 < difference {
                depth -= 1;
                let left = &stack[depth].1;
                current = join(left, &current, position, &mut nodes);
                area_sum += f64::from(scaled_half_area(&current.bounds, input.scale));
            }
            stack[depth] = (difference, current);
            depth += 1;
        }
    }
    (stack[0].1, area_sum)
}

/// Joins two adjacent subtrees, of which the right one ends at `last`. A new node takes the next entry of `nodes`.
#[inline(always)]
fn join<'a>(
    left: &Subtree,
    right: &Subtree,
    last: usize,
    nodes: &mut impl Iterator<Item = (u32, &'a mut PackedPair)>,
) -> Subtree {
    let count = left.count + right.count;
    let mut child = (last + 1 - count as usize) as u32 | LEAF_RANGE;
    if count > LEAF_SIZE
        && let Some((index, node)) = nodes.next()
    {
        *node = Pair::of(left, right).packed();
        child = index;
    }
    left.joined(right, child)
}
