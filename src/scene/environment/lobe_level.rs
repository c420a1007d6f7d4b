//! Levels of an image pyramid for sums over whole rows of lobes.
//!
//! The texels of a row of the result look up the same point of a level, moved along its row by the distance between them. So its weights
//! are computed once for all texels that have the same position between the texels of the level.
//!
//! A row of a level, and one of sums, is stored in runs of texels at even steps of one turn, [`RUN`] of them. Sums of a run lie between
//! texels of two runs, each of which is read from end to end.

use glam::Vec2;

use super::equirect::{EquirectImage, floor};

/// Texels of a run, and columns of the coarsest level.
pub(super) const RUN: usize = 16;

/// Texels of a run of a level: more than a turn, so that one that begins at any column continues.
const STORED_RUN: usize = 2 * RUN + 2;

/// A level of a pyramid.
pub(super) struct LobeLevel {
    /// A power of two, of at least [`RUN`].
    width: usize,
    height: usize,
    /// For each row, its runs by the columns that they begin at.
    texels: Vec<[[f32; 4]; STORED_RUN]>,
}

/// A row of sums.
pub(super) struct LobeSums {
    /// Its runs by the columns that they begin at.
    runs: Vec<[[f32; 4]; RUN]>,
    /// Texels of two rows of a level with their weights, run by run.
    lines: Vec<[[f32; 4]; RUN + 2]>,
}

/// A row of a level: its texels, the texel below the first column of the image, and its weight.
struct Tap<'t> {
    runs: &'t [[[f32; 4]; STORED_RUN]],
    first: usize,
    weight: f32,
}

impl LobeSums {
    /// Zeros for a row of `width` texels: a power of two, of at least [`RUN`].
    pub(super) fn zeros(width: usize) -> Self {
        Self { runs: vec![[[0.0; 4]; RUN]; width / RUN], lines: Vec::new() }
    }

    /// The sums, column by column.
    pub(super) fn into_row(self) -> impl Iterator<Item = [f32; 3]> {
        let width = self.runs.len() * RUN;
        (0..width).map(move |column| {
            let [red, green, blue, _] = self.runs[column % (width / RUN)][column / (width / RUN)];
            [red, green, blue]
        })
    }
}

impl LobeLevel {
    pub(super) fn new(image: &EquirectImage) -> Self {
        let (width, height, count) = (image.width, image.height, image.width / RUN);
        let run = |index: usize| {
            let row = &image.pixels[index / count * width..][..width];
            std::array::from_fn(|step| {
                let [red, green, blue] = row[(index % count + step * count) % width];
                [red, green, blue, 0.0]
            })
        };
        Self { width, height, texels: (0..height * count).map(run).collect() }
    }

    /// Adds the level at `uv`, bilinearly interpolated and times `weight`, to the first of the sums, and to the others at positions moved by
    /// even steps of one turn.
    #[inline(always)]
    pub(super) fn add(&self, uv: Vec2, weight: f32, sums: &mut LobeSums) {
        let (x, y) = (uv.x * self.width as f32 - 0.5, uv.y * self.height as f32 - 0.5);
        let (column, row) = (floor(x), floor(y));
        let bottom_share = y - row as f32;
        let right_share = x - column as f32;
        let taps = [
            self.tap(column, row, weight * (1.0 - bottom_share)),
            self.tap(column, row + 1, weight * bottom_share),
        ];
        let count = self.width / RUN;
        if count > sums.runs.len() {
            return add_strided(&taps, right_share, sums);
        }
        // Both rows from the first column on, one turn and two texels
        let LobeSums { runs, lines } = sums;
        lines.resize(count, [[0.0; 4]; RUN + 2]);
        for (step, line) in lines.iter_mut().enumerate() {
            let [above, below] = [0, 1].map(|tap: usize| taps[tap].from::<{ RUN + 2 }>(step).as_flattened());
            for ((sum, above), below) in line.as_flattened_mut().iter_mut().zip(above).zip(below) {
                *sum = above * taps[0].weight + below * taps[1].weight;
            }
        }
        // Several results look up the same interval between two texels.
        let phases = runs.len() / count;
        for (index, sums) in runs.iter_mut().enumerate() {
            let position = right_share + (index % phases) as f32 / phases as f32;
            let (skipped, right) = if position < 1.0 { (0, position) } else { (1, position - 1.0) };
            let column = index / phases + skipped;
            let [near, far] =
                [column, column + 1].map(|column| lines[column % count][column / count..].as_flattened());
            for ((sum, near), far) in sums.as_flattened_mut().iter_mut().zip(near).zip(far) {
                *sum += near * (1.0 - right) + far * right;
            }
        }
    }

    /// A row at most one beyond a pole, where the border row repeats, rotated by 180°.
    #[inline(always)]
    fn tap(&self, column: i32, row: i32, weight: f32) -> Tap<'_> {
        let inside = row.clamp(0, self.height as i32 - 1);
        let half_turn = if inside == row { 0 } else { self.width as i32 / 2 };
        let first = (column + half_turn).rem_euclid(self.width as i32) as usize;
        let count = self.width / RUN;
        Tap { runs: &self.texels[inside as usize * count..][..count], first, weight }
    }
}

impl Tap<'_> {
    /// The texels at the first column, moved by `steps` of less than a run, and at even steps of one turn from there on.
    #[inline(always)]
    fn from<const COUNT: usize>(&self, steps: usize) -> &[[f32; 4]] {
        let column = self.first + steps;
        &self.runs[column % self.runs.len()][column / self.runs.len()..][..COUNT]
    }
}

/// [`LobeLevel::add`] for a level of more columns than sums.
#[inline(always)]
fn add_strided(taps: &[Tap<'_>; 2], right: f32, sums: &mut LobeSums) {
    let stride = taps[0].runs.len() / sums.runs.len();
    for tap in taps {
        for (index, sums) in sums.runs.iter_mut().enumerate() {
            let [near, far] = [0, 1].map(|step| tap.from::<RUN>(index * stride + step).as_flattened());
            for ((sum, near), far) in sums.as_flattened_mut().iter_mut().zip(near).zip(far) {
                *sum += (near * (1.0 - right) + far * right) * tap.weight;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn sums_are_bilinear_lookups_at_even_steps() {
        for width in [16, 32, 128] {
            let image = EquirectImage::of(width, |d| Vec3::new(1.0 + d.x * d.y, 1.0 + d.z, d.x));
            let level = LobeLevel::new(&image);
            for count in [16, 32, 64, 256] {
                // Columns between all texels, both poles, and both edges
                for (u, v) in
                    (0..40).map(|at| (at as f32 / 40.0, (at * 7 % 40) as f32 / 40.0)).chain([(1.0, 1.0)])
                {
                    let mut sums = LobeSums::zeros(count);
                    level.add(Vec2::new(u, v), 0.25, &mut sums);
                    level.add(Vec2::new(u, v), 0.25, &mut sums);
                    for (index, sum) in sums.into_row().enumerate() {
                        let turned = (u + index as f32 / count as f32).fract();
                        let expected = image.bilinear(Vec2::new(turned, v)) * 0.5;
                        let error = (Vec3::from_array(sum) - expected).abs().max_element();
                        assert!(error < 1e-4, "{width} {count} {u} {v} {index}: {error}");
                    }
                }
            }
        }
    }
}
