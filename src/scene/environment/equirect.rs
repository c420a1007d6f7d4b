//! Equirectangular images: the map between texels and directions, bilinear lookups, and resampling.
//!
//! Columns run around +Y: the centre of the image is −Z (where a glTF camera looks), its right quarter +X, both edges +Z.
//! Rows run from +Y at the top to −Y at the bottom.

use std::f32::consts::PI;

use fearless_simd::Level;
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::arc_tangent::{atan2, atan2_reducible, is_reducible};
use crate::geometry::{ActiveLanes, F32Lanes, Vec2Lanes, Vec3Lanes, vectorized};

/// Radiance on an equirectangular grid, row-major from the top.
#[derive(Clone, Debug)]
pub(super) struct EquirectImage {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<[f32; 3]>,
}

/// Image coordinates of a unit direction, in the unit square with the origin at the top left.
pub(super) fn uv_from_direction(direction: Vec3) -> Vec2 {
    uv_of_angles(atan2(direction.x, -direction.z), atan2(horizontal(direction), direction.y))
}

/// [`uv_from_direction`] of the directions of a block, by the instruction set `level`.
pub(super) fn uvs_from_directions(
    level: Level,
    directions: &Vec3Lanes,
    lanes: ActiveLanes,
    uvs: &mut Vec2Lanes,
) {
    let mut is_done = F32Lanes::default();
    vectorized!(level, {
        for (lane, is_done) in is_done.iter_mut().enumerate() {
            let direction = directions.get(lane);
            let horizontal = horizontal(direction);
            let azimuth = atan2_reducible(direction.x, -direction.z);
            uvs.set(lane, uv_of_angles(azimuth, atan2_reducible(horizontal, direction.y)));
            let done = is_reducible(direction.x, -direction.z) & is_reducible(horizontal, direction.y);
            *is_done = if done { 1.0 } else { 0.0 };
        }
    });
    for lane in lanes.filtered(|lane| is_done[lane] == 0.0) {
        uvs.set(lane, uv_from_direction(directions.get(lane)));
    }
}

/// Length of the part of a direction across the axis.
#[inline(always)]
fn horizontal(direction: Vec3) -> f32 {
    (direction.x * direction.x + direction.z * direction.z).sqrt()
}

#[inline(always)]
fn uv_of_angles(azimuth: f32, polar: f32) -> Vec2 {
    Vec2::new(0.5 + azimuth / (2.0 * PI), polar / PI)
}

/// Unit direction of image coordinates in the unit square.
pub(super) fn direction_from_uv(uv: Vec2) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = libm::sincosf((uv.x - 0.5) * 2.0 * PI);
    let (sin_polar, cos_polar) = libm::sincosf(uv.y * PI);
    Vec3::new(sin_polar * sin_azimuth, cos_polar, -sin_polar * cos_azimuth)
}

/// The largest integer that is not above `value`; 0 for not a number.
#[inline(always)]
pub(super) fn floor(value: f32) -> i32 {
    let whole = value as i32;
    if whole as f32 > value { whole - 1 } else { whole }
}

impl EquirectImage {
    /// An image `width` texels wide of `radiance` in each texel's direction.
    #[cfg(test)]
    pub(super) fn of(width: usize, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let mut image = Self { width, height: width / 2, pixels: Vec::new() };
        for row in 0..width / 2 {
            for column in 0..width {
                let direction = direction_from_uv(image.texel_uv(column, row));
                image.pixels.push(radiance(direction).to_array());
            }
        }
        image
    }

    /// The centre of a texel in image coordinates.
    pub(super) fn texel_uv(&self, column: usize, row: usize) -> Vec2 {
        Vec2::new((column as f32 + 0.5) / self.width as f32, (row as f32 + 0.5) / self.height as f32)
    }

    /// Bilinear interpolation between texel centres. Columns wrap around. Beyond a pole the border row repeats, rotated by 180°.
    #[inline]
    pub(super) fn bilinear(&self, uv: Vec2) -> Vec3 {
        let x = uv.x * self.width as f32 - 0.5;
        let y = uv.y * self.height as f32 - 0.5;
        let (column, row) = (floor(x), floor(y));
        let (right_share, bottom_share) = (x - column as f32, y - row as f32);
        let [left_share, top_share] = [1.0 - right_share, 1.0 - bottom_share];
        let [[a, b], [c, d]] =
            self.neighbours_inside(column, row).unwrap_or_else(|| self.neighbours(column, row));
        let (top, bottom) = (a * left_share + b * right_share, c * left_share + d * right_share);
        (top * top_share + bottom * bottom_share).truncate()
    }

