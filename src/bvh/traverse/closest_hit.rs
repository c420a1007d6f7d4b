//! Closest-hit query of a single ray.

use super::visitor::{Candidate, Filter, LeafIntersector, TriangleSlot, Visitor, positive_lower};
use crate::bvh::hit::{Hit, HitOrder};
use crate::bvh::triangle_flags::TriangleFlags;
use crate::geometry::{Facing, Ray};

/// Finds the first hit in [`HitOrder`]. With `CULL`, back faces of single-sided triangles do not count.
pub(crate) struct ClosestHit<'a, const CULL: bool> {
    after: Option<HitOrder>,
    filter: Filter<'a>,
    lower: f32,
    /// Lower bound of the closest hit so far; the end of the ray while there is none.
    near: f32,
    /// Upper bound of the closest hit so far; the end of the ray while there is none.
    far: f32,
    best: Best,
}

/// Closest hit so far.
#[derive(Clone, Copy)]
enum Best {
    None,
    /// A certain hit with the triangle in this slot, known by its bounds only.
    Bounded(TriangleSlot),
    Exact(Hit),
}

impl<'a, const CULL: bool> ClosestHit<'a, CULL> {
    /// Query for the first hit of `ray` after `after`.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, after: Option<HitOrder>, filter: Filter<'a>) -> Self {
        let lower = match after {
            Some(after) if after.t > ray.t_min => after.t,
            _ => ray.t_min,
        };
        Self {
            after,
            filter,
            lower: positive_lower(lower),
            near: ray.t_max,
            far: ray.t_max,
            best: Best::None,
        }
    }

    /// Closest hit after a loop over exact hits.
    pub(crate) fn exact(&self) -> Option<Hit> {
        match self.best {
            Best::Exact(hit) => Some(hit),
            Best::None | Best::Bounded(_) => None,
        }
    }

    /// Closest hit after a traversal with `leaves`.
    #[inline(always)]
    pub(crate) fn finish(&self, leaves: &LeafIntersector) -> Option<Hit> {
        match self.best {
            Best::None => None,
            Best::Bounded(slot) => Some(leaves.intersect_conservative(slot)),
            Best::Exact(hit) => Some(hit),
        }
    }

    /// Computes the exact hits of the closest one so far and of a candidate, and keeps the first.
    #[inline(never)]
    fn compare_exactly(&mut self, candidate: &Candidate, leaves: &LeafIntersector) {
        if let Best::Bounded(slot) = self.best {
            self.set(&leaves.intersect_conservative(slot));
        }
        if let Some(hit) = leaves.intersect(candidate.slot) {
            self.accept(&hit, candidate.tag.flags());
        }
    }

    /// Whether a hit with a triangle of these flags counts only where the filter accepts it.
    #[inline(always)]
    fn is_filtered(flags: TriangleFlags) -> bool {
        if CULL { flags.has(TriangleFlags::FILTERED) } else { flags.is_filtered_from_any_side() }
    }

    fn set(&mut self, hit: &Hit) {
        self.best = Best::Exact(*hit);
        (self.near, self.far) = (hit.t, hit.t);
    }
}

impl<const CULL: bool> Visitor for ClosestHit<'_, CULL> {
    #[inline(always)]
    fn is_ordered(&self) -> bool {
        true
    }

    #[inline(always)]
    fn lower(&self) -> f32 {
        self.lower
    }

    #[inline(always)]
    fn upper(&self) -> f32 {
        self.far
    }

    #[inline(always)]
    fn test(&mut self, candidate: &Candidate, leaves: &LeafIntersector) -> bool {
        let flags = candidate.tag.flags();
        if candidate.is_certain {
            if candidate.near > self.far
                || CULL && candidate.is_back && flags.has(TriangleFlags::SINGLE_SIDED)
            {
                return false;
            }
            let is_closer = candidate.near > self.lower && candidate.far < self.near;
            if is_closer && !Self::is_filtered(flags) {
                self.best = Best::Bounded(candidate.slot);
                (self.near, self.far) = (candidate.near, candidate.far);
                return false;
            }
        }
        self.compare_exactly(candidate, leaves);
        false
    }

    fn accept(&mut self, hit: &Hit, flags: TriangleFlags) -> bool {
        let order = hit.order();
        let is_first = match self.best {
            Best::Exact(best) => order < best.order(),
            Best::None | Best::Bounded(_) => true,
        };
        if !is_first || self.after.is_some_and(|after| order <= after) {
            return false;
        }
        if CULL && flags.has(TriangleFlags::SINGLE_SIDED) && hit.facing == Facing::Back {
            return false;
        }
        if Self::is_filtered(flags) && !(self.filter)(hit) {
            return false;
        }
        self.set(hit);
        false
    }
}
