//! Eight boxes or eight triangles at once: the only lane code of the room, in plain Rust and in AVX2.
//!
//! Kernels find candidates and err towards visiting; what a hit is, is decided by [`crate::geometry::ShearedRay`]. Both
//! levels do the same operations in the same order (no fused ones), so that they find the same candidates.
//!
//! # Boxes
//!
//! Source: the slab test with a widened far distance is Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Here entry
//! distances are shortened and exit distances lengthened by [`SLACK`], more than twice the relative error of a
//! difference, a reciprocal, two products and the rounding of `t`; and the origin is moved outward by
//! [`BOX_PADDING`] of its largest coordinate, as the definition of a hit asks. The direction is scaled by a power
//! of two so that its largest component is in [1, 2), and its other components are not taken smaller than 2⁻³⁰:
//! within the scene this moves the ray by less than the padding, and no distance is 0·∞.
//!
//! # Triangles
//!
//! The edge functions of the definition in `f32`. With `u = 2⁻²⁴`, `M` the largest lateral coordinate after the shear
//! and `Z` a bound of all coordinates before it, a lateral coordinate is off by at most `8uZ` and an edge function
//! by at most `4·8uZ·M + 2·(8uZ)² + 4uM²`, where `M ≤ 2Z`. A triangle is passed over only if one edge function is below
//! and another above the margin `2⁻¹⁸·Z·(M + 2⁻²²·Z)`, which is larger by half; a tiny constant covers underflow, and
//! huge margins, where a product may have overflowed, pass nothing over.

#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "AVX2 intrinsics and calls into code compiled for AVX2")]
mod avx2;
#[cfg(test)]
mod tests;

use super::wide::{Triangles, WIDTH, WideNode};
use super::{SimdLevel, TraversalCounters};
use crate::geometry::{BOX_PADDING, Ray, dominant_axes};

/// Relative shortening of entry and lengthening of exit distances.
const SLACK: f32 = 1.0 / (1 << 20) as f32;
/// Smallest direction component, in units of the largest.
const SMALLEST_COMPONENT: f32 = 1.0 / (1 << 30) as f32;
/// Margin of edge functions, in units of `Z·M`.
const EDGE_MARGIN: f32 = 1.0 / (1 << 18) as f32;
/// `M` counts as at least this many `Z` in the margin.
const LATERAL_FLOOR: f32 = 1.0 / (1 << 22) as f32;
/// Margins above this pass nothing over.
const LARGEST_MARGIN: f32 = 1.0e30;
/// Added to margins for products that underflow.
const SMALLEST_MARGIN: f32 = 1.0e-37;

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
}

/// Children of a node that a ray enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entered {
    /// One bit a child.
    pub(super) mask: u32,
    /// Where, in units of [`LaneRay::scale`]; not negative.
    pub(super) distances: [f32; WIDTH],
}