    /// The texels at a column and the next one, of a row and the next one; `None` at the edges of the image. Fourth components are undefined.
    #[inline(always)]
    fn neighbours_inside(&self, column: i32, row: i32) -> Option<[[Vec4; 2]; 2]> {
        if column < 0 || row < 0 || column as usize + 1 >= self.width {
            return None;
        }
        let values = self.pixels.as_flattened();
        let pair = |row: usize| {
            // A fourth value behind the second texel takes the place of four loads.
            let pair = values.get((row * self.width + column as usize) * 3..)?.first_chunk::<7>()?;
            let [a, b, c, d, e, f, g] = *pair;
            Some([Vec4::new(a, b, c, d), Vec4::new(d, e, f, g)])
        };
        Some([pair(row as usize)?, pair(row as usize + 1)?])
    }

    /// The same anywhere in the image, and at most one beyond an edge.
    #[inline(never)]
    fn neighbours(&self, column: i32, row: i32) -> [[Vec4; 2]; 2] {
        [row, row + 1].map(|row| {
            [column, column + 1].map(|column| Vec3::from_array(*self.texel_beyond(column, row)).extend(0.0))
        })
    }

    /// The texel at a column at most one beyond an edge, in a row at most one beyond a pole.
    pub(super) fn texel_beyond(&self, column: i32, row: i32) -> &[f32; 3] {
        let (line, half_turn) = self.line(row);
        &line[self.wrapped(column + half_turn)]
    }

    /// A row at most one beyond a pole, and the columns to rotate it by.
    #[inline(always)]
    fn line(&self, row: i32) -> (&[[f32; 3]], i32) {
        let inside = row.clamp(0, self.height as i32 - 1);
        let half_turn = if inside == row { 0 } else { self.width as i32 / 2 };
        (&self.pixels[inside as usize * self.width..][..self.width], half_turn)
    }

    /// A column from one before the first to one and a half turns after it, wrapped around.
    #[inline(always)]
    fn wrapped(&self, column: i32) -> usize {
        let width = self.width as i32;
        let column = if column < 0 { column + width } else { column };
        (if column >= width { column - width } else { column }) as usize
    }

    /// Resamples to another grid. Each new texel holds the mean over its solid angle.
    pub(super) fn resampled(&self, width: usize, height: usize) -> Self {
        let columns = overlaps(self.width, width, |edge| edge);
        // The area of a band between two polar angles is proportional to the difference of their cosines.
        let rows = overlaps(self.height, height, |edge| -libm::cos(edge * std::f64::consts::PI));
        let mut pixels = vec![[0.0; 3]; width * height];
        pixels.par_chunks_exact_mut(width).zip(&rows).for_each(|(pixels, (first_row, row_shares))| {
            let band = self.mean_of_rows(*first_row, row_shares);
            write_means(pixels, &band, &columns);
        });
        Self { width, height, pixels }
    }

    /// Means of bilinear lookups over the cells of a grid of twice as many columns as rows.
    pub(super) fn interpolated(&self, rows: usize) -> Self {
        // Two along each axis are exact where a cell is a texel.
        const LOOKUPS: usize = 2;
        let columns = 2 * rows;
        let steps = LOOKUPS as f32;
        let mut pixels = vec![[0.0; 3]; columns * rows];
        pixels.par_chunks_exact_mut(columns).enumerate().for_each(|(row, pixels)| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let lookup = |index: usize| {
                    let (x, y) = (column * LOOKUPS + index % LOOKUPS, row * LOOKUPS + index / LOOKUPS);
                    let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
                    self.bilinear(Vec2::new(x / (columns as f32 * steps), y / (rows as f32 * steps)))
                };
                let sum: Vec3 = (0..LOOKUPS * LOOKUPS).map(lookup).sum();
                *pixel = (sum / (steps * steps)).to_array();
            }
        });
        Self { width: columns, height: rows, pixels }
    }

    /// Means of bilinear lookups over the cells of a grid whose cells are no smaller than texels: what lies half a texel beside a bright one is bright, too.
    pub(super) fn interpolated_means(&self, width: usize, height: usize) -> Self {
        let columns = tent_overlaps(self.width, width);
        let rows = tent_overlaps(self.height, height);
        let mut pixels = vec![[0.0; 3]; width * height];
        pixels.par_chunks_exact_mut(width).zip(&rows).for_each(|(pixels, (first_row, row_shares))| {
            // The column before the first, all columns, and the one after the last
            let mut band = vec![[0.0_f64; 3]; self.width + 2];
            for (row, share) in (*first_row as i32 - 1..).zip(row_shares) {
                for (sum, column) in band.iter_mut().zip(-1..) {
                    for (total, channel) in sum.iter_mut().zip(self.texel_beyond(column, row)) {
                        *total += f64::from(*channel) * share;
                    }
                }
            }
            write_means(pixels, &band, &columns);
        });
        Self { width, height, pixels }
    }

    fn mean_of_rows(&self, first_row: usize, shares: &[f64]) -> Vec<[f64; 3]> {
        let mut band = vec![[0.0_f64; 3]; self.width];
        for (row, share) in self.pixels[first_row * self.width..].chunks_exact(self.width).zip(shares) {
            for (sum, pixel) in band.iter_mut().zip(row) {
                for (total, channel) in sum.iter_mut().zip(pixel) {
                    *total += f64::from(*channel) * share;
                }
            }
        }
        band
    }
}

