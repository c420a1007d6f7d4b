//! Linear Rec.709 light, the sRGB transfer function both ways, luminance, exposure and the tone curves of previews.
//!
//! Sources: ITU-R BT.709-6 (primaries, luminance), IEC 61966-2-1:1999 (sRGB transfer function), Naka and Rushton, "S-potentials
//! from luminosity units in the retina of fish", 1966 (the saturating response behind the standard tone curve).
//! EXR pixels never pass through here: they stay scene-linear.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

/// CIE xy coordinates of three primaries and of white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chromaticities {
    /// Red primary.
    pub red: Vec2,
    /// Green primary.
    pub green: Vec2,
    /// Blue primary.
    pub blue: Vec2,
    /// White point.
    pub white: Vec2,
}

/// The colour space of every radiance in the program: Rec.709 primaries, white D65.
pub const REC709: Chromaticities = Chromaticities {
    red: Vec2::new(0.64, 0.33),
    green: Vec2::new(0.30, 0.60),
    blue: Vec2::new(0.15, 0.06),
    white: Vec2::new(0.3127, 0.3290),
};

/// What each linear Rec.709 channel adds to luminance; their sum is one.
const LUMINANCE_WEIGHTS: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Luminance of a linear Rec.709 colour, in the units of the colour.
pub fn luminance(color: Vec3) -> f32 {
    color.x * LUMINANCE_WEIGHTS.x + color.y * LUMINANCE_WEIGHTS.y + color.z * LUMINANCE_WEIGHTS.z
}

/// The factor that an exposure of `stops` (EV) multiplies light with: two to that power.
pub fn exposure_scale(stops: f32) -> f32 {
    libm::exp2f(stops)
}

/// Encodes linear light for an sRGB display; 0 to 1 both ways, numbers outside follow the same two pieces.
fn linear_to_srgb(linear: f32) -> f32 {
    let linear = f64::from(linear);
    let encoded =
        if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 };
    encoded as f32
}

/// Decodes an eight-bit sRGB value by table.
pub fn srgb8_to_linear(encoded: u8) -> f32 {
    srgb8_table()[usize::from(encoded)]
}

/// The linear values of all eight-bit sRGB values, for those who look up many.
pub fn srgb8_table() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|code| decode(code as f64 / 255.0) as f32))
}

/// [`linear_to_srgb8`] by table, for many values: the last code whose lower edge is not above `linear`.
pub fn linear_to_srgb8_by_table(linear: f32) -> u8 {
    /// Equal cells of the unit interval; no code is so narrow that a cell holds more than two edges.
    const CELLS: usize = 4096;
    /// Lower edges of all codes, and the code at the beginning of each cell.
    struct Codes {
        edges: [f32; 256],
        first: [u8; CELLS],
    }
    static CODES: OnceLock<Box<Codes>> = OnceLock::new();
    let codes = CODES.get_or_init(|| {
        let edges: [f32; 256] = std::array::from_fn(|code| match code {
            0 => 0.0,
            _ => decode((code as f64 - 0.5) / 255.0) as f32,
        });
        let code_at = |linear: f32| (edges.partition_point(|edge| *edge <= linear) - 1) as u8;
        Box::new(Codes { edges, first: std::array::from_fn(|cell| code_at(cell as f32 / CELLS as f32)) })
    });
    // The cast saturates and takes NaN to zero.
    let cell = ((linear * CELLS as f32) as usize).min(CELLS - 1);
    let mut code = codes.first[cell];
    while code < 255 && linear >= codes.edges[usize::from(code) + 1] {
        code += 1;
    }
    code
}

/// Decodes a sixteen-bit sRGB value by table.
pub fn srgb16_to_linear(encoded: u16) -> f32 {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| (0..=65535_u32).map(|code| decode(f64::from(code) / 65535.0) as f32).collect())
        [usize::from(encoded)]
}

