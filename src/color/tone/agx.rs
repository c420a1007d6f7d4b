//! AgX: low contrast, with headroom for bright colours, which desaturate like film.
//!
//! Sources: Troy Sobotka, "AgX" (2022), and Benjamin Wrensch's polynomial of its base look (2023): a matrix that
//! desaturates, the logarithm over 16.5 stops, a polynomial of degree six, and the inverse matrix. The result is encoded for a
//! display of gamma 2.2. It is decoded here, because all curves return linear light.

use glam::{Mat3, Vec3};

/// From linear Rec.709, by columns.
const BEFORE: Mat3 = Mat3::from_cols(
    Vec3::new(0.842_479_06, 0.042_328_242, 0.042_375_655),
    Vec3::new(0.078_433_6, 0.878_468_64, 0.078_433_6),
    Vec3::new(0.079_223_745, 0.079_166_13, 0.879_143),
);
/// Inverse of `BEFORE`.
const AFTER: Mat3 = Mat3::from_cols(
    Vec3::new(1.196_879, -0.052_896_85, -0.052_971_636),
    Vec3::new(-0.098_020_88, 1.151_903_1, -0.098_043_45),
    Vec3::new(-0.099_029_74, -0.098_961_18, 1.151_073_7),
);
/// Darkest and brightest light, in stops relative to 1.
const STOPS: [f32; 2] = [-12.473_93, 4.026_069];
/// Coefficients of the curve, constant term first.
const POLYNOMIAL: [f32; 7] = [-0.002_32, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];

/// Applies the curve to light without negative channels. The result is not clipped.
pub(super) fn apply(light: Vec3) -> Vec3 {
    let finite = light.map(|channel| if channel < f32::MAX { channel } else { f32::MAX });
    let curved = (BEFORE * (finite * 0.25)).map(|quarter| curve(libm::log2f(quarter) + 2.0));
    (AFTER * curved).map(|encoded| if encoded > 0.0 { libm::powf(encoded, 2.2) } else { 0.0 })
}

fn curve(stops: f32) -> f32 {
    let [darkest, brightest] = STOPS;
    let x = ((stops - darkest) / (brightest - darkest)).clamp(0.0, 1.0);
    POLYNOMIAL.iter().rev().fold(0.0, |sum, factor| sum * x + factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_inverse() {
        let both = AFTER * BEFORE;
        assert!(both.abs_diff_eq(Mat3::IDENTITY, 1e-4), "{both}");
    }

    #[test]
    fn mid_grey_has_its_published_value() {
        // 0.18 lies 10 of 16.5 stops up: x = 0.606061, the polynomial gives 0.49673, and 0.49673^2.2 = 0.21452.
        let grey = apply(Vec3::splat(0.18));
        assert!((grey - Vec3::splat(0.214_52)).abs().max_element() < 2e-4, "{grey}");
        // The matrices' rows sum to one within 2e-4.
        assert!(apply(Vec3::splat(20.0)).min_element() > 0.99);
        assert_eq!(apply(Vec3::ZERO), Vec3::ZERO);
    }
}
