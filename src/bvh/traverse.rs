//! Walking the wide tree with one ray.
//!
//! Source: ordered traversal with an explicit stack, nearest child first, as in Wald, Benthin, Boulos, "Getting Rid of
//! Packets", RT 2008. A node is passed over only if its entry distance, already shortened by the slack of
//! [`super::lanes`], is beyond the best hit, never if it is equal, since a lower id may wait there.
//!
//! The stack is an array that covers ordinary trees, and grows on the heap beyond it: no node is ever lost.

use super::lanes::{LaneRay, LaneTask, Lanes};
use super::query::Visitor;
use super::wide::{Leaf, NO_CHILD, WIDTH, WideNode, WideTree};
use super::{Hit, TraversalCounters};
use crate::geometry::{Ray, ShearedRay};

/// Entries that need no heap.
const SHALLOW: usize = 64;

/// A child index below its entry distance, whose bits order like the number because it is not negative.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Pending(u64);

struct Stack {
    shallow: [Pending; SHALLOW],
    len: usize,
    deep: Vec<Pending>,
}

/// One query of a tree.
pub(super) struct Walk<'a, V> {
    /// The tree.
    pub(super) tree: &'a WideTree,
    /// The ray.
    pub(super) ray: &'a Ray,
    /// Receives the hits.
    pub(super) visitor: &'a mut V,
}

impl<V: Visitor> LaneTask for Walk<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, counters: &mut TraversalCounters) {
        let Walk { tree, ray, visitor } = self;
        if tree.root == NO_CHILD {
            return;
        }
        let lane_ray = LaneRay::new(ray, visitor.lower());
        let sheared_ray = ShearedRay::new(ray);
        let mut stack = Stack::new();
        let mut current = Pending::new(0.0, tree.root);
        loop {
            let child = current.child();
            if let Some(leaf) = Leaf::of(child) {
                let pack = tree.triangles(leaf);
                counters.triangles += pack.count() as u64;
                let mut mask = L::candidates(&pack, &lane_ray);
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let Some(hit) = sheared_ray.meet(&pack.corners(lane)) else {
                        continue;
                    };
                    let tag = pack.tag(lane);
                    let hit = Hit::of(hit, tag.primitive());
                    if visitor.offer(&hit, tag.flags()) {
                        return;
                    }
                }
            } else {
                let node = &tree.nodes[child as usize];
                counters.nodes += 1;
                let entered = L::enter(node, &lane_ray, visitor.upper() * lane_ray.scale);
                if let Some(next) = nearest_first::<V>(node, entered.mask, &entered.distances, &mut stack) {
                    current = next;
                    continue;
                }
            }

            // The next one that the best hit does not hide.
            let upper = visitor.upper() * lane_ray.scale;
            loop {
                let Some(pending) = stack.pop() else { return };
                if pending.distance() <= upper {
                    current = pending;
                    break;
                }
            }
        }
    }
}

/// Puts the entered children on the stack, far ones first, and returns the nearest.
#[inline(always)]
fn nearest_first<V: Visitor>(
    node: &WideNode,
    mut mask: u32,
    distances: &[f32; WIDTH],
    stack: &mut Stack,
) -> Option<Pending> {
    let mut next = || {
        if mask == 0 {
            return None;
        }
        let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
        mask &= mask - 1;
        Some(Pending::new(distances[lane], node.children[lane]))
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
        stack.push(pending);
    }
    Some(nearest)
}

impl Pending {
    #[inline(always)]
    fn new(distance: f32, child: u32) -> Self {
        Self(u64::from(distance.to_bits()) << 32 | u64::from(child))
    }

    #[inline(always)]
    fn distance(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn child(self) -> u32 {
        self.0 as u32
    }
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        Self { shallow: [Pending(0); SHALLOW], len: 0, deep: Vec::new() }
    }

    #[inline(always)]
    fn push(&mut self, pending: Pending) {
        if self.len < SHALLOW {
            self.shallow[self.len] = pending;
            self.len += 1;
        } else {
            self.deep.push(pending);
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
