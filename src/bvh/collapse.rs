//! From a binary tree to the wide one.
//!
//! Source: the collapse by opening the child of largest area first is Wald, Benthin, Boulos, "Getting
//! Rid of Packets", RT 2008. Subtrees of at most eight references become leaves; copies of a triangle that
//! splitting put into one leaf are kept once.

use rayon::prelude::*;

use super::PrimitiveFlags;
use super::fit::FittedBoxes;
use super::lbvh::{LEAF, RadixTree};
use super::radix_sort::Keyed;
use super::split_clip::Reference;
use super::wide::{Leaf, NO_CHILD, Tag, WIDTH, WORDS_A_PLACE, WideNode, WideTree, write_leaf};
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::{Aabb, Triangle};

/// Subtrees of fewer references than this are one task.
const SMALLEST_TASK: u32 = 2048;
/// Otherwise a task is this part of all references.
const TASKS: u32 = 64;

/// What the collapse reads.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    /// The binary tree.
    pub(super) tree: &'a RadixTree,
    /// Its boxes.
    pub(super) boxes: &'a FittedBoxes,
    /// Its leaves in order.
    pub(super) keys: &'a [Keyed],
    /// The references of the leaves.
    pub(super) references: &'a [Reference],
}

/// Part of the wide tree whose inner indices start at zero. A leaf starts at the place of its first key.
#[derive(Default)]
struct Part {
    nodes: Vec<WideNode>,
    /// First and last key of each leaf.
    leaves: Vec<[u32; 2]>,
    /// Subtrees left to other tasks: binary node, and the node and lane that wait for it.
    open: Vec<(u32, usize, usize)>,
}

impl WideTree {
    /// Collapses the binary tree into this one, whose memory is used again.
    pub(super) fn collapse(
        &mut self,
        source: Source,
        triangles: &[Triangle],
        flags: &[PrimitiveFlags],
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        self.root = NO_CHILD;
        self.nodes.clear();
        let count = source.keys.len() as u32;
        self.words.clear();
        self.words.resize(count as usize * WORDS_A_PLACE + WIDTH, 0.0);
        if count == 0 {
            return Ok(());
        }
        if source.is_leaf_sized(source.root()) {
            self.root = source.leaf([0, count - 1]).word();
            self.fill_leaves(source, &[[0, count - 1]], triangles, flags);
            return Ok(());
        }

        // The top by itself, then the subtrees below in parallel.
        let task = (count / TASKS).max(SMALLEST_TASK);
        let mut top = Part::default();
        top.grow(source, source.root(), task);
        let parts: Vec<Part> = top
            .open
            .par_iter()
            .map(|&(root, ..)| {
                cancel.check()?;
                let mut part = Part::default();
                part.grow(source, root, 0);
                Ok(part)
            })
            .collect::<Result<_, _>>()?;

        // Join: nodes and leaves of the parts follow those of the top.
        let mut leaves = std::mem::take(&mut top.leaves);
        let mut first_node = top.nodes.len() as u32;
        for (&(_, node, lane), part) in top.open.iter().zip(&parts) {
            top.nodes[node].children[lane] = first_node;
            first_node += part.nodes.len() as u32;
        }
        self.root = 0;
        self.nodes.append(&mut top.nodes);
        for mut part in parts {
            let node_offset = self.nodes.len() as u32;
            for child in part.nodes.iter_mut().flat_map(|node| &mut node.children) {
                if *child != NO_CHILD && Leaf::of(*child).is_none() {
                    *child += node_offset;
                }
            }
            self.nodes.append(&mut part.nodes);
            leaves.append(&mut part.leaves);
        }
        self.fill_leaves(source, &leaves, triangles, flags);
        Ok(())
    }

    fn fill_leaves(
        &mut self,
        source: Source,
        ranges: &[[u32; 2]],
        triangles: &[Triangle],
        flags: &[PrimitiveFlags],
    ) {
        for &range in ranges {
            let (primitives, count) = source.primitives(range);
            let start = range[0] as usize * WORDS_A_PLACE;
            let words = &mut self.words[start..start + count * WORDS_A_PLACE];
            let triangles = primitives[..count].iter().map(|&primitive| {
                (triangles[primitive as usize].vertices, Tag::new(primitive, flags[primitive as usize]))
            });
            write_leaf(words, triangles);
        }
    }
}

