//! What the three queries make of the triangles that a walk over a tree, or over all triangles, finds.
//!
//! Most hits are settled by bounds of their distance alone; the exact one is computed for the winner, and wherever two
//! are too close to call.

use super::wide::{Leaf, Tag, WideTree};
use super::{Hit, HitOrder, PrimitiveFlags};
use crate::geometry::{Facing, Ray, ShearedRay, TriangleHit};

/// Says whether a hit with a filtered triangle counts. It is asked seldom, so that walks are compiled once for all filters.
pub(super) type Filter<'a> = &'a dyn Fn(&Hit) -> bool;

/// [`Filter`] of a batch, which is told the subscript of the ray.
pub(super) type BatchFilter<'a> = &'a dyn Fn(usize, &Hit) -> bool;

/// Where a triangle stands in a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its leaf.
    pub(super) leaf: Leaf,
    /// Which one of the leaf.
    pub(super) lane: u32,
}

/// A triangle that a ray may meet, as far as single precision tells.
pub(super) struct Candidate {
    /// The triangle.
    pub(super) place: Place,
    /// Id and flags.
    pub(super) tag: Tag,
    /// Whether the triangle is met beyond doubt, but for the limits of the ray.
    pub(super) sure: bool,
    /// If sure: whether it is the back side.
    pub(super) back: bool,
    /// If sure: the hit is not nearer.
    pub(super) near: f32,
    /// If sure: the hit is not farther.
    pub(super) far: f32,
}

/// Decides by the definition of a hit.
pub(super) struct Judge<'a> {
    /// The tree.
    pub(super) tree: &'a WideTree,
    /// The ray.
    pub(super) ray: &'a Ray,
}

/// Receives the triangles that a ray may meet, in any order.
pub(super) trait Visitor {
    /// Whether near nodes are better walked first.
    const ORDERED: bool;
    /// Hits at a smaller `t` are of no interest.
    fn lower(&self) -> f32;
    /// Hits at a larger `t` are of no interest.
    fn upper(&self) -> f32;
    /// Takes a candidate; true ends the walk.
    fn consider(&mut self, candidate: &Candidate, judge: &Judge) -> bool;
    /// Takes a hit; true ends the walk.
    fn offer(&mut self, hit: &Hit, flags: PrimitiveFlags) -> bool;
}

/// Finds the first hit in [`HitOrder`]; with `CULL`, back faces of single-sided triangles do not count.
pub(super) struct Nearest<'a, const CULL: bool> {
    after: Option<HitOrder>,
    filter: Filter<'a>,
    lower: f32,
    /// The first hit so far is not nearer, and not farther than this; both are the ray's end before there is one.
    near: f32,
    far: f32,
    best: Best,
}

/// The first hit so far.
#[derive(Clone, Copy)]
enum Best {
    None,
    /// With this triangle, which is met beyond doubt.
    Sure(Place),
    Exact(Hit),
}

/// Finds whether there is any hit.
pub(super) struct Any<'a> {
    filter: Filter<'a>,
    lower: f32,
    upper: f32,
    /// Whether there is one.
    pub(super) found: bool,
}

/// The lower limit, or the smallest distance that counts.
#[inline(always)]
pub(super) fn positive_lower(lower: f32) -> f32 {
    if lower > f32::MIN_POSITIVE { lower } else { f32::MIN_POSITIVE }
}

impl Hit {
    /// A hit of the definition, with the triangle's id.
    #[inline(always)]
    pub(super) fn of(hit: TriangleHit, primitive: u32) -> Self {
        Self { t: hit.t, primitive, u: hit.u, v: hit.v, facing: hit.facing }
    }
}

impl Judge<'_> {
    /// The hit with a triangle of the tree.
    pub(super) fn meet(&self, Place { leaf, lane }: Place) -> Option<Hit> {
        let triangles = self.tree.triangles(leaf);
        let hit = ShearedRay::new(self.ray).meet(&triangles.corners(lane as usize))?;
        Some(Hit::of(hit, triangles.tag(lane as usize).primitive()))
    }

    /// The hit with a triangle of the tree that is met beyond doubt.
    #[inline(always)]
    pub(super) fn meet_surely(&self, Place { leaf, lane }: Place) -> Hit {
        let triangles = self.tree.triangles(leaf);
        let ray = ShearedRay::new(self.ray);
        let corners = triangles.corners_in_order(lane as usize, ray.axes());
        Hit::of(ray.meet_surely(corners), triangles.tag(lane as usize).primitive())
    }
}

