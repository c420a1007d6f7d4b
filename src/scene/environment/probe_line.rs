//! What a filtered lookup reads of an equirectangular image: probes of one width on a line, by the differentials of a ray.

use std::f32::consts::PI;

use fearless_simd::Level;
use glam::Vec3;

use crate::geometry::{F32Lanes, LANES, Vec3Lanes, vectorized};
use crate::scene::{MAX_PROBES, PROBE_SPACING};

/// The probes of a lookup.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbeLine {
    /// The long axis of the ellipse that the differentials span, on which the probes lie.
    long_axis: Vec3,
    /// Width of a probe, in rows of the image; at least one, and infinite for the mean of the image.
    pub(super) width: f32,
    /// Number of probes, from 1 to [`MAX_PROBES`].
    pub(super) probes: f32,
}

impl ProbeLine {
    /// The probes of differentials in an image whose rows are `row` radians high.
    ///
    /// All cases are computed and one is selected, without branches: [`ProbeLines`] computes blocks of them by this function.
    #[inline(always)]
    pub(super) fn new(row: f32, [a, b]: [Vec3; 2]) -> Self {
        let (aa, bb, ab) = (a.dot(a), b.dot(b), a.dot(b));
        // The squares of both axes of the ellipse have the same sum.
        let is_narrow = aa + bb <= row * row;
        let half_difference = (aa - bb) * 0.5;
        let root = (half_difference * half_difference + ab * ab).sqrt();
        let long = ((aa + bb) * 0.5 + root).sqrt();
        // Not so for a half-space and more, or not a number
        let is_bounded = long < PI;
        let axis = if half_difference >= 0.0 {
            a * (half_difference + root) + b * ab
        } else {
            a * ab + b * (root - half_difference)
        };
        let least = long / (MAX_PROBES as f32 * PROBE_SPACING);
        let short = larger(larger(a.cross(b).dot(a.cross(b)).sqrt() / long, least), row);
        let probes = (long / (short * PROBE_SPACING) - 0.1).ceil();
        let [probes, width] = if is_bounded { [probes, short / row] } else { [1.0, f32::INFINITY] };
        let [probes, width] = if is_narrow { [1.0, 1.0] } else { [probes, width] };
        // A null vector has no axis.
        let inverse = 1.0 / axis.dot(axis).sqrt();
        let inverse = if inverse < f32::INFINITY { inverse } else { 0.0 };
        Self { long_axis: axis * inverse * long, width, probes: if probes > 1.0 { probes } else { 1.0 } }
    }

    /// Where a probe of a lookup around a unit direction lies: a direction of any length.
    #[inline(always)]
    pub(super) fn probe(&self, direction: Vec3, index: u32) -> Vec3 {
        direction + self.long_axis * ((index as f32 + 0.5) / self.probes - 0.5)
    }
}

/// The probes of a block of lookups.
#[derive(Debug, Default)]
pub(super) struct ProbeLines {
    long_axis: Vec3Lanes,
    width: F32Lanes,
    probes: F32Lanes,
}

impl ProbeLines {
    /// [`ProbeLine::new`] of each lane, by the instruction set `level`.
    pub(super) fn fill(&mut self, level: Level, row: f32, differentials: &[Vec3Lanes; 2]) {
        vectorized!(level, {
            for lane in 0..LANES {
                let [a, b] = differentials;
                let ProbeLine { long_axis, width, probes } = ProbeLine::new(row, [a.get(lane), b.get(lane)]);
                self.long_axis.set(lane, long_axis);
                self.width[lane] = width;
                self.probes[lane] = probes;
            }
        });
    }

    /// The probes of a lane.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> ProbeLine {
        ProbeLine { long_axis: self.long_axis.get(lane), width: self.width[lane], probes: self.probes[lane] }
    }
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
