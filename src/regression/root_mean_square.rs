//! Root mean square error, and the peak signal-to-noise ratio.

use serde::Serialize;

/// Root mean square error over the three colours of all pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RootMeanSquare {
    /// In units of the values.
    pub error: f64,
    /// Decibels: 20 log₁₀(peak / error), where the peak is 1 for displays and the reference's largest value for light; infinite
    /// without an error.
    pub peak_ratio_decibels: f64,
}

/// Compares the colours of two images of one size. `peak` is the largest possible value; `None` takes the largest of the reference.
pub fn root_mean_square(actual: &[[f32; 3]], reference: &[[f32; 3]], peak: Option<f64>) -> RootMeanSquare {
    let (mut sum, mut largest) = (0.0, 0.0);
    for (actual, reference) in actual.as_flattened().iter().zip(reference.as_flattened()) {
        let difference = f64::from(*actual) - f64::from(*reference);
        if difference.is_finite() {
            sum += difference * difference;
        }
        let value = f64::from(*reference);
        if value.is_finite() && value > largest {
            largest = value;
        }
    }
    let error = (sum / (reference.len() * 3).max(1) as f64).sqrt();
    let ratio = peak.unwrap_or(largest) / error;
    let decibels = if error == 0.0 { f64::INFINITY } else { 20.0 * libm::log10(ratio) };
    RootMeanSquare { error, peak_ratio_decibels: decibels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_off_everywhere_is_twenty_decibels() {
        let (a, b) = (vec![[0.35; 3]; 8], vec![[0.25; 3]; 8]);
        let found = root_mean_square(&a, &b, Some(1.0));
        assert!((found.error - 0.1).abs() < 1e-7 && (found.peak_ratio_decibels - 20.0).abs() < 1e-5);
        // One value of 12 off by 1: √(1/12).
        let mut one = vec![[2.0; 3]; 4];
        one[1][2] = 3.0;
        let found = root_mean_square(&one, &[[2.0; 3]; 4], None);
        assert!((found.error - (1.0_f64 / 12.0).sqrt()).abs() < 1e-12);
        assert!((found.peak_ratio_decibels - 20.0 * libm::log10(2.0 * 12.0_f64.sqrt())).abs() < 1e-9);
        assert_eq!(root_mean_square(&b, &b, None).peak_ratio_decibels, f64::INFINITY);
    }
}
