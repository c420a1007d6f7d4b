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
        let mut far = second;
        if V::ORDERED && far < nearest {
            std::mem::swap(&mut far, &mut nearest);
        }
        let bottom = self.push(far);
        while let Some(mut pending) = next() {
            if V::ORDERED && pending < nearest {
                std::mem::swap(&mut pending, &mut nearest);
            }
            self.insert::<V>(bottom, pending);
        }
        Some(nearest)
    }

    /// Puts an entry on the stack and returns its place.
    #[inline(always)]
    fn push(&mut self, pending: Pending) -> usize {
        if self.len < SHALLOW {
            self.shallow[self.len] = pending;
            self.len += 1;
        } else {
            self.deep.push(pending);
        }
        self.len - 1
    }

    /// Puts an entry among those from `bottom` up, farthest first if the order matters.
    #[inline(always)]
    fn insert<V: Visitor>(&mut self, bottom: usize, pending: Pending) {
        let mut place = self.push(pending);
        while V::ORDERED && place > bottom && self.deep.is_empty() && self.shallow[place - 1] < pending {
            self.shallow[place] = self.shallow[place - 1];
            place -= 1;
            self.shallow[place] = pending;
        }
    }

    /// The last entry that is not beyond `upper`; those after it are dropped.
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
