//! Directions towards the bright parts of an environment.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::arc_tangent::atan2;
use crate::geometry::sin_cos_of_turn;

/// Cells are averaged over this many directions along each axis.
const DIRECTIONS_PER_AXIS: u32 = 3;

/// Guides are short, so that those of all rows stay in the cache; the sums of as many intervals are in one or two lines of it.
const INTERVALS_PER_PART: usize = 8;

/// A bound on the rounding errors of a direction, in widths of cells of images of up to 65536 columns.
const BORDER: f32 = 1.0 / 64.0;

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
    columns: usize,
    /// Prefix sums of the rows' probabilities, from 0 to 1; empty if there is nothing to sample.
    row_sums: Vec<f32>,
    row_guide: Vec<u32>,
    /// For each row, prefix sums of its cells' probabilities, from 0 to 1.
    cell_sums: Vec<f32>,
    cell_guides: Vec<u32>,
    /// Cosines of the rows' polar angles, from 1 to -1.
    row_cosines: Vec<f64>,
}

impl EnvironmentDistribution {
    /// The distribution of `rows` × `columns` cells, at least one of each. `radiance` is the luminance from a unit direction.
    pub(super) fn of(rows: u32, columns: u32, radiance: impl Fn(Vec3) -> f32) -> Self {
        let (rows, columns) = (rows.max(1), columns.max(1));
        Self::new(columns, mean_radiances(rows, columns, &radiance))
    }

    /// The distribution of cells of a mean luminance each, row-major from the top.
    pub(super) fn new(columns: u32, mut cells: Vec<f32>) -> Self {
        let rows = cells.len() as u32 / columns;
        let row_cosines: Vec<f64> = (0..=rows).map(|row| row_cosine(row, rows)).collect();

        // Subtract the mean.
        let solid_angles: Vec<f64> =
            row_cosines.windows(2).map(|edges| (edges[0] - edges[1]) / (2.0 * f64::from(columns))).collect();
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
            return Self { columns, row_sums, row_guide, cell_sums, cell_guides, row_cosines };
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
        Self { columns, row_sums, row_guide, cell_sums, cell_guides, row_cosines }
    }

    /// A unit direction and its density by solid angle; `None` if the environment is uniform or black.
    pub(super) fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        if self.row_sums.is_empty() {
            return None;
        }
        let (row, v) = invert(&self.row_sums, &self.row_guide, u.y);
        let guide_length = guide_length(self.columns);
        let guide = &self.cell_guides[row * guide_length..][..guide_length];
        let (column, u) = invert(self.cell_sums(row), guide, u.x);
        // A direction that is rounded into the next cell is replaced by the cell's central one.
        let sampled = self.direction(row, column, u, v);
        let is_at_border = (u - 0.5).abs().max((v - 0.5).abs()) > 0.5 - BORDER;
        let is_inside = !is_at_border || self.cell(sampled) == (row, column);
        let direction = if is_inside { sampled } else { self.direction(row, column, 0.5, 0.5) };
        Some((direction, self.density(row, column)))
    }

    /// The density of a unit direction by solid angle.
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        if self.row_sums.is_empty() {
            return 0.0;
        }
        let (row, column) = self.cell(direction);
        self.density(row, column)
    }

    fn cell_sums(&self, row: usize) -> &[f32] {
        &self.cell_sums[row * (self.columns + 1)..][..=self.columns]
    }

    /// The density in a cell: its probability by its solid angle.
    fn density(&self, row: usize, column: usize) -> f32 {
        let cells = self.cell_sums(row);
        let row_probability = self.row_sums[row + 1] - self.row_sums[row];
        let cell_probability = cells[column + 1] - cells[column];
        let cosines = (self.row_cosines[row] - self.row_cosines[row + 1]) as f32;
        row_probability * cell_probability * self.columns as f32 / (TAU * cosines)
    }

    /// The direction at (`u`, `v`) of a cell; equal areas are equal solid angles.
    fn direction(&self, row: usize, column: usize, u: f32, v: f32) -> Vec3 {
        let (top, bottom) = (self.row_cosines[row], self.row_cosines[row + 1]);
        let azimuth = (column as f32 + u) * (TAU / self.columns as f32) - PI;
        direction(azimuth, top + (bottom - top) * f64::from(v))
    }

    /// Row and column of a direction.
    fn cell(&self, direction: Vec3) -> (usize, usize) {
        let rows = self.row_sums.len() - 1;
        let horizontal = (direction.x * direction.x + direction.z * direction.z).sqrt();
        let polar = atan2(horizontal, direction.y) / PI;
        let azimuth = atan2(direction.x, -direction.z) / TAU + 0.5;
        let row = (polar * rows as f32) as usize;
        let column = (azimuth * self.columns as f32) as usize;
        (row.min(rows - 1), column.min(self.columns - 1))
    }
}

/// Mean radiances of all cells, row by row.
fn mean_radiances(rows: u32, columns: u32, radiance: &impl Fn(Vec3) -> f32) -> Vec<f32> {
    let position = |index: u32| (index as f32 + 0.5) / DIRECTIONS_PER_AXIS as f32;
    let mut cells = vec![0.0; rows as usize * columns as usize];
    for (row, cells) in (0..rows).zip(cells.chunks_mut(columns as usize)) {
        let (top, bottom) = (row_cosine(row, rows), row_cosine(row + 1, rows));
        for (column, cell) in cells.iter_mut().enumerate() {
            let mut sum = 0.0;
            for (i, j) in (0..DIRECTIONS_PER_AXIS).flat_map(|i| (0..DIRECTIONS_PER_AXIS).map(move |j| (i, j)))
            {
                let azimuth = (column as f32 + position(i)) * (TAU / columns as f32) - PI;
                let value = radiance(direction(azimuth, top + (bottom - top) * f64::from(position(j))));
                sum += if value > 0.0 { value.min(f32::MAX / 16.0) } else { 0.0 };
            }
            *cell = sum / (DIRECTIONS_PER_AXIS * DIRECTIONS_PER_AXIS) as f32;
        }
    }
    cells
}

/// The cosine of the polar angle above a row.
fn row_cosine(row: u32, rows: u32) -> f64 {
    libm::cos(std::f64::consts::PI * f64::from(row) / f64::from(rows))
}

/// The direction of an azimuth from -Z towards +X and of the cosine of the polar angle from +Y.
fn direction(azimuth: f32, cosine: f64) -> Vec3 {
    let horizontal = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt() as f32;
    let (sin, cos) = sin_cos_of_turn(azimuth);
    Vec3::new(sin * horizontal, cosine as f32, -cos * horizontal)
}

/// Stores the prefix sums of `values` by their total, from 0 to 1, and returns the total; stores zeros if that is zero.
fn prefix_sums(values: impl Iterator<Item = f64> + Clone, sums: &mut [f32]) -> f64 {
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