/// Encodes linear light to the sixteen-bit sRGB value of the nearest light.
pub fn linear_to_srgb16(linear: f32) -> u16 {
    let decoded = |code: u32| srgb16_to_linear(code as u16);
    let (mut low, mut high) = (0_u32, 65535_u32);
    while high - low > 1 {
        let middle = u32::midpoint(low, high);
        if decoded(middle) <= linear { low = middle } else { high = middle }
    }
    if linear - decoded(low) < decoded(high) - linear { low as u16 } else { high as u16 }
}

/// Encodes linear light to the nearest eight-bit sRGB value; below 0 and NaN give 0, above 1 gives 255.
pub fn linear_to_srgb8(linear: f32) -> u8 {
    // The float-to-integer cast saturates and takes NaN to zero.
    (linear_to_srgb(linear) * 255.0 + 0.5) as u8
}

fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// How scene-linear light, exposed, is squeezed into what a display can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// A soft filmic curve that keeps hue: the largest channel p goes to y = p^1.25 / (p^1.25 + m), with m such that
    /// mid-grey 0.18 stays where it is (slope in stops there 1.025: natural contrast, a gentle toe, a long shoulder, white
    /// only at infinity). The other channels keep their ratio to it, then the colour moves towards white by y⁶, so that
    /// strong coloured light bleaches as film does. Bijective from non-negative light to the unit cube without its far faces.
    #[default]
    Standard,
}

impl ToneCurve {
    /// The name typed on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
        }
    }

    /// Exposed scene-linear light to display-linear light in 0 to 1. Negative channels and NaN count as 0.
    pub fn apply(self, light: Vec3) -> Vec3 {
        match self {
            Self::Standard => standard::apply(light),
        }
    }
}

mod standard {
    use glam::Vec3;

    /// m = 0.18^1.25 · (1 − 0.18) / 0.18, which makes 0.18 a fixed point.
    const HALF_RESPONSE: f32 = 0.534_111_56;

    pub(super) fn apply(light: Vec3) -> Vec3 {
        let light = Vec3::new(positive(light.x), positive(light.y), positive(light.z));
        let peak = largest(light);
        if peak == 0.0 {
            return Vec3::ZERO;
        }
        if peak == f32::INFINITY {
            return Vec3::ONE;
        }
        let shown_peak = 1.0 / (1.0 + HALF_RESPONSE / (peak * peak.sqrt().sqrt()));
        let bleach = bleach(shown_peak);
        light / peak * (shown_peak * (1.0 - bleach)) + Vec3::splat(shown_peak * bleach)
    }

    #[cfg(test)]
    pub(super) fn invert(shown: Vec3) -> Vec3 {
        let shown_peak = largest(shown);
        if shown_peak <= 0.0 {
            return Vec3::ZERO;
        }
        let peak = libm::powf(HALF_RESPONSE * shown_peak / (1.0 - shown_peak), 0.8);
        let bleach = bleach(shown_peak);
        (shown - Vec3::splat(shown_peak * bleach)) * (peak / (shown_peak * (1.0 - bleach)))
    }

    fn bleach(shown_peak: f32) -> f32 {
        let square = shown_peak * shown_peak;
        square * square * square
    }

    fn positive(value: f32) -> f32 {
        if value > 0.0 { value } else { 0.0 }
    }

