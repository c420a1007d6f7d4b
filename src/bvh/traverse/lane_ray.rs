//! Ray against eight boxes or eight triangles at once.
//!
//! # Boxes
//!
//! Slab test with a lengthened far distance: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Departures:
//!
//! * Entry distances are shortened and exit distances lengthened by [`SLACK`], more than twice the relative error of a
//!   difference, a reciprocal, two products and the rounding of `t`.
//! * The origin is moved outward by [`BOX_PADDING`] of its largest coordinate, as the definition of a hit requires.
//! * The direction is scaled by a power of two so that its largest component is in [1, 2). Its other components are at least
//!   2⁻³⁰: within the scene this moves the ray by less than the padding, and no distance is 0·∞.

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;

use super::edge_functions::{Corner, EdgeFunctions};
use super::visitor::lower_or_zero;
use crate::bvh::wide_tree::{Triangles, WIDTH, WideNode};
use crate::geometry::{BOX_PADDING, Ray, dominant_axes};

/// Relative shortening of entry distances and lengthening of exit distances.
const SLACK: f32 = 1.0 / (1 << 20) as f32;
/// Smallest direction component, in units of the largest.
const MIN_COMPONENT: f32 = 1.0 / (1 << 30) as f32;

/// Ray with the precomputed values of the box and triangle tests.
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
    /// Lower limit of box distances.
    lower: f32,
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
    /// Reciprocal of the direction's component along the depth axis.
    pub(super) depth_reciprocal: f32,
}

/// Children of a node that a ray enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entered {
    /// One bit per child.
    pub(super) mask: u32,
    /// Entry distances in units of [`LaneRay::scale`]; not negative.
    pub(super) distances: [f32; WIDTH],
}

impl LaneRay {
    /// Prepares `ray`. Boxes that end before `lower` (in `t`) are not entered.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, lower: f32) -> Self {
        let axes = dominant_axes(ray.direction);
        let [x, y, depth] = axes.map(|axis| ray.direction.to_array()[axis]);
        // By comparisons, so that the box test does not wait for the lookup of `axes`.
        let max = |a: f32, b: f32| if a > b { a } else { b };
        let size = ray.direction.abs();
        let largest = max(max(size.x, size.y), size.z);
        debug_assert!(largest.to_bits() == depth.abs().to_bits());
        // Largest power of two not above the largest component, by its exponent bits, and its reciprocal.
        let exponent = (largest.to_bits() >> 23).clamp(1, 253);
        let scale = f32::from_bits(exponent << 23);
        let over_scale = f32::from_bits((254 - exponent) << 23);
        let direction = ray.direction * over_scale;

        let smallest = Vec3::splat(largest * over_scale * MIN_COMPONENT);
        let reciprocal = direction.abs().max(smallest).copysign(direction).recip();
        let outward = Vec3::splat(ray.origin.abs().max_element() * BOX_PADDING).copysign(direction);
        Self {
            backward: direction.to_array().map(f32::is_sign_negative),
            near_origin: (ray.origin + outward).to_array(),
            far_origin: (ray.origin - outward).to_array(),
            near_reciprocal: (reciprocal * (1.0 - SLACK)).to_array(),
            far_reciprocal: (reciprocal * (1.0 + SLACK)).to_array(),
            scale,
            lower: lower_or_zero(lower) * scale,
            axes,
            origin: ray.origin.to_array(),
            shear: [x / depth, y / depth],
            depth_reciprocal: reciprocal.to_array()[axes[2]] * over_scale,
        }
    }

    /// Index in [`WideNode::planes`] of the first plane of `axis` along the ray. It is computed from a flag rather than stored,
    /// so that the compiler sees that it is in range.
    #[inline(always)]
    fn near_plane(&self, axis: usize) -> usize {
        axis + 3 * usize::from(self.backward[axis])
    }

    /// Index of the second plane of `axis` along the ray.
    #[inline(always)]
    fn far_plane(&self, axis: usize) -> usize {
        axis + 3 * usize::from(!self.backward[axis])
    }

    /// Distances to the first planes of an axis.
    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, node: &WideNode, axis: usize) -> f32x8<S> {
        let plane = f32x8::load_array_ref(simd, &node.planes[self.near_plane(axis)]);
        (plane - self.near_origin[axis]) * self.near_reciprocal[axis]
    }

    /// Distances to the second planes of an axis.
    #[inline(always)]
    fn far<S: Simd>(&self, simd: S, node: &WideNode, axis: usize) -> f32x8<S> {
        let plane = f32x8::load_array_ref(simd, &node.planes[self.far_plane(axis)]);
        (plane - self.far_origin[axis]) * self.far_reciprocal[axis]
    }

    /// Children of `node` that the ray enters at or before `upper`, a box distance.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, node: &WideNode, upper: f32) -> Entered {
        let [x, y, z] = [self.near(simd, node, 0), self.near(simd, node, 1), self.near(simd, node, 2)];
        let entry = x.max(y).max(z.max(self.lower));
        let [x, y, z] = [self.far(simd, node, 0), self.far(simd, node, 1), self.far(simd, node, 2)];
        let exit = x.min(y).min(z.min(upper));
        let mask = entry.simd_le(exit).to_bitmask() as u32;
        Entered { mask, distances: entry.into() }
    }

    /// One corner of all triangles of a leaf, relative to the origin and sheared.
    #[inline(always)]
    fn corner<S: Simd>(&self, simd: S, triangles: &Triangles, corner: usize) -> Corner<f32x8<S>> {
        let [kx, ky, kz] = self.axes;
        let x = f32x8::load_array_ref(simd, triangles.lanes(corner, kx)) - self.origin[kx];
        let y = f32x8::load_array_ref(simd, triangles.lanes(corner, ky)) - self.origin[ky];
        let z = f32x8::load_array_ref(simd, triangles.lanes(corner, kz)) - self.origin[kz];
        [x - z * self.shear[0], y - z * self.shear[1], z]
    }

    /// Edge functions of the triangles of a leaf.
    #[inline(always)]
    pub(super) fn edge_functions<S: Simd>(&self, simd: S, triangles: &Triangles) -> EdgeFunctions<f32x8<S>> {
        EdgeFunctions::new([
            self.corner(simd, triangles, 0),
            self.corner(simd, triangles, 1),
            self.corner(simd, triangles, 2),
        ])
    }
}
