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
    sum: f64,
    squares: f64,
}

impl PixelNoise {
    /// Adds samples.
    pub(super) fn add(&mut self, values: &[SampleValue]) {
        for value in values {
            let light = f64::from(luminance(value.radiance));
            self.count += 1.0;
            self.sum += light;
            self.squares += light * light;
        }
    }

    /// The standard error of the mean luminance, as a difference of display values. Samples that are spread evenly err less than this.
    pub(super) fn display_error(&self) -> f32 {
        let mean = self.sum / self.count;
        let variance = (self.squares / self.count - mean * mean) / (self.count - 1.0);
        let error = if variance > 0.0 { variance.sqrt() } else { 0.0 };
        display_value((mean + error) as f32) - display_value(mean as f32)
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
