//! Boxes of the radix tree's nodes, computed bottom-up in parallel.
//!
//! Source: Karras 2012, section 4. A thread per leaf walks towards the root. The first thread to reach a node ends; the second
//! finds both children done and continues. One atomic counter per node distinguishes them.
//!
//! The numbers are stored as bits of atomics, so that no `unsafe` is needed. The counter's acquire and release make both
//! children visible to the thread that continues. Relaxed loads and stores compile to plain ones.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use super::radix_tree::{LEAF, MortonKey, NO_PARENT, RadixTree};
use crate::bvh::references::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

const CHUNK: usize = 1 << 12;

/// Box, height and area sum of an internal node whose children are done.
#[derive(Debug, Default)]
struct FittedNode {
    corners: [AtomicU32; 6],
    visits: AtomicU32,
    /// Levels below; zero for a leaf.
    height: AtomicU32,
    /// Sum of the surface areas of this node and of all internal nodes below, as `f64` bits.
    area_sum: AtomicU64,
}

/// Boxes of the internal nodes of a tree.
#[derive(Debug, Default)]
pub(crate) struct BottomUpBoxes {
    nodes: Vec<FittedNode>,
}

/// Box, height and sum of areas of a finished subtree.
#[derive(Clone, Copy)]
struct Subtree {
    bounds: Aabb,
    height: u32,
    area_sum: f64,
}

impl BottomUpBoxes {
    /// Computes the box of every internal node of `tree`, whose leaves are `keys` in order.
    pub(crate) fn fit(
        &mut self,
        tree: &RadixTree,
        keys: &[MortonKey],
        references: &[Reference],
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        self.nodes.truncate(tree.nodes.len());
        self.nodes.par_iter_mut().for_each(|node| *node.visits.get_mut() = 0);
        self.nodes.resize_with(tree.nodes.len(), FittedNode::default);

        let leaf = |position: u32| Subtree::leaf(references[keys[position as usize].index as usize].bounds);
        (0..keys.len().div_ceil(CHUNK)).into_par_iter().try_for_each(|chunk| {
            cancel.check()?;
            for position in chunk * CHUNK..keys.len().min((chunk + 1) * CHUNK) {
                self.walk_up(tree, position as u32, &leaf);
            }
            Ok(())
        })
    }

    /// Bounds of an internal node.
    pub(crate) fn bounds(&self, node: u32) -> Aabb {
        self.nodes[node as usize].load().bounds
    }

    /// Levels below the root; zero for a single leaf.
    pub(crate) fn depth(&self) -> u32 {
        self.nodes.first().map_or(0, |root| root.load().height)
    }

    /// Sum of the surface areas of all internal nodes.
    pub(crate) fn inner_area_sum(&self) -> f64 {
        self.nodes.first().map_or(0.0, |root| root.load().area_sum)
    }

    /// Propagates a leaf's box upward, up to the first node whose other child is not done.
    fn walk_up(&self, tree: &RadixTree, position: u32, leaf: &impl Fn(u32) -> Subtree) {
        let mut child = position | LEAF;
        let mut below = leaf(position);
        loop {
            let parent = tree.parent(child);
            if parent == NO_PARENT {
                return;
            }
            let node = &self.nodes[parent as usize];
            if node.visits.fetch_add(1, Ordering::AcqRel) == 0 {
                return;
            }
            let [left, right] = tree.nodes[parent as usize].children;
            let sibling = if child == left { right } else { left };
            let other =
                if sibling & LEAF == 0 { self.nodes[sibling as usize].load() } else { leaf(sibling & !LEAF) };
            below = below.joined(&other);
            node.store(&below);
            child = parent;
        }
    }
}

impl Subtree {
    fn leaf(bounds: Aabb) -> Self {
        Self { bounds, height: 0, area_sum: 0.0 }
    }

    /// Subtree of both under one node. The result does not depend on their order, to the last bit.
    fn joined(&self, other: &Self) -> Self {
        let bounds = self.bounds.union(other.bounds);
        Self {
            bounds,
            height: 1 + self.height.max(other.height),
            area_sum: bounds.area() + (self.area_sum + other.area_sum),
        }
    }
}

