//! What the three queries make of the hits that a walk over a tree, or over all triangles, finds.

use super::{Hit, HitOrder, PrimitiveFlags};
use crate::geometry::{Facing, Ray, TriangleHit};

/// Receives hits in any order.
pub(super) trait Visitor {
    /// Whether near nodes are better walked first.
    const ORDERED: bool;
    /// Hits at a smaller `t` are of no interest.
    fn lower(&self) -> f32;
    /// Hits at a larger `t` are of no interest.
    fn upper(&self) -> f32;
    /// Takes a hit; true ends the walk.
    fn offer(&mut self, hit: &Hit, flags: PrimitiveFlags) -> bool;
}

/// Finds the first hit in [`HitOrder`]; with `CULL`, back faces of single-sided triangles do not count.
pub(super) struct Nearest<F, const CULL: bool> {
    after: Option<HitOrder>,
    filter: F,
    lower: f32,
    upper: f32,
    /// The first hit so far.
    pub(super) best: Option<Hit>,
}

/// Finds whether there is any hit.
pub(super) struct Any<F> {
    filter: F,
    lower: f32,
    upper: f32,
    /// Whether there is one.
    pub(super) found: bool,
}

impl Hit {
    /// A hit of the definition, with the triangle's id.
    #[inline(always)]
    pub(super) fn of(hit: TriangleHit, primitive: u32) -> Self {
        Self { t: hit.t, primitive, u: hit.u, v: hit.v, facing: hit.facing }
    }
}

impl<F: Fn(&Hit) -> bool, const CULL: bool> Nearest<F, CULL> {
    /// Looks for the first hit of `ray` after `after`.
    pub(super) fn new(ray: &Ray, after: Option<HitOrder>, filter: F) -> Self {
        let lower = match after {
            Some(after) if after.t > ray.t_min => after.t,
            _ => ray.t_min,
        };
        Self { after, filter, lower, upper: ray.t_max, best: None }
    }
}

impl<F: Fn(&Hit) -> bool, const CULL: bool> Visitor for Nearest<F, CULL> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn lower(&self) -> f32 {
        self.lower
    }

    #[inline(always)]
    fn upper(&self) -> f32 {
        self.upper
    }

    #[inline(always)]
    fn offer(&mut self, hit: &Hit, flags: PrimitiveFlags) -> bool {
        let order = hit.order();
        let is_first = self.best.is_none_or(|best| order < best.order());
        if !is_first || self.after.is_some_and(|after| order <= after) {
            return false;
        }
        if CULL && flags.has(PrimitiveFlags::SINGLE_SIDED) && hit.facing == Facing::Back {
            return false;
        }
        if flags.has(PrimitiveFlags::FILTERED) && !(self.filter)(hit) {
            return false;
        }
        self.best = Some(*hit);
        self.upper = hit.t;
        false
    }
}

impl<F: Fn(&Hit) -> bool> Any<F> {
    /// Looks for any hit of `ray`.
    pub(super) fn new(ray: &Ray, filter: F) -> Self {
        Self { filter, lower: ray.t_min, upper: ray.t_max, found: false }
    }
}

impl<F: Fn(&Hit) -> bool> Visitor for Any<F> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn lower(&self) -> f32 {
        self.lower
    }

    #[inline(always)]
    fn upper(&self) -> f32 {
        self.upper
    }

    #[inline(always)]
    fn offer(&mut self, hit: &Hit, flags: PrimitiveFlags) -> bool {
        self.found = !flags.has(PrimitiveFlags::FILTERED) || (self.filter)(hit);
        self.found
    }
}
