//! Directions of an environment by sectors of the sphere, for those who know how much of each sector they see.

use std::f32::consts::TAU;
use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::cell_grid::CellGrid;
use super::distribution::{mean_radiances, prefix_sums};
use super::map_rotation::MapRotation;
use crate::geometry::DirectionSample;

/// Rows of sectors, of equal polar angles: 11.25° each.
pub(crate) const SECTOR_ROWS: usize = 16;
/// Columns of sectors, of equal azimuths: 11.25° each.
pub(crate) const SECTOR_COLUMNS: usize = 32;
/// All sectors, row by row from the top.
pub(crate) const SECTORS: usize = SECTOR_ROWS * SECTOR_COLUMNS;

/// The sectors of an environment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnvironmentSectors<'a> {
    tables: &'a SectorTables,
    /// The rotation of the image whose space they are in, unless that is the world's.
    map: Option<&'a MapRotation>,
}

impl<'a> EnvironmentSectors<'a> {
    pub(super) fn new(tables: &'a SectorTables, map: Option<&'a MapRotation>) -> Self {
        Self { tables, map }
    }

    /// Shares of the environment's power. They sum to 1.
    pub(crate) fn powers(&self) -> &'a [f32] {
        &self.tables.powers
    }

    /// Samples a direction of a sector that has power. Its density in the sector is proportional to the radiance.
    pub(crate) fn sample(&self, sector: usize, u: Vec2) -> DirectionSample {
        let DirectionSample { direction, pdf } = self.tables.sample(sector, u);
        let direction = self.map.map_or(direction, |map| map.world_from_map(direction));
        DirectionSample { direction, pdf }
    }

    /// The sector of a direction, and the density of the direction in it.
    pub(crate) fn find(&self, direction: Vec3) -> (usize, f32) {
        self.tables.find(self.map.map_or(direction, |map| map.map_from_world(direction)))
    }
}

/// Densities in sectors, each piecewise constant by `edge` × `edge` cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SectorTables {
    grid: CellGrid,
    edge: usize,
    powers: Vec<f32>,
    /// For each sector, prefix sums of the probabilities of its rows, from 0 to 1.
    row_sums: Vec<f32>,
    /// For each row of each sector, prefix sums of the probabilities of its cells, from 0 to 1.
    cell_sums: Vec<f32>,
}

impl SectorTables {
    /// The sectors of `rows` rows of cells, a multiple of [`SECTOR_ROWS`], and twice as many columns. `radiance` is the luminance from a unit
    /// direction. `None` if all is dark.
    pub(super) fn of(rows: usize, radiance: impl Fn(Vec3) -> f32) -> Option<Self> {
        Self::new(&mean_radiances(rows as u32, 2 * rows as u32, radiance))
    }

    /// The sectors of cells of a mean luminance each, row-major from the top.
    pub(super) fn new(cells: &[f32]) -> Option<Self> {
        let rows = (cells.len() / 2).isqrt();
        let (edge, columns) = (rows / SECTOR_ROWS, 2 * rows);
        debug_assert_eq!(
            cells.len(),
            edge * SECTOR_ROWS * columns,
            "rows of sectors, and twice as many columns"
        );
        let grid = CellGrid::new(rows as u32, columns as u32);
        let mut powers = [0.0_f64; SECTORS];
        let mut row_sums = vec![0.0; SECTORS * (edge + 1)];
        let mut cell_sums = vec![0.0; SECTORS * edge * (edge + 1)];
        for (sector, power) in powers.iter_mut().enumerate() {
            let (first_row, first_column) = corner(sector, edge);
            let totals: Vec<f64> = (0..edge)
                .map(|row| {
                    let first = (first_row + row) * columns + first_column;
                    let sums = &mut cell_sums[(sector * edge + row) * (edge + 1)..][..=edge];
                    let values = cells[first..][..edge].iter().map(|&cell| f64::from(cell));
                    prefix_sums(values, sums) * grid.cosines(first_row + row)
                })
                .collect();
            *power = prefix_sums(totals.iter().copied(), &mut row_sums[sector * (edge + 1)..][..=edge]);
        }
        let total: f64 = powers.iter().sum();
        (total > 0.0).then(|| Self {
            grid,
            edge,
            powers: powers.iter().map(|power| (power / total) as f32).collect(),
            row_sums,
            cell_sums,
        })
    }

    /// Sectors of equal radiance.
    pub(super) fn uniform() -> Option<&'static Self> {
        static UNIFORM: OnceLock<Option<SectorTables>> = OnceLock::new();
        UNIFORM.get_or_init(|| Self::new(&[1.0; SECTORS])).as_ref()
    }

    fn sample(&self, sector: usize, u: Vec2) -> DirectionSample {
        let (row, v) = interval(self.row_sums(sector), u.y);
        let (column, u) = interval(self.cell_sums(sector, row), u.x);
        let (first_row, first_column) = corner(sector, self.edge);
        let direction = self.grid.direction_inside((first_row + row, first_column + column), u, v);
        DirectionSample { direction, pdf: self.density(sector, (row, column)) }
    }

    fn find(&self, direction: Vec3) -> (usize, f32) {
        let (row, column) = self.grid.cell(direction);
        let sector = row / self.edge * SECTOR_COLUMNS + column / self.edge;
        (sector, self.density(sector, (row % self.edge, column % self.edge)))
    }

    fn row_sums(&self, sector: usize) -> &[f32] {
        &self.row_sums[sector * (self.edge + 1)..][..=self.edge]
    }

    fn cell_sums(&self, sector: usize, row: usize) -> &[f32] {
        &self.cell_sums[(sector * self.edge + row) * (self.edge + 1)..][..=self.edge]
    }

    /// The density in a cell of a sector: its probability by its solid angle.
    fn density(&self, sector: usize, (row, column): (usize, usize)) -> f32 {
        let (rows, cells) = (self.row_sums(sector), self.cell_sums(sector, row));
        let probability = (rows[row + 1] - rows[row]) * (cells[column + 1] - cells[column]);
        let cosines = self.grid.cosines(sector / SECTOR_COLUMNS * self.edge + row) as f32;
        probability * self.grid.columns() as f32 / (TAU * cosines)
    }
}

/// The first row and column of the cells of a sector.
fn corner(sector: usize, edge: usize) -> (usize, usize) {
    (sector / SECTOR_COLUMNS * edge, sector % SECTOR_COLUMNS * edge)
}

/// The interval of prefix sums from 0 to 1 that holds `u`, and the position of `u` in it, both numbers in [0, 1). It is never an empty one.
pub(crate) fn interval(sums: &[f32], u: f32) -> (usize, f32) {
    // Counting all takes no branch and is done in lanes.
    let index = sums[1..].iter().map(|&sum| u32::from(sum <= u)).sum::<u32>() as usize;
    let index = index.min(sums.len() - 2);
    let position = (u - sums[index]) / (sums[index + 1] - sums[index]);
    (index, position.min(1.0_f32.next_down()))
}

#[cfg(test)]
mod tests;
