//! The noise of a pixel's mean, estimated from its samples.

use super::adaptive::display_value;
use crate::film::PixelMoments;

/// The largest standard error of the mean of `count` samples: of a colour channel, as a difference of display values from 0 to 1 at an exposure, or of
/// the coverage. Samples that are spread evenly err less than this. Fewer than two samples have an infinite error.
pub(super) fn display_error(moments: &PixelMoments, count: u32, exposure_scale: f32) -> f32 {
    if count < 2 {
        return f32::INFINITY;
    }
    let [red, green, blue, (_, coverage)] = moments.means_and_errors(count);
    let display = |radiance: f64| display_value(radiance as f32 * exposure_scale);
    let shown = |(mean, error): (f64, f64)| display(mean + error) - display(mean);
    [red, green, blue].map(shown).into_iter().fold(coverage as f32, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(samples: &[[f32; 4]]) -> PixelMoments {
        let mut moments = PixelMoments::default();
        for sample in samples {
            for (channel, &value) in sample.iter().enumerate() {
                moments.sums[channel].add(value);
                moments.squares[channel].add_square(value);
            }
        }
        moments
    }

    #[test]
    fn the_error_is_that_of_the_mean() {
        // Half of 400 samples are 0, half are 2: the variance is 1, the error of the mean 1 / √399.
        let samples: Vec<_> = (0..400).map(|i| [1.0, (i % 2) as f32 * 2.0, 1.0, 1.0]).collect();
        let expected = display_value(1.0 + 1.0 / 399_f32.sqrt()) - display_value(1.0);
        assert!((display_error(&moments(&samples), 400, 1.0) - expected).abs() < 1e-5);
        let brighter = display_value(4.0 + 4.0 / 399_f32.sqrt()) - display_value(4.0);
        assert!((display_error(&moments(&samples), 400, 4.0) - brighter).abs() < 1e-5);
    }

    #[test]
    fn equal_samples_have_no_error_and_one_has_no_estimate() {
        let sample = [0.3, 0.1, 7.0, 1.0];
        assert!(display_error(&moments(&[sample; 8]), 8, 1.0) < 1e-6);
        assert_eq!(display_error(&moments(&[sample]), 1, 1.0), f32::INFINITY);
    }

    #[test]
    fn coverage_counts_as_it_is() {
        // Half covered: variance 1/4, error 1 / (2 √3) for four samples.
        let samples = [[0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]];
        assert!((display_error(&moments(&samples), 4, 1.0) - 0.5 / 3_f32.sqrt()).abs() < 1e-6);
    }
}