impl<'a, const CULL: bool> Nearest<'a, CULL> {
    /// Looks for the first hit of `ray` after `after`.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, after: Option<HitOrder>, filter: Filter<'a>) -> Self {
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

    /// The first hit of a walk over all triangles.
    pub(super) fn exact(&self) -> Option<Hit> {
        match self.best {
            Best::Exact(hit) => Some(hit),
            Best::None | Best::Sure(_) => None,
        }
    }

    /// The first hit of a walk over the judge's tree.
    #[inline(always)]
    pub(super) fn finish(&self, judge: &Judge) -> Option<Hit> {
        match self.best {
            Best::None => None,
            Best::Sure(place) => Some(judge.meet_surely(place)),
            Best::Exact(hit) => Some(hit),
        }
    }

    /// Decides between the first hit so far and a candidate by the definition.
    #[inline(never)]
    fn compare(&mut self, candidate: &Candidate, judge: &Judge) {
        if let Best::Sure(place) = self.best {
            self.set(&judge.meet_surely(place));
        }
        if let Some(hit) = judge.meet(candidate.place) {
            self.offer(&hit, candidate.tag.flags());
        }
    }

    fn set(&mut self, hit: &Hit) {
        self.best = Best::Exact(*hit);
        (self.near, self.far) = (hit.t, hit.t);
    }
}

impl<const CULL: bool> Visitor for Nearest<'_, CULL> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn lower(&self) -> f32 {
        self.lower
    }

    #[inline(always)]
    fn upper(&self) -> f32 {
        self.far
    }

    #[inline(always)]
    fn consider(&mut self, candidate: &Candidate, judge: &Judge) -> bool {
        let flags = candidate.tag.flags();
        if candidate.sure {
            if candidate.near > self.far
                || candidate.far < self.lower
                || CULL && candidate.back && flags.has(PrimitiveFlags::SINGLE_SIDED)
            {
                return false;
            }
            let in_front = candidate.near > self.lower && candidate.far < self.near;
            if in_front && !flags.has(PrimitiveFlags::FILTERED) {
                self.best = Best::Sure(candidate.place);
                (self.near, self.far) = (candidate.near, candidate.far);
                return false;
            }
        }
        self.compare(candidate, judge);
        false
    }

    fn offer(&mut self, hit: &Hit, flags: PrimitiveFlags) -> bool {
        let order = hit.order();
        let is_first = match self.best {
            Best::Exact(best) => order < best.order(),
            Best::None | Best::Sure(_) => true,
        };
        if !is_first || self.after.is_some_and(|after| order <= after) {
            return false;
        }
        if CULL && flags.has(PrimitiveFlags::SINGLE_SIDED) && hit.facing == Facing::Back {
            return false;
        }
        if flags.has(PrimitiveFlags::FILTERED) && !(self.filter)(hit) {
            return false;
        }
        self.set(hit);
        false
    }
}

impl<'a> Any<'a> {
    /// Looks for any hit of `ray`.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, filter: Filter<'a>) -> Self {
        Self { filter, lower: positive_lower(ray.t_min), upper: ray.t_max, found: false }
    }
}

impl Visitor for Any<'_> {
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
    fn consider(&mut self, candidate: &Candidate, judge: &Judge) -> bool {
        let flags = candidate.tag.flags();
        if candidate.sure {
            if candidate.near > self.upper || candidate.far < self.lower {
                return false;
            }
            let between = candidate.near > self.lower && candidate.far < self.upper;
            if between && !flags.has(PrimitiveFlags::FILTERED) {
                self.found = true;
                return true;
            }
        }
        judge.meet(candidate.place).is_some_and(|hit| self.offer(&hit, flags))
    }

    fn offer(&mut self, hit: &Hit, flags: PrimitiveFlags) -> bool {
        self.found = !flags.has(PrimitiveFlags::FILTERED) || (self.filter)(hit);
        self.found
    }
}
