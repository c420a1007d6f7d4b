//! A smooth function of two numbers between 0 and 1, by table.
//!
//! Source: Catmull and Rom, "A Class of Local Interpolating Splines", 1974: cubic pieces through the stored values. Beyond the
//! ends the last piece runs on as a parabola.

/// Values at steps of two coordinates from 0 to 1.
#[derive(Clone, Debug)]
pub(super) struct CubicTable {
    rows: usize,
    columns: usize,
    /// Row by row, with one more row and column at each end than there are steps from 0 to 1.
    values: Vec<f32>,
}

impl CubicTable {
    /// `value(x, y)` at `rows` steps of x and `columns` steps of y; at least three each.
    pub(super) fn new(rows: usize, columns: usize, value: impl Fn(f32, f32) -> f32) -> Self {
        let mut grid = vec![Vec::new(); rows + 2];
        for (row, line) in grid[1..=rows].iter_mut().enumerate() {
            line.resize(columns + 2, 0.0);
            for (column, slot) in line[1..=columns].iter_mut().enumerate() {
                *slot = value(row as f32 / (rows - 1) as f32, column as f32 / (columns - 1) as f32);
            }
            line[0] = beyond(line[1], line[2], line[3]);
            line[columns + 1] = beyond(line[columns], line[columns - 1], line[columns - 2]);
        }
        grid[0] = line_beyond(&grid[1], &grid[2], &grid[3]);
        grid[rows + 1] = line_beyond(&grid[rows], &grid[rows - 1], &grid[rows - 2]);
        Self { rows, columns, values: grid.concat() }
    }

    /// The function at (x, y), both from 0 to 1.
    pub(super) fn at(&self, x: f32, y: f32) -> f32 {
        let (row, weights_x) = piece(x, self.rows);
        let (column, weights_y) = piece(y, self.columns);
        let mut sum = 0.0;
        for (step, weight) in weights_x.into_iter().enumerate() {
            let start = (row + step) * (self.columns + 2) + column;
            let line = &self.values[start..start + 4];
            let along = line[0] * weights_y[0]
                + line[1] * weights_y[1]
                + line[2] * weights_y[2]
                + line[3] * weights_y[3];
            sum += along * weight;
        }
        sum
    }
}

fn line_beyond(near: &[f32], next: &[f32], far: &[f32]) -> Vec<f32> {
    near.iter().zip(next).zip(far).map(|((near, next), far)| beyond(*near, *next, *far)).collect()
}

/// The next value of a parabola through three, nearest first.
fn beyond(near: f32, next: f32, far: f32) -> f32 {
    3.0 * (near - next) + far
}

/// The first of four neighbours around `x`, and their weights.
fn piece(x: f32, steps: usize) -> (usize, [f32; 4]) {
    let place = x.clamp(0.0, 1.0) * (steps - 1) as f32;
    let below = (place as usize).min(steps - 2);
    let t = place - below as f32;
    let (square, cube) = (t * t, t * t * t);
    let weights = [
        0.5 * (2.0 * square - t - cube),
        1.0 + 0.5 * (3.0 * cube - 5.0 * square),
        0.5 * (t + 4.0 * square - 3.0 * cube),
        0.5 * (cube - square),
    ];
    (below, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_exact_up_to_the_ends() {
        let function = |x: f32, y: f32| (x * x - 0.3 * x) * (2.0 - y * y);
        let table = CubicTable::new(5, 9, function);
        for (x, y) in [(0.0, 0.0), (1.0, 1.0), (0.03, 0.97), (0.5, 0.31), (0.99, 0.01)] {
            assert!((table.at(x, y) - function(x, y)).abs() < 1e-6, "{x} {y}: {}", table.at(x, y));
        }
    }
}
