//! Directions towards the bright parts of an environment.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::cell_grid::CellGrid;
use crate::geometry::DirectionSample;

/// Cells are averaged over this many directions along each axis.
const DIRECTIONS_PER_AXIS: u32 = 3;

/// Guides are short, so that those of all rows stay in the cache; the sums of as many intervals are in one or two lines of it.
const INTERVALS_PER_PART: usize = 8;

/// Less than this share of the environment's power above its mean is a rounding error.
const LEAST_SHARE: f64 = 1e-6;

/// A piecewise constant density over the sphere, proportional to what an environment's radiance exceeds its mean by.
///
/// Cells are those of an equirectangular image (+Y up, -Z in the centre). The density covers only what is worth the samples beside
/// those of the BSDF: MIS compensation (Karlík, Šik, Vévoda, Skřivan and Křivánek, "MIS Compensation: Optimizing Sampling
/// Techniques in Multiple Importance Sampling", 2019, section 5). It is zero where the radiance is at or below the mean, and
/// everywhere if the environment is uniform: an estimator needs a second technique, one that reaches all directions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EnvironmentDistribution {
    grid: CellGrid,
    /// Prefix sums of the rows' probabilities, from 0 to 1; empty if there is nothing to sample.
    row_sums: Vec<f32>,
    row_guide: Vec<u32>,
    /// For each row, prefix sums of its cells' probabilities, from 0 to 1.
    cell_sums: Vec<f32>,
    cell_guides: Vec<u32>,
}

impl EnvironmentDistribution {
    /// The distribution of `rows` × `columns` cells, at least one of each. `radiance` is the luminance from a unit direction.
    pub(super) fn of(rows: u32, columns: u32, radiance: impl Fn(Vec3) -> f32) -> Self {
        let (rows, columns) = (rows.max(1), columns.max(1));
        Self::new(columns, mean_radiances(rows, columns, radiance))
    }

    /// The distribution of cells of a mean luminance each, row-major from the top.
    pub(super) fn new(columns: u32, mut cells: Vec<f32>) -> Self {
        let rows = cells.len() as u32 / columns;
        let grid = CellGrid::new(rows, columns);

        // Subtract the mean.
        let solid_angles: Vec<f64> =
            (0..grid.rows()).map(|row| grid.cosines(row) / (2.0 * f64::from(columns))).collect();
        let columns = columns as usize;
        let power = |cells: &[f32]| -> f64 {
            let row_sum = |row: &[f32]| row.iter().map(|&cell| f64::from(cell)).sum::<f64>();
            cells
                .chunks(columns)
                .zip(&solid_angles)
                .map(|(row, solid_angle)| row_sum(row) * solid_angle)
                .sum()
        };
        let mean = power(&cells);
        for cell in &mut cells {
            *cell = (*cell - mean as f32).max(0.0);
        }
        if !(mean > 0.0 && power(&cells) > LEAST_SHARE * mean) {
            let (row_sums, row_guide, cell_sums, cell_guides) = Default::default();
            return Self { grid, row_sums, row_guide, cell_sums, cell_guides };
        }

        // Sum the cells of each row, then the rows.
        let mut cell_sums = vec![0.0; (columns + 1) * rows as usize];
        let sums = cell_sums.chunks_mut(columns + 1).zip(cells.chunks(columns));
        let totals: Vec<f64> =
            sums.map(|(sums, row)| prefix_sums(row.iter().map(|&cell| f64::from(cell)), sums)).collect();
        let mut row_sums = vec![0.0; rows as usize + 1];
        prefix_sums(
            totals.iter().zip(&solid_angles).map(|(total, solid_angle)| total * solid_angle),
            &mut row_sums,
        );
        let row_guide = guide(&row_sums).collect();
        let cell_guides = cell_sums.chunks(columns + 1).flat_map(guide).collect();
        Self { grid, row_sums, row_guide, cell_sums, cell_guides }
    }

