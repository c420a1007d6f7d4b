//! Binary tree: output of the builders and input of [`super::collapse`].

use glam::Vec3;

use crate::bvh::wide_tree::WIDTH;
use crate::geometry::Aabb;
use crate::parallel_resize::resize_zeroed;

/// Bit that marks child words of leaves: a range of positions, named by its first.
pub(crate) const LEAF_RANGE: u32 = 1 << 31;
/// Subtrees of at most this many references become one leaf of the wide tree.
pub(crate) const LEAF_SIZE: u32 = WIDTH as u32;

/// Inner node: boxes, words and reference counts of both children.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    /// Boxes of the children.
    pub(crate) bounds: [Aabb; 2],
    /// Index of a node or, with [`LEAF_RANGE`] set, first position of a leaf.
    pub(crate) children: [u32; 2],
    /// Number of references below each child.
    pub(crate) counts: [u32; 2],
}

/// [`Pair`] as words. Memory for lists of words comes zeroed from the operating system, and what is never used is never touched.
pub(crate) type PackedPair = [u32; 16];

/// Finished subtree, not yet linked to a parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Subtree {
    /// Box.
    pub(crate) bounds: Aabb,
    /// Child word.
    pub(crate) child: u32,
    /// Number of references.
    pub(crate) count: u32,
    /// Levels of nodes below.
    pub(crate) height: u32,
}

/// Binary tree over references.
#[derive(Debug, Default)]
pub(crate) struct BinaryTree {
    /// Inner nodes; most entries may be unused.
    pub(crate) nodes: Vec<PackedPair>,
    /// Triangle index at each position.
    pub(crate) triangle_ids: Vec<u32>,
    /// Root; `None` without references.
    pub(crate) root: Option<Subtree>,
    /// Sum of the surface areas of all nodes, in units of [`scaled_half_area`].
    pub(crate) area_sum: f64,
}

impl Pair {
    /// Node with two children.
    #[inline(always)]
    pub(crate) fn of(left: &Subtree, right: &Subtree) -> Self {
        Self {
            bounds: [left.bounds, right.bounds],
            children: [left.child, right.child],
            counts: [left.count, right.count],
        }
    }

    /// The node as words.
    #[inline(always)]
    pub(crate) fn packed(&self) -> PackedPair {
        let [[a, b, c], [d, e, f]] = self.bounds.map(|bounds| bounds.min.to_array());
        let [[g, h, i], [j, k, l]] = self.bounds.map(|bounds| bounds.max.to_array());
        let [a, b, c, d, e, f] = [a, b, c, d, e, f].map(f32::to_bits);
        let [g, h, i, j, k, l] = [g, h, i, j, k, l].map(f32::to_bits);
        let ([m, n], [o, p]) = (self.children, self.counts);
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]
    }

    /// The node of these words.
    #[inline(always)]
    pub(crate) fn unpacked(&[a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]: &PackedPair) -> Self {
        let point = |x, y, z| Vec3::new(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z));
        let left = Aabb { min: point(a, b, c), max: point(g, h, i) };
        let right = Aabb { min: point(d, e, f), max: point(j, k, l) };
        Self { bounds: [left, right], children: [m, n], counts: [o, p] }
    }
}

impl Subtree {
    /// Leaf of a single reference.
    #[inline(always)]
    pub(crate) fn leaf(bounds: Aabb, position: usize) -> Self {
        Self { bounds, child: position as u32 | LEAF_RANGE, count: 1, height: 0 }
    }

    /// Subtree of the node `child`, whose children are these two.
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
    /// Discards the last tree and resizes to `nodes` nodes and `positions` positions.
    pub(crate) fn reset(&mut self, nodes: usize, positions: usize) {
        resize_zeroed(&mut self.nodes, nodes, [0; _]);
        resize_zeroed(&mut self.triangle_ids, positions, 0);
        (self.root, self.area_sum) = (None, 0.0);
    }

    /// Node of a child word.
    #[inline(always)]
    pub(crate) fn node(&self, child: u32) -> Pair {
        Pair::unpacked(&self.nodes[child as usize])
    }

    /// Levels below the root; zero for a single reference.
    pub(crate) fn depth(&self) -> u32 {
        self.root.map_or(0, |root| root.height)
    }

    /// Surface area heuristic cost with unit costs for nodes and references: the areas of all boxes over that of the root. If
    /// the root has no area, every box counts as one.
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
