//! Colour: Rec.709 primaries, luminance, the sRGB transfer function, exposure and tone curves ([`ToneCurve`]).
//!
//! Sources: ITU-R BT.709-6 (primaries, luminance), IEC 61966-2-1:1999 (sRGB transfer function).
//! EXR pixels are scene-linear and use none of these transforms.

mod chromaticities;
mod tone;

use std::sync::OnceLock;

use glam::Vec3;

pub(crate) use chromaticities::{Chromaticities, REC709};
pub use tone::ToneCurve;

/// Weights of the linear Rec.709 channels in luminance; their sum is one.
const LUMINANCE_WEIGHTS: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Luminance of a linear Rec.709 colour, in the units of the colour.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.x * LUMINANCE_WEIGHTS.x + color.y * LUMINANCE_WEIGHTS.y + color.z * LUMINANCE_WEIGHTS.z
}

/// Factor of an exposure of `stops` (EV): two to that power.
pub(crate) fn exposure_scale(stops: f32) -> f32 {
    libm::exp2f(stops)
}

/// Encodes linear light with the sRGB transfer function. Values outside 0 to 1 continue its two pieces.
fn linear_to_srgb(linear: f32) -> f32 {
    let linear = f64::from(linear);
    let encoded =
        if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 };
    encoded as f32
}

/// Decodes an sRGB value between 0 and 1 in single precision.
pub(crate) fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded > 0.04045 { libm::powf((encoded + 0.055) / 1.055, 2.4) } else { encoded / 12.92 }
}

/// Decodes an eight-bit sRGB value by table.
pub(crate) fn srgb8_to_linear(encoded: u8) -> f32 {
    srgb8_table()[usize::from(encoded)]
}

/// Linear values of all eight-bit sRGB values.
pub(crate) fn srgb8_table() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|code| decode(code as f64 / 255.0) as f32))
}

/// Equal cells of the unit interval in [`Srgb8Codes`]. No cell contains more than one edge beyond its start: from the edge of code 1 on they are at
/// least 1 / (255 · 12.92) apart.
const SRGB8_CELLS: usize = 4096;

/// [`linear_to_srgb8`] by table.
pub(crate) struct Srgb8Codes {
    /// Lower edges of all codes, then one that only infinity reaches.
    edges: [f32; 257],
    /// The code at the start of each cell.
    first: [u8; SRGB8_CELLS],
}

impl Srgb8Codes {
    /// The table.
    pub(crate) fn get() -> &'static Self {
        static CODES: OnceLock<Box<Srgb8Codes>> = OnceLock::new();
        CODES.get_or_init(|| {
            let edges: [f32; 257] = std::array::from_fn(|code| match code {
                0 => 0.0,
                1..=255 => decode((code as f64 - 0.5) / 255.0) as f32,
                _ => f32::INFINITY,
            });
            let code_at = |linear: f32| (edges.partition_point(|edge| *edge <= linear) - 1) as u8;
            Box::new(Self {
                edges,
                first: std::array::from_fn(|cell| code_at(cell as f32 / SRGB8_CELLS as f32)),
            })
        })
    }

    /// The last code whose lower edge does not exceed `linear`. Without branches, which would be mispredicted.
    #[inline(always)]
    pub(crate) fn encode(&self, linear: f32) -> u8 {
        // The cast saturates and takes NaN to zero.
        let cell = ((linear * SRGB8_CELLS as f32) as usize).min(SRGB8_CELLS - 1);
        let code = usize::from(self.first[cell]);
        (code + usize::from(linear >= self.edges[code + 1])).min(255) as u8
    }
}

/// Decodes a sixteen-bit sRGB value by table.
pub(crate) fn srgb16_to_linear(encoded: u16) -> f32 {
    srgb16_table()[usize::from(encoded)]
}

/// Linear values of all sixteen-bit sRGB values.
pub(crate) fn srgb16_table() -> &'static [f32] {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| (0..=65535_u32).map(|code| decode(f64::from(code) / 65535.0) as f32).collect())
}

/// Encodes linear light to the sixteen-bit sRGB value whose linear value is nearest. NaN gives 0.
pub(crate) fn linear_to_srgb16(linear: f32) -> u16 {
    if linear.is_nan() {
        return 0;
    }
    let decoded = |code: u32| srgb16_to_linear(code as u16);
    let (mut low, mut high) = (0_u32, 65535_u32);
    while high - low > 1 {
        let middle = u32::midpoint(low, high);
        if decoded(middle) <= linear { low = middle } else { high = middle }
    }
    if linear - decoded(low) < decoded(high) - linear { low as u16 } else { high as u16 }
}

/// Encodes linear light to the nearest eight-bit sRGB value. Values below 0 and NaN give 0, values above 1 give 255.
pub(crate) fn linear_to_srgb8(linear: f32) -> u8 {
    // The float-to-integer cast saturates and takes NaN to zero.
    (linear_to_srgb(linear) * 255.0 + 0.5) as u8
}

fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
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
            assert_eq!(Srgb8Codes::get().encode(srgb8_to_linear(code)), code);
            assert_eq!(linear_to_srgb16(srgb16_to_linear(u16::from(code) * 251)), u16::from(code) * 251);
        }
        for step in 0..100_000 {
            let linear = step as f32 / 99_000.0;
            let (slow, fast) = (linear_to_srgb8(linear), Srgb8Codes::get().encode(linear));
            // Both round; on an edge between codes they may round differently.
            let edge = linear_to_srgb(linear) * 255.0 + 0.5;
            assert!(slow == fast || (edge - edge.round()).abs() < 1e-4, "{linear}: {slow} {fast}");
        }
        assert_eq!(
            [-1.0, f32::NAN, 2.0, f32::INFINITY].map(|linear| Srgb8Codes::get().encode(linear)),
            [0, 0, 255, 255]
        );
        assert_eq!([-1.0, 1.0, 2.0, f32::NAN].map(linear_to_srgb16), [0, 65535, 65535, 0]);
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
}
