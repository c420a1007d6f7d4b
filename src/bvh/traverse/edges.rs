//! What single precision tells of rays and triangles: surely beside, surely a hit and about where, or too close to call.
//!
//! The edge functions of the definition of a hit ([`crate::geometry::ShearedRay`]) in `f32`, one (ray, triangle) pair a
//! lane. What they cannot tell is decided by the definition.
//!
//! # Margins
//!
//! With `u = 2⁻²⁴`, `M` the largest lateral coordinate after the shear, `Z` the sum of `M` and the largest depth, and a
//! shear of at most 2, raw coordinates are at most `2Z`. A lateral coordinate is then off by at most `12uZ` (the
//! differences, a shear off by `2u`, its product, the last difference) and an edge function by at most
//! `4·12uZ·M + 2·(12uZ)² + 4uM² ≤ 52uZM + 288u²Z²`. The margin `2⁻¹⁷·Z·(M + 2⁻²²·Z)`, that is `128uZM + 512u²Z²`, is
//! larger by 1.7; a tiny constant covers underflow. Where margins are huge or edge functions not finite, nothing is sure.
//!
//! A lane is beside the triangle if one edge function is below and another above the margin. If all are on one side of it,
//! the definition accepts the hit as far as its place in the triangle goes: no edge function is zero, the true determinant is at
//! least `2⁻¹⁹·Z·(M + 2⁻²²·Z)`, and since `S ≤ 6M²` the bound `S·M ≤ 2²⁹·X·|det|` holds with room to spare.
//!
//! # Distances
//!
//! `t` is the mean of the depths weighted by the edge functions, over the direction's component. Errors of the weights
//! move it by at most `Σ|δ|·span/|det|`, where `span` is the range of depths and each `|δ|` at most 52/128 of the margin, together
//! less than 1.25 margins; sums, products and
//! quotients by at most `2⁻²⁰` of the largest depth, which includes the last rounding of the true `t`; and products that
//! underflow by less than [`SMALLEST_MARGIN`] over the determinant.

use fearless_simd::{Simd, SimdFloat, prelude::*};

/// Margin of edge functions, in units of `Z·M`.
const EDGE_MARGIN: f32 = 1.0 / (1 << 17) as f32;
/// `M` counts as at least this many `Z` in the margin.
const LATERAL_FLOOR: f32 = 1.0 / (1 << 22) as f32;
/// Added to margins for products that underflow.
const SMALLEST_MARGIN: f32 = 1.0e-37;
/// With smaller margins nothing is sure: edge functions times depths may underflow.
const SMALLEST_SURE_MARGIN: f32 = 1.0e-25;
/// With larger margins nothing is sure.
const LARGEST_MARGIN: f32 = 1.0e30;
/// Larger determinants count as not finite.
const LARGEST_DETERMINANT: f32 = 1.0e37;
/// Rounding errors of a distance, in units of the largest depth.
const DEPTH_ERROR: f32 = 1.0 / (1 << 20) as f32;
/// The largest shear that the margins allow for.
pub(super) const LARGEST_SHEAR: f32 = 2.0;

/// A corner relative to the ray's origin, sheared: two lateral coordinates and the depth.
pub(super) type Corner<V> = [V; 3];

/// What the edge functions tell of all lanes.
pub(super) struct Edges<V> {
    /// Lanes that are not beside the triangle.
    pub(super) possible: u32,
    /// Lanes inside the triangle beyond doubt.
    pub(super) sure: u32,
    functions: [V; 3],
    det: V,
    margin: V,
    largest_depth: V,
}

/// Bounds of the ray parameter of the hits that are sure.
pub(super) struct Distances<V> {
    /// No hit is nearer.
    pub(super) near: V,
    /// No hit is farther.
    pub(super) far: V,
}

#[inline(always)]
fn bits<S: Simd>(mask: impl SimdMask<S>) -> u32 {
    mask.to_bitmask() as u32
}

impl<V> Edges<V> {
    /// Evaluates the edge functions of the triangles `[a, b, c]`.
    #[inline(always)]
    pub(super) fn new<S: Simd>([a, b, c]: [Corner<V>; 3]) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let det = u + v + w;

        let lateral_a = a[0].abs().max(a[1].abs());
        let lateral_b = b[0].abs().max(b[1].abs());
        let lateral_c = c[0].abs().max(c[1].abs());
        let lateral = lateral_a.max(lateral_b).max(lateral_c);
        let largest_depth = a[2].abs().max(b[2].abs()).max(c[2].abs());
        let depth = lateral + largest_depth;
        let margin = (lateral + depth * LATERAL_FLOOR) * (depth * EDGE_MARGIN) + SMALLEST_MARGIN;

        let lowest = u.min(v).min(w);
        let highest = u.max(v).max(w);
        let finite = margin.simd_lt(LARGEST_MARGIN) & det.abs().simd_lt(LARGEST_DETERMINANT);
        let below = lowest.simd_lt(-margin);
        let above = highest.simd_gt(margin);
        let beside = below & above & finite;
        let inside = (lowest.simd_gt(margin) | highest.simd_lt(-margin))
            & finite
            & margin.simd_gt(SMALLEST_SURE_MARGIN);
        Self { possible: !bits(beside), sure: bits(inside), functions: [u, v, w], det, margin, largest_depth }
    }

    /// Lanes that meet the back of the triangle, if they are sure.
    #[inline(always)]
    pub(super) fn back<S: Simd>(&self) -> u32
    where
        V: SimdFloat<S, Element = f32>,
    {
        bits(self.det.simd_lt(0.0))
    }

    /// Where the sure hits are; `reciprocal` is one over the direction's component along the depth.
    #[inline(always)]
    pub(super) fn distances<S: Simd>(&self, simd: S, depths: [V; 3], reciprocal: V) -> Distances<V>
    where
        V: SimdFloat<S, Element = f32>,
    {
        let [u, v, w] = self.functions;
        let [a, b, c] = depths;
        let span = a.max(b).max(c) - a.min(b).min(c);
        let one_over_det = V::splat(simd, 1.0) / self.det;
        let t = (u * a + v * b + w * c) * one_over_det * reciprocal;
        let weights = self.margin * 1.25 * span * one_over_det.abs();
        let underflow = one_over_det.abs() * SMALLEST_MARGIN;
        let error = (weights + self.largest_depth * DEPTH_ERROR + underflow) * reciprocal.abs();
        Distances { near: t - error, far: t + error }
    }
}
