//! The tree that rays walk: eight children a node, up to eight triangles a leaf.
//!
//! Source: the collapse of a binary tree by opening the child of largest area first is Wald, Benthin, Boulos, "Getting
//! Rid of Packets", RT 2008. Subtrees of at most eight references become leaves; copies of a triangle that
//! splitting put into one leaf are kept once.

use rayon::prelude::*;

use super::PrimitiveFlags;
use super::fit::FittedBoxes;
use super::lbvh::{LEAF, RadixTree};
use super::radix_sort::Keyed;
use super::split_clip::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::{Aabb, Triangle};
use glam::Vec3;

/// Children a node and triangles a leaf.
pub(super) const WIDTH: usize = 8;
/// A child that is not there; its box is entered by no ray.
pub(super) const NO_CHILD: u32 = u32::MAX;

/// Subtrees of fewer references than this are one task.
const SMALLEST_TASK: u32 = 2048;
/// Otherwise a task is this part of all references.
const TASKS: u32 = 64;
const LEAVES_A_CHUNK: usize = 1 << 10;

/// Boxes of up to eight children, by plane: min x, y, z, max x, y, z.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// The planes of all children.
    pub(super) planes: [[f32; WIDTH]; 6],
    /// Index of a node, of a leaf if [`LEAF`] is set, or [`NO_CHILD`].
    pub(super) children: [u32; WIDTH],
}

/// A leaf: up to eight triangles, lane by lane.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct TrianglePack {
    /// By corner, axis, lane.
    pub(super) corners: [[[f32; WIDTH]; 3]; 3],
    /// Ids of the triangles.
    pub(super) primitives: [u32; WIDTH],
    /// Flags of the triangles.
    pub(super) flags: [PrimitiveFlags; WIDTH],
    /// How many there are.
    pub(super) count: u32,
}

/// The wide tree.
#[derive(Debug)]
pub(super) struct WideTree {
    /// Child index of the root.
    pub(super) root: u32,
    /// Inner nodes.
    pub(super) nodes: Vec<WideNode>,
    /// Leaves.
    pub(super) leaves: Vec<TrianglePack>,
}

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

impl Default for WideTree {
    fn default() -> Self {
        Self { root: NO_CHILD, nodes: Vec::new(), leaves: Vec::new() }
    }
}

/// Part of the wide tree whose inner indices start at zero; leaves are ranges of keys.
#[derive(Default)]
struct Part {
    nodes: Vec<WideNode>,
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
        if count == 0 {
            self.leaves.clear();
            return Ok(());
        }
        if source.is_leaf_sized(source.root()) {
            self.root = LEAF;
            return self.fill_leaves(source, &[[0, count - 1]], triangles, flags, cancel);
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
            let (node_offset, leaf_offset) = (self.nodes.len() as u32, leaves.len() as u32);
            for child in part.nodes.iter_mut().flat_map(|node| &mut node.children) {
                if *child != NO_CHILD {
                    *child += if *child & LEAF == 0 { node_offset } else { leaf_offset };
                }
            }
            self.nodes.append(&mut part.nodes);
            leaves.append(&mut part.leaves);
        }
        self.fill_leaves(source, &leaves, triangles, flags, cancel)
    }

    /// Bytes of the arrays.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.leaves.as_slice())
    }

    fn fill_leaves(
        &mut self,
        source: Source,
        ranges: &[[u32; 2]],
        triangles: &[Triangle],
        flags: &[PrimitiveFlags],
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        self.leaves.resize(ranges.len(), TrianglePack::EMPTY);
        self.leaves.par_chunks_mut(LEAVES_A_CHUNK).zip(ranges.par_chunks(LEAVES_A_CHUNK)).try_for_each(
            |(packs, ranges)| {
                cancel.check()?;
                for (pack, &[first, last]) in packs.iter_mut().zip(ranges) {
                    *pack = TrianglePack::EMPTY;
                    for key in &source.keys[first as usize..=last as usize] {
                        let primitive = source.references[key.index as usize].primitive;
                        let triangle = &triangles[primitive as usize];
                        pack.add(primitive, triangle, flags[primitive as usize]);
                    }
                }
                Ok(())
            },
        )
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
                    (self.leaves.len() - 1) as u32 | LEAF
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

impl WideNode {
    /// No children.
    pub(super) const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [NO_CHILD; WIDTH],
    };

    /// Sets a child and its box.
    pub(super) fn put(&mut self, lane: usize, child: u32, bounds: &Aabb) {
        self.children[lane] = child;
        for axis in 0..3 {
            self.planes[axis][lane] = bounds.min[axis];
            self.planes[3 + axis][lane] = bounds.max[axis];
        }
    }

    /// The box of a child.
    pub(super) fn bounds(&self, lane: usize) -> Aabb {
        let [x0, y0, z0, x1, y1, z1] = self.planes.map(|plane| plane[lane]);
        Aabb { min: Vec3::new(x0, y0, z0), max: Vec3::new(x1, y1, z1) }
    }
}

impl TrianglePack {
    /// No triangles.
    pub(super) const EMPTY: Self = Self {
        corners: [[[0.0; WIDTH]; 3]; 3],
        primitives: [u32::MAX; WIDTH],
        flags: [PrimitiveFlags(0); WIDTH],
        count: 0,
    };

    /// Adds a triangle unless it is here already.
    pub(super) fn add(&mut self, primitive: u32, triangle: &Triangle, flags: PrimitiveFlags) {
        let lane = self.count as usize;
        if self.primitives[..lane].contains(&primitive) {
            return;
        }
        self.primitives[lane] = primitive;
        self.flags[lane] = flags;
        for (corner, vertex) in self.corners.iter_mut().zip(&triangle.vertices) {
            for axis in 0..3 {
                corner[axis][lane] = vertex[axis];
            }
        }
        self.count += 1;
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub(super) fn triangle(&self, lane: usize) -> [Vec3; 3] {
        self.corners.each_ref().map(|axes| Vec3::new(axes[0][lane], axes[1][lane], axes[2][lane]))
    }
}
