//! Boxes of eight triangles at once, none of which is near to being degenerate: nearly all boxes of [`super::references`].
//!
//! The operations are those for a single triangle in their order, so the bits are the same at every level.

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;

use crate::geometry::{Aabb, BOX_PADDING, Triangle, are_clearly_regular};

/// Triangles per group.
pub(super) const LANES: usize = 8;

/// Points by axis.
type Points<S> = [f32x8<S>; 3];

/// Padded boxes of eight triangles.
pub(super) struct LaneBoxes<S: Simd> {
    low: Points<S>,
    high: Points<S>,
}

/// Lane by lane, the boxes around all boxes and around their centres.
pub(super) struct LaneBounds<S: Simd> {
    boxes: LaneBoxes<S>,
    centers: LaneBoxes<S>,
}

impl<S: Simd> LaneBoxes<S> {
    /// Boxes of eight triangles; `None` if one of them may be degenerate.
    #[inline(always)]
    pub(super) fn of(simd: S, triangles: &[Triangle; LANES]) -> Option<Self> {
        let [a, b, c] = corners(simd, triangles);
        if !are_clearly_regular(simd, &[a, b, c]) {
            return None;
        }
        let [mut low, mut high] = [a, a];
        for axis in 0..3 {
            low[axis] = low[axis].min(b[axis]).min(c[axis]);
            high[axis] = high[axis].max(b[axis]).max(c[axis]);
        }
        let mut magnitude = f32x8::splat(simd, 0.0);
        for axis in 0..3 {
            magnitude = magnitude.max(low[axis].abs()).max(high[axis].abs());
        }
        let padding = magnitude * BOX_PADDING + f32::MIN_POSITIVE;
        for axis in 0..3 {
            low[axis] -= padding;
            high[axis] += padding;
        }
        Some(Self { low, high })
    }

    /// Surface areas, square metres.
    #[inline(always)]
    pub(super) fn areas(&self) -> [f32; LANES] {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.low, self.high);
        let (x, y, z) = (x1 - x0, y1 - y0, z1 - z0);
        ((x * y + y * z + z * x) * 2.0).to_array()
    }

    /// The boxes in the order of the triangles.
    #[inline(always)]
    pub(super) fn boxes(&self) -> [Aabb; LANES] {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.low, self.high);
        let (x0, y0, z0) = (x0.to_array(), y0.to_array(), z0.to_array());
        let (x1, y1, z1) = (x1.to_array(), y1.to_array(), z1.to_array());
        let mut boxes = [Aabb::EMPTY; LANES];
        for (lane, bounds) in boxes.iter_mut().enumerate() {
            bounds.min = Vec3::new(x0[lane], y0[lane], z0[lane]);
            bounds.max = Vec3::new(x1[lane], y1[lane], z1[lane]);
        }
        boxes
    }
}

impl<S: Simd> LaneBounds<S> {
    /// Bounds of nothing.
    #[inline(always)]
    pub(super) fn empty(simd: S) -> Self {
        let low = [f32x8::splat(simd, f32::INFINITY); 3];
        let high = [f32x8::splat(simd, f32::NEG_INFINITY); 3];
        Self { boxes: LaneBoxes { low, high }, centers: LaneBoxes { low, high } }
    }

    /// Adds eight boxes.
    #[inline(always)]
    pub(super) fn add(&mut self, boxes: &LaneBoxes<S>) {
        for axis in 0..3 {
            let (low, high) = (boxes.low[axis], boxes.high[axis]);
            self.boxes.low[axis] = self.boxes.low[axis].min(low);
            self.boxes.high[axis] = self.boxes.high[axis].max(high);
            let center = low * 0.5 + high * 0.5;
            self.centers.low[axis] = self.centers.low[axis].min(center);
            self.centers.high[axis] = self.centers.high[axis].max(center);
        }
    }

    /// Box around all boxes, and box around their centres.
    #[inline(always)]
    pub(super) fn total(&self) -> [Aabb; 2] {
        [&self.boxes, &self.centers].map(|lanes| {
            let least = |x: f32x8<S>| x.to_array().into_iter().fold(f32::INFINITY, f32::min);
            let most = |x: f32x8<S>| x.to_array().into_iter().fold(f32::NEG_INFINITY, f32::max);
            Aabb { min: lanes.low.map(least).into(), max: lanes.high.map(most).into() }
        })
    }
}

/// Corners of eight triangles.
#[inline(always)]
fn corners<S: Simd>(simd: S, triangles: &[Triangle; LANES]) -> [Points<S>; 3] {
    let mut rows = [[0.0; LANES]; 9];
    for (lane, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.vertices;
        let numbers = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z];
        for (row, number) in rows.iter_mut().zip(numbers) {
            row[lane] = number;
        }
    }
    let mut corners = [[f32x8::splat(simd, 0.0); 3]; 3];
    for (row, numbers) in rows.iter().enumerate() {
        corners[row / 3][row % 3] = f32x8::from_slice(simd, numbers);
    }
    corners
}
