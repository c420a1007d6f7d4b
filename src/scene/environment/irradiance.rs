//! Irradiance map of an equirectangular image, and means of it under other lobes as wide.
//!
//! The image is integrated directly. Spherical harmonics would ring around a sun. On an equirectangular grid a kernel of the cosine
//! depends only on the two rows and the difference of the columns, so it is computed once for each pair of rows.

use std::f64::consts::PI;

use rayon::prelude::*;

use glam::Vec3;

use super::bordered_image::BorderedImage;
use super::equirect::EquirectImage;

/// Columns of the result, which has half as many rows. A cosine lobe is wide, so this suffices.
const WIDTH: usize = 64;
const HEIGHT: usize = WIDTH / 2;

/// Irradiance E(n) = ∫ L(ω) max(n·ω, 0) dω for normals on a 64x32 grid and at the poles, as level floors and ceilings have them. The width
/// of `source` must be a multiple of 64.
///
/// The sum of the kernel is scaled to π for each normal, so that uniform light is exact.
pub(super) fn irradiance_map(source: &EquirectImage) -> BorderedImage {
    let source = Source::new(source, |cosine| cosine);
    let poles = [0.0, PI].map(|polar| Vec3::from(source.row(polar, PI)[0]));
    BorderedImage::with_poles(&source.image(PI), poles)
}

/// Means of the image around the normals of [`irradiance_map`], by a weight of the cosine between 0 and 1.
pub(super) fn mean_image(source: &EquirectImage, weight: fn(f64) -> f64) -> EquirectImage {
    Source::new(source, weight).image(1.0)
}

/// The image with what all rows of the result need.
struct Source {
    /// Rows of the image.
    columns: Vec<ColumnRow>,
    /// See [`azimuth_cosines`].
    azimuth_cosines: Vec<f64>,
    /// Weight of light by its cosine with the normal.
    weight: fn(f64) -> f64,
}

impl Source {
    fn new(image: &EquirectImage, weight: fn(f64) -> f64) -> Self {
        let columns = image.pixels.chunks_exact(image.width).map(ColumnRow::new).collect();
        Self { columns, azimuth_cosines: azimuth_cosines(image.width), weight }
    }

    /// Sums of the light by weights whose own sum is `total`.
    fn image(&self, total: f64) -> EquirectImage {
        let polar = |row: usize| (row as f64 + 0.5) / HEIGHT as f64 * PI;
        let rows = (0..HEIGHT).into_par_iter().map(|row| self.row(polar(row), total));
        let rows: Vec<[[f32; 3]; WIDTH]> = rows.collect();
        EquirectImage { width: WIDTH, height: HEIGHT, pixels: rows.concat() }
    }

    fn row(&self, normal_polar: f64, total: f64) -> [[f32; 3]; WIDTH] {
        let mut sums = [[0.0_f64; 3]; WIDTH];
        let mut kernel_sum = 0.0;
        for (row, columns) in self.columns.iter().enumerate() {
            let kernel = self.kernel(row, normal_polar);
            let row_sum: f64 = kernel.iter().map(|&weight| f64::from(weight)).sum();
            if row_sum == 0.0 {
                continue;
            }
            kernel_sum += row_sum;
            columns.add(&kernel, &mut sums);
        }
        sums.map(|sum| sum.map(|channel| (channel * total / kernel_sum) as f32))
    }

    /// Weights of the texels of a source row, from the texel whose left edge is at or before the normal's azimuth.
    fn kernel(&self, row: usize, normal_polar: f64) -> Vec<f32> {
        let height = self.columns.len() as f64;
        let band = libm::cos(row as f64 / height * PI) - libm::cos((row as f64 + 1.0) / height * PI);
        let polar = (row as f64 + 0.5) / height * PI;
        let along = libm::cos(polar) * libm::cos(normal_polar);
        let across = libm::sin(polar) * libm::sin(normal_polar);
        let weight = |azimuth_cosine: &f64| {
            let cosine = along + across * azimuth_cosine;
            if cosine > 0.0 { ((self.weight)(cosine) * band) as f32 } else { 0.0 }
        };
        self.azimuth_cosines.iter().map(weight).collect()
    }
}

/// Cosines of the azimuths between a normal and the texels of a row, in the order of [`Source::kernel`].
fn azimuth_cosines(source_width: usize) -> Vec<f64> {
    let offset = first_texel_offset(source_width);
    let azimuth = |step: usize| (step as f64 + offset) / source_width as f64 * 2.0 * PI;
    (0..source_width).map(|step| libm::cos(azimuth(step))).collect()
}

/// Distance from the centre of a result column to the centre of the source texel that contains it, in source texels.
fn first_texel_offset(source_width: usize) -> f64 {
    let centre = source_width as f64 / WIDTH as f64 * 0.5;
    centre.floor() + 0.5 - centre
}

/// A row of the source by its distance from the columns of the result, so that one weight multiplies consecutive values.
struct ColumnRow {
    /// For each channel: every texel at the first distance from a column, for two turns, then those at the next distance.
    channels: [Vec<f32>; 3],
    /// Texels from one column to the next.
    stride: usize,
}

