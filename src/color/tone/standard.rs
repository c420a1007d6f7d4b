//! Rayframe's standard tone curve.
//!
//! Source: Naka and Rushton, "S-potentials from luminosity units in the retina of fish", 1966: the saturating response, here with
//! the exponent 1.25. The largest channel p goes to y = p^1.25 / (p^1.25 + m), with m such that mid-grey 0.18 is a
//! fixed point (slope in stops there 1.025: natural contrast, a gentle toe, a long shoulder, white only at infinity). The other
//! channels keep their ratio to it, then the colour moves towards white by y⁶, so that bright saturated light desaturates as
//! on film. Different light gives different colours, and no channel of a colour is below y⁷: a bright primary is never pure.

use glam::Vec3;

use super::channels::largest;

/// m = 0.18^1.25 · (1 − 0.18) / 0.18, which makes 0.18 a fixed point.
const HALF_RESPONSE: f32 = 0.534_111_56;

/// Applies the curve to light without negative channels.
pub(super) fn apply(light: Vec3) -> Vec3 {
    let peak = largest(light);
    if peak == 0.0 {
        return Vec3::ZERO;
    }
    if peak == f32::INFINITY {
        return Vec3::ONE;
    }
    let shown_peak = 1.0 / (1.0 + HALF_RESPONSE / (peak * peak.sqrt().sqrt()));
    let desaturation = desaturation(shown_peak);
    light / peak * (shown_peak * (1.0 - desaturation)) + Vec3::splat(shown_peak * desaturation)
}

#[cfg(test)]
fn invert(shown: Vec3) -> Vec3 {
    let shown_peak = largest(shown);
    if shown_peak <= 0.0 {
        return Vec3::ZERO;
    }
    let peak = libm::powf(HALF_RESPONSE * shown_peak / (1.0 - shown_peak), 0.8);
    let desaturation = desaturation(shown_peak);
    (shown - Vec3::splat(shown_peak * desaturation)) * (peak / (shown_peak * (1.0 - desaturation)))
}

fn desaturation(shown_peak: f32) -> f32 {
    let square = shown_peak * shown_peak;
    square * square * square
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mid_grey_is_a_fixed_point_and_the_inverse_inverts() {
        assert!((apply(Vec3::splat(0.18)) - Vec3::splat(0.18)).abs().max_element() < 1e-3);
        // y(1) = 1 / (1 + m) = 0.6518, desaturation preserves greys.
        assert!((apply(Vec3::ONE).x - 0.651_84).abs() < 1e-4);
        let light = Vec3::new(4.0, 0.5, 0.01);
        assert!((invert(apply(light)) - light).abs().max_element() < 1e-4);
    }

    #[test]
    fn pure_light_shows_the_least_of_the_other_channels() {
        // y(1) = 0.65184, and 0.65184^7 = 0.0500.
        assert!((apply(Vec3::X) - Vec3::new(0.651_84, 0.05, 0.05)).abs().max_element() < 1e-4);
    }
}
