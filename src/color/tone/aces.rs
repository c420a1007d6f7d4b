//! Approximation of the ACES 1.0 reference rendering for sRGB displays.
//!
//! Source: Stephen Hill's fit of ACES 1.0's RRT and sRGB ODT ("BakingLab", 2016): a matrix, a rational curve
//! on each channel, and a second matrix. Contrast is high, and bright light desaturates.

use glam::{Mat3, Vec3};

/// From linear Rec.709, by columns.
const BEFORE: Mat3 = Mat3::from_cols(
    Vec3::new(0.597_19, 0.076, 0.0284),
    Vec3::new(0.354_58, 0.908_34, 0.133_83),
    Vec3::new(0.048_23, 0.015_66, 0.837_77),
);
/// To linear Rec.709, by columns.
const AFTER: Mat3 = Mat3::from_cols(
    Vec3::new(1.604_75, -0.102_08, -0.003_27),
    Vec3::new(-0.531_08, 1.108_13, -0.072_76),
    Vec3::new(-0.073_67, -0.006_05, 1.076_02),
);
/// Clamp of the input. Beyond it the curve is constant in `f32`; below it squares remain finite.
const BRIGHTEST: f32 = 1e9;

/// Applies the curve to light without negative channels. The result is not clipped.
pub(super) fn apply(light: Vec3) -> Vec3 {
    let light = light.map(|channel| if channel < BRIGHTEST { channel } else { BRIGHTEST });
    AFTER * (BEFORE * light).map(curve)
}

fn curve(x: f32) -> f32 {
    (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_follow_the_fit() {
        // Both matrices preserve greys to three digits: 0.18 becomes 0.036734 / 0.347885.
        let grey = apply(Vec3::splat(0.18));
        assert!((grey - Vec3::splat(0.105_59)).abs().max_element() < 1e-3, "{grey}");
        // The fit's limit, 1 / 0.983729, lies beyond white.
        assert!((apply(Vec3::splat(1e8)) - Vec3::splat(1.016_54)).abs().max_element() < 2e-3);
    }
}
