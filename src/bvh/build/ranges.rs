//! Ranges of Karras' radix tree, visited bottom-up.
//!
//! The radix tree over sorted keys is the Cartesian tree over the differences of adjacent keys: a range splits where the
//! difference is largest. From left to right, a stack holds the ranges that have no right sibling yet: Vuillemin, "A Unifying
//! Look at Data Structures", CACM 1980. This finds the nodes of Karras 2012 without storing them.

use super::morton::MortonOrder;

/// Stack bound: each entry's difference has a lower highest bit than the one below, of 63 code bits and 28 position bits.
pub(crate) const MAX_STACK: usize = 96;

/// Range of positions that is a node of the radix tree, or a single reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Range {
    /// First position.
    pub(crate) first: usize,
    /// Number of positions.
    pub(crate) count: usize,
}

/// Complete ranges without a right sibling.
#[derive(Debug)]
pub(crate) struct Ranges {
    entries: [Entry; MAX_STACK],
    depth: usize,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Difference between the range's last code and the next one.
    difference: u64,
    /// First position.
    position: usize,
    /// First cluster.
    cluster: usize,
}

impl Range {
    /// Difference between the range's last code and the next one; the largest at the end.
    pub(crate) fn difference(&self, order: &MortonOrder) -> u64 {
        let last = self.first + self.count - 1;
        if last + 1 == order.len() { u64::MAX } else { order.difference(last) }
    }
}

impl Ranges {
    /// No ranges.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { entries: [Entry { difference: 0, position: 0, cluster: 0 }; MAX_STACK], depth: 0 }
    }

    /// Adds a range, whose clusters are those from `cluster` on. Passes the first cluster and the number of references of every node
    /// that ends with it to `complete`, children first.
    #[inline(always)]
    pub(crate) fn add(
        &mut self,
        range: &Range,
        cluster: usize,
        difference: u64,
        mut complete: impl FnMut(usize, usize),
    ) {
        let mut entry = Entry { difference, position: range.first, cluster };
        while self.depth > 0 && self.entries[self.depth - 1].difference < difference {
            self.depth -= 1;
            entry = Entry { difference, ..self.entries[self.depth] };
            complete(entry.cluster, range.first + range.count - entry.position);
        }
        self.entries[self.depth] = entry;
        self.depth += 1;
    }
}

/// Highest nodes of the radix tree with at most `task` references, in order.
pub(crate) fn tasks(order: &MortonOrder, task: usize) -> Vec<Range> {
    let mut found = Vec::new();
    let mut todo = Vec::new();
    if order.len() > 0 {
        todo.push(Range { first: 0, count: order.len() });
    }
    while let Some(range) = todo.pop() {
        if range.count <= task.max(1) {
            found.push(range);
            continue;
        }
        let left = left_count(order, &range);
        todo.push(Range { first: range.first + left, count: range.count - left });
        todo.push(Range { count: left, ..range });
    }
    found
}

/// Number of positions of the left child: the highest differing bit is clear in their keys.
fn left_count(order: &MortonOrder, range: &Range) -> usize {
    let (first, last) = (range.first, range.first + range.count - 1);
    let codes = order.code(first) ^ order.code(last);
    let is_right = |position: usize| match codes {
        0 => position >> (first ^ last).ilog2() & 1 == 1,
        _ => order.code(position) >> codes.ilog2() & 1 == 1,
    };
    let (mut left, mut right) = (first, last);
    while right - left > 1 {
        let middle = left.midpoint(right);
        *(if is_right(middle) { &mut right } else { &mut left }) = middle;
    }
    right - first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build::morton::tests::order_of;
    use crate::bvh::reference::radix_tree::{MortonKey, RadixTree};
    use crate::cancel::CancelFlag;

    fn codes(n: u64, mask: u64) -> Vec<u64> {
        let scrambled = |i: u64| (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 1;
        let mut codes: Vec<u64> = (0..n).map(|i| scrambled(i) & mask).collect();
        codes.sort_unstable();
        codes
    }

    /// First position and count of every inner node of Karras' construction, sorted.
    fn expected(codes: &[u64]) -> Vec<(usize, usize)> {
        let keys: Vec<MortonKey> = (0..).zip(codes).map(|(index, &code)| MortonKey { code, index }).collect();
        let mut tree = RadixTree::default();
        tree.build(&keys, &CancelFlag::new()).unwrap();
        let mut ranges: Vec<_> = tree
            .nodes
            .iter()
            .map(|node| (node.range[0] as usize, (node.range[1] - node.range[0] + 1) as usize))
            .collect();
        ranges.sort_unstable();
        ranges
    }

    #[test]
    fn nodes_are_those_of_karras_from_leaves_or_from_tasks() {
        for n in [1, 2, 3, 100, 10_000] {
            for mask in [!0 >> 1, 0xff, 0xff << 40, 0] {
                let codes = codes(n, mask);
                let order = order_of(&codes);
                for task in [1, 2, 70, 20_000] {
                    let tasks = tasks(&order, task);
                    assert_eq!(tasks.iter().map(|task| task.count).sum::<usize>(), codes.len());
                    let mut found = Vec::new();
                    let mut ranges = Ranges::new();
                    for range in &tasks {
                        let end = range.first + range.count;
                        ranges.add(range, range.first, range.difference(&order), |first, count| {
                            assert_eq!(first + count, end);
                            found.push((first, count));
                        });
                    }
                    found.sort_unstable();
                    let mut above = expected(&codes);
                    above.retain(|&(_, count)| count > task);
                    // The node above may be one whose children are both tasks.
                    assert_eq!(found, above, "{n} {mask:x} {task}");
                }
            }
        }
    }
}
