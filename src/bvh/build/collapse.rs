//! Collapse of a binary tree to the wide tree.
//!
//! Source: Wald, Benthin, Boulos, "Getting Rid of Packets", RT 2008: a node's child of largest area is opened first. Subtrees of
//! at most eight references become leaves. A leaf stores a triangle once, even if splitting gave it several references there.
//!
//! A subtree of n references owns n leaf slots, so parallel tasks write leaves without synchronization. The number of nodes of
//! a task is known only at its end; its nodes are then moved to their place after those of the top.

use std::hint::black_box;

use rayon::prelude::*;

use super::binary_tree::{BinaryTree, LEAF_RANGE, LEAF_SIZE, Pair};
use crate::bvh::box_area::scaled_half_area;
use crate::bvh::references::Input;
use crate::bvh::wide_tree::{
    BLOCK, Leaf, NO_CHILD, Tag, WIDTH, WORDS_PER_SLOT, WideNode, WideTree, write_leaf,
};
use crate::cancel::Cancelled;
use crate::geometry::Aabb;
use crate::parallel_resize::{resize_with, resize_zeroed};

/// Smallest number of references per task.
const MIN_TASK: u32 = 2048;
/// Number of tasks for large inputs.
const TASKS: u32 = 64;

/// References per node of the binary tree that are assumed where its nodes are fetched. There are about four, since subtrees that become leaves
/// have no nodes; an estimate too large leaves a few to be loaded later, one too small fetches those of other branches.
const REFERENCES_PER_NODE: usize = 5;
/// Leaves whose triangles are fetched together.
const LEAVES_PER_BATCH: usize = 32;

/// Inputs of the collapse.
#[derive(Clone, Copy)]
pub(crate) struct CollapseInput<'a> {
    /// The binary tree.
    pub(crate) tree: &'a BinaryTree,
    /// The triangles.
    pub(crate) input: Input<'a>,
    /// Factor of lengths before areas are computed.
    pub(crate) scale: f32,
    /// Whether a triangle may have several references.
    pub(crate) has_copies: bool,
}

/// Memory kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    top: Vec<WideNode>,
    parts: Vec<TaskOutput>,
}

/// Nodes and leaves of a task.
#[derive(Debug, Default)]
struct TaskOutput {
    /// Nodes; indices start from zero.
    nodes: Vec<WideNode>,
    /// Number of triangles and of slots of each leaf.
    leaves: Vec<(u8, u8)>,
    /// Triangle indices of all leaves.
    triangle_ids: Vec<u32>,
}

/// Subtree of the binary tree that becomes one child of a wide node.
#[derive(Clone, Copy)]
struct Branch {
    bounds: Aabb,
    child: u32,
    count: u32,
    /// Negative if it becomes a leaf.
    area: f32,
}

/// Subtree left to a task, and the node and lane of the top that refer to it.
struct OpenBranch {
    branch: Branch,
    node: usize,
    lane: usize,
}

/// Task: a subtree, its output, and the words of its leaves.
struct Part<'a> {
    source: CollapseInput<'a>,
    output: &'a mut TaskOutput,
    words: &'a mut [f32],
    /// First slot of the next leaf.
    slot: usize,
}

impl WideTree {
    /// Replaces this tree with the collapsed binary tree; memory is reused.
    pub(crate) fn collapse(&mut self, source: CollapseInput, scratch: &mut Scratch) -> Result<(), Cancelled> {
        self.root = NO_CHILD;
        scratch.top.clear();
        let words = source.tree.triangle_ids.len() * WORDS_PER_SLOT + BLOCK;
        resize_zeroed(&mut self.words, words, 0.0);
        let Some(root) = source.tree.root else {
            self.nodes.clear();
            return Ok(());
        };

        // Collapse the top, then the subtrees below in parallel.
        let task = (root.count / TASKS).max(MIN_TASK);
        let root = source.branch(&Pair::of(&root, &root), 0);
        let mut open = Vec::new();
        if root.count > task {
            self.root = source.open_top(root, task, &mut scratch.top, &mut open);
        } else {
            open.push(OpenBranch { branch: root, node: 0, lane: 0 });
        }
        let roots = grow_parts(source, &open, &mut self.words, scratch)?;
        self.join(&open, &roots, scratch);
        Ok(())
    }

