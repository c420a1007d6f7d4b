//! Tone curves: how scene-linear light becomes something that a display can show.

mod aces;
mod agx;
mod neutral;
mod standard;

use glam::Vec3;

/// How scene-linear light, exposed, is squeezed into what a display can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// The program's own: natural contrast around mid-grey, which stays where it is, and a long shoulder.
    #[default]
    Standard,
    /// `AgX`: low contrast, with room for bright and coloured light.
    Agx,
    /// The look of ACES 1.0: high contrast.
    Aces,
    /// Khronos PBR Neutral: base colours come out as they are.
    Neutral,
}

impl ToneCurve {
    /// The name typed on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Agx => "agx",
            Self::Aces => "aces",
            Self::Neutral => "neutral",
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
        };
        shown.map(|channel| if channel < 1.0 { positive(channel) } else { 1.0 })
    }
}

fn positive(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

fn largest(color: Vec3) -> f32 {
    let larger = if color.x > color.y { color.x } else { color.y };
    if larger > color.z { larger } else { color.z }
}

fn smallest(color: Vec3) -> f32 {
    let smaller = if color.x < color.y { color.x } else { color.y };
    if smaller < color.z { smaller } else { color.z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::exposure_scale;

    const CURVES: [ToneCurve; 4] = [ToneCurve::Standard, ToneCurve::Agx, ToneCurve::Aces, ToneCurve::Neutral];

    #[test]
    fn brighter_greys_are_shown_brighter_up_to_white() {
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
    fn coloured_light_keeps_its_order_and_bleaches() {
        for curve in CURVES {
            let light = Vec3::new(0.8, 0.2, 0.02);
            let shown = curve.apply(light);
            assert!(shown.x > shown.y && shown.y > shown.z, "{curve:?}: {shown}");
            let blinding = curve.apply(light * 1e5);
            assert!(blinding.min_element() > 0.9, "{curve:?}: {blinding}");
        }
    }

    #[test]
    fn curves_take_anything() {
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
