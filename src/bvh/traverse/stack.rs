//! Traversal stack of a single ray, nearest entry on top.
//!
//! An array of fixed capacity covers ordinary trees. Deeper trees continue on the heap, so that no node is ever lost. The
//! array is not initialised, which would cost as much as two nodes of each ray.

use arrayvec::ArrayVec;

use super::lane_ray::Entered;
use crate::bvh::wide_tree::{WIDTH, WideNode};

/// Capacity of the array.
const SHALLOW: usize = 64;

/// Entry distance in the upper bits, child word in the lower. The bits of a distance sort like the number because it is not
/// negative.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pending(u64);

/// Stack of pending children.
pub(super) struct Stack {
    shallow: ArrayVec<Pending, SHALLOW>,
    deep: Vec<Pending>,
}

impl Pending {
    #[inline(always)]
    pub(super) fn new(distance: f32, child: u32) -> Self {
        Self(u64::from(distance.to_bits()) << 32 | u64::from(child))
    }

    #[inline(always)]
    pub(super) fn distance(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    pub(super) fn child(self) -> u32 {
        self.0 as u32
    }
}

impl Stack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { shallow: ArrayVec::new_const(), deep: Vec::new() }
    }

    /// Pushes the entered children, farthest first if `is_ordered`, and returns the nearest instead of pushing it.
    #[inline(always)]
    pub(super) fn push_all(
        &mut self,
        is_ordered: bool,
        node: &WideNode,
        entered: &Entered,
    ) -> Option<Pending> {
        let mut mask = entered.mask;
        let mut next = || {
            if mask == 0 {
                return None;
            }
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            Some(Pending::new(entered.distances[lane], node.children[lane]))
        };

        // One or two children are the common case.
        let mut nearest = next()?;
        let Some(second) = next() else {
            return Some(nearest);
        };
        let mut far = second;
        if is_ordered && far < nearest {
            std::mem::swap(&mut far, &mut nearest);
        }
        let bottom = self.push(far);
        while let Some(mut pending) = next() {
            if is_ordered && pending < nearest {
                std::mem::swap(&mut pending, &mut nearest);
            }
            self.insert(is_ordered, bottom, pending);
        }
        Some(nearest)
    }

    /// Pushes an entry and returns its position.
    #[inline(always)]
    fn push(&mut self, pending: Pending) -> usize {
        if let Err(full) = self.shallow.try_push(pending) {
            self.deep.push(full.element());
        }
        self.shallow.len() - 1
    }

    /// Inserts an entry among those from `bottom` up, farthest first if `is_ordered`.
    #[inline(always)]
    fn insert(&mut self, is_ordered: bool, bottom: usize, pending: Pending) {
        let mut position = self.push(pending);
        if !is_ordered || !self.deep.is_empty() {
            return;
        }
        let entries = self.shallow.as_mut_slice();
        while position > bottom && entries[position - 1] < pending {
            entries[position] = entries[position - 1];
            position -= 1;
            entries[position] = pending;
        }
    }

    /// Pops entries up to the first that is not beyond `upper`, and returns that one.
    #[inline(always)]
    pub(super) fn pop_within(&mut self, upper: f32) -> Option<Pending> {
        loop {
            let pending = self.pop()?;
            if pending.distance() <= upper {
                return Some(pending);
            }
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Pending> {
        if self.shallow.is_full()
            && let Some(pending) = self.deep.pop()
        {
            return Some(pending);
        }
        self.shallow.pop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stack_grows_and_keeps_its_order() {
        let mut stack = Stack::new();
        for i in 0..200 {
            stack.push(Pending(i));
        }
        for i in (0..200).rev() {
            assert!(stack.pop() == Some(Pending(i)));
        }
        assert!(stack.pop().is_none());
    }

    /// Pushes the eight children of nodes, whose words are `first` and following ones; the nearest is pushed last.
    fn push_node(stack: &mut Stack, is_ordered: bool, first: u32) {
        let node = WideNode { children: std::array::from_fn(|lane| first + lane as u32), ..WideNode::EMPTY };
        let distances = std::array::from_fn(|lane| ((lane * 5 + 3) % WIDTH) as f32);
        let entered = Entered { mask: (1 << WIDTH) - 1, distances };
        let nearest = stack.push_all(is_ordered, &node, &entered).unwrap();
        assert!(!is_ordered || nearest.distance() == 0.0);
        stack.push(nearest);
    }

    #[test]
    fn children_of_a_node_are_popped_nearest_first() {
        let mut stack = Stack::new();
        push_node(&mut stack, true, 16);
        for distance in 0..WIDTH {
            let pending = stack.pop().unwrap();
            // 5 is its own inverse modulo 8.
            assert_eq!(pending.child() as usize, 16 + (distance * 5 + 1) % WIDTH);
            assert_eq!(pending.distance(), distance as f32);
        }
        assert!(stack.pop().is_none());
    }

    #[test]
    fn no_child_beyond_the_fixed_array_is_lost() {
        for is_ordered in [false, true] {
            let mut stack = Stack::new();
            // The array ends among the children of a node.
            stack.push(Pending::new(0.0, 0));
            for node in 0..20 {
                push_node(&mut stack, is_ordered, 1 + node * WIDTH as u32);
            }
            let count = 1 + 20 * WIDTH;
            assert_eq!((stack.shallow.len(), stack.deep.len()), (SHALLOW, count - SHALLOW));
            for node in (0..20).rev() {
                let first = 1 + node * WIDTH as u32;
                let mut children: Vec<u32> = (0..WIDTH).map(|_| stack.pop().unwrap().child()).collect();
                children.sort_unstable();
                assert!(children.into_iter().eq(first..first + WIDTH as u32));
            }
            assert_eq!(stack.pop().map(Pending::child), Some(0));
            assert!(stack.pop().is_none());
        }
    }
}
