//! Tables of smooth functions over the unit square, with cubic interpolation.
//!
//! Lagrange cubics through the four values around a position; the first and last interval use the nearest four.

/// Values of N functions on a grid over the unit square.
#[derive(Clone, Debug)]
pub(super) struct CubicTable<const N: usize> {
    rows: usize,
    columns: usize,
    /// Row by row, with one extrapolated row and column at each end.
    values: Vec<[f32; N]>,
}

impl<const N: usize> CubicTable<N> {
    /// Tabulates `value(x, y)` at `rows` steps of x and `columns` steps of y, at least four each.
    pub(super) fn new(rows: usize, columns: usize, value: impl Fn(f32, f32) -> [f32; N]) -> Self {
        Self::of_grid(&grid_values(rows, columns, value), rows)
    }

    /// The table of the values of [`grid_values`].
    pub(super) fn of_grid(values: &[[f32; N]], rows: usize) -> Self {
        let columns = values.len() / rows;
        let mut grid = vec![Vec::new(); rows + 2];
        for (line, values) in grid[1..=rows].iter_mut().zip(values.chunks_exact(columns)) {
            line.resize(columns + 2, [0.0; N]);
            line[1..=columns].copy_from_slice(values);
            line[0] = extrapolated([&line[1], &line[2], &line[3], &line[4]]);
            line[columns + 1] = extrapolated([3, 2, 1, 0].map(|back| &line[columns - 3 + back]));
        }
        grid[0] = extrapolated_line([&grid[1], &grid[2], &grid[3], &grid[4]]);
        grid[rows + 1] = extrapolated_line([3, 2, 1, 0].map(|back| &grid[rows - 3 + back]));
        Self { rows, columns, values: grid.concat() }
    }

    /// The functions at (x, y), both in [0, 1].
    pub(super) fn at(&self, x: f32, y: f32) -> [f32; N] {
        let (row, weights_x) = interval(x, self.rows);
        let (column, weights_y) = interval(y, self.columns);
        let mut sums = [0.0; N];
        for (step, weight_x) in weights_x.into_iter().enumerate() {
            let start = (row + step) * (self.columns + 2) + column;
            for (entry, weight_y) in self.values[start..start + 4].iter().zip(weights_y) {
                let weight = weight_x * weight_y;
                for (sum, value) in sums.iter_mut().zip(entry) {
                    *sum += weight * value;
                }
            }
        }
        sums
    }
}

/// `value(x, y)` at `rows` steps of x and `columns` steps of y over the unit square, row by row.
pub(super) fn grid_values<const N: usize>(
    rows: usize,
    columns: usize,
    value: impl Fn(f32, f32) -> [f32; N],
) -> Vec<[f32; N]> {
    let step = |index: usize, steps: usize| index as f32 / (steps - 1) as f32;
    let at = |index: usize| value(step(index / columns, rows), step(index % columns, columns));
    (0..rows * columns).map(at).collect()
}

fn extrapolated_line<const N: usize>(lines: [&Vec<[f32; N]>; 4]) -> Vec<[f32; N]> {
    (0..lines[0].len()).map(|column| extrapolated(lines.map(|line| &line[column]))).collect()
}

/// Extrapolates cubics by one step from four values, nearest first.
fn extrapolated<const N: usize>(values: [&[f32; N]; 4]) -> [f32; N] {
    let [near, next, far, farthest] = values;
    std::array::from_fn(|at| 4.0 * (near[at] + far[at]) - 6.0 * next[at] - farthest[at])
}

/// The first of the four neighbours of `x`, and their weights.
fn interval(x: f32, steps: usize) -> (usize, [f32; 4]) {
    let position = x.clamp(0.0, 1.0) * (steps - 1) as f32;
    let below = (position as usize).min(steps - 2);
    let t = position - below as f32;
    (below, lagrange_weights(t))
}

/// The first of the four of `steps` values around `position`, which counts steps, and their weights.
#[inline(always)]
pub(super) fn nearest_four(position: f32, steps: usize) -> (usize, [f32; 4]) {
    let second = (position as usize).clamp(1, steps - 3);
    (second - 1, lagrange_weights(position - second as f32))
}

/// Weights of four values at the positions −1, 0, 1 and 2 of the cubic through them at `t`.
pub(super) fn lagrange_weights(t: f32) -> [f32; 4] {
    let (before, to_next, to_last) = (t + 1.0, 1.0 - t, 2.0 - t);
    [
        t * to_next * to_last * (-1.0 / 6.0),
        before * to_next * to_last * 0.5,
        before * t * to_last * 0.5,
        before * t * to_next * (-1.0 / 6.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_exact_up_to_the_ends() {
        let function = |x: f32, y: f32| [(x * x * x - 0.3 * x) * (2.0 - y * y), 1.0 - x];
        let table = CubicTable::new(5, 9, function);
        for (x, y) in [(0.0, 0.0), (1.0, 1.0), (0.03, 0.97), (0.5, 0.31), (0.99, 0.01)] {
            let (found, expected) = (table.at(x, y), function(x, y));
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{x} {y}: {found} {expected}");
            }
        }
    }
}