    /// Samples a direction; `None` if the environment is uniform or black.
    pub(super) fn sample(&self, u: Vec2) -> Option<DirectionSample> {
        if self.row_sums.is_empty() {
            return None;
        }
        let (row, v) = invert(&self.row_sums, &self.row_guide, u.y);
        let guide_length = guide_length(self.grid.columns());
        let guide = &self.cell_guides[row * guide_length..][..guide_length];
        let (column, u) = invert(self.cell_sums(row), guide, u.x);
        let direction = self.grid.direction_inside((row, column), u, v);
        Some(DirectionSample { direction, pdf: self.density(row, column) })
    }

    /// The density of a unit direction by solid angle.
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        if self.row_sums.is_empty() {
            return 0.0;
        }
        let (row, column) = self.grid.cell(direction);
        self.density(row, column)
    }

    fn cell_sums(&self, row: usize) -> &[f32] {
        let columns = self.grid.columns();
        &self.cell_sums[row * (columns + 1)..][..=columns]
    }

    /// The density in a cell: its probability by its solid angle.
    fn density(&self, row: usize, column: usize) -> f32 {
        let cells = self.cell_sums(row);
        let row_probability = self.row_sums[row + 1] - self.row_sums[row];
        let cell_probability = cells[column + 1] - cells[column];
        let cosines = self.grid.cosines(row) as f32;
        row_probability * cell_probability * self.grid.columns() as f32 / (TAU * cosines)
    }
}

/// Mean radiances of all cells, row by row.
pub(super) fn mean_radiances(rows: u32, columns: u32, radiance: impl Fn(Vec3) -> f32) -> Vec<f32> {
    let grid = CellGrid::new(rows, columns);
    let position = |index: u32| (index as f32 + 0.5) / DIRECTIONS_PER_AXIS as f32;
    let places = || (0..DIRECTIONS_PER_AXIS).flat_map(|i| (0..DIRECTIONS_PER_AXIS).map(move |j| (i, j)));
    let mean = |cell: (usize, usize)| {
        let values = places().map(|(i, j)| {
            let value = radiance(grid.direction(cell, position(i), position(j)));
            if value > 0.0 { value.min(f32::MAX / 16.0) } else { 0.0 }
        });
        values.sum::<f32>() / (DIRECTIONS_PER_AXIS * DIRECTIONS_PER_AXIS) as f32
    };
    (0..grid.rows()).flat_map(|row| (0..grid.columns()).map(move |column| (row, column))).map(mean).collect()
}

/// Stores the prefix sums of `values` by their total, from 0 to 1, and returns the total; stores zeros if that is zero.
pub(crate) fn prefix_sums(values: impl Iterator<Item = f64> + Clone, sums: &mut [f32]) -> f64 {
    let total: f64 = values.clone().sum();
    sums.fill(0.0);
    if total > 0.0 {
        let mut sum = 0.0;
        for (stored, value) in sums[1..].iter_mut().zip(values) {
            sum += value;
            *stored = (sum / total).min(1.0) as f32;
        }
    }
    total
}

/// For equal parts of the unit interval, one for [`INTERVALS_PER_PART`] intervals of prefix sums: the interval that holds the part's lower
/// end (Chen and Asau, "On Generating Random Variates from an Empirical Distribution", 1974).
fn guide(sums: &[f32]) -> impl Iterator<Item = u32> + '_ {
    let last = sums.len() - 2;
    let parts = guide_length(sums.len() - 1);
    let mut index = 0;
    (0..parts).map(move |part| {
        while index < last && sums[index + 1] <= part as f32 / parts as f32 {
            index += 1;
        }
        index as u32
    })
}

/// Number of parts of a guide to so many intervals.
fn guide_length(intervals: usize) -> usize {
    intervals.div_ceil(INTERVALS_PER_PART)
}

/// The interval of prefix sums that holds `u`, a number in [0, 1), and the position of `u` in it. It is never an empty one.
fn invert(sums: &[f32], guide: &[u32], u: f32) -> (usize, f32) {
    let part = (u * guide.len() as f32) as usize;
    let mut index = guide[part.min(guide.len() - 1)] as usize;
    let last = sums.len() - 2;
    // The part's lower end may be rounded up.
    while index > 0 && sums[index] > u {
        index -= 1;
    }
    while index < last && sums[index + 1] <= u {
        index += 1;
    }
    let position = (u - sums[index]) / (sums[index + 1] - sums[index]);
    (index, position)
}

#[cfg(test)]
mod tests;
