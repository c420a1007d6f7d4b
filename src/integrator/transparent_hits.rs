//! See-through surfaces along rays, all collected by one query instead of one query for each.
//!
//! A query for anything solid asks its filter about every see-through surface on the way, in no order and once for
//! each leaf that holds it. Where it finds nothing solid, what the filter saw is all there is.

use std::cell::{Cell, RefCell};
use std::cmp::Ordering;

use crate::bvh::{Hit, HitOrder};

/// Most hits that are kept; beyond, they are fewer than were met.
const LIMIT: usize = 1 << 16;

/// Hits of several rays.
#[derive(Debug, Default)]
pub(super) struct TransparentHits {
    /// By subscript of the ray, and along each ray once they are sorted.
    hits: RefCell<Vec<(u32, Hit)>>,
    is_overfull: Cell<bool>,
}

impl TransparentHits {
    /// Forgets all hits, not the memory.
    pub(super) fn clear(&mut self) {
        self.hits.get_mut().clear();
        self.is_overfull.set(false);
    }

    /// Whether some hits found no room.
    pub(super) fn is_overfull(&self) -> bool {
        self.is_overfull.get()
    }

    /// Keeps a hit of ray `ray`; called from filters.
    pub(super) fn add(&self, ray: usize, hit: &Hit) {
        let mut hits = self.hits.borrow_mut();
        if hits.len() < LIMIT { hits.push((ray as u32, *hit)) } else { self.is_overfull.set(true) }
    }

    /// Sorts the hits of the rays that `counts` accepts and forgets the others.
    pub(super) fn sort(&mut self, counts: impl Fn(usize) -> bool) {
        let hits = self.hits.get_mut();
        hits.retain(|(ray, _)| counts(*ray as usize));
        hits.sort_unstable_by(|(ray_a, a), (ray_b, b)| {
            ray_a.cmp(ray_b).then(a.order().partial_cmp(&b.order()).unwrap_or(Ordering::Equal))
        });
    }

    /// Steps along one ray of the sorted hits: each call gives the first hit after the one that it is told.
    pub(super) fn along(&self, ray: u32) -> impl FnMut(Option<HitOrder>) -> Option<Hit> + '_ {
        let mut next = self.hits.borrow().partition_point(|(other, _)| *other < ray);
        move |after| {
            let hits = self.hits.borrow();
            while let Some((other, hit)) = hits.get(next)
                && *other == ray
            {
                next += 1;
                // A triangle in several leaves is met several times.
                if after.is_none_or(|after| hit.order() > after) {
                    return Some(*hit);
                }
            }
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Facing;

    fn hit(t: f32, triangle: u32) -> Hit {
        Hit { t, triangle, u: 0.25, v: 0.25, facing: Facing::Front }
    }

    #[test]
    fn each_ray_steps_over_its_own_hits_once_in_order() {
        let mut transparent_hits = TransparentHits::default();
        // Ray 2: triangles 9 and 4 coincide, 4 is in two leaves; ray 1 does not count.
        let met = [
            (2, hit(3.0, 7)),
            (0, hit(1.0, 1)),
            (2, hit(2.0, 9)),
            (1, hit(0.5, 3)),
            (2, hit(2.0, 4)),
            (2, hit(2.0, 4)),
        ];
        for (ray, hit) in met {
            transparent_hits.add(ray, &hit);
        }
        transparent_hits.sort(|ray| ray != 1);
        let steps = |ray| {
            let mut next = transparent_hits.along(ray);
            let mut after = None;
            let mut primitives = Vec::new();
            while let Some(hit) = next(after) {
                after = Some(hit.order());
                primitives.push(hit.triangle);
            }
            primitives
        };
        assert_eq!(steps(0), [1]);
        assert!(steps(1).is_empty() && steps(3).is_empty());
        assert_eq!(steps(2), [4, 9, 7]);
    }

    #[test]
    fn too_many_hits_are_told() {
        let mut transparent_hits = TransparentHits::default();
        for i in 0..LIMIT {
            transparent_hits.add(i, &hit(1.0, 0));
        }
        assert!(!transparent_hits.is_overfull());
        transparent_hits.add(0, &hit(2.0, 0));
        assert!(transparent_hits.is_overfull());
        transparent_hits.clear();
        assert!(!transparent_hits.is_overfull());
    }
}