impl ColumnRow {
    fn new(pixels: &[[f32; 3]]) -> Self {
        let stride = pixels.len() / WIDTH;
        let channels = [0, 1, 2].map(|channel| {
            let turns = |phase: usize| (0..2 * WIDTH).map(move |column| (column % WIDTH) * stride + phase);
            (0..stride).flat_map(turns).map(|texel| pixels[texel][channel]).collect()
        });
        Self { channels, stride }
    }

    /// Adds the row, weighted by the texels' distances from each column.
    fn add(&self, kernel: &[f32], sums: &mut [[f64; 3]; WIDTH]) {
        for (channel, texels) in self.channels.iter().enumerate() {
            let mut row_sums = [0.0_f32; WIDTH];
            for (distance, weight) in kernel.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                let position = distance + self.stride / 2;
                let first = position % self.stride * (2 * WIDTH) + position / self.stride;
                for (sum, texel) in row_sums.iter_mut().zip(&texels[first..first + WIDTH]) {
                    *sum += texel * weight;
                }
            }
            for (total, row_sum) in sums.iter_mut().zip(row_sums) {
                total[channel] += f64::from(row_sum);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::equirect::{direction_from_uv, uv_from_direction};
    use super::*;

    #[test]
    fn uniform_light_gives_pi() {
        for width in [64, 128, 256] {
            let result =
                Source::new(&EquirectImage::of(width, |_| Vec3::new(1.0, 2.0, 0.0)), |cosine| cosine)
                    .image(PI);
            for pixel in &result.pixels {
                assert!((pixel[0] - std::f32::consts::PI).abs() < 1e-4);
                assert!((pixel[1] - 2.0 * std::f32::consts::PI).abs() < 2e-4);
                assert_eq!(pixel[2], 0.0);
            }
        }
    }

    #[test]
    fn low_harmonics_have_their_known_factors() {
        // A cosine lobe scales linear functions by 2π/3 and x² − 1/3 by π/4 (Ramamoorthi and Hanrahan 2001, equation 8).
        let result = irradiance_map(&EquirectImage::of(256, |d| {
            Vec3::new(1.0 + 0.5 * d.x, 1.0 - 0.8 * d.z, 1.0 + d.y * d.y - 1.0 / 3.0)
        }));
        for index in 0..200 {
            let uv = glam::Vec2::new((index as f32 * 0.618_034).fract(), (index as f32 + 0.5) / 200.0);
            let n = direction_from_uv(uv);
            let pi = std::f32::consts::PI;
            let expected = Vec3::new(
                pi + 0.5 * n.x * 2.0 * pi / 3.0,
                pi - 0.8 * n.z * 2.0 * pi / 3.0,
                pi + (n.y * n.y - 1.0 / 3.0) * pi / 4.0,
            );
            let found = result.bilinear(uv_from_direction(n));
            assert!((found - expected).abs().max_element() < 0.01, "{n}: {found} for {expected}");
        }
    }

    #[test]
    fn level_floors_receive_nothing_from_below_the_horizon() {
        // Bands of the sky above and below the horizon: 2.8°, or two rows of texels. A floor receives π sin² of the height.
        let height = 2.0 * PI / 128.0;
        for side in [1.0, -1.0] {
            let band =
                |d: Vec3| if (0.0..libm::sin(height) as f32).contains(&(d.y * side)) { 1.0 } else { 0.0 };
            let map = irradiance_map(&EquirectImage::of(256, |d| Vec3::splat(band(d))));
            let sine = libm::sin(height);
            let lit = map.bilinear(uv_from_direction(Vec3::Y * side)).x;
            assert!((f64::from(lit) / (PI * sine * sine) - 1.0).abs() < 0.02, "{lit}");
            let dark = map.bilinear(uv_from_direction(Vec3::NEG_Y * side));
            assert!(dark.abs().max_element() < 1e-6, "{dark}");
        }
    }

    #[test]
    fn a_small_sun_gives_its_cosine() {
        // A texel of radiance L and solid angle Ω far away gives L Ω cos θ, and nothing below the horizon.
        let mut image = EquirectImage::of(256, |_| Vec3::ZERO);
        let (column, row) = (77, 40);
        let sun = direction_from_uv(image.texel_uv(column, row));
        image.pixels[row * 256 + column] = [1e4; 3];
        let edge = |row: usize| libm::cos(row as f64 / 128.0 * PI) as f32;
        let band = edge(row) - edge(row + 1);
        let power = 1e4 * band * 2.0 * std::f32::consts::PI / 256.0;
        let result = Source::new(&image, |cosine| cosine).image(PI);
        for row in 0..HEIGHT {
            for column in 0..WIDTH {
                let n = direction_from_uv(result.texel_uv(column, row));
                let expected = power * if n.dot(sun) > 0.0 { n.dot(sun) } else { 0.0 };
                let found = result.pixels[row * WIDTH + column][1];
                assert!((found - expected).abs() < 1e-3 * power, "{found} for {expected}");
            }
        }
    }
}
