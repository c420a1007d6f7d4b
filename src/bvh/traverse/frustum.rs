//! Frustum that bounds all rays of a packet: ranges of origins and of slopes along the depth axis.
//!
//! Interval arithmetic: Reshetov, Soupikov, Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005. Departure: it tests
//! eight boxes at once. Where a box spans the depths `[d₀, d₁]`, measured from the nearest and farthest origin, the lateral
//! coordinates of the rays lie between `min o + min(s·d₀, s·d₁)` with the least slope and the same maximum with the largest.
//!
//! Slopes are widened by 2⁻¹⁹ of themselves and boxes by 2⁻²⁰ of the largest origin coordinate. The latter is twice the
//! padding that the definition of a hit requires. Together they cover some four roundings of each step.

use fearless_simd::{Simd, f32x8, f32x16, prelude::*};

use super::packet::{LANES, Packet};
use crate::bvh::wide_tree::{WIDTH, WideNode};
use crate::geometry::BOX_PADDING;

/// Relative widening of slopes.
const SLOPE_SLACK: f32 = 1.0 / (1 << 19) as f32;
/// Factor of entry distances before they are compared with exit distances. Relative to itself, a distance is off by three roundings, of the
/// reciprocal, the fused operation and `t`; this factor covers 32. The product of origin and reciprocal is off by a rounding of the
/// origin, which [`Frustum::padding`] covers.
pub(super) const ENTRY_SLACK: f32 = 1.0 - 1.0 / (1 << 19) as f32;

/// Bounds of the rays of a packet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frustum {
    axes: [usize; 3],
    /// Whether the depth grows towards smaller coordinates.
    backward: bool,
    /// Lowest and highest origin coordinates.
    origin: [[f32; 3]; 2],
    /// Least and largest lateral movement per unit of depth.
    slope: [[f32; 2]; 2],
    /// Least ray parameter per unit of each axis; zero where rays run both ways.
    rate: [f32; 3],
    /// How the rays run along each axis.
    pub(super) sense: [Sense; 3],
    /// Length by which boxes are grown.
    pub(super) padding: f32,
}

/// How the rays of a packet run along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sense {
    /// All towards larger coordinates.
    Rising,
    /// All towards smaller coordinates.
    Falling,
    /// Both ways.
    Mixed,
}

/// Eight boxes by plane: min x, y, z, max x, y, z.
pub(super) type Planes = [[f32; WIDTH]; 6];

/// Boxes that some rays may enter.
pub(super) struct EnteredBoxes {
    /// One bit per box.
    pub(super) mask: u32,
    /// Lower bounds of the entry distances of all rays.
    pub(super) distances: [f32; WIDTH],
}

impl Frustum {
    /// Bounds of no rays.
    const EMPTY: Self = Self {
        axes: [0, 1, 2],
        backward: false,
        origin: [[0.0; 3]; 2],
        slope: [[0.0; 2]; 2],
        rate: [0.0; 3],
        sense: [Sense::Mixed; 3],
        padding: 0.0,
    };

    /// Bounds of the rays of a packet that is filled.
    #[inline(always)]
    pub(super) fn around<S: Simd>(simd: S, packet: &Packet) -> Self {
        let kz = packet.axes[2];
        let backward = packet.reciprocal[kz][0][0] < 0.0;
        let mut frustum = Self { axes: packet.axes, backward, ..Self::EMPTY };
        let mut largest = 0.0_f32;
        let used = packet.vectors();
        for axis in 0..3 {
            let [low, high] = range(simd, &packet.origin[axis][..used]);
            frustum.origin[0][axis] = low;
            frustum.origin[1][axis] = high;
            largest = largest.max(-low).max(high);
            let [low, high] = range(simd, &packet.reciprocal[axis][..used]);
            (frustum.sense[axis], frustum.rate[axis]) = if low > 0.0 {
                (Sense::Rising, low)
            } else if high < 0.0 {
                (Sense::Falling, -high)
            } else {
                (Sense::Mixed, 0.0)
            };
        }
        frustum.padding = largest * (2.0 * BOX_PADDING);
        for lateral in 0..2 {
            let [low, high] = range(simd, &packet.shear[lateral][..used]);
            let [low, high] = if backward { [-high, -low] } else { [low, high] };
            frustum.slope[0][lateral] = low - low.abs() * SLOPE_SLACK;
            frustum.slope[1][lateral] = high + high.abs() * SLOPE_SLACK;
        }
        frustum
    }