    /// Appends the nodes of all parts to those of the top.
    fn join(&mut self, open: &[OpenBranch], roots: &[u32], scratch: &mut Scratch) {
        let Scratch { top, parts } = scratch;
        let parts = &parts[..open.len()];
        let mut first = top.len();
        let mut offsets = Vec::with_capacity(parts.len());
        for ((open, part), &root) in open.iter().zip(parts).zip(roots) {
            let word = moved(root, first as u32);
            match top.get_mut(open.node) {
                Some(node) => node.children[open.lane] = word,
                None => self.root = word,
            }
            offsets.push(first as u32);
            first += part.nodes.len();
        }

        resize_with(&mut self.nodes, first, || WideNode::EMPTY);
        let (copy, mut rest) = self.nodes.split_at_mut(top.len());
        copy.clone_from_slice(top);
        let mut targets = Vec::with_capacity(parts.len());
        for part in parts {
            let (target, after) = rest.split_at_mut(part.nodes.len());
            targets.push(target);
            rest = after;
        }
        targets.into_par_iter().zip(parts).zip(offsets).for_each(|((target, part), offset)| {
            target.clone_from_slice(&part.nodes);
            for child in target.iter_mut().flat_map(|node| &mut node.children) {
                *child = moved(*child, offset);
            }
        });
    }
}

/// Child word after the nodes of its part have moved by `offset`.
fn moved(child: u32, offset: u32) -> u32 {
    if child == NO_CHILD || Leaf::of(child).is_some() { child } else { child + offset }
}

/// Collapses the open subtrees, whose slots follow each other; returns their child words.
fn grow_parts(
    source: CollapseInput,
    open: &[OpenBranch],
    words: &mut [f32],
    scratch: &mut Scratch,
) -> Result<Vec<u32>, Cancelled> {
    if scratch.parts.len() < open.len() {
        scratch.parts.resize_with(open.len(), TaskOutput::default);
    }
    let mut first_slot = 0;
    let mut rest = words;
    let mut parts = Vec::with_capacity(open.len());
    for (open, output) in open.iter().zip(&mut scratch.parts) {
        let count = open.branch.count as usize;
        let (words, after) = rest.split_at_mut(count * WORDS_PER_SLOT);
        parts.push((open.branch, Part { source, output, words, slot: first_slot }));
        first_slot += count;
        rest = after;
    }
    parts
        .into_par_iter()
        .map(|(branch, mut part)| {
            source.input.cancel.check()?;
            part.output.clear();
            source.fetch_nodes(&branch);
            let root = part.grow(&branch);
            part.write_leaves();
            Ok(root)
        })
        .collect()
}

impl CollapseInput<'_> {
    /// Prefetches the nodes below a branch in memory order, which is faster than loading them one by one on the way down.
    /// [`super::hploc`] stores them before the branch's own node.
    fn fetch_nodes(&self, branch: &Branch) {
        if branch.child & LEAF_RANGE == 0 {
            let last = branch.child as usize;
            let first = last.saturating_sub(branch.count as usize / REFERENCES_PER_NODE);
            let sum = self.tree.nodes[first..=last].iter().fold(0, |sum, pair| sum ^ pair[0]);
            black_box(sum);
        }
    }

    /// Child of a node.
    #[inline(always)]
    fn branch(&self, pair: &Pair, side: usize) -> Branch {
        let (bounds, count) = (pair.bounds[side], pair.counts[side]);
        let area = if count <= LEAF_SIZE { -1.0 } else { scaled_half_area(&bounds, self.scale) };
        Branch { bounds, child: pair.children[side], count, area }
    }

    /// Up to eight branches that together hold the references of `branch`, which is too large for a leaf.
    #[inline(always)]
    fn children(&self, branch: &Branch) -> ([Branch; WIDTH], usize) {
        let mut children = [*branch; WIDTH];
        let mut count = 1;
        let mut slot = 0;
        loop {
            let pair = self.tree.node(children[slot].child);
            children[slot] = self.branch(&pair, 0);
            children[count] = self.branch(&pair, 1);
            count += 1;
            if count == WIDTH {
                break;
            }
            slot = (0..count).fold(0, |a, b| if children[b].area > children[a].area { b } else { a });
            if children[slot].area < 0.0 {
                break;
            }
        }
        (children, count)
    }

    /// Collapses branches of more than `task` references, and lists smaller ones in the order of their slots.
    fn open_top(
        &self,
        branch: Branch,
        task: u32,
        nodes: &mut Vec<WideNode>,
        open: &mut Vec<OpenBranch>,
    ) -> u32 {
        let index = nodes.len();
        nodes.push(WideNode::EMPTY);
        let (children, count) = self.children(&branch);
        for (lane, &branch) in children[..count].iter().enumerate() {
            let word = if branch.count > task {
                self.open_top(branch, task, nodes, open)
            } else {
                open.push(OpenBranch { branch, node: index, lane });
                NO_CHILD
            };
            nodes[index].put(lane, word, &branch.bounds);
        }
        index as u32
    }

    /// Triangles of a branch of at most [`LEAF_SIZE`] references, each once.
    #[inline(always)]
    fn triangles_of(&self, branch: &Branch) -> ([u32; WIDTH], usize) {
        let mut found = [0; WIDTH];
        let mut count = 0;
        let mut todo = [(0, 0); WIDTH];
        todo[0] = (branch.child, branch.count);
        let mut pending = 1;
        while pending > 0 {
            pending -= 1;
            let (child, references) = todo[pending];
            if child & LEAF_RANGE == 0 {
                let pair = self.tree.node(child);
                todo[pending] = (pair.children[1], pair.counts[1]);
                todo[pending + 1] = (pair.children[0], pair.counts[0]);
                pending += 2;
                continue;
            }
            let first = (child & !LEAF_RANGE) as usize;
            for &triangle_id in &self.tree.triangle_ids[first..first + references as usize] {
                if !self.has_copies || !found[..count].contains(&triangle_id) {
                    found[count] = triangle_id;
                    count += 1;
                }
            }
        }
        (found, count)
    }
}

