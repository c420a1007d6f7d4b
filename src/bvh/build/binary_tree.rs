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

    /// The node as words: the lower corners of both boxes, the upper ones, children, counts.
    #[inline(always)]
    pub(crate) fn packed(&self) -> PackedPair {
        let [left, right] = &self.bounds;
        let corners = [left.min, right.min, left.max, right.max];
        let mut words = [0; 16];
        words[..12].copy_from_slice(corners.map(|corner| corner.to_array().map(f32::to_bits)).as_flattened());
        words[12..14].copy_from_slice(&self.children);
        words[14..].copy_from_slice(&self.counts);
        words
    }

    /// The node of these words.
    #[inline(always)]
    pub(crate) fn unpacked(words: &PackedPair) -> Self {
        let corner =
            |first: usize| Vec3::from_array([0, 1, 2].map(|axis| f32::from_bits(words[first + axis])));
        let bounds = [0, 3].map(|first| Aabb { min: corner(first), max: corner(6 + first) });
        Self { bounds, children: [words[12], words[13]], counts: [words[14], words[15]] }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_packed_by_corner() {
        let point = |x: f32| Vec3::new(x, x + 1.0, x + 2.0);
        let bounds = [0.0, 3.0].map(|x| Aabb { min: point(x), max: point(x + 6.0) });
        let pair = Pair { bounds, children: [12, LEAF_RANGE + 13], counts: [14, 15] };
        let words = pair.packed();
        assert!(words[..12].iter().map(|&word| f32::from_bits(word)).eq((0..12_u8).map(f32::from)));
        assert_eq!(words[12..], [12, LEAF_RANGE + 13, 14, 15]);
        assert_eq!(Pair::unpacked(&words), pair);
    }
}
