//! The binary tree that builders make and [`super::collapse`] reads.

use crate::bvh::wide_tree::WIDTH;
use crate::geometry::Aabb;

/// Set in a child word that names references in a row, by the place of the first.
pub(crate) const LEAF_RANGE: u32 = 1 << 31;
/// Subtrees of at most this many references become one leaf of the wide tree.
pub(crate) const LEAF_SIZE: u32 = WIDTH as u32;

/// An inner node: the boxes of both children, what they are, and how many references each has. One cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Pair {
    /// Boxes of the children.
    pub(crate) bounds: [Aabb; 2],
    /// Index of a node; or, with [`LEAF_RANGE`] set, the first of the child's places.
    pub(crate) children: [u32; 2],
    /// References of the children.
    pub(crate) counts: [u32; 2],
}

/// A finished subtree, without its place in the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Subtree {
    /// Its box.
    pub(crate) bounds: Aabb,
    /// Its child word.
    pub(crate) child: u32,
    /// Its references.
    pub(crate) count: u32,
    /// Levels of nodes below.
    pub(crate) height: u32,
}

/// A binary tree.
#[derive(Debug, Default)]
pub(crate) struct BinaryTree {
    /// Inner nodes; some may not belong to the tree.
    pub(crate) nodes: Vec<Pair>,
    /// The triangles at the places.
    pub(crate) triangle_ids: Vec<u32>,
    /// The whole tree, unless there are no references.
    pub(crate) root: Option<Subtree>,
    /// Sum of the surface areas of all nodes, in units of [`scaled_half_area`].
    pub(crate) area_sum: f64,
}

impl Pair {
    /// A place that is not yet filled.
    pub(crate) const NONE: Self = Self { bounds: [Aabb::EMPTY; 2], children: [u32::MAX; 2], counts: [0; 2] };

    /// The node of two subtrees.
    #[inline(always)]
    pub(crate) fn of(left: &Subtree, right: &Subtree) -> Self {
        Self {
            bounds: [left.bounds, right.bounds],
            children: [left.child, right.child],
            counts: [left.count, right.count],
        }
    }
}

impl Subtree {
    /// A single reference.
    #[inline(always)]
    pub(crate) fn leaf(bounds: Aabb, place: usize) -> Self {
        Self { bounds, child: place as u32 | LEAF_RANGE, count: 1, height: 0 }
    }

    /// Both under the node `child`.
    #[inline(always)]
    pub(crate) fn joined(&self, other: &Self, child: u32) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            child,
            count: self.count + other.count,
            height: 1 + self.height.max(other.height),
        }
    }
}

impl BinaryTree {
    /// Makes room for `nodes` nodes and `places` places, and forgets the last tree.
    pub(crate) fn reset(&mut self, nodes: usize, places: usize) {
        self.nodes.resize(nodes, Pair::NONE);
        self.triangle_ids.resize(places, u32::MAX);
        (self.root, self.area_sum) = (None, 0.0);
    }

    /// Levels below the root; a single reference has none.
    pub(crate) fn depth(&self) -> u32 {
        self.root.map_or(0, |root| root.height)
    }

    /// Surface area heuristic cost where visiting a node and testing a reference both cost one: the areas of all boxes over
    /// that of the root's. Where that is zero every box counts in full.
    pub(crate) fn sah_cost(&self, measures: &crate::bvh::references::Measures) -> f32 {
        let scene = measures.bounds.area();
        let metres = f64::from(measures.scale()).recip();
        let inner = 2.0 * self.area_sum * metres * metres;
        if scene > 0.0 {
            ((inner + measures.area_sum) / scene) as f32
        } else {
            (2 * measures.count).saturating_sub(1) as f32
        }
    }
}
