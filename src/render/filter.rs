//! Pixel filters: how much a sample counts for a pixel by its distance from the middle.
//!
//! Source: Ernst, Stamminger, Greiner, "Filter Importance Sampling", RT 2006: samples are placed as densely as the filter is
//! high, and count alike. So a pixel needs no sample of another, and crops stay exact. Where a filter is negative its samples
//! count negatively.

use std::f64::consts::PI;

use glam::Vec2;

/// A separable filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelFilter {
    /// The pixel's square, one pixel wide.
    #[default]
    Box,
    /// Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", SIGGRAPH 1988, with B = C = 1/3: four pixels
    /// wide, sharpens a little. Takes 16 samples or more to show.
    Mitchell,
    /// The four-term window of Harris, "On the Use of Windows for Harmonic Analysis", 1978, three pixels wide.
    BlackmanHarris,
}

/// A place in the picture that counts for a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelSample {
    /// From the pixel's top left corner, pixels.
    pub(super) offset: Vec2,
    /// 1 or −1.
    pub(super) weight: f32,
}

/// Intervals of the table that turns uniform numbers into distances.
const CELLS: usize = 1024;

impl PixelFilter {
    /// All filters.
    pub const ALL: [Self; 3] = [Self::Box, Self::Mitchell, Self::BlackmanHarris];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Mitchell => "mitchell",
            Self::BlackmanHarris => "blackman-harris",
        }
    }

    /// Where it ends, pixels from the middle.
    fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Mitchell => 2.0,
            Self::BlackmanHarris => 1.5,
        }
    }

    /// Its height at `x` pixels from the middle, along one axis; not normalised.
    fn height(self, x: f64) -> f64 {
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

    /// Moves points that are spread evenly over the pixel's square so that they are as dense as the filter is high.
    pub(super) fn samples(self, even: &[Vec2]) -> Vec<PixelSample> {
        if self == Self::Box {
            return even.iter().map(|&offset| PixelSample { offset, weight: 1.0 }).collect();
        }
        let table = self.distances();
        let place = |u: f32| {
            let (distance, weight) = look_up(&table, self, f64::from(u));
            (distance as f32 + 0.5, weight)
        };
        even.iter()
            .map(|point| {
                let ((x, weight_x), (y, weight_y)) = (place(point.x), place(point.y));
                PixelSample { offset: Vec2::new(x, y), weight: weight_x * weight_y }
            })
            .collect()
    }

    /// The area below the absolute height up to the end of each cell, divided by the whole.
    fn distances(self) -> Vec<f64> {
        let width = 2.0 * self.radius() / CELLS as f64;
        let mut sum = 0.0;
        let mut sums = Vec::with_capacity(CELLS);
        for cell in 0..CELLS {
            sum += self.height((cell as f64 + 0.5) * width - self.radius()).abs();
            sums.push(sum);
        }
        sums.iter().map(|below| below / sum).collect()
    }
}

/// Where the share `u` of the area lies below, and the filter's sign there.
fn look_up(table: &[f64], filter: PixelFilter, u: f64) -> (f64, f32) {
    let cell = table.partition_point(|&below| below <= u).min(CELLS - 1);
    let start = if cell == 0 { 0.0 } else { table[cell - 1] };
    let share = (u - start) / (table[cell] - start).max(f64::MIN_POSITIVE);
    let distance = ((cell as f64 + share) / CELLS as f64 * 2.0 - 1.0) * filter.radius();
    let middle = ((cell as f64 + 0.5) / CELLS as f64 * 2.0 - 1.0) * filter.radius();
    (distance, if filter.height(middle) < 0.0 { -1.0 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::super::sampling::pixel_offsets;
    use super::*;

    #[test]
    fn a_box_moves_nothing() {
        let even = pixel_offsets(7, 0);
        let samples = PixelFilter::Box.samples(&even);
        assert!(
            samples.iter().zip(&even).all(|(sample, &even)| sample.offset == even && sample.weight == 1.0)
        );
    }

    #[test]
    fn weighted_samples_have_the_moments_of_the_filter() {
        // Over the filter along one axis: ∫ f = 1 after normalisation, the mean is the middle, and the second moment is
        // ∫ x² f: by quadrature here, from the placed samples there.
        let even = pixel_offsets(4096, 0);
        for filter in PixelFilter::ALL {
            let samples = filter.samples(&even);
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
                area += filter.height(x);
                second += x * x * filter.height(x);
            }
            assert!(moment(1).abs() < 2e-3, "{filter:?} {}", moment(1));
            assert!((moment(2) - second / area).abs() < 8e-3, "{filter:?} {} {}", moment(2), second / area);
        }
    }

    #[test]
    fn mitchell_is_continuous_and_sums_to_one() {
        // B-spline family: the filter's integer translates sum to a constant, here 6.
        for x in [0.0, 0.1, 0.25, 0.5, 0.9] {
            let sum: f64 = (-3..=3).map(|k| PixelFilter::Mitchell.height(x + f64::from(k))).sum();
            assert!((sum - 6.0).abs() < 1e-12, "{sum}");
        }
        assert!(PixelFilter::Mitchell.height(1.5) < 0.0);
    }
}
