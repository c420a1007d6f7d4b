//! The noise of a pixel's mean, estimated from its samples.

use super::adaptive::display_value;
use crate::color::luminance;
use crate::integrator::whitted::SampleValue;

/// Samples of the first pass; later ones double the number.
pub(super) const FIRST_PASS: usize = 32;

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PixelNoise {
    count: f64,
    /// Sums of luminance and coverage.
    sums: [f64; 2],
    squares: [f64; 2],
}

impl PixelNoise {
    /// Adds samples.
    pub(super) fn add(&mut self, values: &[SampleValue]) {
        for value in values {
            self.count += 1.0;
            for (channel, value) in [luminance(value.radiance), value.coverage].into_iter().enumerate() {
                let value = f64::from(value);
                self.sums[channel] += value;
                self.squares[channel] += value * value;
            }
        }
    }

    /// The larger of the standard errors of the mean luminance, as a difference of display values, and of the mean coverage. Samples that are
    /// spread evenly err less than this.
    pub(super) fn display_error(&self) -> f32 {
        let [(light, light_error), (_, coverage_error)] = [0, 1].map(|channel| self.mean_and_error(channel));
        let error = display_value((light + light_error) as f32) - display_value(light as f32);
        error.max(coverage_error as f32)
    }

    fn mean_and_error(&self, channel: usize) -> (f64, f64) {
        let mean = self.sums[channel] / self.count;
        let variance = (self.squares[channel] / self.count - mean * mean) / (self.count - 1.0);
        (mean, if variance > 0.0 { variance.sqrt() } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn the_error_is_that_of_the_mean() {
        // Half of 400 samples are 0, half are 2: the variance is 1, the error of the mean 1 / √399.
        let mut noise = PixelNoise::default();
        for radiance in [Vec3::ZERO, Vec3::splat(2.0)] {
            noise.add(&[SampleValue { radiance, coverage: 1.0 }; 200]);
        }
        let expected = display_value(1.0 + 1.0 / 399_f32.sqrt()) - display_value(1.0);
        assert!((noise.display_error() - expected).abs() < 1e-5);
        let mut still = PixelNoise::default();
        still.add(&[SampleValue { radiance: Vec3::ONE, coverage: 1.0 }; 8]);
        assert_eq!(still.display_error(), 0.0);
    }
}
