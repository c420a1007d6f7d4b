//! Edge functions in single precision: whether a lane's ray misses its triangle, certainly hits it, or is too close to call.
//!
//! These are the edge functions of the definition of a hit ([`crate::geometry::ShearedRay`]) in `f32`, one pair of ray and
//! triangle per lane. Pairs that they cannot decide are left to the definition.
//!
//! # Inside or outside
//!
//! The translated and sheared corners equal those of the definition, and the sign of an edge function is exact where it is not
//! zero. A lane misses the triangle if one edge function is negative and another positive. If all have one sign, the
//! barycentric part of the test passes. Zeros and numbers that are not finite are left to the definition.
//!
//! # Distances
//!
//! `t` is the mean of the depths weighted by the edge functions, over the direction's component along the depth axis. Let `M` be
//! the largest lateral coordinate. An edge function is at most `2M²` and off by at most `2⁻²⁴·4M²`. Errors `δ` of the weights
//! move the mean by at most `Σ|δ|·span/|det|`, where `span` is the range of depths: `3·2⁻²²·M²·span/|det|`, rounded up to
//! `2⁻²⁰`. Sums, products and quotients move it by at most ten roundings of the largest depth; with the last rounding of the
//! true `t` that is less than `2⁻²⁰` of it. Underflow is below [`UNDERFLOW`], since determinants are not tiny. Where a product of an
//! edge function and a depth overflows, `t` is not finite, and the bounds are not numbers: no comparison with them holds.

use fearless_simd::{Simd, SimdFloat, prelude::*};

/// Error of the weights, in units of `M²`.
const WEIGHT_ERROR: f32 = 1.0 / (1 << 20) as f32;
/// Rounding errors of a distance, in units of the largest depth.
const DEPTH_ERROR: f32 = 1.0 / (1 << 20) as f32;
/// Bound of products that underflow, over the smallest determinant.
const UNDERFLOW: f32 = 1.0e-19;
/// With smaller determinants no hit is certain: edge functions times depths may underflow.
const MIN_DETERMINANT: f32 = 1.0e-25;
/// Larger determinants count as not finite.
const MAX_DETERMINANT: f32 = 1.0e37;

/// Corner relative to the ray's origin, sheared: two lateral coordinates and the depth.
pub(super) type Corner<V> = [V; 3];

/// Edge functions of all lanes and their outcome.
pub(super) struct EdgeFunctions<V> {
    /// Lanes that do not miss the triangle.
    pub(super) possible: u32,
    /// Lanes that are certainly inside the triangle.
    pub(super) certain: u32,
    corners: [Corner<V>; 3],
    values: [V; 3],
    det: V,
}

/// Bounds of the ray parameter of certain hits.
pub(super) struct DistanceBounds<V> {
    /// Lower bound.
    pub(super) near: V,
    /// Upper bound.
    pub(super) far: V,
}

#[inline(always)]
fn bits<S: Simd>(mask: impl SimdMask<S>) -> u32 {
    mask.to_bitmask() as u32
}

impl<V> EdgeFunctions<V> {
    /// Evaluates the edge functions of the triangles with these corners.
    #[inline(always)]
    pub(super) fn new<S: Simd>(corners: [Corner<V>; 3]) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let [a, b, c] = corners;
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let det = u + v + w;
        let lowest = u.min(v).min(w);
        let highest = u.max(v).max(w);
        let size = det.abs();
        let is_finite = size.simd_lt(MAX_DETERMINANT);
        let misses = lowest.simd_lt(0.0) & highest.simd_gt(0.0) & is_finite;
        let inside = (lowest.simd_gt(0.0) | highest.simd_lt(0.0)) & size.simd_gt(MIN_DETERMINANT) & is_finite;
        Self { possible: !bits(misses), certain: bits(inside), corners, values: [u, v, w], det }
    }

    /// Of the certain lanes, those that hit the back of the triangle.
    #[inline(always)]
    pub(super) fn back<S: Simd>(&self) -> u32
    where
        V: SimdFloat<S, Element = f32>,
    {
        bits(self.det.simd_lt(0.0))
    }

    /// Bounds of the certain hits; `reciprocal` is one over the direction's component along the depth axis.
    #[inline(always)]
    pub(super) fn distance_bounds<S: Simd>(&self, simd: S, reciprocal: V) -> DistanceBounds<V>
    where
        V: SimdFloat<S, Element = f32>,
    {
        let [u, v, w] = self.values;
        let [a, b, c] = self.corners;
        let lateral_a = a[0].abs().max(a[1].abs());
        let lateral_b = b[0].abs().max(b[1].abs());
        let lateral_c = c[0].abs().max(c[1].abs());
        let lateral = lateral_a.max(lateral_b).max(lateral_c);
        let deepest = a[2].max(b[2]).max(c[2]);
        let shallowest = a[2].min(b[2]).min(c[2]);
        let largest_depth = deepest.abs().max(shallowest.abs());

        let over_det = V::splat(simd, 1.0) / self.det;
        let t = (u * a[2] + v * b[2] + w * c[2]) * over_det * reciprocal;
        let weights = lateral * lateral * WEIGHT_ERROR * (deepest - shallowest) * over_det.abs();
        let error = (weights + largest_depth * DEPTH_ERROR + UNDERFLOW) * reciprocal.abs();
        // Zero, or not a number.
        let overflow = t * 0.0;
        let error = error + overflow;
        DistanceBounds { near: t - error, far: t + error }
    }
}