/// The kernels of one instruction set.
pub(super) trait Lanes {
    /// Which children are entered at or before `upper`.
    fn enter(node: &WideNode, ray: &LaneRay, upper: f32) -> Entered;
    /// Which triangles of a pack may be hit, one bit each.
    fn candidates(pack: &Triangles<'_>, ray: &LaneRay) -> u32;
}

/// A computation that is compiled once a level; implementations are `#[inline(always)]`.
pub(super) trait LaneTask {
    /// What it returns.
    type Output;
    /// Runs it.
    fn run<L: Lanes>(self, counters: &mut TraversalCounters) -> Self::Output;
}

impl LaneRay {
    /// Prepares `ray`; box distances below `lower` (in `t`) are of no interest.
    pub(super) fn new(ray: &Ray, lower: f32) -> Self {
        let axes = dominant_axes(ray.direction);
        let largest = ray.direction[axes[2]].abs();
        // The power of two at or below the largest component, by its exponent bits, and its reciprocal.
        let exponent = (largest.to_bits() >> 23).clamp(1, 253);
        let scale = f32::from_bits(exponent << 23);
        let direction = ray.direction * f32::from_bits((254 - exponent) << 23);

        let padding = ray.origin.abs().max_element() * BOX_PADDING;
        let mut prepared = Self {
            backward: [false; 3],
            near_origin: [0.0; 3],
            far_origin: [0.0; 3],
            near_reciprocal: [0.0; 3],
            far_reciprocal: [0.0; 3],
            scale,
            lower: if lower > 0.0 { lower * scale } else { 0.0 },
            axes,
            origin: ray.origin.to_array(),
            shear: [
                ray.direction[axes[0]] / ray.direction[axes[2]],
                ray.direction[axes[1]] / ray.direction[axes[2]],
            ],
        };
        for axis in 0..3 {
            let backward = direction[axis].is_sign_negative();
            let outward = if backward { -padding } else { padding };
            let component = if direction[axis].abs() >= SMALLEST_COMPONENT {
                direction[axis]
            } else {
                SMALLEST_COMPONENT.copysign(direction[axis])
            };
            prepared.backward[axis] = backward;
            prepared.near_origin[axis] = ray.origin[axis] + outward;
            prepared.far_origin[axis] = ray.origin[axis] - outward;
            prepared.near_reciprocal[axis] = (1.0 / component) * (1.0 - SLACK);
            prepared.far_reciprocal[axis] = (1.0 / component) * (1.0 + SLACK);
        }
        prepared
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
}

/// Plain Rust.
pub(super) struct Scalar;

/// The larger one; `b` if either is not a number.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller one; `b` if either is not a number.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl Lanes for Scalar {
    #[inline(always)]
    fn enter(node: &WideNode, ray: &LaneRay, upper: f32) -> Entered {
        let mut distances = [0.0; WIDTH];
        let mut mask = 0;
        for (lane, distance) in distances.iter_mut().enumerate() {
            let near = |axis: usize| {
                (node.planes[ray.near_plane(axis)][lane] - ray.near_origin[axis]) * ray.near_reciprocal[axis]
            };
            let far = |axis: usize| {
                (node.planes[ray.far_plane(axis)][lane] - ray.far_origin[axis]) * ray.far_reciprocal[axis]
            };
            let entry = larger(larger(near(0), near(1)), larger(near(2), ray.lower));
            let exit = smaller(smaller(far(0), far(1)), smaller(far(2), upper));
            *distance = entry;
            mask |= u32::from(entry <= exit) << lane;
        }
        Entered { mask, distances }
    }

    #[inline(always)]
    fn candidates(pack: &Triangles<'_>, ray: &LaneRay) -> u32 {
        let [kx, ky, kz] = ray.axes;
        let mut mask = 0;
        for lane in 0..WIDTH {
            let corner = |i: usize| {
                let z = pack.lanes(i, kz)[lane] - ray.origin[kz];
                let x = (pack.lanes(i, kx)[lane] - ray.origin[kx]) - ray.shear[0] * z;
                let y = (pack.lanes(i, ky)[lane] - ray.origin[ky]) - ray.shear[1] * z;
                (x, y, z)
            };
            let (ax, ay, az) = corner(0);
            let (bx, by, bz) = corner(1);
            let (cx, cy, cz) = corner(2);
            let u = cx * by - cy * bx;
            let v = ax * cy - ay * cx;
            let w = bx * ay - by * ax;
            let lateral = larger(
                larger(larger(ax.abs(), ay.abs()), larger(bx.abs(), by.abs())),
                larger(cx.abs(), cy.abs()),
            );
            let depth = lateral + larger(larger(az.abs(), bz.abs()), cz.abs());
            let margin = (lateral + depth * LATERAL_FLOOR) * (depth * EDGE_MARGIN) + SMALLEST_MARGIN;
            let outside = smaller(smaller(u, v), w) < -margin
                && larger(larger(u, v), w) > margin
                && margin < LARGEST_MARGIN;
            mask |= u32::from(!outside) << lane;
        }
        mask & ((1 << pack.count()) - 1)
    }
}

impl SimdLevel {
    /// The best level of the machine that runs.
    pub fn best() -> Self {
        if Self::Avx2.is_supported() { Self::Avx2 } else { Self::Scalar }
    }

    /// Whether the machine that runs has this level; queries fall back to [`SimdLevel::Scalar`] where it has not.
    pub fn is_supported(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => std::arch::is_x86_feature_detected!("avx2"),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 => false,
        }
    }
}

/// Runs `task` with the kernels of `level`, or plain ones where the machine lacks it.
#[inline]
pub(super) fn dispatch<T: LaneTask>(
    level: SimdLevel,
    task: T,
    counters: &mut TraversalCounters,
) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if level == SimdLevel::Avx2 && level.is_supported() {
        return avx2::run(task, counters);
    }
    let _ = level;
    task.run::<Scalar>(counters)
}
