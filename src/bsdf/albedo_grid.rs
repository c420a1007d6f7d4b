//! The grid that all tables of GGX albedos share, and bilinear interpolation on it.
//!
//! Rows are even in the root of the roughness, columns in a blend of √cos θ and √cos θ / (√cos θ + √α): the first resolves the
//! Fresnel curve, the second masking, whose scale is α. So albedos bend little within a cell, and looking one up takes two roots and
//! a division.

use glam::Vec4;

use crate::geometry::{F32Lanes, LANES};

/// Rows of roughness.
pub(super) const ROWS: usize = 49;
/// Columns of the view's elevation; an odd number has a middle column.
pub(super) const COLUMNS: usize = 97;
/// Roughness of the first row, which stands for 0; the integrals need a finite α.
const MIN_ROUGHNESS: f32 = 1e-4;
/// Part of √cos θ in the columns.
const EVEN: f32 = 0.5;

/// A cell of the grid with the position in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// The grid point of the lowest row and column.
    first: i32,
    /// Weights of that point, the next in its row, and both in the next row.
    weights: [f32; 4],
}

impl Cell {
    /// The cell of a lobe of `roughness` and a column from 0 to 1.
    #[inline(always)]
    pub(super) fn at(roughness: f32, column: f32) -> Self {
        let (row, down) = interval(roughness.sqrt(), ROWS);
        let (column, right) = interval(column, COLUMNS);
        let (up, left) = (1.0 - down, 1.0 - right);
        Self {
            first: row * COLUMNS as i32 + column,
            weights: [up * left, up * right, down * left, down * right],
        }
    }

    /// The cell of a view.
    #[inline(always)]
    pub(super) fn of_view(cos_o: f32, roughness: f32) -> Self {
        Self::at(roughness, column(cos_o, roughness))
    }

    /// Interpolates several values of the four grid points.
    #[inline(always)]
    pub(super) fn interpolate<T, const N: usize>(
        &self,
        points: &[T],
        values: impl Fn(&T) -> [f32; N],
    ) -> [f32; N] {
        let (first, weights) = (self.first as usize, self.weights);
        let (upper, lower) = (&points[first..first + 2], &points[first + COLUMNS..first + COLUMNS + 2]);
        let taps = [&upper[0], &upper[1], &lower[0], &lower[1]].map(values);
        std::array::from_fn(|at| {
            (taps[0][at] * weights[0] + taps[1][at] * weights[1])
                + (taps[2][at] * weights[2] + taps[3][at] * weights[3])
        })
    }
}

/// The cells of a block of views.
#[derive(Debug, Default)]
pub(super) struct CellLanes {
    first: [i32; LANES],
    weights: [F32Lanes; 4],
}

impl CellLanes {
    /// The cells of [`Cell::of_view`].
    #[inline(always)]
    pub(super) fn locate(&mut self, cos_o: &F32Lanes, roughness: &F32Lanes) {
        for lane in 0..LANES {
            let Cell { first, weights } = Cell::of_view(cos_o[lane].clamp(0.0, 1.0), roughness[lane]);
            self.first[lane] = first;
            for (lanes, weight) in self.weights.iter_mut().zip(weights) {
                lanes[lane] = weight;
            }
        }
    }

    /// Interpolates the four grid points around a lane's position.
    #[inline(always)]
    pub(super) fn interpolate(&self, lane: usize, points: &[Vec4]) -> Vec4 {
        let first = self.first[lane] as usize;
        let (Some([a, b]), Some([c, d])) =
            (points.get(first..first + 2), points.get(first + COLUMNS..first + COLUMNS + 2))
        else {
            return Vec4::ZERO;
        };
        let [upper_left, upper_right, lower_left, lower_right] =
            [0, 1, 2, 3].map(|at| self.weights[at][lane]);
        (*a * upper_left + *b * upper_right) + (*c * lower_left + *d * lower_right)
    }
}

/// Roughness of a row.
pub(super) fn roughness_of(row: usize) -> f32 {
    let root = row as f32 / (ROWS - 1) as f32;
    let roughness = root * root;
    if roughness > MIN_ROUGHNESS { roughness } else { MIN_ROUGHNESS }
}

/// Column of a view, 0 to 1.
#[inline(always)]
pub(super) fn column(cos_o: f32, roughness: f32) -> f32 {
    let root = cos_o.sqrt();
    root * EVEN + root * (1.0 + roughness) / (root + roughness) * (1.0 - EVEN)
}

/// The cosine whose column is `own`, by bisection of a rising function.
pub(super) fn cosine_of(own: f32, column: impl Fn(f32) -> f32) -> f32 {
    let (mut low, mut high) = (0.0_f32, 1.0_f32);
    for _ in 0..60 {
        let middle = f32::midpoint(low, high);
        if column(middle) < own { low = middle } else { high = middle }
    }
    f32::midpoint(low, high)
}

/// The cosine of a column of [`Cell::of_view`].
pub(super) fn view_of(own: usize, roughness: f32) -> f32 {
    cosine_of(own as f32 / (COLUMNS - 1) as f32, |cosine| column(cosine, roughness))
}

/// `value(row, column)` at every `step`th grid point, row by row.
pub(super) fn grid_points<T>(step: usize, value: impl Fn(usize, usize) -> T) -> Vec<T> {
    (0..ROWS * COLUMNS).step_by(step).map(|point| value(point / COLUMNS, point % COLUMNS)).collect()
}

/// The interval of `x`, from 0 to 1, between even steps, and the position in it.
#[inline(always)]
fn interval(x: f32, steps: usize) -> (i32, f32) {
    let (last, position) = (steps as i32 - 1, x * (steps - 1) as f32);
    let below = (position as i32).clamp(0, last - 1);
    (below, position - below as f32)
}
