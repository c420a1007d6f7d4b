//! The invariants of a finished hierarchy, for tests and for doubts.

use super::lbvh::LEAF;
use super::split_clip::is_traced;
use super::wide::{NO_CHILD, WIDTH, WideTree};
use super::{Bvh, PrimitiveFlags, Structure};
use crate::geometry::{Aabb, Triangle};

impl Bvh {
    /// Walks the hierarchy and describes the first broken invariant: every node and leaf is reached once; boxes contain
    /// those of their children; every triangle that takes part, and no other, is in at least one leaf, with its own
    /// corners, once a leaf, and the boxes of its leaves cover its bounds.
    pub fn validate(&self, triangles: &[Triangle], flags: &[PrimitiveFlags]) -> Result<(), String> {
        match &self.structure {
            Structure::BruteForce(_) => Ok(()),
            Structure::Wide(tree) => validate(tree, triangles, flags),
        }
    }
}

fn validate(tree: &WideTree, triangles: &[Triangle], flags: &[PrimitiveFlags]) -> Result<(), String> {
    let mut node_visits = vec![0_u32; tree.nodes.len()];
    let mut leaf_visits = vec![0_u32; tree.leaves.len()];
    let mut covered = vec![Aabb::EMPTY; triangles.len()];
    let everything = Aabb { min: glam::Vec3::NEG_INFINITY, max: glam::Vec3::INFINITY };
    let mut todo = vec![(tree.root, everything)];
    while let Some((child, bounds)) = todo.pop() {
        if child == NO_CHILD {
            continue;
        }
        if child & LEAF != 0 {
            let leaf = (child & !LEAF) as usize;
            leaf_visits[leaf] += 1;
            check_leaf(tree, leaf, triangles)?;
            for &primitive in &tree.leaves[leaf].primitives[..tree.leaves[leaf].count as usize] {
                let covered = &mut covered[primitive as usize];
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

    if node_visits.iter().chain(&leaf_visits).any(|&visits| visits != 1) {
        return Err("a node or leaf is not reached exactly once".to_owned());
    }
    for (primitive, ((triangle, &flags), covered)) in triangles.iter().zip(flags).zip(&covered).enumerate() {
        if is_traced(triangle, flags) == covered.is_empty() {
            return Err(format!("triangle {primitive} is missing, or there although it takes no part"));
        }
        if !covered.is_empty() && !covered.contains(&triangle.bounds()) {
            return Err(format!("the leaves of triangle {primitive} do not cover it"));
        }
    }
    Ok(())
}

fn check_leaf(tree: &WideTree, leaf: usize, triangles: &[Triangle]) -> Result<(), String> {
    let pack = &tree.leaves[leaf];
    let count = pack.count as usize;
    if count == 0 || count > WIDTH {
        return Err(format!("leaf {leaf} has {count} triangles"));
    }
    for (lane, &primitive) in pack.primitives[..count].iter().enumerate() {
        if pack.primitives[..lane].contains(&primitive) {
            return Err(format!("leaf {leaf} has triangle {primitive} twice"));
        }
        if triangles[primitive as usize].vertices != pack.triangle(lane) {
            return Err(format!("leaf {leaf} has other corners for triangle {primitive}"));
        }
    }
    Ok(())
}
