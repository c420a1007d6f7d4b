//! Reconstruction filters of pixels.
//!
//! Source: Ernst, Stamminger, Greiner, "Filter Importance Sampling", RT 2006: the density of samples is proportional to the absolute
//! filter, and their weights are 1, or −1 where the filter is negative. So a pixel needs no sample of another one, and
//! crops stay exact.

use std::f64::consts::PI;

use glam::Vec2;

/// A separable reconstruction filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelFilter {
    /// Box, one pixel wide.
    #[default]
    Box,
    /// Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", SIGGRAPH 1988, with B = C = 1/3: four pixels
    /// wide, sharpens slightly. Needs 16 samples or more.
    Mitchell,
    /// The four-term window of Harris, "On the Use of Windows for Harmonic Analysis", 1978, three pixels wide.
    BlackmanHarris,
}

/// A sample position of a pixel with its filter weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelSample {
    /// Offset from the pixel's top left corner, pixels.
    pub(super) offset: Vec2,
    /// 1 or −1.
    pub(super) weight: f32,
}

/// Intervals of the inverted cumulative distribution.
const CELLS: usize = 1024;

impl PixelFilter {
    /// All filters.
    pub const ALL: [Self; 3] = [Self::Box, Self::Mitchell, Self::BlackmanHarris];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Mitchell => "mitchell",
            Self::BlackmanHarris => "blackman-harris",
        }
    }

    /// Whether some samples have a weight of −1.
    pub fn has_negative_lobes(self) -> bool {
        match self {
            Self::Box | Self::BlackmanHarris => false,
            Self::Mitchell => true,
        }
    }

    /// Half the width, pixels.
    fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Mitchell => 2.0,
            Self::BlackmanHarris => 1.5,
        }
    }

    /// The filter at `x` pixels from the centre along one axis; not normalised.
    fn value(self, x: f64) -> f64 {
        let distance = x.abs();
        if distance > self.radius() {
            return 0.0;
        }
        match self {
            Self::Box => 1.0,
            Self::Mitchell if distance < 1.0 => (7.0 * distance - 12.0) * distance * distance + 16.0 / 3.0,
            Self::Mitchell => ((-7.0 / 3.0 * distance + 12.0) * distance - 20.0) * distance + 32.0 / 3.0,
            Self::BlackmanHarris => {
                let angle = PI * (x / self.radius() + 1.0);
                0.35875 - 0.48829 * libm::cos(angle) + 0.14128 * libm::cos(2.0 * angle)
                    - 0.01168 * libm::cos(3.0 * angle)
            }
        }
    }

    /// Warps points that are uniform in the unit square so that their density follows the absolute filter.
    pub(super) fn samples(self, uniform: &[Vec2]) -> Vec<PixelSample> {
        if self == Self::Box {
            return uniform.iter().map(|&offset| PixelSample { offset, weight: 1.0 }).collect();
        }
        let table = self.cumulative_distribution();
        let warp = |u: f32| {
            let (distance, weight) = invert(&table, self, f64::from(u));
            (distance as f32 + 0.5, weight)
        };
        uniform
            .iter()
            .map(|point| {
                let ((x, weight_x), (y, weight_y)) = (warp(point.x), warp(point.y));
                PixelSample { offset: Vec2::new(x, y), weight: weight_x * weight_y }
            })
            .collect()
    }

    /// Cumulative distribution of the absolute filter at the end of each cell.
    fn cumulative_distribution(self) -> Vec<f64> {
        let width = 2.0 * self.radius() / CELLS as f64;
        let mut sum = 0.0;
        let mut sums = Vec::with_capacity(CELLS);
        for cell in 0..CELLS {
            sum += self.value((cell as f64 + 0.5) * width - self.radius()).abs();
            sums.push(sum);
        }
        sums.iter().map(|below| below / sum).collect()
    }
}

/// The distance from the centre at which the cumulative distribution is `u`, and the sign of the filter there.
fn invert(table: &[f64], filter: PixelFilter, u: f64) -> (f64, f32) {
    let cell = table.partition_point(|&below| below <= u).min(CELLS - 1);
    let start = if cell == 0 { 0.0 } else { table[cell - 1] };
    let share = ((u - start) / (table[cell] - start).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let distance = ((cell as f64 + share) / CELLS as f64 * 2.0 - 1.0) * filter.radius();
    let center = ((cell as f64 + 0.5) / CELLS as f64 * 2.0 - 1.0) * filter.radius();
    (distance, if filter.value(center) < 0.0 { -1.0 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::super::pixel_offsets::pixel_offsets;
    use super::*;

    #[test]
    fn the_box_filter_moves_no_sample() {
        let uniform = pixel_offsets(7, 0);
        let samples = PixelFilter::Box.samples(&uniform);
        assert!(
            samples
                .iter()
                .zip(&uniform)
                .all(|(sample, &offset)| sample.offset == offset && sample.weight == 1.0)
        );
    }

    #[test]
    fn weighted_samples_have_the_moments_of_the_filter() {
        // For the normalised filter along one axis, the mean is 0 and the second moment is ∫ x² f. The samples' moments are compared
        // with quadrature.
        let uniform = pixel_offsets(4096, 0);
        for filter in PixelFilter::ALL {
            let samples = filter.samples(&uniform);
            let total: f64 = samples.iter().map(|sample| f64::from(sample.weight)).sum();
            let moment = |power: i32| {
                let term = |sample: &PixelSample| {
                    f64::from(sample.weight) * (f64::from(sample.offset.x) - 0.5).powi(power)
                };
                samples.iter().map(term).sum::<f64>() / total
            };
            let steps = 20_000;
            let (mut area, mut second) = (0.0, 0.0);
            for step in 0..steps {
                let x = (f64::from(step) + 0.5) / f64::from(steps) * 5.0 - 2.5;
                area += filter.value(x);
                second += x * x * filter.value(x);
            }
            assert!(moment(1).abs() < 2e-3, "{filter:?} {}", moment(1));
            assert!((moment(2) - second / area).abs() < 8e-3, "{filter:?} {} {}", moment(2), second / area);
        }
    }

    #[test]
    fn mitchell_is_continuous_and_sums_to_one() {
        // B-spline family: the filter's integer translates sum to a constant, here 6.
        for x in [0.0, 0.1, 0.25, 0.5, 0.9] {
            let sum: f64 = (-3..=3).map(|k| PixelFilter::Mitchell.value(x + f64::from(k))).sum();
            assert!((sum - 6.0).abs() < 1e-12, "{sum}");
        }
        assert!(PixelFilter::Mitchell.value(1.5) < 0.0);
    }
}
