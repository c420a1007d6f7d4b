//! Ray against eight boxes or eight triangles at once.
//!
//! # Boxes
//!
//! Slab test with a lengthened far distance: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Departures:
//!
//! * Entry distances are shortened and exit distances lengthened by [`SLACK`], more than twice the relative error of a
//!   reciprocal, its product with the slack, the distance and the rounding of `t`.
//! * The origin is moved outward by [`BOX_PADDING`] of its largest coordinate, as the definition of a hit requires.
//! * The direction is scaled by a power of two so that its largest component is in [1, 2). Its other components are at least
//!   2⁻³⁰: within the scene this moves the ray by less than the padding, and no distance is 0·∞.
//! * The distance to a plane is the difference of two products with the reciprocal, of which that of the origin is computed once: one fused
//!   operation where the instruction set has it. The rounding of either product moves the origin or the plane by 2⁻²⁴ of its
//!   coordinate, which the padding covers. Rays whose products could overflow ([`is_extreme`]) take the product of the difference.

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;

use super::edge_functions::{Corner, EdgeFunctions};
use super::visitor::lower_or_zero;
use crate::bvh::wide_tree::{Triangles, WIDTH, WideNode};
use crate::geometry::{BOX_PADDING, Ray, dominant_axes};

/// Relative shortening of entry distances and lengthening of exit distances.
const SLACK: f32 = 1.0 / (1 << 20) as f32;
/// Smallest direction component of box tests, in units of the largest, which is along the depth axis.
pub(super) const MIN_COMPONENT: f32 = 1.0 / (1 << 30) as f32;
/// Limit of origin coordinates whose products with the reciprocals of a normal direction are finite.
const MAX_ORIGIN: f32 = (1_u128 << 96) as f32;

/// Ray with the precomputed values of the box and triangle tests: any ray if `EXTREME`, otherwise one for which [`is_extreme`] is false.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneRay<const EXTREME: bool> {
    /// Axes along which the ray runs towards smaller coordinates.
    backward: [bool; 3],
    /// Values of the box test alone.
    pub(super) slabs: Slabs,
    /// Box distances are `t` times this.
    pub(super) scale: f32,
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
    /// Reciprocal of the direction's component along the depth axis.
    pub(super) depth_reciprocal: f32,
}

/// Values of the box test. Those of the first planes along the ray are `near`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    near_reciprocal: [f32; 3],
    far_reciprocal: [f32; 3],
    /// What is subtracted for the first planes: from the planes of an extreme ray its origin; of any other, from their products with the
    /// reciprocal that of the origin.
    near_subtrahend: [f32; 3],
    /// The same for the second planes.
    far_subtrahend: [f32; 3],
    /// Lower limit of box distances.
    lower: f32,
}

/// Children of a node that a ray enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entered {
    /// One bit per child.
    pub(super) mask: u32,
    /// Entry distances in units of [`LaneRay::scale`]; not negative.
    pub(super) distances: [f32; WIDTH],
}

/// Whether products of the origin and the reciprocals of a ray might not be finite: it starts far away, or its direction is subnormal or
/// not finite.
#[inline(always)]
pub(super) fn is_extreme(ray: &Ray) -> bool {
    let ([x, y, z], [u, v, w]) = (ray.origin.abs().to_array(), ray.direction.abs().to_array());
    let is_near = x < MAX_ORIGIN && y < MAX_ORIGIN && z < MAX_ORIGIN;
    let is_finite = u <= f32::MAX && v <= f32::MAX && w <= f32::MAX;
    let is_normal = u >= f32::MIN_POSITIVE || v >= f32::MIN_POSITIVE || w >= f32::MIN_POSITIVE;
    !(is_near && is_finite && is_normal)
}

impl<const EXTREME: bool> LaneRay<EXTREME> {
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
        let (near_origin, far_origin) = (ray.origin + outward, ray.origin - outward);
        let (near_reciprocal, far_reciprocal) = (reciprocal * (1.0 - SLACK), reciprocal * (1.0 + SLACK));
        let subtrahend = |origin: Vec3, reciprocal: Vec3| if EXTREME { origin } else { origin * reciprocal };
        let slabs = Slabs {
            near_reciprocal: near_reciprocal.to_array(),
            far_reciprocal: far_reciprocal.to_array(),
            near_subtrahend: subtrahend(near_origin, near_reciprocal).to_array(),
            far_subtrahend: subtrahend(far_origin, far_reciprocal).to_array(),
            lower: lower_or_zero(lower) * scale,
        };
        Self {
            backward: direction.to_array().map(f32::is_sign_negative),
            slabs,
            scale,
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

    /// Distances to planes.
    #[inline(always)]
    #[expect(clippy::disallowed_methods, reason = "whichever way it is rounded, no box with a hit is missed")]
    fn distances<S: Simd>(simd: S, planes: &[f32; WIDTH], subtrahend: f32, reciprocal: f32) -> f32x8<S> {
        let planes = f32x8::load_array_ref(simd, planes);
        if EXTREME { (planes - subtrahend) * reciprocal } else { planes.mul_sub(reciprocal, subtrahend) }
    }

    /// Children of `node` that the ray enters at or before `upper`, a box distance. `slabs` are those of the ray, by a reference that may be hidden
    /// from the optimiser.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, slabs: &Slabs, node: &WideNode, upper: f32) -> Entered {
        let near = |axis: usize| {
            let (subtrahend, reciprocal) = (slabs.near_subtrahend[axis], slabs.near_reciprocal[axis]);
            Self::distances(simd, &node.planes[self.near_plane(axis)], subtrahend, reciprocal)
        };
        let far = |axis: usize| {
            let (subtrahend, reciprocal) = (slabs.far_subtrahend[axis], slabs.far_reciprocal[axis]);
            Self::distances(simd, &node.planes[self.far_plane(axis)], subtrahend, reciprocal)
        };
        let entry = near(0).max(near(1)).max(near(2).max(slabs.lower));
        let exit = far(0).min(far(1)).min(far(2).min(upper));
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