    /// Whether all rays start at one point.
    pub(super) fn has_one_origin(&self) -> bool {
        self.origin[0] == self.origin[1]
    }

    /// Largest lateral range of the rays at one unit of depth from their origins.
    pub(super) fn spread(&self) -> f32 {
        (self.slope[1][0] - self.slope[0][0]).max(self.slope[1][1] - self.slope[0][1])
    }

    /// Children of a node that any ray may enter at or before `upper`.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, node: &WideNode, upper: f32) -> EnteredBoxes {
        self.enter_boxes(simd, &node.planes, upper)
    }

    /// Boxes that any ray may enter at or before `upper`.
    #[inline(always)]
    pub(super) fn enter_boxes<S: Simd>(&self, simd: S, planes: &Planes, upper: f32) -> EnteredBoxes {
        let kz = self.axes[2];
        let zero = f32x8::splat(simd, 0.0);
        // Depths at which the boxes begin, from the nearest origin, and end, from the farthest.
        let (begin, end) = if self.backward {
            let nearest = f32x8::splat(simd, self.origin[0][kz] - self.padding);
            let farthest = f32x8::splat(simd, self.origin[1][kz] + self.padding);
            (nearest - load(simd, planes, 3 + kz), farthest - load(simd, planes, kz))
        } else {
            let nearest = self.origin[1][kz] + self.padding;
            let farthest = self.origin[0][kz] - self.padding;
            (load(simd, planes, kz) - nearest, load(simd, planes, 3 + kz) - farthest)
        };
        let begin = begin.max(zero);
        let (beside_x, entry_x) = self.lateral(simd, planes, 0, begin, end);
        let (beside_y, entry_y) = self.lateral(simd, planes, 1, begin, end);
        let entry = (begin * self.rate[kz]).max(entry_x).max(entry_y);
        let hit = end.simd_ge(zero)
            & beside_x
            & beside_y
            & (entry * ENTRY_SLACK).simd_le(f32x8::splat(simd, upper));
        EnteredBoxes { mask: hit.to_bitmask() as u32, distances: entry.into() }
    }

    /// Boxes that overlap the rays along one lateral axis, and the least ray parameter there.
    #[inline(always)]
    fn lateral<S: Simd>(
        &self,
        simd: S,
        planes: &Planes,
        lateral: usize,
        begin: f32x8<S>,
        end: f32x8<S>,
    ) -> (fearless_simd::mask32x8<S>, f32x8<S>) {
        let axis = self.axes[lateral];
        let (low, high) = (load(simd, planes, axis), load(simd, planes, 3 + axis));
        let (least, largest) = (self.slope[0][lateral], self.slope[1][lateral]);
        let lowest_origin = self.origin[0][axis] - self.padding;
        let highest_origin = self.origin[1][axis] + self.padding;
        let lowest = if least < 0.0 { end } else { begin } * least + lowest_origin;
        let highest = if largest > 0.0 { end } else { begin } * largest + highest_origin;
        let overlap = low.simd_le(highest) & high.simd_ge(lowest);
        let ahead = if self.sense[axis] == Sense::Falling {
            f32x8::splat(simd, lowest_origin) - high
        } else {
            low - highest_origin
        };
        (overlap, ahead * self.rate[axis])
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, planes: &Planes, plane: usize) -> f32x8<S> {
    f32x8::load_array_ref(simd, &planes[plane])
}

/// Least and largest number of the rows.
#[inline(always)]
fn range<S: Simd>(simd: S, rows: &[[f32; LANES]]) -> [f32; 2] {
    let mut low = f32x16::load_array_ref(simd, &rows[0]);
    let mut high = low;
    for lanes in &rows[1..] {
        let lanes = f32x16::load_array_ref(simd, lanes);
        low = low.min(lanes);
        high = high.max(lanes);
    }
    [low.reduce_min(), high.reduce_max()]
}
