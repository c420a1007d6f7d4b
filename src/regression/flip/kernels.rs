//! The one-dimensional filters of FLIP: contrast sensitivity of the eye, and edge and point detection.
//!
//! Source: Andersson et al. 2020, sections 4.1.1 (contrast sensitivity, after Johnson and Fairchild) and 4.3. All of them
//! are separable, so each is applied in two passes.

use std::f64::consts::PI;

/// A contrast sensitivity function in space: sum of amplitude · √(π / width) · exp(−π² z² / width), z in degrees.
type Sensitivity = [(f64, f64); 2];

const LIGHTNESS: Sensitivity = [(1.0, 0.0047), (0.0, 1e-5)];
const RED_GREEN: Sensitivity = [(1.0, 0.0053), (0.0, 1e-5)];
const BLUE_YELLOW: Sensitivity = [(34.1, 0.04), (13.5, 0.025)];
/// The largest of these widths.
const WIDEST: f64 = 0.04;
/// Width of a feature, degrees.
const FEATURE_WIDTH_DEGREES: f64 = 0.082;

/// The filters at one resolution, each of `2 · radius + 1` weights.
pub(super) struct Kernels {
    /// Pixels on either side.
    pub(super) radius: usize,
    /// Blur of the lightness.
    pub(super) lightness: Vec<f32>,
    /// Blur of red against green.
    pub(super) red_green: Vec<f32>,
    /// Blur of blue against yellow is the sum of two, each applied in both directions.
    pub(super) blue_yellow: [Vec<f32>; 2],
    /// Gaussian, across features.
    pub(super) bell: Vec<f32>,
    /// First derivative of the Gaussian, for edges.
    pub(super) slope: Vec<f32>,
    /// Second derivative of the Gaussian, for points.
    pub(super) bend: Vec<f32>,
}

impl Kernels {
    /// The filters for an observer who sees this many pixels a degree.
    pub(super) fn new(pixels_per_degree: f64) -> Self {
        let blur_radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil();
        let deviation = 0.5 * FEATURE_WIDTH_DEGREES * pixels_per_degree;
        let feature_radius = (3.0 * deviation).ceil();
        let radius = blur_radius.max(feature_radius) as usize;
        let sampled = |reach: f64, weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let offsets = (0..=2 * radius).map(|index| index as f64 - radius as f64);
            offsets.map(|x| if x.abs() <= reach { weight(x) } else { 0.0 }).collect()
        };
        let blur = |amplitude: f64, width: f64| {
            let z = |x: f64| x / pixels_per_degree;
            // The square root, because the filter is applied in both directions.
            let amplitude = (amplitude * (PI / width).sqrt()).sqrt();
            sampled(blur_radius, &|x| amplitude * libm::exp(-PI * PI * z(x) * z(x) / width))
        };
        let both = |[first, second]: Sensitivity| {
            let parts = [blur(first.0, first.1), blur(second.0, second.1)];
            let total: f64 = parts.iter().map(|part| part.iter().sum::<f64>()).map(|sum| sum * sum).sum();
            parts.map(|part| part.iter().map(|weight| (weight / total.sqrt()) as f32).collect::<Vec<f32>>())
        };
        let bell = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
        let [lightness, _] = both(LIGHTNESS);
        let [red_green, _] = both(RED_GREEN);
        Self {
            radius,
            lightness,
            red_green,
            blue_yellow: both(BLUE_YELLOW),
            bell: balanced(&sampled(feature_radius, &bell)),
            slope: balanced(&sampled(feature_radius, &|x| -x * bell(x))),
            bend: balanced(&sampled(feature_radius, &|x| (x * x / (deviation * deviation) - 1.0) * bell(x))),
        }
    }
}

/// Normalises weights so that positive ones sum to 1 and negative ones to −1.
fn balanced(weights: &[f64]) -> Vec<f32> {
    let above: f64 = weights.iter().filter(|weight| **weight > 0.0).sum();
    let below: f64 = -weights.iter().filter(|weight| **weight < 0.0).sum::<f64>();
    weights
        .iter()
        .map(|weight| (weight / if *weight > 0.0 { above } else { below.max(f64::MIN_POSITIVE) }) as f32)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(weights: &[f32]) -> f64 {
        weights.iter().map(|&weight| f64::from(weight)).sum()
    }

    #[test]
    fn blurs_keep_a_constant_image_and_derivatives_erase_it() {
        for pixels_per_degree in [5.0, 67.0, 120.0] {
            let kernels = Kernels::new(pixels_per_degree);
            for blur in [&kernels.lightness, &kernels.red_green, &kernels.bell] {
                assert!((sum(blur) - 1.0).abs() < 1e-6);
            }
            let [narrow, wide] = kernels.blue_yellow.each_ref().map(|part| sum(part));
            assert!((narrow * narrow + wide * wide - 1.0).abs() < 1e-6);
            assert!(sum(&kernels.slope).abs() < 1e-6 && sum(&kernels.bend).abs() < 1e-6);
        }
    }

    #[test]
    fn radii_match_the_paper() {
        // 3 √(0.04 / 2π²) · 67 = 9.05, up to 10; 3 · 0.041 · 67 = 8.24, up to 9.
        let kernels = Kernels::new(67.0);
        assert_eq!(kernels.radius, 10);
        assert_eq!((kernels.bell[0], kernels.bell.len()), (0.0, 21));
        assert!(kernels.bell[1] > 0.0);
    }
}
