//! Radix tree over sorted Morton codes (LBVH), built with its boxes in one pass.
//!
//! The radix tree over sorted keys is the Cartesian tree over the differences of adjacent keys: a range splits where the
//! difference is largest. It is built from left to right with a stack of subtrees that have no right sibling yet: Vuillemin,
//! "A Unifying Look at Data Structures", CACM 1980. The tree equals that of Karras 2012, which finds it node by node
//! ([`crate::bvh::reference::karras`]); this pass reads less and needs no atomics.
//!
//! A range of n positions owns the n node indices from its first position on, so parallel tasks write without
//! synchronization. Ranges of at most [`LEAF_SIZE`] references become leaves and get no node. A task therefore needs only some
//! of its indices; it uses the first ones, children before parents.

use super::binary_tree::{BinaryTree, LEAF_RANGE, LEAF_SIZE, Pair, Subtree};
use super::morton::MortonOrder;
use crate::bvh::box_area::scaled_half_area;
use crate::bvh::references::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

/// Smallest number of references per task.
const MIN_TASK: usize = 1 << 12;
/// Number of tasks for large inputs.
const TASKS: usize = 32;
/// Boxes fetched together, so that their cache misses overlap.
const BATCH: usize = 128;
/// Stack bound: each entry's difference has a lower highest bit than the one below, of 63 code bits and 28 position bits.
const MAX_STACK: usize = 96;

/// Inputs of the pass.
#[derive(Clone, Copy)]
struct Pass<'a> {
    order: &'a MortonOrder,
    references: &'a [Reference],
    /// Factor of lengths before areas are computed.
    scale: f32,
    task: usize,
    leaf_size: u32,
    cancel: &'a CancelFlag,
}

/// Output of a range: one node and one triangle index per position.
struct Output<'a> {
    nodes: &'a mut [Pair],
    triangle_ids: &'a mut [u32],
}

/// Subtree of a range, and the sum of its nodes' areas.
type Built = Result<(Subtree, f64), Cancelled>;

/// Fills `tree` with the radix tree over `references` in `order`; areas are of boxes multiplied by `scale`.
pub(crate) fn build(
    tree: &mut BinaryTree,
    order: &MortonOrder,
    references: &[Reference],
    scale: f32,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    let task = (order.len() / TASKS).max(MIN_TASK);
    Pass { order, references, scale, task, leaf_size: LEAF_SIZE, cancel }.fill(tree)
}

