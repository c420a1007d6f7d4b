//! Binary radix tree over sorted Morton codes, each node found independently of all others.
//!
//! Source: Karras, "Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees", HPG 2012, section 3
//! (ranges and splits, with δ as the length of the common prefix) and section 4 (equal codes are distinguished by their
//! position).

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use crate::cancel::{CancelFlag, Cancelled};

const CHUNK: usize = 1 << 13;

/// Bit that marks child indices of leaves; the other bits are the position of a key in sorted order.
pub(crate) const LEAF: u32 = 1 << 31;
/// Parent of the root.
pub(crate) const NO_PARENT: u32 = u32::MAX;

/// Morton code and the index of its reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MortonKey {
    /// Morton code.
    pub(crate) code: u64,
    /// Index into the references.
    pub(crate) index: u32,
}

/// Internal node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct RadixNode {
    /// Left and right child: an internal node, or a leaf if [`LEAF`] is set.
    pub(crate) children: [u32; 2],
    /// First and last leaf below.
    pub(crate) range: [u32; 2],
}

/// Binary radix tree. Node 0 is the root; n leaves have n − 1 internal nodes.
#[derive(Debug, Default)]
pub(crate) struct RadixTree {
    /// Internal nodes.
    pub(crate) nodes: Vec<RadixNode>,
    /// Parents of the internal nodes, then of the leaves.
    pub(crate) parents: Vec<AtomicU32>,
    /// Number of leaves.
    pub(crate) leaves: usize,
}

impl RadixTree {
    /// Builds the tree of `keys`, which are sorted by code.
    pub(crate) fn build(&mut self, keys: &[MortonKey], cancel: &CancelFlag) -> Result<(), Cancelled> {
        self.leaves = keys.len();
        let internal = keys.len().saturating_sub(1);
        // Every node is written below.
        self.nodes.resize(internal, RadixNode::default());
        self.parents.resize_with(internal + keys.len(), || AtomicU32::new(NO_PARENT));
        if let Some(root) = self.parents.first_mut() {
            *root.get_mut() = NO_PARENT;
        }

        let parents = &self.parents;
        self.nodes.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, nodes)| {
            cancel.check()?;
            for (i, node) in nodes.iter_mut().enumerate() {
                let index = chunk * CHUNK + i;
                *node = node_at(keys, index);
                for child in node.children {
                    parents[parent_slot(internal, child)].store(index as u32, Ordering::Relaxed);
                }
            }
            Ok(())
        })
    }

    /// Parent of a child index.
    pub(crate) fn parent(&self, child: u32) -> u32 {
        self.parents[parent_slot(self.nodes.len(), child)].load(Ordering::Relaxed)
    }
}

fn parent_slot(internal: usize, child: u32) -> usize {
    if child & LEAF == 0 { child as usize } else { internal + (child & !LEAF) as usize }
}

/// δ(i, j): number of leading bits that the keys at `i` and `j` share, codes first and then positions; −1 outside.
fn delta(keys: &[MortonKey], i: usize, j: isize) -> i32 {
    let Some(other) = usize::try_from(j).ok().and_then(|j| keys.get(j)) else {
        return -1;
    };
    let difference = keys[i].code ^ other.code;
    if difference == 0 {
        (64 + (i as u32 ^ j as u32).leading_zeros()) as i32
    } else {
        difference.leading_zeros() as i32
    }
}

