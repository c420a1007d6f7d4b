//! Check of the invariants of a finished hierarchy.

use crate::bvh::hierarchy::{Bvh, Structure};
use crate::bvh::is_traced;
use crate::bvh::triangle_flags::TriangleFlags;
use crate::bvh::wide_tree::{Leaf, NO_CHILD, WIDTH, WideTree};
use crate::geometry::{Aabb, Triangle};

impl Bvh {
    /// Traverses the hierarchy and describes the first broken invariant:
    ///
    /// * Every node and leaf is reached once.
    /// * Boxes contain the boxes of their children.
    /// * Every traced triangle, and no other, is in at least one leaf, once per leaf and with its own corners.
    /// * The boxes of a triangle's leaves cover its bounds.
    pub fn validate(&self, triangles: &[Triangle], flags: &[TriangleFlags]) -> Result<(), String> {
        match &self.structure {
            Structure::BruteForce(_) => Ok(()),
            Structure::Wide(tree) => validate(tree, triangles, flags),
        }
    }
}

fn validate(tree: &WideTree, triangles: &[Triangle], flags: &[TriangleFlags]) -> Result<(), String> {
    let mut node_visits = vec![0_u32; tree.nodes.len()];
    let mut slot_visits = vec![0_u32; tree.slots()];
    let mut covered = vec![Aabb::EMPTY; triangles.len()];
    let everything = Aabb { min: glam::Vec3::NEG_INFINITY, max: glam::Vec3::INFINITY };
    let mut todo = vec![(tree.root, everything)];
    while let Some((child, bounds)) = todo.pop() {
        if child == NO_CHILD {
            continue;
        }
        if let Some(leaf) = Leaf::of(child) {
            let triangles_of_leaf = tree.triangles(leaf);
            check_leaf(tree, leaf, triangles)?;
            for lane in 0..leaf.count() {
                slot_visits[leaf.first() + lane] += 1;
                let covered = &mut covered[triangles_of_leaf.tag(lane).triangle() as usize];
                *covered = covered.union(bounds);
            }
            continue;
        }
        node_visits[child as usize] += 1;
        let node = &tree.nodes[child as usize];
        for lane in 0..WIDTH {
            let inner = node.bounds(lane);
            if node.children[lane] != NO_CHILD && (inner.is_empty() || !bounds.contains(&inner)) {
                return Err(format!("child {lane} of node {child} is not inside its parent's box"));
            }
            todo.push((node.children[lane], inner));
        }
    }

    if node_visits.iter().any(|&visits| visits != 1) || slot_visits.iter().any(|&visits| visits > 1) {
        return Err("a node is not reached exactly once, or two leaves overlap".to_owned());
    }
    for (triangle_id, ((triangle, &flags), covered)) in triangles.iter().zip(flags).zip(&covered).enumerate()
    {
        if is_traced(triangle, flags) == covered.is_empty() {
            return Err(format!("triangle {triangle_id} is missing, or present although it is not traced"));
        }
        if !covered.is_empty() && !covered.contains(&triangle.bounds()) {
            return Err(format!("the leaves of triangle {triangle_id} do not cover it"));
        }
    }
    Ok(())
}

fn check_leaf(tree: &WideTree, leaf: Leaf, triangles: &[Triangle]) -> Result<(), String> {
    let inside = tree.triangles(leaf);
    for lane in 0..leaf.count() {
        let triangle_id = inside.tag(lane).triangle();
        if (0..lane).any(|other| inside.tag(other).triangle() == triangle_id) {
            return Err(format!("{leaf:?} has triangle {triangle_id} twice"));
        }
        if triangles[triangle_id as usize].vertices != inside.corners(lane) {
            return Err(format!("{leaf:?} has other corners for triangle {triangle_id}"));
        }
    }
    Ok(())
}
