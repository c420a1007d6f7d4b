//! Cells of equal azimuths and polar angles on the sphere of directions.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::arc_tangent::atan2;
use crate::geometry::sin_cos_of_turn;

/// A bound on the rounding errors of a direction, in widths of cells of images of up to 65536 columns.
const BORDER: f32 = 1.0 / 64.0;

/// The cells of an equirectangular image (+Y up, -Z in the centre).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CellGrid {
    columns: usize,
    /// Cosines of the rows' polar angles, from 1 to -1.
    row_cosines: Vec<f64>,
}

impl CellGrid {
    /// At least one row and one column.
    pub(super) fn new(rows: u32, columns: u32) -> Self {
        Self {
            columns: columns.max(1) as usize,
            row_cosines: (0..=rows.max(1)).map(|row| row_cosine(row, rows.max(1))).collect(),
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.row_cosines.len() - 1
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// Difference of the cosines at the edges of a row.
    pub(super) fn cosines(&self, row: usize) -> f64 {
        self.row_cosines[row] - self.row_cosines[row + 1]
    }

    /// A direction at (`u`, `v`) of a cell, which [`CellGrid::cell`] finds there: one that is rounded into the next cell is replaced by the
    /// cell's central one.
    pub(super) fn direction_inside(&self, (row, column): (usize, usize), u: f32, v: f32) -> Vec3 {
        let direction = self.direction((row, column), u, v);
        let is_at_border = (u - 0.5).abs().max((v - 0.5).abs()) > 0.5 - BORDER;
        let is_inside = !is_at_border || self.cell(direction) == (row, column);
        if is_inside { direction } else { self.direction((row, column), 0.5, 0.5) }
    }

    /// The direction at (`u`, `v`) of a cell; equal areas are equal solid angles.
    pub(super) fn direction(&self, (row, column): (usize, usize), u: f32, v: f32) -> Vec3 {
        let (top, bottom) = (self.row_cosines[row], self.row_cosines[row + 1]);
        let azimuth = (column as f32 + u) * (TAU / self.columns as f32) - PI;
        direction(azimuth, top + (bottom - top) * f64::from(v))
    }

    /// Row and column of a direction.
    pub(super) fn cell(&self, direction: Vec3) -> (usize, usize) {
        let rows = self.rows();
        let horizontal = (direction.x * direction.x + direction.z * direction.z).sqrt();
        let polar = atan2(horizontal, direction.y) / PI;
        let azimuth = atan2(direction.x, -direction.z) / TAU + 0.5;
        let row = (polar * rows as f32) as usize;
        let column = (azimuth * self.columns as f32) as usize;
        (row.min(rows - 1), column.min(self.columns - 1))
    }
}

/// The cosine of the polar angle above a row.
fn row_cosine(row: u32, rows: u32) -> f64 {
    libm::cos(std::f64::consts::PI * f64::from(row) / f64::from(rows))
}

/// The direction of an azimuth from -Z towards +X and of the cosine of the polar angle from +Y.
pub(super) fn direction(azimuth: f32, cosine: f64) -> Vec3 {
    let horizontal = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt() as f32;
    let (sin, cos) = sin_cos_of_turn(azimuth);
    Vec3::new(sin * horizontal, cosine as f32, -cos * horizontal)
}