    fn largest(color: Vec3) -> f32 {
        let larger = if color.x > color.y { color.x } else { color.y };
        if larger > color.z { larger } else { color.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_has_its_published_values() {
        // Code 188 is the often quoted half of white: ((188/255 + 0.055) / 1.055)^2.4 = 0.50289.
        assert!((srgb8_to_linear(188) - 0.502_886).abs() < 1e-6);
        // The linear piece: 10 / 255 / 12.92 = 0.0030353.
        assert!((srgb8_to_linear(10) - 0.003_035_3).abs() < 1e-7);
        assert_eq!((srgb8_to_linear(0), srgb8_to_linear(255)), (0.0, 1.0));
        assert_eq!((srgb16_to_linear(0), srgb16_to_linear(65535)), (0.0, 1.0));
        // Mid-grey shows as 0.4614.
        assert!((linear_to_srgb(0.18) - 0.461_356).abs() < 1e-6);
    }

    #[test]
    fn all_codes_survive_the_round_trip() {
        for code in 0..=255_u8 {
            assert_eq!(linear_to_srgb8(srgb8_to_linear(code)), code);
            // 65535 = 257 · 255, so every eight-bit code is also a sixteen-bit code.
            assert_eq!(srgb16_to_linear(u16::from(code) * 257), srgb8_to_linear(code));
        }
    }

    #[test]
    fn the_table_encodes_as_the_formula() {
        for code in 0..=255_u8 {
            assert_eq!(linear_to_srgb8_by_table(srgb8_to_linear(code)), code);
            assert_eq!(linear_to_srgb16(srgb16_to_linear(u16::from(code) * 251)), u16::from(code) * 251);
        }
        for step in 0..100_000 {
            let linear = step as f32 / 99_000.0;
            let (slow, fast) = (linear_to_srgb8(linear), linear_to_srgb8_by_table(linear));
            // Both round; on an edge between codes they may round differently.
            let edge = linear_to_srgb(linear) * 255.0 + 0.5;
            assert!(slow == fast || (edge - edge.round()).abs() < 1e-4, "{linear}: {slow} {fast}");
        }
        assert_eq!([-1.0, f32::NAN, 2.0, f32::INFINITY].map(linear_to_srgb8_by_table), [0, 0, 255, 255]);
        assert_eq!([-1.0, 1.0, 2.0].map(linear_to_srgb16), [0, 65535, 65535]);
    }

    #[test]
    fn encoding_clamps_what_no_display_shows() {
        for (light, code) in
            [(-1.0, 0), (f32::NAN, 0), (f32::NEG_INFINITY, 0), (2.0, 255), (f32::INFINITY, 255)]
        {
            assert_eq!(linear_to_srgb8(light), code);
        }
    }

    #[test]
    fn luminance_of_white_is_one() {
        assert!((luminance(Vec3::ONE) - 1.0).abs() < 1e-6);
        assert_eq!(exposure_scale(-2.0), 0.25);
    }

    #[test]
    fn tone_curve_keeps_grey_and_order() {
        let grey = ToneCurve::Standard.apply(Vec3::splat(0.18));
        assert!((grey - Vec3::splat(0.18)).abs().max_element() < 1e-3, "{grey}");
        // y(1) = 1 / (1 + m) = 0.6518, bleaching leaves a grey alone.
        assert!((ToneCurve::Standard.apply(Vec3::ONE).x - 0.651_84).abs() < 1e-4);
        let mut last = 0.0;
        for step in 1..400 {
            let shown = ToneCurve::Standard.apply(Vec3::splat(exposure_scale(step as f32 * 0.1 - 20.0))).x;
            assert!(shown >= last && shown <= 1.0);
            last = shown;
        }
        assert!(last > 0.9999);
    }

    #[test]
    fn tone_curve_inverts_and_bleaches() {
        let light = Vec3::new(4.0, 0.5, 0.01);
        let shown = ToneCurve::Standard.apply(light);
        assert!((standard::invert(shown) - light).abs().max_element() < 1e-4);
        let blinding = ToneCurve::Standard.apply(light * 1e5);
        assert!(blinding.min_element() > 0.98, "{blinding}");
        assert!(shown.x > shown.y && shown.y > shown.z);
    }

    #[test]
    fn tone_curve_takes_anything() {
        let curve = ToneCurve::Standard;
        assert_eq!(curve.apply(Vec3::new(f32::NAN, -1.0, 0.0)), Vec3::ZERO);
        assert_eq!(curve.apply(Vec3::new(f32::INFINITY, 1.0, 0.0)), Vec3::ONE);
        let huge = curve.apply(Vec3::splat(f32::MAX));
        assert!(huge.is_finite() && huge.max_element() <= 1.0);
        let tiny = curve.apply(Vec3::splat(f32::from_bits(1)));
        assert!(tiny.is_finite() && tiny.min_element() >= 0.0);
    }
}