impl FittedNode {
    fn store(&self, subtree: &Subtree) {
        let Subtree { bounds, height, area_sum } = subtree;
        let corners = bounds.min.to_array().into_iter().chain(bounds.max.to_array());
        for (slot, corner) in self.corners.iter().zip(corners) {
            slot.store(corner.to_bits(), Ordering::Relaxed);
        }
        self.height.store(*height, Ordering::Relaxed);
        self.area_sum.store(area_sum.to_bits(), Ordering::Relaxed);
    }

    fn load(&self) -> Subtree {
        let corner = |i: usize| f32::from_bits(self.corners[i].load(Ordering::Relaxed));
        Subtree {
            bounds: Aabb {
                min: Vec3::new(corner(0), corner(1), corner(2)),
                max: Vec3::new(corner(3), corner(4), corner(5)),
            },
            height: self.height.load(Ordering::Relaxed),
            area_sum: f64::from_bits(self.area_sum.load(Ordering::Relaxed)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tree over boxes at scrambled positions, with its inputs.
    fn fitted(
        n: u32,
        pool: &rayon::ThreadPool,
    ) -> (RadixTree, BottomUpBoxes, Vec<MortonKey>, Vec<Reference>) {
        let references: Vec<Reference> = (0..n)
            .map(|i| {
                let x = i.wrapping_mul(2654435761);
                let corner = Vec3::new((x % 1000) as f32, (x / 1000 % 1000) as f32, (x % 77) as f32);
                Reference {
                    bounds: Aabb { min: corner, max: corner + Vec3::splat((i % 5) as f32) },
                    triangle_id: i,
                }
            })
            .collect();
        let mut keys: Vec<MortonKey> = (0..n)
            .map(|i| MortonKey { code: u64::from(i.wrapping_mul(2654435761) >> 3), index: i })
            .collect();
        let (mut tree, mut boxes) = (RadixTree::default(), BottomUpBoxes::default());
        let cancel = CancelFlag::new();
        pool.install(|| {
            keys.sort_by_key(|key| key.code);
            tree.build(&keys, &cancel).unwrap();
            boxes.fit(&tree, &keys, &references, &cancel).unwrap();
        });
        (tree, boxes, keys, references)
    }

    #[test]
    fn boxes_equal_the_union_of_their_range() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        for n in [0, 1, 2, 3, 1000] {
            let (tree, boxes, keys, references) = fitted(n, &pool);
            for (i, node) in tree.nodes.iter().enumerate() {
                let [first, last] = node.range.map(|position| position as usize);
                let expected = keys[first..=last]
                    .iter()
                    .fold(Aabb::EMPTY, |all, key| all.union(references[key.index as usize].bounds));
                assert_eq!(boxes.bounds(i as u32), expected);
            }
        }
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let pools = [1, 2, 3, 8].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
        let results: Vec<_> = pools
            .iter()
            .map(|pool| {
                let (tree, boxes, ..) = fitted(50_000, pool);
                (tree.nodes, boxes.depth(), boxes.inner_area_sum().to_bits())
            })
            .collect();
        assert!(results.iter().all(|result| *result == results[0]));
    }

    #[test]
    fn area_and_depth_of_two_unit_cubes() {
        // The root is 2 x 1 x 1.
        let cube = |x: f32| Reference {
            bounds: Aabb { min: Vec3::X * x, max: Vec3::X * x + Vec3::ONE },
            triangle_id: x as u32,
        };
        let references = [cube(0.0), cube(1.0)];
        let keys = [MortonKey { code: 0, index: 0 }, MortonKey { code: 1, index: 1 }];
        let (mut tree, mut boxes) = (RadixTree::default(), BottomUpBoxes::default());
        tree.build(&keys, &CancelFlag::new()).unwrap();
        boxes.fit(&tree, &keys, &references, &CancelFlag::new()).unwrap();
        assert_eq!(boxes.depth(), 1);
        assert_eq!(boxes.inner_area_sum(), 10.0);
    }
}