/// Means of a row of values by the first value and the shares of it and the following ones for each.
fn write_means(means: &mut [[f32; 3]], values: &[[f64; 3]], shares: &[(usize, Vec<f64>)]) {
    for (mean, (first, shares)) in means.iter_mut().zip(shares) {
        let mut sum = [0.0_f64; 3];
        for (value, share) in values[*first..].iter().zip(shares) {
            for (total, channel) in sum.iter_mut().zip(value) {
                *total += channel * share;
            }
        }
        *mean = sum.map(|channel| channel as f32);
    }
}

/// The weights of linear interpolation between the centres of `old` equal cells, averaged over each of `new` ones: the first old cell of each, counted from
/// the one before the first, and the weights of it and the following ones.
fn tent_overlaps(old: usize, new: usize) -> Vec<(usize, Vec<f64>)> {
    // The integral of the tent from -1
    let below = |x: f64| {
        let x = x.clamp(-1.0, 1.0);
        if x < 0.0 { 0.5 * (x + 1.0) * (x + 1.0) } else { 1.0 - 0.5 * (1.0 - x) * (1.0 - x) }
    };
    let size = old as f64 / new as f64;
    let cell = |index: usize| {
        let [start, end] = [index, index + 1].map(|edge| edge as f64 * size - 0.5);
        let (first, last) = ((start.floor() as i32).max(-1), (end.ceil() as i32).min(old as i32));
        let weight = |center: i32| (below(end - f64::from(center)) - below(start - f64::from(center))) / size;
        ((first + 1) as usize, (first..=last).map(weight).collect())
    };
    (0..new).map(cell).collect()
}

