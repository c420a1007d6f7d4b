//! Walking the wide tree with one ray.
//!
//! Source: ordered traversal with an explicit stack, nearest child first, as in Wald, Benthin, Boulos, "Getting Rid of
//! Packets", RT 2008. A node is passed over only if its entry distance, already shortened by [`SLACK`], is beyond the
//! best hit, never if it is equal, since a lower id may wait there.
//!
//! # Boxes
//!
//! Source: the slab test with a widened far distance is Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Here entry
//! distances are shortened and exit distances lengthened by [`SLACK`], more than twice the relative error of a
//! difference, a reciprocal, two products and the rounding of `t`; and the origin is moved outward by
//! [`BOX_PADDING`] of its largest coordinate, as the definition of a hit asks. The direction is scaled by a power
//! of two so that its largest component is in [1, 2), and its other components are not taken smaller than 2⁻³⁰:
//! within the scene this moves the ray by less than the padding, and no distance is 0·∞.

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;

use super::edges::{Corner, Edges};
use super::stack::{Pending, Stack};
use crate::bvh::TraversalCounters;
use crate::bvh::query::{Candidate, Judge, Place, Visitor};
use crate::bvh::wide::{Leaf, NO_CHILD, Triangles, WIDTH, WideNode};
use crate::geometry::{BOX_PADDING, Ray, dominant_axes};

/// Relative shortening of entry and lengthening of exit distances.
const SLACK: f32 = 1.0 / (1 << 20) as f32;
/// Smallest direction component, in units of the largest.
const SMALLEST_COMPONENT: f32 = 1.0 / (1 << 30) as f32;

/// A ray as the kernels use it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneRay {
    /// Axes along which the ray runs towards smaller coordinates.
    backward: [bool; 3],
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    near_reciprocal: [f32; 3],
    far_reciprocal: [f32; 3],
    /// Box distances are `t` times this.
    pub(super) scale: f32,
    /// Smallest box distance of interest.
    lower: f32,
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
    /// One over the direction's component along the depth.
    pub(super) depth_reciprocal: f32,
}

/// Children of a node that a ray enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entered {
    /// One bit a child.
    pub(super) mask: u32,
    /// Where, in units of [`LaneRay::scale`]; not negative.
    pub(super) distances: [f32; WIDTH],
}

/// Walks `tree` with one ray.
#[inline(always)]
pub(super) fn walk<S: Simd, V: Visitor>(
    simd: S,
    judge: &Judge,
    visitor: &mut V,
    counters: &mut TraversalCounters,
) {
    let tree = judge.tree;
    // A ray that is no ray meets nothing.
    let is_ray = judge.ray.direction.is_finite() && judge.ray.origin.is_finite();
    if tree.root == NO_CHILD || !is_ray {
        return;
    }
    let ray = LaneRay::new(judge.ray, visitor.lower());
    let (mut nodes, mut triangle_tests) = (0, 0);
    let mut stack = Stack::new();
    let mut current = Pending::new(0.0, tree.root);
    loop {
        let child = current.child();
        if let Some(leaf) = Leaf::of(child) {
            let triangles = tree.triangles(leaf);
            triangle_tests += triangles.count() as u64;
            if ray.visit(simd, leaf, &triangles, judge, visitor) {
                break;
            }
        } else {
            let node = &tree.nodes[child as usize];
            nodes += 1;
            let entered = ray.enter(simd, node, visitor.upper() * ray.scale);
            if let Some(next) = stack.push_all::<V>(node, &entered) {
                current = next;
                continue;
            }
        }

        // The next one that the best hit does not hide.
        let upper = visitor.upper() * ray.scale;
        let Some(pending) = stack.pop_within(upper) else { break };
        current = pending;
    }
    counters.nodes += nodes;
    counters.triangles += triangle_tests;
}

impl LaneRay {
    /// Prepares `ray`; box distances below `lower` (in `t`) are of no interest.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, lower: f32) -> Self {
        let axes = dominant_axes(ray.direction);
        let depth = ray.direction[axes[2]];
        let largest = depth.abs();
        // The power of two at or below the largest component, by its exponent bits, and its reciprocal.
        let exponent = (largest.to_bits() >> 23).clamp(1, 253);
        let scale = f32::from_bits(exponent << 23);
        let over_scale = f32::from_bits((254 - exponent) << 23);
        let direction = ray.direction * over_scale;

