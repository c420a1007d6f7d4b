//! Levels of an image pyramid for sums over whole rows of lobes.
//!
//! The texels of a row of the result look up the same point of a level, moved along its row by the distance between them. So its weights
//! are computed once for all texels that have the same position between the texels of the level.

use glam::{Vec2, Vec4};

use super::equirect::{EquirectImage, floor};

/// A level, four floats a texel.
pub(super) struct LobeLevel {
    /// A power of two.
    width: usize,
    height: usize,
    texels: Vec<Vec4>,
}

/// A row of a level: its texels, the texel below the first column of the image, and its weight.
struct Tap<'t> {
    texels: &'t [Vec4],
    first: usize,
    weight: f32,
}

impl LobeLevel {
    pub(super) fn new(image: &EquirectImage) -> Self {
        let texels = image.pixels.iter().map(|&[red, green, blue]| Vec4::new(red, green, blue, 0.0));
        Self { width: image.width, height: image.height, texels: texels.collect() }
    }

    /// Adds the level at `uv`, bilinearly interpolated and times `weight`, to the first of `sums`, and to the others at positions moved by
    /// even steps of one turn. There is a power of two of them. `line` is scratch memory.
    pub(super) fn add(&self, uv: Vec2, weight: f32, line: &mut Vec<Vec4>, sums: &mut [Vec4]) {
        let (x, y) = (uv.x * self.width as f32 - 0.5, uv.y * self.height as f32 - 0.5);
        let (column, row) = (floor(x), floor(y));
        let bottom_share = y - row as f32;
        let right_share = x - column as f32;
        let taps = [
            self.tap(column, row, weight * (1.0 - bottom_share)),
            self.tap(column, row + 1, weight * bottom_share),
        ];
        if self.width > sums.len() {
            return self.add_strided(&taps, right_share, sums);
        }
        // Both rows from the first column on, one turn and two texels
        let mask = self.width - 1;
        line.clear();
        line.extend((0..self.width + 2).map(|step| {
            let at = |tap: &Tap<'_>| tap.texels[(tap.first + step) & mask] * tap.weight;
            at(&taps[0]) + at(&taps[1])
        }));
        // Several results look up the same interval between two texels.
        let phases = sums.len() / self.width;
        for phase in 0..phases {
            let position = right_share + phase as f32 / phases as f32;
            let (skipped, right) = if position < 1.0 { (0, position) } else { (1, position - 1.0) };
            let left = 1.0 - right;
            let (near, far) = (&line[skipped..], &line[skipped + 1..]);
            for ((sum, near), far) in sums[phase..].iter_mut().step_by(phases).zip(near).zip(far) {
                *sum += *near * left + *far * right;
            }
        }
    }

    /// [`LobeLevel::add`] for a level of more columns than sums.
    fn add_strided(&self, taps: &[Tap<'_>; 2], right: f32, sums: &mut [Vec4]) {
        let (mask, stride, left) = (self.width - 1, self.width / sums.len(), 1.0 - right);
        for tap in taps {
            for (index, sum) in sums.iter_mut().enumerate() {
                let first = tap.first + index * stride;
                let (near, far) = (tap.texels[first & mask], tap.texels[(first + 1) & mask]);
                *sum += (near * left + far * right) * tap.weight;
            }
        }
    }

    /// A row at most one beyond a pole, where the border row repeats, rotated by 180°.
    fn tap(&self, column: i32, row: i32, weight: f32) -> Tap<'_> {
        let inside = row.clamp(0, self.height as i32 - 1);
        let half_turn = if inside == row { 0 } else { self.width as i32 / 2 };
        let first = (column + half_turn).rem_euclid(self.width as i32) as usize;
        Tap { texels: &self.texels[inside as usize * self.width..][..self.width], first, weight }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn sums_are_bilinear_lookups_at_even_steps() {
        let image = EquirectImage::of(32, |d| Vec3::new(1.0 + d.x * d.y, 1.0 + d.z, d.x));
        let level = LobeLevel::new(&image);
        for count in [8, 16, 32, 64, 128] {
            for uv in [Vec2::new(0.3, 0.01), Vec2::new(0.99, 0.4), Vec2::new(0.004, 0.993)] {
                let mut sums = vec![Vec4::ONE; count];
                level.add(uv, 0.5, &mut Vec::new(), &mut sums);
                for (index, sum) in sums.iter().enumerate() {
                    let turned = (uv.x + index as f32 / count as f32).fract();
                    let expected = Vec3::ONE + image.bilinear(Vec2::new(turned, uv.y)) * 0.5;
                    assert!((sum.truncate() - expected).abs().max_element() < 1e-5, "{count} {uv} {index}");
                }
            }
        }
    }
}
