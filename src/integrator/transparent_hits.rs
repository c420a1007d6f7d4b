//! Transparent surfaces along rays, collected by one occlusion query instead of one query for each surface.
//!
//! An occlusion query asks its filter about every transparent surface along the ray, in no order and once for each leaf that
//! holds it. Where the query finds no opaque surface, the filter has seen all surfaces.

use std::cell::{Cell, RefCell};
use std::cmp::Ordering;

use crate::bvh::{Hit, HitOrder};

/// Transparent surfaces that one ray passes at most.
pub const TRANSPARENCY_LIMIT: u32 = 256;

/// Hits that are kept at most.
const MAX_HITS: usize = 1 << 16;

/// Transparent hits of several rays.
#[derive(Debug)]
pub(super) struct TransparentHits {
    /// [`MAX_HITS`]; further ones are dropped.
    pub(super) most_hits: usize,
    /// With the index of the ray, in the order in which they were added.
    hits: RefCell<Vec<(u32, Hit)>>,
    /// By ray, in order along each ray.
    sorted: Vec<Hit>,
    /// For each ray the index after its last hit.
    ends: Vec<u32>,
    dropped: Cell<usize>,
}

impl Default for TransparentHits {
    fn default() -> Self {
        Self {
            most_hits: MAX_HITS,
            hits: RefCell::default(),
            sorted: Vec::new(),
            ends: Vec::new(),
            dropped: Cell::new(0),
        }
    }
}

impl TransparentHits {
    /// Removes all hits and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.hits.get_mut().clear();
        self.dropped.set(0);
    }

    /// Whether hits were dropped.
    pub(super) fn is_overfull(&self) -> bool {
        self.dropped.get() > 0
    }

    /// Into how many parts the rays have to be divided at least so that no hits of theirs are dropped, unless they have unequal numbers of them.
    pub(super) fn least_parts(&self) -> usize {
        1 + self.dropped.get().div_ceil(self.most_hits)
    }

    /// Adds a hit of ray `ray`; called from filters.
    pub(super) fn add(&self, ray: usize, hit: &Hit) {
        let mut hits = self.hits.borrow_mut();
        if hits.len() < self.most_hits {
            hits.push((ray as u32, *hit));
        } else {
            self.dropped.set(self.dropped.get() + 1);
        }
    }

    /// Sorts the hits of those of `rays` rays that `keeps` accepts, and removes the others.
    pub(super) fn sort(&mut self, rays: usize, keeps: impl Fn(usize) -> bool) {
        let Self { hits, sorted, ends, .. } = self;
        let hits = hits.get_mut();
        hits.retain(|(ray, _)| keeps(*ray as usize));

        // The index of the first hit of each ray, which becomes the end as hits are copied
        ends.clear();
        ends.resize(rays, 0);
        for (ray, _) in hits.iter() {
            ends[*ray as usize] += 1;
        }
        let mut first = 0;
        for end in ends.iter_mut() {
            first += std::mem::replace(end, first);
        }
        sorted.clear();
        sorted.extend(hits.iter().map(|(_, hit)| *hit));
        for (ray, hit) in hits.iter() {
            let end = &mut ends[*ray as usize];
            sorted[*end as usize] = *hit;
            *end += 1;
        }

        // Along each ray
        let mut first = 0;
        for end in ends.iter() {
            let along = &mut sorted[first..*end as usize];
            along.sort_unstable_by(|a, b| a.order().partial_cmp(&b.order()).unwrap_or(Ordering::Equal));
            first = *end as usize;
        }
    }

    /// Steps along one ray of the sorted hits: each call returns the first hit after the given one.
    pub(super) fn along(&self, ray: u32) -> impl FnMut(Option<HitOrder>) -> Option<Hit> + '_ {
        let ray = ray as usize;
        let first = ray.checked_sub(1).map_or(0, |before| self.ends[before]);
        let mut hits = self.sorted[first as usize..self.ends[ray] as usize].iter();
        // A triangle in several leaves is listed several times.
        move |after| hits.find(|hit| after.is_none_or(|after| hit.order() > after)).copied()
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
        let mut hits = TransparentHits::default();
        // Ray 2: triangles 9 and 4 coincide, 4 is in two leaves. Ray 1 is not kept.
        let all = [
            (2, hit(3.0, 7)),
            (0, hit(1.0, 1)),
            (2, hit(2.0, 9)),
            (1, hit(0.5, 3)),
            (2, hit(2.0, 4)),
            (2, hit(2.0, 4)),
        ];
        for (ray, hit) in all {
            hits.add(ray, &hit);
        }
        hits.sort(4, |ray| ray != 1);
        let steps = |ray| {
            let mut next = hits.along(ray);
            let mut after = None;
            let mut triangles = Vec::new();
            while let Some(hit) = next(after) {
                after = Some(hit.order());
                triangles.push(hit.triangle);
            }
            triangles
        };
        assert_eq!(steps(0), [1]);
        assert!(steps(1).is_empty() && steps(3).is_empty());
        assert_eq!(steps(2), [4, 9, 7]);
    }

    #[test]
    fn dropped_hits_are_reported() {
        let mut hits = TransparentHits::default();
        for i in 0..MAX_HITS {
            hits.add(i, &hit(1.0, 0));
        }
        assert!(!hits.is_overfull());
        for (added, parts) in [(1, 2), (MAX_HITS - 1, 2), (1, 3)] {
            for _ in 0..added {
                hits.add(0, &hit(2.0, 0));
            }
            assert!(hits.is_overfull());
            assert_eq!(hits.least_parts(), parts);
        }
        hits.clear();
        assert!(!hits.is_overfull());
        assert_eq!(hits.least_parts(), 1);
    }
}
