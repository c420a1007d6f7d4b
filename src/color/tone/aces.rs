//! The look of the Academy Color Encoding System's reference rendering for sRGB displays, in a short form.
//!
//! Source: Stephen Hill's fit of ACES 1.0's RRT and sRGB ODT ("BakingLab", 2016): a matrix into a space where channels are
//! bent one by one, a rational curve, and a matrix back. Contrast is high, and strong light bleaches.

use glam::{Mat3, Vec3};

/// From linear Rec.709; columns.
const BEFORE: Mat3 = Mat3::from_cols(
    Vec3::new(0.597_19, 0.076, 0.0284),
    Vec3::new(0.354_58, 0.908_34, 0.133_83),
    Vec3::new(0.048_23, 0.015_66, 0.837_77),
);
/// To linear Rec.709; columns.
const AFTER: Mat3 = Mat3::from_cols(
    Vec3::new(1.604_75, -0.102_08, -0.003_27),
    Vec3::new(-0.531_08, 1.108_13, -0.072_76),
    Vec3::new(-0.073_67, -0.006_05, 1.076_02),
);
/// Beyond it the curve is flat to a float's last bit, and squares stay finite.
const BRIGHTEST: f32 = 1e9;

/// Light without negative channels to what is shown, before it is clipped.
pub(super) fn apply(light: Vec3) -> Vec3 {
    let light = light.map(|channel| if channel < BRIGHTEST { channel } else { BRIGHTEST });
    AFTER * (BEFORE * light).map(bend)
}

fn bend(x: f32) -> f32 {
    (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_follow_the_fit() {
        // Both matrices leave greys alone to three digits: 0.18 becomes 0.036734 / 0.347885.
        let grey = apply(Vec3::splat(0.18));
        assert!((grey - Vec3::splat(0.105_59)).abs().max_element() < 1e-3, "{grey}");
        // The fit's limit, 1 / 0.983729, lies beyond white.
        assert!((apply(Vec3::splat(1e8)) - Vec3::splat(1.016_54)).abs().max_element() < 2e-3);
    }
}
