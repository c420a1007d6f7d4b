//! Boxes around all triangles of a hierarchy.

use super::hierarchy::{Bvh, Structure};
use super::wide_tree::{Leaf, NO_CHILD};
use crate::geometry::Aabb;

impl Bvh {
    /// A few boxes that together hold every triangle, those of the root's children; `None` where the tree has no node.
    pub fn outer_boxes(&self) -> Option<Vec<Aabb>> {
        match &self.structure {
            Structure::Wide(tree) if tree.root == NO_CHILD => Some(Vec::new()),
            Structure::Wide(tree) if Leaf::of(tree.root).is_none() => {
                let root = tree.nodes.get(tree.root as usize)?;
                let lanes = root.children.iter().enumerate().filter(|&(_, &child)| child != NO_CHILD);
                Some(lanes.map(|(lane, _)| root.bounds(lane)).collect())
            }
            Structure::Wide(_) | Structure::BruteForce(_) => None,
        }
    }
}
