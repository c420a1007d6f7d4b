//! Interface between traversal and queries: candidates, the exact leaf intersector, and the visitor of single rays.
//!
//! Bounds of the distance decide most hits. The exact hit is computed for the closest one at the end, and where bounds of two
//! candidates overlap.

use crate::bvh::hit::Hit;
use crate::bvh::triangle_flags::TriangleFlags;
use crate::bvh::wide_tree::{Leaf, Tag, WideTree};
use crate::geometry::{Ray, ShearedRay};

/// Accepts or rejects a hit with a filtered triangle. A dynamic call, so that traversal is compiled once for all filters.
pub(crate) type Filter<'a> = &'a dyn Fn(&Hit) -> bool;

/// [`Filter`] of a batch, which also gets the ray's index.
pub(crate) type BatchFilter<'a> = &'a dyn Fn(usize, &Hit) -> bool;

/// Slot of a triangle in the wide tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleSlot {
    /// Leaf of the triangle.
    pub(crate) leaf: Leaf,
    /// Index of the triangle in its leaf.
    pub(crate) lane: u32,
}

/// Triangle that a ray may hit, as far as single precision tells.
pub(crate) struct Candidate {
    /// Slot of the triangle.
    pub(crate) slot: TriangleSlot,
    /// Index and flags of the triangle.
    pub(crate) tag: Tag,
    /// Whether the line of the ray certainly intersects the triangle; only the limits of `t` are open.
    pub(crate) is_certain: bool,
    /// If certain: whether the ray hits the back side.
    pub(crate) is_back: bool,
    /// If certain: lower bound of `t`.
    pub(crate) near: f32,
    /// If certain: upper bound of `t`.
    pub(crate) far: f32,
}

/// Exact intersection of one ray with the triangles of a tree.
pub(crate) struct LeafIntersector<'a> {
    /// Tree that holds the triangles.
    pub(crate) tree: &'a WideTree,
    /// Ray in world space.
    pub(crate) ray: &'a Ray,
}

/// Receives the triangles that a ray may hit, in any order.
pub(crate) trait Visitor {
    /// Whether near nodes are traversed first.
    fn is_ordered(&self) -> bool;
    /// Lower limit of `t`.
    fn lower(&self) -> f32;
    /// Upper limit of `t`.
    fn upper(&self) -> f32;
    /// Tests a candidate; true ends the traversal. Certain candidates beyond the limits that held before their leaf are not passed.
    fn test(&mut self, candidate: &Candidate, leaves: &LeafIntersector) -> bool;
    /// Takes an exact hit; true ends the traversal.
    fn accept(&mut self, hit: &Hit, flags: TriangleFlags) -> bool;
}

/// Smallest lower limit of `t`: subnormal distances count as zero.
pub(super) const LEAST_LOWER: f32 = f32::MIN_POSITIVE;

/// `lower`, or [`LEAST_LOWER`] where that is larger.
#[inline(always)]
pub(super) fn positive_lower(lower: f32) -> f32 {
    if lower > LEAST_LOWER { lower } else { LEAST_LOWER }
}

/// `lower`, or zero where it is at most [`LEAST_LOWER`]. Limits of box distances are scaled, and a subnormal product costs
/// some processors more than a hundred cycles.
#[inline(always)]
pub(super) fn lower_or_zero(lower: f32) -> f32 {
    if lower > LEAST_LOWER { lower } else { 0.0 }
}

impl LeafIntersector<'_> {
    /// Hit with the triangle in a slot.
    pub(super) fn intersect(&self, TriangleSlot { leaf, lane }: TriangleSlot) -> Option<Hit> {
        let triangles = self.tree.triangles(leaf);
        let hit = ShearedRay::new(self.ray).intersect(&triangles.corners(lane as usize))?;
        Some(Hit::of(hit, triangles.tag(lane as usize).triangle()))
    }

    /// Hit with the triangle of a certain candidate; the acceptance test is skipped.
    #[inline(always)]
    pub(super) fn intersect_conservative(&self, TriangleSlot { leaf, lane }: TriangleSlot) -> Hit {
        let triangles = self.tree.triangles(leaf);
        let ray = ShearedRay::new(self.ray);
        let corners = triangles.corners_in_order(lane as usize, ray.axes());
        Hit::of(ray.intersect_known(corners), triangles.tag(lane as usize).triangle())
    }
}
