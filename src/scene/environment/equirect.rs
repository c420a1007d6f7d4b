//! Equirectangular images: the map between texels and directions, bilinear lookups, and resampling.
//!
//! Columns run around +Y: the centre of the image is −Z (where a glTF camera looks), its right quarter +X, both edges +Z.
//! Rows run from +Y at the top to −Y at the bottom.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

/// Radiance on an equirectangular grid, row-major from the top.
#[derive(Clone, Debug)]
pub(super) struct EquirectImage {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<[f32; 3]>,
}

/// Image coordinates of a unit direction, in the unit square with the origin at the top left.
pub(super) fn uv_from_direction(direction: Vec3) -> Vec2 {
    let azimuth = libm::atan2f(direction.x, -direction.z);
    let horizontal = (direction.x * direction.x + direction.z * direction.z).sqrt();
    let polar = libm::atan2f(horizontal, direction.y);
    Vec2::new(0.5 + azimuth / (2.0 * PI), polar / PI)
}

/// Unit direction of image coordinates in the unit square.
pub(super) fn direction_from_uv(uv: Vec2) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = libm::sincosf((uv.x - 0.5) * 2.0 * PI);
    let (sin_polar, cos_polar) = libm::sincosf(uv.y * PI);
    Vec3::new(sin_polar * sin_azimuth, cos_polar, -sin_polar * cos_azimuth)
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
    pub(super) fn bilinear(&self, uv: Vec2) -> Vec3 {
        let x = uv.x * self.width as f32 - 0.5;
        let y = uv.y * self.height as f32 - 0.5;
        let (left, top) = (x.floor(), y.floor());
        let (right_share, bottom_share) = (x - left, y - top);
        let (column, row) = (left as isize, top as isize);
        let across = |row: isize| {
            self.wrapped_pixel(column, row) * (1.0 - right_share)
                + self.wrapped_pixel(column + 1, row) * right_share
        };
        across(row) * (1.0 - bottom_share) + across(row + 1) * bottom_share
    }

    /// The texel at a column that wraps around and a row at most one beyond a pole.
    fn wrapped_pixel(&self, column: isize, row: isize) -> Vec3 {
        let inside = row.clamp(0, self.height as isize - 1);
        let half_turn = if inside == row { 0 } else { self.width as isize / 2 };
        let wrapped = (column + half_turn).rem_euclid(self.width as isize);
        Vec3::from_array(self.pixels[inside as usize * self.width + wrapped as usize])
    }

    /// Resamples to another grid. Each new texel holds the mean over its solid angle.
    pub(super) fn resampled(&self, width: usize, height: usize) -> Self {
        let columns = overlaps(self.width, width, |edge| edge);
        // The area of a band between two polar angles is proportional to the difference of their cosines.
        let rows = overlaps(self.height, height, |edge| -libm::cos(edge * std::f64::consts::PI));
        let mut pixels = Vec::with_capacity(width * height);
        for (first_row, row_shares) in &rows {
            let band = self.mean_of_rows(*first_row, row_shares);
            for (first_column, column_shares) in &columns {
                let mut sum = [0.0_f64; 3];
                for (pixel, share) in band[*first_column..].iter().zip(column_shares) {
                    for (total, channel) in sum.iter_mut().zip(pixel) {
                        *total += channel * share;
                    }
                }
                pixels.push(sum.map(|channel| channel as f32));
            }
        }
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