impl Source<'_> {
    fn root(&self) -> u32 {
        if self.tree.nodes.is_empty() { LEAF } else { 0 }
    }

    fn range(&self, node: u32) -> [u32; 2] {
        if node & LEAF == 0 { self.tree.nodes[node as usize].range } else { [node & !LEAF; 2] }
    }

    fn size(&self, node: u32) -> u32 {
        let [first, last] = self.range(node);
        last - first + 1
    }

    fn is_leaf_sized(&self, node: u32) -> bool {
        self.size(node) <= WIDTH as u32
    }

    /// The triangles of a leaf-sized range, each once, and how many there are.
    fn primitives(&self, [first, last]: [u32; 2]) -> ([u32; WIDTH], usize) {
        let mut primitives = [u32::MAX; WIDTH];
        let mut count = 0;
        for key in &self.keys[first as usize..=last as usize] {
            let primitive = self.references[key.index as usize].primitive;
            if !primitives[..count].contains(&primitive) {
                primitives[count] = primitive;
                count += 1;
            }
        }
        (primitives, count)
    }

    fn leaf(&self, range: [u32; 2]) -> Leaf {
        Leaf::new(range[0] as usize, self.primitives(range).1)
    }

    fn bounds(&self, node: u32) -> Aabb {
        if node & LEAF == 0 {
            self.boxes.bounds(node)
        } else {
            let key = self.keys[(node & !LEAF) as usize];
            self.references[key.index as usize].bounds
        }
    }

    /// Up to eight binary nodes that together hold what is below `node`, with their boxes.
    fn children(&self, node: u32) -> ([(u32, Aabb); WIDTH], usize) {
        let mut children = [(NO_CHILD, Aabb::EMPTY); WIDTH];
        // Areas of the children that can be opened; negative for the others.
        let mut areas = [-1.0_f64; WIDTH];
        let mut put = |slot: usize, child: u32, areas: &mut [f64; WIDTH]| {
            let bounds = self.bounds(child);
            children[slot] = (child, bounds);
            areas[slot] = if self.is_leaf_sized(child) { -1.0 } else { bounds.area() };
        };
        let mut open = node;
        let mut slot = 0;
        let mut count = 1;
        let mut inside = [NO_CHILD; WIDTH];
        loop {
            let [left, right] = self.tree.nodes[open as usize].children;
            put(slot, left, &mut areas);
            put(count, right, &mut areas);
            (inside[slot], inside[count]) = (left, right);
            count += 1;
            if count == WIDTH {
                break;
            }
            slot = (0..count).fold(0, |a, b| if areas[b] > areas[a] { b } else { a });
            if areas[slot] < 0.0 {
                break;
            }
            open = inside[slot];
        }
        (children, count)
    }
}

impl Part {
    /// Collapses the subtree of `root`, which is too large for a leaf; leaves subtrees of at most `task` references open.
    fn grow(&mut self, source: Source, root: u32, task: u32) {
        let mut todo = vec![(root, 0)];
        self.nodes.push(WideNode::EMPTY);
        while let Some((binary, wide)) = todo.pop() {
            let (children, count) = source.children(binary);
            for (lane, &(child, bounds)) in children[..count].iter().enumerate() {
                let index = if source.is_leaf_sized(child) {
                    self.leaves.push(source.range(child));
                    source.leaf(source.range(child)).word()
                } else if source.size(child) <= task {
                    self.open.push((child, wide, lane));
                    NO_CHILD
                } else {
                    self.nodes.push(WideNode::EMPTY);
                    todo.push((child, self.nodes.len() - 1));
                    (self.nodes.len() - 1) as u32
                };
                self.nodes[wide].put(lane, index, &bounds);
            }
        }
    }
}
