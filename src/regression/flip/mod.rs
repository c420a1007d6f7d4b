//! FLIP: the perceived difference of two images that alternate, for each pixel, from 0 (equal) to 1.
//!
//! Source: P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. Fairchild, *FLIP: A Difference Evaluator
//! for Alternating Images*, HPG 2020 (display images); P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Möller,
//! *Visualizing Errors in Rendered High Dynamic Range Images*, Eurographics 2021 (unbounded light); the same authors in *Ray
//! Tracing Gems II*, chapter 19. `tests/oracles/compare_flip.py` compares the results with the published tool's.
//!
//! FLIP compares colours only: no alpha, no layers. Negative light counts as zero.

mod band;
mod color;
mod exposures;
mod kernels;

use band::{Band, Rows};
use exposures::tone_mapped;
use kernels::Kernels;
use rayon::prelude::*;

use crate::color::srgb_to_linear;

pub use exposures::Exposures;
pub(super) use exposures::{LEAST_LUMINANCE, has_light};

/// Pixels a degree for an observer 0.7 m from a display 0.7 m wide with 3840 columns.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;
/// Rows of a band. One thread computes a band.
const BAND_ROWS: usize = 32;

/// FLIP of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Row-major, top row first, from 0 to 1.
    pub errors: Vec<f32>,
    /// The exposures over which the maximum was taken; `None` for display images.
    pub exposures: Option<Exposures>,
}

/// FLIP of display images, in sRGB values between 0 and 1. Both are of `size`.
pub fn flip_display(
    reference: &[[f32; 3]],
    test: &[[f32; 3]],
    size: (u32, u32),
    pixels_per_degree: f64,
) -> FlipMap {
    let linear = |image: &[[f32; 3]]| -> Vec<[f32; 3]> {
        image.iter().map(|pixel| pixel.map(|value| srgb_to_linear(unit(value)))).collect()
    };
    let (reference, test) = (linear(reference), linear(test));
    let errors = in_bands(size, pixels_per_degree, |rows, kernels| {
        let band = |image: &[[f32; 3]]| Band::new(rows, kernels.radius, |at| image[at]);
        band::errors(&band(&reference), &band(&test), rows, kernels)
    });
    FlipMap { size, errors, exposures: None }
}

/// FLIP of images of linear light: the maximum over exposures.
pub(super) fn flip_light_at(
    exposures: Exposures,
    reference: &[[f32; 3]],
    test: &[[f32; 3]],
    size: (u32, u32),
    pixels_per_degree: f64,
) -> FlipMap {
    let scales = exposures.scales();
    let errors = in_bands(size, pixels_per_degree, |rows, kernels| {
        let mut worst = vec![0.0_f32; rows.width * rows.count];
        let mut compare_as = |shown: &dyn Fn(f32) -> f32| {
            let band = |image: &[[f32; 3]]| Band::new(rows, kernels.radius, |at| image[at].map(shown));
            let found = band::errors(&band(reference), &band(test), rows, kernels);
            worst.iter_mut().zip(found).for_each(|(worst, error)| *worst = worst.max(error));
        };
        for scale in &scales {
            compare_as(&|light| tone_mapped(light * scale));
        }
        for scale in &exposures.linear {
            compare_as(&|light| unit(light * scale));
        }
        worst
    });
    FlipMap { size, errors, exposures: Some(exposures) }
}

/// Computes the errors of all bands in parallel, in order.
fn in_bands(
    size: (u32, u32),
    pixels_per_degree: f64,
    errors: impl Fn(Rows, &Kernels) -> Vec<f32> + Sync,
) -> Vec<f32> {
    let (width, height) = (size.0 as usize, size.1 as usize);
    if width == 0 {
        return Vec::new();
    }
    let kernels = Kernels::new(pixels_per_degree);
    let bands = (0..height.div_ceil(BAND_ROWS)).into_par_iter().map(|band| {
        let first = band * BAND_ROWS;
        errors(Rows { width, height, first, count: BAND_ROWS.min(height - first) }, &kernels)
    });
    bands.collect::<Vec<_>>().concat()
}

/// A value clamped to the unit interval. NaN becomes 0.
fn unit(value: f32) -> f32 {
    if value > 0.0 { value.clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(size: (u32, u32), offset: f32) -> Vec<[f32; 3]> {
        let count = size.0 * size.1;
        (0..count).map(|at| [at as f32 / count as f32 * 0.5 + offset, 0.3, 0.1 + offset]).collect()
    }

    /// FLIP of linear light between an image and itself.
    fn light_errors(image: &[[f32; 3]], size: (u32, u32)) -> Vec<f32> {
        let exposures = Exposures::of_pair(image, image);
        flip_light_at(exposures, image, image, size, PIXELS_PER_DEGREE).errors
    }

    #[test]
    fn equal_images_have_no_error_and_black_to_white_a_large_one() {
        let size = (40, 37);
        let image = ramp(size, 0.0);
        assert!(flip_display(&image, &image, size, PIXELS_PER_DEGREE).errors.iter().all(|&e| e == 0.0));
        assert!(light_errors(&image, size).iter().all(|&error| error == 0.0));
        // Black and white are 100 apart; 100^0.7 = 25.12. The largest, green to blue with Hunt's chroma, is 308.2^0.7 = 55.2, of
        // which 0.4 is 22.1: 0.95 + (25.12 − 22.1) / 33.1 · 0.05 = 0.9546.
        let (black, white) = (vec![[0.0; 3]; 1480], vec![[1.0; 3]; 1480]);
        let map = flip_display(&black, &white, size, PIXELS_PER_DEGREE);
        assert!(map.errors.iter().all(|&error| (0.95..0.98).contains(&error)), "{}", map.errors[0]);
    }

    #[test]
    fn band_borders_do_not_affect_the_result() {
        // One row more or less moves the borders between bands; only rows near the image's end may change.
        let (tall, cut) = ((24, 80), (24, 70));
        let (reference, test) = (ramp(tall, 0.0), ramp(tall, 0.05));
        let pixels = 24 * 70;
        let whole = flip_display(&reference, &test, tall, PIXELS_PER_DEGREE);
        let part = flip_display(&reference[..pixels], &test[..pixels], cut, PIXELS_PER_DEGREE);
        let away = 24 * 59;
        assert_eq!(whole.errors[..away], part.errors[..away]);
    }

    #[test]
    fn images_of_one_pixel_and_of_none_are_valid() {
        assert_eq!(light_errors(&[[1.0; 3]], (1, 1)), [0.0]);
        assert!(flip_display(&[], &[], (0, 0), 67.0).errors.is_empty());
    }
}
