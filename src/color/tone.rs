//! Tone curves: scene-linear light to display-linear light.

mod aces;
mod agx;
mod channels;
mod neutral;
mod standard;

use glam::Vec3;

use channels::positive;

/// Tone curve of display images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Rayframe's own: natural contrast around mid-grey, which it keeps, and a long shoulder.
    Standard,
    /// AgX: low contrast, with headroom for bright and saturated light.
    Agx,
    /// The look of ACES 1.0: high contrast.
    Aces,
    /// Khronos PBR Neutral: reproduces base colours unchanged.
    #[default]
    Neutral,
    /// No curve: light up to 1 is shown as it is, and more as white.
    Linear,
}

impl ToneCurve {
    /// The name in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Agx => "agx",
            Self::Aces => "aces",
            Self::Neutral => "neutral",
            Self::Linear => "none",
        }
    }

    /// Exposed scene-linear light to display-linear light in 0 to 1. Negative channels and NaN count as 0.
    pub fn apply(self, light: Vec3) -> Vec3 {
        let light = light.map(positive);
        let shown = match self {
            Self::Standard => standard::apply(light),
            Self::Agx => agx::apply(light),
            Self::Aces => aces::apply(light),
            Self::Neutral => neutral::apply(light),
            Self::Linear => light,
        };
        shown.map(|channel| if channel < 1.0 { positive(channel) } else { 1.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::exposure_scale;

    const CURVES: [ToneCurve; 5] =
        [ToneCurve::Standard, ToneCurve::Agx, ToneCurve::Aces, ToneCurve::Neutral, ToneCurve::Linear];

    #[test]
    fn curves_increase_with_grey_up_to_white() {
        for curve in CURVES {
            let mut last = 0.0;
            for step in 1..400 {
                let grey = curve.apply(Vec3::splat(exposure_scale(step as f32 * 0.1 - 20.0)));
                assert!(grey.x >= last && grey.max_element() <= 1.0, "{curve:?} {step}: {grey}");
                last = grey.x;
            }
            assert!(last > 0.99, "{curve:?}: {last}");
        }
    }

    #[test]
    fn saturated_light_keeps_its_channel_order_and_desaturates() {
        for curve in CURVES {
            let light = Vec3::new(0.8, 0.2, 0.02);
            let shown = curve.apply(light);
            assert!(shown.x > shown.y && shown.y > shown.z, "{curve:?}: {shown}");
            let blinding = curve.apply(light * 1e5);
            assert!(blinding.min_element() > 0.9, "{curve:?}: {blinding}");
        }
    }

    #[test]
    fn without_a_curve_light_keeps_its_value_up_to_white() {
        let light = Vec3::new(0.002, 0.5, 3.0);
        assert_eq!(ToneCurve::Linear.apply(light), Vec3::new(0.002, 0.5, 1.0));
    }

    #[test]
    fn curves_accept_any_value() {
        for curve in CURVES {
            assert_eq!(curve.apply(Vec3::new(f32::NAN, -1.0, 0.0)), curve.apply(Vec3::ZERO));
            for light in [
                Vec3::new(f32::INFINITY, 1.0, 0.0),
                Vec3::splat(f32::INFINITY),
                Vec3::splat(f32::MAX),
                Vec3::splat(f32::from_bits(1)),
            ] {
                let shown = curve.apply(light);
                assert!(
                    shown.is_finite() && shown.min_element() >= 0.0 && shown.max_element() <= 1.0,
                    "{curve:?} {light}: {shown}"
                );
            }
            assert!(curve.apply(Vec3::ZERO).max_element() < 1e-3, "{curve:?}");
        }
        assert_eq!(ToneCurve::Standard.apply(Vec3::new(f32::INFINITY, 1.0, 0.0)), Vec3::ONE);
    }
}
