//! What a walk has still to visit, nearest last.
//!
//! The stack is an array that covers ordinary trees, and grows on the heap beyond it: no node is ever lost.

use super::single::Entered;
use crate::bvh::query::Visitor;
use crate::bvh::wide::{WIDTH, WideNode};

/// Entries that need no heap.
const SHALLOW: usize = 64;

/// A child word below its entry distance, whose bits order like the number because it is not negative.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pending(u64);

/// The stack.
pub(super) struct Stack {
    shallow: [Pending; SHALLOW],
    len: usize,
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
        Self { shallow: [Pending(0); SHALLOW], len: 0, deep: Vec::new() }
    }

    /// Puts the entered children on the stack, far ones first if the order matters, and returns the nearest.
    #[inline(always)]
    pub(super) fn push_all<V: Visitor>(&mut self, node: &WideNode, entered: &Entered) -> Option<Pending> {
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
        let mut rest = [second; WIDTH];
        let mut count = 0;
        let mut candidate = Some(second);
        while let Some(pending) = candidate {
            // Keep the others sorted, farthest first.
            let mut far = pending;
            if V::ORDERED && far < nearest {
                std::mem::swap(&mut far, &mut nearest);
            }
            let mut place = count;
            while V::ORDERED && place > 0 && rest[place - 1] < far {
                rest[place] = rest[place - 1];
                place -= 1;
            }
            rest[place] = far;
            count += 1;
            candidate = next();
        }
        for &pending in &rest[..count] {
            self.push(pending);
        }
        Some(nearest)
    }

    #[inline(always)]
    pub(super) fn push(&mut self, pending: Pending) {
        if self.len < SHALLOW {
            self.shallow[self.len] = pending;
            self.len += 1;
        } else {
            self.deep.push(pending);
        }
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<Pending> {
        if self.len == SHALLOW
            && let Some(pending) = self.deep.pop()
        {
            return Some(pending);
        }
        self.len = self.len.checked_sub(1)?;
        Some(self.shallow[self.len])
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
}
