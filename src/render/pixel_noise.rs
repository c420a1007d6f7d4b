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

/// Share of a pixel's samples that hit the scene where all do.
const MOST_COVERED: f64 = 0.999;
/// Exposed radiance of the sample that may be yet to come: two stops above the middle of what a display shows.
const UNSEEN_RADIANCE: f64 = 4.0;

/// The error by which a pixel decides whether it is done: [`display_error`], or what one more sample would change if that is more. That
/// sample's exposed radiance is [`UNSEEN_RADIANCE`], by one more than the number of equal samples that the samples so far are worth:
/// (Σ x)² / Σ x² (Kish, "Survey Sampling", 1965). So a pixel that few or none of its paths light goes on. Pixels where rays miss
/// the scene do not, nor do shadows that cover a part of what receives them, whose colour is black.
pub(super) fn stopping_error(moments: &PixelMoments, count: u32, exposure_scale: f32) -> f32 {
    let error = display_error(moments, count, exposure_scale);
    let [red, green, blue, coverage] = [0, 1, 2, 3].map(|channel: usize| moments.sums[channel].to_f64());
    if coverage < f64::from(count) * MOST_COVERED {
        return error;
    }
    let (channel, sum) =
        [red, green, blue].into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
    let squares = moments.squares[channel].squares_to_f64();
    let equal_samples = if squares > 0.0 { sum * sum / squares } else { 0.0 };
    let count = f64::from(count.max(1));
    let mean = sum / count * f64::from(exposure_scale);
    let unseen = UNSEEN_RADIANCE / ((1.0 + equal_samples) * count);
    error.max(display_value((mean + unseen) as f32) - display_value(mean as f32))
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
    fn dark_pixels_of_a_surface_wait_for_a_bright_sample() {
        // √(4/10,004) is the display value of one sample of radiance 4 in 10,000.
        let dark = |count: usize| moments(&vec![[0.0, 0.0, 0.0, 1.0]; count]);
        assert!(stopping_error(&dark(32), 32, 1.0) > 0.17);
        assert!((stopping_error(&dark(10_000), 10_000, 1.0) - 0.02).abs() < 1e-4);
        // Nothing is there.
        assert_eq!(stopping_error(&moments(&[[0.0; 4]; 32]), 32, 1.0), 0.0);
        // Samples that agree are believed, whatever their colour.
        for color in [[0.2, 0.2, 0.2, 1.0], [0.0, 0.5, 0.0, 1.0]] {
            assert!(stopping_error(&moments(&[color; 32]), 32, 1.0) < 0.004, "{color:?}");
        }
        // One of 32 samples is not.
        let mut one = vec![[0.0, 0.0, 0.0, 1.0]; 32];
        one[7] = [0.01, 0.01, 0.01, 1.0];
        assert!(stopping_error(&moments(&one), 32, 1.0) > 0.1);
    }

    #[test]
    fn coverage_counts_as_it_is() {
        // Half covered: variance 1/4, error 1 / (2 √3) for four samples.
        let samples = [[0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]];
        assert!((display_error(&moments(&samples), 4, 1.0) - 0.5 / 3_f32.sqrt()).abs() < 1e-6);
    }
}
