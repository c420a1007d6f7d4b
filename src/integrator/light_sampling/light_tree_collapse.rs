//! The nodes of up to eight children that light trees are sampled with, from a binary tree.

use arrayvec::ArrayVec;
use rayon::prelude::*;

use super::light_node::{Content, LightNode};
use super::wide_light_node::{WIDTH, WideLightNode};

/// The slot of emitters that are not in the tree, and above the root.
pub(super) const NO_SLOT: u32 = u32::MAX;

/// Levels of more nodes are collapsed in parallel.
const PARALLEL_COUNT: usize = 64;

/// A tree of wide nodes. A slot is a child of a node: [`WIDTH`] × the node's index + the child's.
#[derive(Clone, Debug, Default)]
pub(super) struct WideLightTree {
    /// Level by level, the root first.
    pub(super) nodes: Vec<WideLightNode>,
    /// The slot of each node.
    pub(super) parents: Vec<u32>,
    /// The slot of each emitter.
    pub(super) leaves: Vec<u32>,
}

/// Indices of binary nodes.
type Children = ArrayVec<u32, WIDTH>;

/// Makes the wide tree of a binary one over so many emitters.
pub(super) fn collapse(binary: &[LightNode], emitter_count: usize) -> WideLightTree {
    let mut tree = WideLightTree { leaves: vec![NO_SLOT; emitter_count], ..WideLightTree::default() };
    // The binary nodes, and the slots, of the wide nodes of a level
    let mut level: Vec<(u32, u32)> = if binary.is_empty() { Vec::new() } else { vec![(0, NO_SLOT)] };
    while !level.is_empty() {
        let children: Vec<Children> = level
            .par_iter()
            .with_min_len(PARALLEL_COUNT)
            .map(|(node, _)| children_of(binary, *node))
            .collect();
        let mut next = Vec::new();
        let first_of_next = (tree.nodes.len() + level.len()) as u32;
        for ((_, parent), children) in level.into_iter().zip(children) {
            let first_slot = (tree.nodes.len() * WIDTH) as u32;
            let mut wide = WideLightNode::EMPTY;
            for (lane, (slot, child)) in (first_slot..).zip(children).enumerate() {
                let node = &binary[child as usize];
                match node.content {
                    Content::Emitter(emitter) => {
                        wide.set(lane, node, emitter, true);
                        tree.leaves[emitter as usize] = slot;
                    }
                    Content::Children(_) => {
                        wide.set(lane, node, first_of_next + next.len() as u32, false);
                        next.push((child, slot));
                    }
                }
            }
            tree.nodes.push(wide);
            tree.parents.push(parent);
        }
        level = next;
    }
    tree
}

/// The children of a wide node: those of its binary node, of which the one of most power is replaced by its own as long as there is space.
fn children_of(binary: &[LightNode], node: u32) -> Children {
    let mut children = Children::new();
    children.push(node);
    while children.len() < WIDTH {
        let mut most: Option<(f32, usize, u32)> = None;
        for (lane, &child) in children.iter().enumerate() {
            let node = &binary[child as usize];
            if let Content::Children(first) = node.content {
                let power = node.bounds.power;
                if most.is_none_or(|(largest, ..)| power > largest) {
                    most = Some((power, lane, first));
                }
            }
        }
        let Some((_, lane, first)) = most else { break };
        children[lane] = first;
        children.push(first + 1);
    }
    children
}