impl Pass<'_> {
    /// Fills `tree` with the tree of all references.
    fn fill(&self, tree: &mut BinaryTree) -> Result<(), Cancelled> {
        let count = self.order.len();
        tree.reset(count, count);
        if count == 0 {
            return Ok(());
        }
        let output = Output { nodes: &mut tree.nodes, triangle_ids: &mut tree.triangle_ids };
        let (root, area_sum) = self.build(0, count - 1, output)?;
        (tree.root, tree.area_sum) = (Some(root), area_sum);
        Ok(())
    }

    /// Builds the range from `first` to `last`.
    fn build(&self, first: usize, last: usize, Output { nodes, triangle_ids }: Output) -> Built {
        self.cancel.check()?;
        if last - first < self.task {
            return Ok(self.scan(first, last, Output { nodes, triangle_ids }));
        }
        let split = self.split(first, last);
        let left_count = split + 1 - first;
        let (left_nodes, right_nodes) = nodes.split_at_mut(left_count);
        let (left_ids, right_ids) = triangle_ids.split_at_mut(left_count);
        let left_output = Output { nodes: left_nodes, triangle_ids: left_ids };
        let right_output = Output { nodes: right_nodes, triangle_ids: right_ids };
        let (left, right) = rayon::join(
            || self.build(first, split, left_output),
            || self.build(split + 1, last, right_output),
        );
        let ((left, left_area), (right, right_area)) = (left?, right?);
        // The left part uses at most one node less than it has positions.
        nodes[left_count - 1] = Pair::of(&left, &right);
        let joined = left.joined(&right, split as u32);
        Ok((joined, left_area + right_area + f64::from(scaled_half_area(&joined.bounds, self.scale))))
    }

    /// Last position of the left part: the highest differing bit is clear in the keys up to it.
    fn split(&self, first: usize, last: usize) -> usize {
        let key = |position| (self.order.code(position), position);
        let ((low_code, low_position), (high_code, high_position)) = (key(first), key(last));
        let (codes, positions) = (low_code ^ high_code, low_position ^ high_position);
        let is_right = |position: usize| match codes {
            0 => position >> positions.ilog2() & 1 == 1,
            _ => self.order.code(position) >> codes.ilog2() & 1 == 1,
        };
        let (mut left, mut right) = (first, last);
        while right - left > 1 {
            let middle = left.midpoint(right);
            *(if is_right(middle) { &mut right } else { &mut left }) = middle;
        }
        left
    }

    /// Builds a range from left to right.
    fn scan(&self, first: usize, last: usize, Output { nodes, triangle_ids }: Output) -> (Subtree, f64) {
        let mut area_sum = 0.0;
        let mut stack = [(u64::MAX, Subtree::leaf(Aabb::EMPTY, first)); MAX_STACK];
        let mut depth = 0;
        let mut nodes = (first as u32..).zip(nodes);
        let mut fetched = [(Aabb::EMPTY, u64::MAX); BATCH];
        for batch in (first..=last).step_by(BATCH) {
            let end = (batch + BATCH - 1).min(last);
            let triangle_ids = &mut triangle_ids[batch - first..=end - first];
            // Short loops keep many reads in flight.
            for (position, triangle_id) in (batch..=end).zip(&mut *triangle_ids) {
                *triangle_id = self.references[self.order.index(position) as usize].triangle_id;
            }
            for (position, (bounds, difference)) in (batch..=end).zip(&mut fetched) {
                *bounds = self.references[self.order.index(position) as usize].bounds;
                // After the last one all subtrees are joined.
                *difference = if position == last { u64::MAX } else { self.order.difference(position) };
            }
            for (position, &(bounds, difference)) in (batch..=end).zip(&fetched) {
                let mut current = Subtree::leaf(bounds, position);
                while depth > 0 && stack[depth - 1].0 < difference {
                    depth -= 1;
                    let left = &stack[depth].1;
                    current = self.join(left, &current, position, &mut nodes);
                    area_sum += f64::from(scaled_half_area(&current.bounds, self.scale));
                }
                stack[depth] = (difference, current);
                depth += 1;
            }
        }
        (stack[0].1, area_sum)
    }

    /// Joins two adjacent subtrees, of which the right one ends at `last`. A new node takes the next entry of `nodes`.
    #[inline(always)]
    fn join<'a>(
        &self,
        left: &Subtree,
        right: &Subtree,
        last: usize,
        nodes: &mut impl Iterator<Item = (u32, &'a mut Pair)>,
    ) -> Subtree {
        let count = left.count + right.count;
        let mut child = (last + 1 - count as usize) as u32 | LEAF_RANGE;
        if count > self.leaf_size
            && let Some((index, node)) = nodes.next()
        {
            *node = Pair::of(left, right);
            child = index;
        }
        left.joined(right, child)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build::morton::tests::order_of;
    use crate::bvh::reference::radix_tree::{LEAF, MortonKey, RadixTree};
    use glam::Vec3;

    /// Sorted codes, and boxes unrelated to them.
    fn input(n: u64, mask: u64) -> (Vec<u64>, Vec<Reference>) {
        let scrambled = |i: u64| (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 1;
        let mut codes: Vec<u64> = (0..n).map(|i| scrambled(i) & mask).collect();
        codes.sort_unstable();
        let references = (0..n)
            .map(|i| {
                let x = scrambled(i) as u32;
                let corner = Vec3::new((x % 1000) as f32, (x / 1000 % 1000) as f32, (x % 77) as f32);
                let bounds = Aabb { min: corner, max: corner + Vec3::splat((i % 5) as f32) };
                Reference { bounds, triangle_id: i as u32 }
            })
            .collect();
        (codes, references)
    }

    fn built(codes: &[u64], references: &[Reference], leaf_size: u32) -> BinaryTree {
        let mut tree = BinaryTree::default();
        let order = order_of(codes);
        let cancel = CancelFlag::new();
        let task = (order.len() / TASKS).max(MIN_TASK);
        let pass = Pass { order: &order, references, scale: 1.0, task, leaf_size, cancel: &cancel };
        pass.fill(&mut tree).unwrap();
        tree
    }

    fn union_of(references: &[Reference]) -> Aabb {
        references.iter().fold(Aabb::EMPTY, |all, reference| all.union(reference.bounds))
    }

    #[test]
    fn equals_karras_radix_tree() {
        for n in [0, 1, 2, 3, 100, 30_000] {
            for mask in [!0 >> 1, 0xff, 0xff << 40, 0] {
                let (codes, references) = input(n, mask);
                let tree = built(&codes, &references, 1);
                let keys: Vec<MortonKey> =
                    (0..).zip(&codes).map(|(index, &code)| MortonKey { code, index }).collect();
                let mut expected = RadixTree::default();
                expected.build(&keys, &CancelFlag::new()).unwrap();

                // Traverse both from the root.
                let mut todo = if n > 1 { vec![(tree.root.unwrap().child, 0)] } else { Vec::new() };
                let mut seen = 0;
                while let Some((child, expected_child)) = todo.pop() {
                    assert_eq!(child & LEAF_RANGE != 0, expected_child & LEAF != 0);
                    if child & LEAF_RANGE != 0 {
                        assert_eq!(child & !LEAF_RANGE, expected_child & !LEAF);
                        continue;
                    }
                    seen += 1;
                    let (pair, node) =
                        (&tree.nodes[child as usize], &expected.nodes[expected_child as usize]);
                    let [first, last] = node.range.map(|position| position as usize);
                    let middle = first + pair.counts[0] as usize;
                    assert_eq!(pair.bounds[0], union_of(&references[first..middle]));
                    assert_eq!(pair.bounds[1], union_of(&references[middle..=last]));
                    todo.extend((0..2).map(|side| (pair.children[side], node.children[side])));
                }
                assert_eq!(seen, expected.nodes.len());
                let root = tree.root.map(|root| (root.bounds, root.count));
                assert_eq!(root, (n > 0).then(|| (union_of(&references), n as u32)));
            }
        }
    }

    #[test]
    fn small_ranges_are_leaves() {
        let (codes, references) = input(5000, !0 >> 1);
        let short = built(&codes, &references, LEAF_SIZE);
        assert_eq!(built(&codes, &references, 1).area_sum, short.area_sum);
        // In order, leaves follow each other without gaps.
        let mut todo = vec![(short.root.unwrap().child, 5000)];
        let mut next_position = 0;
        while let Some((child, count)) = todo.pop() {
            assert_eq!(child & LEAF_RANGE != 0, count <= LEAF_SIZE);
            if child & LEAF_RANGE != 0 {
                assert_eq!(child & !LEAF_RANGE, next_position);
                next_position += count;
                continue;
            }
            let pair = &short.nodes[child as usize];
            todo.extend([1, 0].map(|side| (pair.children[side], pair.counts[side])));
        }
        assert_eq!(next_position, 5000);
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let (codes, references) = input(50_000, !0 >> 1);
        let results = [1, 2, 3, 8].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let tree = pool.install(|| built(&codes, &references, LEAF_SIZE));
            (tree.nodes, tree.triangle_ids, tree.root, tree.area_sum.to_bits())
        });
        assert!(results.iter().all(|result| *result == results[0]));
    }

    #[test]
    fn cost_and_depth_of_two_unit_cubes() {
        // Two leaves of area 6 under a root of 2 x 1 x 1, area 10: (10 + 6 + 6) / 10.
        let cube = |x: f32| Reference {
            bounds: Aabb { min: Vec3::X * x, max: Vec3::X * x + Vec3::ONE },
            triangle_id: x as u32,
        };
        let references = [cube(0.0), cube(1.0)];
        let measures = crate::bvh::references::measure(&references);
        let order = order_of(&[0, 1]);
        let mut tree = BinaryTree::default();
        build(&mut tree, &order, &references, measures.scale(), &CancelFlag::new()).unwrap();
        assert_eq!(tree.depth(), 1);
        assert!((tree.sah_cost(&measures) - 2.2).abs() < 1.0e-6);
    }
}
