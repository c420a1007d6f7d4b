//! Probabilities of the sectors of the environment.

use glam::Vec2;

use crate::scene::{SECTOR_COLUMNS, SECTOR_ROWS, SECTORS, interval, prefix_sums};

/// Index of an entry.
pub(in crate::integrator) type VisibleEntry = u16;

/// Probabilities of all sectors, as seen from a group of points.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    /// Prefix sums of the rows of sectors, from 0 to 1.
    row_sums: [f32; SECTOR_ROWS + 1],
    /// For each row, prefix sums of its sectors, from 0 to 1.
    sums: [[f32; SECTOR_COLUMNS + 1]; SECTOR_ROWS],
}

impl Entry {
    /// Probabilities that are proportional to weights; `None` if all are 0.
    pub(super) fn new(weights: &[f32; SECTORS]) -> Option<Self> {
        let mut entry =
            Self { row_sums: [0.0; SECTOR_ROWS + 1], sums: [[0.0; SECTOR_COLUMNS + 1]; SECTOR_ROWS] };
        let rows = weights.chunks_exact(SECTOR_COLUMNS).zip(&mut entry.sums);
        let totals: Vec<f64> = rows
            .map(|(weights, sums)| prefix_sums(weights.iter().map(|&weight| f64::from(weight)), sums))
            .collect();
        (prefix_sums(totals.iter().copied(), &mut entry.row_sums) > 0.0).then_some(entry)
    }

    /// A sector, its probability, and a point of the unit square that does not depend on the choice.
    pub(super) fn sample(&self, u: Vec2) -> (usize, f32, Vec2) {
        let (row, v) = interval(&self.row_sums, u.y);
        let (column, u) = interval(&self.sums[row], u.x);
        let sector = row * SECTOR_COLUMNS + column;
        (sector, self.probability(sector), Vec2::new(u, v))
    }

    /// The probability of a sector.
    pub(super) fn probability(&self, sector: usize) -> f32 {
        let (row, column) = (sector / SECTOR_COLUMNS, sector % SECTOR_COLUMNS);
        let sums = &self.sums[row];
        (self.row_sums[row + 1] - self.row_sums[row]) * (sums[column + 1] - sums[column])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sectors_are_chosen_by_their_weights() {
        let weights = std::array::from_fn(|sector| if sector % 5 == 0 { (sector % 7) as f32 } else { 0.0 });
        let entry = Entry::new(&weights).unwrap();
        let total: f32 = weights.iter().sum();
        let (mut counts, side) = ([0; SECTORS], 512);
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let u = (Vec2::new(i as f32, j as f32) + 0.5) / side as f32;
            let (sector, probability, left) = entry.sample(u);
            assert_eq!(probability, entry.probability(sector));
            assert!(left.min_element() >= 0.0 && left.max_element() < 1.0, "{left}");
            counts[sector] += 1;
        }
        for (sector, weight) in weights.iter().enumerate() {
            assert!((entry.probability(sector) - weight / total).abs() < 1e-6);
            let found = counts[sector] as f32 / (side * side) as f32;
            assert!((found - weight / total).abs() < 1e-3, "{sector}: {found}");
        }
        assert_eq!(Entry::new(&[0.0; SECTORS]), None);
    }
}