impl Part<'_> {
    /// Collapses a branch; returns its child word.
    fn grow(&mut self, branch: &Branch) -> u32 {
        if branch.count <= LEAF_SIZE {
            return self.leaf(branch);
        }
        let index = self.output.nodes.len();
        self.output.nodes.push(WideNode::EMPTY);
        let (children, count) = self.source.children(branch);
        for (lane, child) in children[..count].iter().enumerate() {
            let word = self.grow(child);
            self.output.nodes[index].put(lane, word, &child.bounds);
        }
        index as u32
    }

    /// Lists a leaf; returns its child word.
    fn leaf(&mut self, branch: &Branch) -> u32 {
        let count = if branch.child & LEAF_RANGE != 0 && !self.source.has_copies {
            let first = (branch.child & !LEAF_RANGE) as usize;
            let row = &self.source.tree.triangle_ids[first..first + branch.count as usize];
            self.output.triangle_ids.extend_from_slice(row);
            row.len()
        } else {
            let (triangle_ids, count) = self.source.triangles_of(branch);
            self.output.triangle_ids.extend_from_slice(&triangle_ids[..count]);
            count
        };
        self.output.leaves.push((count as u8, branch.count as u8));
        let first = self.slot;
        self.slot += branch.count as usize;
        Leaf::new(first, count).word()
    }

    /// Writes the words of all leaves. Triangles are fetched for several leaves at once, so that their cache misses overlap.
    fn write_leaves(self) {
        let Input { triangles, flags, .. } = self.source.input;
        let mut words = self.words;
        let mut triangle_ids = self.output.triangle_ids.as_slice();
        for leaves in self.output.leaves.chunks(LEAVES_PER_BATCH) {
            let count = leaves.iter().map(|&(count, _)| count as usize).sum();
            let (batch, primitives_after) = triangle_ids.split_at(count);
            triangle_ids = primitives_after;
            // A short loop keeps many reads in flight.
            let touched = batch.iter().fold(0, |sum, &triangle_id| {
                let [a, .., c] = &triangles[triangle_id as usize].vertices;
                sum ^ a.x.to_bits() ^ c.z.to_bits()
            });
            black_box(touched);
            let mut rest = batch;
            for &(count, slots) in leaves {
                let (leaf, rest_after) = rest.split_at(count as usize);
                let (out, words_after) = words.split_at_mut(slots as usize * WORDS_PER_SLOT);
                let triangle = |&triangle_id: &u32| {
                    let at = triangle_id as usize;
                    (triangles[at].vertices, Tag::new(triangle_id, flags[at]))
                };
                write_leaf(&mut out[..leaf.len() * WORDS_PER_SLOT], leaf.iter().map(triangle));
                (rest, words) = (rest_after, words_after);
            }
        }
    }
}

impl TaskOutput {
    fn clear(&mut self) {
        self.nodes.clear();
        self.leaves.clear();
        self.triangle_ids.clear();
    }
}