        let smallest = Vec3::splat(largest * over_scale * SMALLEST_COMPONENT);
        let reciprocal = direction.abs().max(smallest).copysign(direction).recip();
        let outward = Vec3::splat(ray.origin.abs().max_element() * BOX_PADDING).copysign(direction);
        Self {
            backward: direction.to_array().map(f32::is_sign_negative),
            near_origin: (ray.origin + outward).to_array(),
            far_origin: (ray.origin - outward).to_array(),
            near_reciprocal: (reciprocal * (1.0 - SLACK)).to_array(),
            far_reciprocal: (reciprocal * (1.0 + SLACK)).to_array(),
            scale,
            lower: if lower > 0.0 { lower * scale } else { 0.0 },
            axes,
            origin: ray.origin.to_array(),
            shear: [ray.direction[axes[0]] / depth, ray.direction[axes[1]] / depth],
            depth_reciprocal: reciprocal[axes[2]] * over_scale,
        }
    }

    /// Index in [`WideNode::planes`] of the plane of `axis` that the ray meets first. It is made from a flag rather than
    /// stored, so that the compiler sees that it is in range.
    #[inline(always)]
    fn near_plane(&self, axis: usize) -> usize {
        axis + 3 * usize::from(self.backward[axis])
    }

    /// Index of the other plane of `axis`.
    #[inline(always)]
    fn far_plane(&self, axis: usize) -> usize {
        axis + 3 * usize::from(!self.backward[axis])
    }

    /// Where the planes of an axis are met that come first.
    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, node: &WideNode, axis: usize) -> f32x8<S> {
        let plane = f32x8::load_array_ref(simd, &node.planes[self.near_plane(axis)]);
        (plane - self.near_origin[axis]) * self.near_reciprocal[axis]
    }

    /// Where the planes of an axis are met that come last.
    #[inline(always)]
    fn far<S: Simd>(&self, simd: S, node: &WideNode, axis: usize) -> f32x8<S> {
        let plane = f32x8::load_array_ref(simd, &node.planes[self.far_plane(axis)]);
        (plane - self.far_origin[axis]) * self.far_reciprocal[axis]
    }

    /// Which children are entered at or before `upper`.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, node: &WideNode, upper: f32) -> Entered {
        let [x, y, z] = [self.near(simd, node, 0), self.near(simd, node, 1), self.near(simd, node, 2)];
        let entry = x.max(y).max(z).max(self.lower);
        let [x, y, z] = [self.far(simd, node, 0), self.far(simd, node, 1), self.far(simd, node, 2)];
        let exit = x.min(y).min(z).min(upper);
        let mask = entry.simd_le(exit).to_bitmask() as u32;
        Entered { mask, distances: entry.into() }
    }

    /// A corner of a leaf's triangles, relative to the origin and sheared.
    #[inline(always)]
    fn corner<S: Simd>(&self, simd: S, triangles: &Triangles, corner: usize) -> Corner<f32x8<S>> {
        let [kx, ky, kz] = self.axes;
        let x = f32x8::load_array_ref(simd, triangles.lanes(corner, kx)) - self.origin[kx];
        let y = f32x8::load_array_ref(simd, triangles.lanes(corner, ky)) - self.origin[ky];
        let z = f32x8::load_array_ref(simd, triangles.lanes(corner, kz)) - self.origin[kz];
        [x - z * self.shear[0], y - z * self.shear[1], z]
    }

    /// The edge functions of a leaf's triangles.
    #[inline(always)]
    pub(super) fn edges<S: Simd>(&self, simd: S, triangles: &Triangles) -> Edges<f32x8<S>> {
        Edges::new([
            self.corner(simd, triangles, 0),
            self.corner(simd, triangles, 1),
            self.corner(simd, triangles, 2),
        ])
    }

    /// Shows a leaf's triangles to the visitor; true if it has seen enough.
    #[inline(always)]
    fn visit<S: Simd, V: Visitor>(
        &self,
        simd: S,
        leaf: Leaf,
        triangles: &Triangles,
        judge: &Judge,
        visitor: &mut V,
    ) -> bool {
        let edges = self.edges(simd, triangles);
        let mut possible = edges.possible & ((1 << triangles.count()) - 1);
        if possible == 0 {
            return false;
        }
        let distances = edges.distances(simd, f32x8::splat(simd, self.depth_reciprocal));
        let (near, far): ([f32; WIDTH], [f32; WIDTH]) = (distances.near.into(), distances.far.into());
        let back = edges.back();
        while possible != 0 {
            let lane = possible.trailing_zeros() as usize & (WIDTH - 1);
            possible &= possible - 1;
            let candidate = Candidate {
                place: Place { leaf, lane: lane as u32 },
                tag: triangles.tag(lane),
                sure: edges.sure >> lane & 1 != 0,
                back: back >> lane & 1 != 0,
                near: near[lane],
                far: far[lane],
            };
            if visitor.consider(&candidate, judge) {
                return true;
            }
        }
        false
    }
}