/// Overlaps of `new` equal cells of the unit interval with `old` ones: for each new cell, the first old cell that it touches
/// and the shares of its measure in that cell and the following ones. `measure` is an increasing function of the position.
fn overlaps(old: usize, new: usize, measure: impl Fn(f64) -> f64) -> Vec<(usize, Vec<f64>)> {
    (0..new)
        .map(|cell| {
            // Integers decide which cells touch, so that rounding never adds or loses one.
            let first = cell * old / new;
            let last = ((cell + 1) * old).div_ceil(new);
            let edge = |index: usize| {
                // Edges in units of 1 / (old · new).
                let position = (index * new).clamp(cell * old, (cell + 1) * old);
                measure(position as f64 / (old as f64 * new as f64))
            };
            let whole = edge(last) - edge(first);
            let shares = (first..last).map(|index| (edge(index + 1) - edge(index)) / whole).collect();
            (first, shares)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_map_to_the_documented_coordinates() {
        for (direction, uv) in [
            (Vec3::NEG_Z, Vec2::new(0.5, 0.5)),
            (Vec3::X, Vec2::new(0.75, 0.5)),
            (Vec3::NEG_X, Vec2::new(0.25, 0.5)),
            (Vec3::Y, Vec2::new(0.5, 0.0)),
            (Vec3::NEG_Y, Vec2::new(0.5, 1.0)),
        ] {
            let found = uv_from_direction(direction);
            assert!((found.y - uv.y).abs() < 1e-6, "{direction}: {found}");
            assert!(direction.y != 0.0 || (found.x - uv.x).abs() < 1e-6, "{direction}: {found}");
        }
        for index in 0..200 {
            let uv = Vec2::new((index as f32 * 0.618_034).fract(), (index as f32 + 0.5) / 200.0);
            let direction = direction_from_uv(uv);
            assert!((direction.length() - 1.0).abs() < 1e-6);
            let difference = uv_from_direction(direction) - uv;
            // The left and the right edge coincide.
            assert!((difference.x - difference.x.round()).abs() < 1e-5 && difference.y.abs() < 1e-5);
        }
    }

    #[test]
    fn lookups_wrap_around_and_continue_beyond_the_poles() {
        let image =
            EquirectImage { width: 2, height: 2, pixels: vec![[1.0; 3], [3.0; 3], [5.0; 3], [9.0; 3]] };
        assert_eq!(image.bilinear(Vec2::new(0.25, 0.25)), Vec3::splat(1.0));
        // Half way between the last and the first column, above the first row's centre.
        assert_eq!(image.bilinear(Vec2::new(0.0, 0.0)), Vec3::splat(2.0));
        assert_eq!(image.bilinear(Vec2::new(1.0, 1.0)), Vec3::splat(7.0));
        assert_eq!(image.bilinear(Vec2::new(0.5, 0.5)), Vec3::splat(4.5));
    }

    #[test]
    fn interpolated_means_are_those_of_lookups() {
        let (width, height) = (9, 6);
        let pixels = (0..54).map(|index| [index as f32 * 0.37, (index * index % 11) as f32, 0.1]).collect();
        let image = EquirectImage { width, height, pixels };
        for (columns, rows) in [(9, 6), (7, 4), (4, 2), (1, 1)] {
            let means = image.interpolated_means(columns, rows);
            for cell in 0..columns * rows {
                const LOOKUPS: usize = 128;
                let (column, row) = (cell % columns, cell / columns);
                let at = |index: usize, cell: usize, cells: usize| {
                    (cell as f32 + (index as f32 + 0.5) / LOOKUPS as f32) / cells as f32
                };
                let lookup = |index: usize| {
                    let (x, y) = (at(index % LOOKUPS, column, columns), at(index / LOOKUPS, row, rows));
                    image.bilinear(Vec2::new(x, y)).as_dvec3()
                };
                let mean =
                    (0..LOOKUPS * LOOKUPS).map(lookup).sum::<glam::DVec3>() / (LOOKUPS * LOOKUPS) as f64;
                let found = Vec3::from(means.pixels[cell]).as_dvec3();
                assert!(
                    (found - mean).abs().max_element() < 0.02,
                    "{columns}x{rows}, {cell}: {found} {mean}"
                );
            }
        }
    }

    #[test]
    fn lookups_have_the_bits_of_their_definition() {
        let (width, height) = (7, 4);
        let pixels = (0..28).map(|index| [index as f32 * 0.37, (index * index % 11) as f32, 0.1]).collect();
        let image = EquirectImage { width, height, pixels };
        let pixel = |column: isize, row: isize| {
            let inside = row.clamp(0, 3);
            let half_turn = if inside == row { 0 } else { 3 };
            Vec3::from_array(image.pixels[(inside * 7 + (column + half_turn).rem_euclid(7)) as usize])
        };
        for index in 0..=900 {
            let uv = Vec2::new((index % 31) as f32 / 30.0, (index / 31) as f32 / 29.0);
            let (x, y) = (uv.x * 7.0 - 0.5, uv.y * 4.0 - 0.5);
            let (column, row) = (x.floor() as isize, y.floor() as isize);
            let (right, bottom) = (x - x.floor(), y - y.floor());
            let across = |row: isize| pixel(column, row) * (1.0 - right) + pixel(column + 1, row) * right;
            let expected = across(row) * (1.0 - bottom) + across(row + 1) * bottom;
            assert_eq!(image.bilinear(uv), expected, "{uv}");
        }
    }

    #[test]
    fn resampling_keeps_the_total_light() {
        let (width, height) = (7, 5);
        let pixels = (0..width * height).map(|index| [(index * index % 23) as f32, 1.0, 0.0]).collect();
        let image = EquirectImage { width, height, pixels };
        let total = |image: &EquirectImage| {
            let mut sum = 0.0;
            for row in 0..image.height {
                let edge =
                    |index: usize| libm::cos(index as f64 / image.height as f64 * std::f64::consts::PI);
                let area = (edge(row) - edge(row + 1)) / image.width as f64;
                for pixel in &image.pixels[row * image.width..(row + 1) * image.width] {
                    sum += f64::from(pixel[0]) * area;
                }
            }
            sum
        };
        for (new_width, new_height) in [(4, 2), (1, 1), (7, 5), (64, 32), (13, 3)] {
            let other = image.resampled(new_width, new_height);
            assert!((total(&other) - total(&image)).abs() < 1e-5, "{new_width}x{new_height}");
            assert!(other.pixels.iter().all(|pixel| (pixel[1] - 1.0).abs() < 1e-6 && pixel[2] == 0.0));
        }
    }
}
