//! Albedos under the exact Fresnel curve at even steps of the index of refraction, interpolated by cubics.
//!
//! The scale is ln((n − 1) / 2), n being the larger index over the smaller one: near 1 the curve scales with √(n² − 1), far above 1
//! with n, so each step moves it by the same factor.

use super::albedo_grid::Cell;
use super::cubic_table::nearest_four;
use super::stored_values::{UNIT, decoded};

/// Number of indices.
pub(super) const PLANES: usize = 21;
const STEP: f32 = 0.4;
/// ln((n − 1) / 2) of the first index, such that 1.5, the index of most materials, is in the table.
const FIRST: f32 = -1.386_294_4 - 10.0 * STEP;
/// Indices of the first and the last plane.
pub(super) const FIRST_IOR: f32 = 1.009_157_8;
/// See [`FIRST_IOR`].
pub(super) const LAST_IOR: f32 = 28.299_075;

/// A position between the planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct IndexPosition {
    /// The first of four planes.
    plane: usize,
    weights: [f32; 4],
}

impl IndexPosition {
    /// The position of an index above 1; of the nearest one in the tables.
    pub(super) fn new(ior: f32) -> Self {
        let (plane, weights) = nearest_four(steps_to(ior), PLANES);
        Self { plane, weights: weights.map(|weight| weight * UNIT) }
    }

    /// Interpolates a stored table at a cell.
    pub(super) fn interpolate(&self, stored: &[u8], cell: &Cell) -> f32 {
        let (points, _) = stored.as_chunks::<{ 2 * PLANES }>();
        let [value] = cell.interpolate(points, |point| [self.weighted(point)]);
        value
    }

    /// The value of a stored table at a grid point.
    pub(super) fn at_point(&self, stored: &[u8], point: usize) -> f32 {
        let (points, _) = stored.as_chunks::<{ 2 * PLANES }>();
        self.weighted(&points[point])
    }

    /// The cubic through the values of four planes.
    #[inline(always)]
    fn weighted(&self, point: &[u8; 2 * PLANES]) -> f32 {
        let values: [f32; 4] = point[2 * self.plane..].first_chunk::<8>().map_or([0.0; 4], decoded);
        let [a, b, c, d] = self.weights;
        (values[0] * a + values[1] * b) + (values[2] * c + values[3] * d)
    }
}

/// Steps from the first plane to an index above 1, up to the last plane.
pub(super) fn steps_to(ior: f32) -> f32 {
    let steps = (libm::logf(0.5 * (ior - 1.0)) - FIRST) / STEP;
    steps.clamp(0.0, (PLANES - 1) as f32)
}

/// The index so many steps from the first plane.
pub(super) fn ior_after(steps: f32) -> f32 {
    1.0 + 2.0 * libm::expf(FIRST + STEP * steps)
}

/// The index of a plane.
pub(super) fn ior_of(plane: usize) -> f32 {
    ior_after(plane as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_planes_reach_from_the_first_to_the_last_index() {
        assert!((ior_of(0) - FIRST_IOR).abs() < 1e-6 && (ior_of(PLANES - 1) - LAST_IOR).abs() < 1e-4);
        assert!((ior_of(10) - 1.5).abs() < 1e-6);
    }
}
