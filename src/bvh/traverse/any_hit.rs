//! Any-hit (occlusion) query of a single ray.

use super::visitor::{Candidate, Filter, LeafIntersector, Visitor, positive_lower};
use crate::bvh::hit::Hit;
use crate::bvh::triangle_flags::TriangleFlags;
use crate::geometry::Ray;

/// Finds whether a ray hits anything.
pub(crate) struct AnyHit<'a> {
    filter: Filter<'a>,
    lower: f32,
    upper: f32,
    /// Whether a hit was found.
    pub(crate) found: bool,
}

impl<'a> AnyHit<'a> {
    /// Query for any hit of `ray`.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, filter: Filter<'a>) -> Self {
        Self { filter, lower: positive_lower(ray.t_min), upper: ray.t_max, found: false }
    }
}

impl Visitor for AnyHit<'_> {
    #[inline(always)]
    fn is_ordered(&self) -> bool {
        false
    }

    #[inline(always)]
    fn lower(&self) -> f32 {
        self.lower
    }

    #[inline(always)]
    fn upper(&self) -> f32 {
        self.upper
    }

    #[inline(always)]
    fn test(&mut self, candidate: &Candidate, leaves: &LeafIntersector) -> bool {
        let flags = candidate.tag.flags();
        if candidate.is_certain {
            let is_within = candidate.near > self.lower && candidate.far < self.upper;
            if is_within && !flags.is_filtered_from_any_side() {
                self.found = true;
                return true;
            }
        }
        leaves.intersect(candidate.slot).is_some_and(|hit| self.accept(&hit, flags))
    }

    fn accept(&mut self, hit: &Hit, flags: TriangleFlags) -> bool {
        self.found = !flags.is_filtered_from_any_side() || (self.filter)(hit);
        self.found
    }
}