/// Internal node whose range starts or ends at key `i` (Karras' figure 4).
fn node_at(keys: &[MortonKey], i: usize) -> RadixNode {
    let at = i as isize;

    // Direction of the range: towards the neighbour that shares more bits.
    let d: isize = if delta(keys, i, at + 1) > delta(keys, i, at - 1) { 1 } else { -1 };

    // Upper bound for its length, then its other end by binary search.
    let delta_min = delta(keys, i, at - d);
    let mut longest = 2;
    while delta(keys, i, at + longest * d) > delta_min {
        longest *= 2;
    }
    let mut length = 0;
    let mut step = longest / 2;
    while step > 0 {
        if delta(keys, i, at + (length + step) * d) > delta_min {
            length += step;
        }
        step /= 2;
    }
    let end = at + length * d;

    // The last key that shares more bits with `i` than the whole range does.
    let delta_node = delta(keys, i, end);
    let mut split = 0;
    let mut step = length;
    loop {
        step = (step + 1) / 2;
        if delta(keys, i, at + (split + step) * d) > delta_node {
            split += step;
        }
        if step <= 1 {
            break;
        }
    }
    let gamma = at + split * d + d.min(0);

    // Children of one key are leaves.
    let (first, last) = (at.min(end), at.max(end));
    let child = |position: isize, is_leaf: bool| position as u32 | if is_leaf { LEAF } else { 0 };
    RadixNode {
        children: [child(gamma, first == gamma), child(gamma + 1, last == gamma + 1)],
        range: [first as u32, last as u32],
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Reference implementation: splits ranges top down where the highest differing bit changes.
    pub(crate) fn serial_tree(keys: &[MortonKey]) -> Vec<RadixNode> {
        let n = keys.len();
        let mut nodes = vec![RadixNode::default(); n.saturating_sub(1)];
        let bit_at = |i: usize, bit: u32| ((u128::from(keys[i].code) << 32 | i as u128) >> bit) & 1;
        // (node, first, last): a left child is named after its last key, a right one after its first.
        let mut todo = if n > 1 { vec![(0, 0, n - 1)] } else { vec![] };
        while let Some((node, first, last)) = todo.pop() {
            let bit = (0..96).rev().find(|&bit| bit_at(first, bit) != bit_at(last, bit)).unwrap();
            let gamma = (first..last).rfind(|&i| bit_at(i, bit) == 0).unwrap();
            let mut children = [gamma as u32 | LEAF, (gamma + 1) as u32 | LEAF];
            if first != gamma {
                children[0] = gamma as u32;
                todo.push((gamma, first, gamma));
            }
            if last != gamma + 1 {
                children[1] = (gamma + 1) as u32;
                todo.push((gamma + 1, gamma + 1, last));
            }
            nodes[node] = RadixNode { children, range: [first as u32, last as u32] };
        }
        nodes
    }

    fn check(codes: &[u64]) {
        let keys: Vec<MortonKey> =
            codes.iter().enumerate().map(|(i, &code)| MortonKey { code, index: i as u32 }).collect();
        let mut tree = RadixTree::default();
        tree.build(&keys, &CancelFlag::new()).unwrap();
        assert!(tree.nodes == serial_tree(&keys));
        for (i, node) in tree.nodes.iter().enumerate() {
            for child in node.children {
                assert_eq!(tree.parent(child), i as u32);
            }
        }
        if keys.len() > 1 {
            assert_eq!(tree.parent(0), NO_PARENT);
        }
    }

    #[test]
    fn equals_the_serial_tree() {
        let mut state = 1_u64;
        for n in [0, 1, 2, 3, 7, 100, 30_000] {
            for mask in [!0 >> 1, 0xff, 1] {
                let mut codes: Vec<u64> = (0..n)
                    .map(|_| {
                        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                        state >> 7 & mask
                    })
                    .collect();
                codes.sort_unstable();
                check(&codes);
            }
        }
    }

    #[test]
    fn equals_the_serial_tree_for_equal_codes_and_chains() {
        check(&vec![0; 20_000]);
        let chain: Vec<u64> = (0..63).map(|i| (1 << i) - 1).collect();
        check(&chain);
    }

    #[test]
    fn reproduces_figure_3_of_the_paper() {
        // Eight 5-bit keys (Karras 2012, figure 3; Lemmon 2016, figure 6). A node splits after the last key that has a 0 in the
        // highest bit in which its keys differ; this key's position names the left child, the next one the right.
        let codes = [0b00001, 0b00010, 0b00100, 0b00101, 0b10011, 0b11000, 0b11001, 0b11110];
        let nodes = [
            ([0, 7], [3, 4]),               // 0xxxx | 1xxxx
            ([0, 1], [LEAF, 1 | LEAF]),     // 00001 | 00010
            ([2, 3], [2 | LEAF, 3 | LEAF]), // 00100 | 00101
            ([0, 3], [1, 2]),               // 000xx | 001xx
            ([4, 7], [4 | LEAF, 5]),        // 10011 | 11xxx
            ([5, 7], [6, 7 | LEAF]),        // 1100x | 11110
            ([5, 6], [5 | LEAF, 6 | LEAF]), // 11000 | 11001
        ];
        check(&codes);
        let keys: Vec<MortonKey> = (0..).zip(codes).map(|(index, code)| MortonKey { code, index }).collect();
        let mut tree = RadixTree::default();
        tree.build(&keys, &CancelFlag::new()).unwrap();
        assert_eq!(tree.nodes, nodes.map(|(range, children)| RadixNode { children, range }));
        // The internal nodes, then the leaves.
        let parents: Vec<u32> =
            (1..7).chain((0..8).map(|leaf| leaf | LEAF)).map(|at| tree.parent(at)).collect();
        assert_eq!(parents, [3, 3, 0, 0, 4, 5, 1, 1, 2, 2, 4, 6, 6, 5]);
    }
}
