//! Named channels of samples.

use std::borrow::Cow;

use half::f16;
use half::slice::HalfFloatSliceExt as _;

/// Name of the layer that holds the channels R, G, B and A.
pub const BEAUTY: &str = "beauty";

/// Samples of one channel, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 16-bit floating point.
    Half(Vec<f16>),
    /// 32-bit floating point.
    Float(Vec<f32>),
    /// 32-bit unsigned integers, used for ids.
    Uint(Vec<u32>),
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::Half(samples) => samples.len(),
            Self::Float(samples) => samples.len(),
            Self::Uint(samples) => samples.len(),
        }
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Floating-point samples as 32-bit floats, which hold every half exactly; `None` for ids.
    pub fn floats(&self) -> Option<Cow<'_, [f32]>> {
        match self {
            Self::Half(samples) => Some(samples.iter().map(|sample| sample.to_f32()).collect()),
            Self::Float(samples) => Some(Cow::Borrowed(samples)),
            Self::Uint(_) => None,
        }
    }

    /// The same values with halves widened to floats.
    #[must_use]
    pub fn widened(self) -> Self {
        match self {
            Self::Half(samples) => Self::Float(samples.into_iter().map(f16::to_f32).collect()),
            samples => samples,
        }
    }
}

/// Whether programs call the layer of the finished image so: Blender, Nuke and others, also with the name of a view before or after it.
pub fn is_finished_image(layer: &str) -> bool {
    let is_finished =
        |word: &str| ["combined", "rgba", BEAUTY].iter().any(|name| word.eq_ignore_ascii_case(name));
    layer.split('.').any(is_finished)
}

/// One channel of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name as in an EXR file, such as `R` or `normal.X`; up to 31 bytes of ASCII, which every reader accepts.
    pub name: String,
    /// One sample a pixel.
    pub samples: Samples,
}

/// Name of the layer of a channel.
///
/// An OpenEXR layer is the part of a channel's name before the last dot. The names of this program's AOVs are recognised
/// besides: `R`, `G`, `B` and `A` are [`BEAUTY`], `Z` is `depth`, and the ranks of a Cryptomatte are one layer.
pub fn layer_of(channel: &str) -> &str {
    match (channel, channel.rsplit_once('.')) {
        ("R" | "G" | "B" | "A" | "Y" | "RY" | "BY", _) => BEAUTY,
        ("Z", _) => "depth",
        (_, Some(("forward" | "backward", _))) => "motion",
        (_, Some((layer, _))) => without_rank(layer),
        (name, None) => name,
    }
}

/// A layer without the number of ranks of a Cryptomatte: `crypto_object00` is `crypto_object`.
pub(super) fn without_rank(layer: &str) -> &str {
    if is_cryptomatte(layer) {
        layer.trim_end_matches(|character: char| character.is_ascii_digit())
    } else {
        layer
    }
}

/// Whether a layer holds a Cryptomatte: numbers that name things, whatever its channels are called.
pub fn is_cryptomatte(layer: &str) -> bool {
    let name = layer.rsplit('.').next().unwrap_or(layer).to_ascii_lowercase();
    name.starts_with("crypto_")
        || matches!(
            name.trim_end_matches(|character: char| character.is_ascii_digit()),
            "cryptoobject" | "cryptomaterial" | "cryptoasset" | "cryptomatte"
        )
}

/// The nearest half. Values beyond ±65504 become ±65504, NaN becomes 0, and −0 becomes 0.
pub fn half_from_f32(value: f32) -> f16 {
    if value.is_nan() {
        return f16::ZERO;
    }
    let half = f16::from_f32(value.clamp(-65504.0, 65504.0));
    if half == f16::ZERO { f16::ZERO } else { half }
}

/// Rounds each of `values` as [`half_from_f32`] does, several at a time.
pub fn halves_from_f32(values: &[f32], halves: &mut [f16]) {
    /// Values in a buffer of the stack.
    const BLOCK: usize = 256;
    let mut finite = [0.0; BLOCK];
    for (halves, values) in halves.chunks_mut(BLOCK).zip(values.chunks(BLOCK)) {
        let finite = &mut finite[..values.len()];
        for (finite, &value) in finite.iter_mut().zip(values) {
            *finite = if value.is_nan() { 0.0 } else { value.clamp(-65504.0, 65504.0) };
        }
        halves.convert_from_f32_slice(finite);
        for half in halves {
            *half = if *half == f16::ZERO { f16::ZERO } else { *half };
        }
    }
}

/// The value as float channels store it: infinities become the largest floats, NaN becomes 0, and −0 becomes 0.
pub fn finite_f32(value: f32) -> f32 {
    if value.is_nan() || value == 0.0 { 0.0 } else { value.clamp(f32::MIN, f32::MAX) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_finite_and_have_one_zero() {
        // 65504 is the largest half; 65520 and up would round to infinity.
        for (value, expected) in [
            (0.1, 0.099_975_586),
            (70000.0, 65504.0),
            (f32::INFINITY, 65504.0),
            (f32::NEG_INFINITY, -65504.0),
            (f32::NAN, 0.0),
        ] {
            assert_eq!(half_from_f32(value).to_f32(), expected);
        }
        assert_eq!(half_from_f32(-0.0).to_bits(), 0);
        assert_eq!(half_from_f32(-1e-12).to_bits(), 0);
    }

    #[test]
    fn many_halves_are_rounded_as_single_ones_are() {
        // All upper halves of floats, with lower halves on both sides of ties.
        let values: Vec<f32> = (0..=0xffff_u32)
            .flat_map(|upper| [0, 0x0fff, 0x1000, 0x1001].map(|lower| f32::from_bits(upper << 16 | lower)))
            .collect();
        let mut halves = vec![f16::NAN; values.len()];
        halves_from_f32(&values, &mut halves);
        let bits = |halves: Vec<f16>| halves.into_iter().map(f16::to_bits).collect::<Vec<_>>();
        assert!(bits(halves) == bits(values.into_iter().map(half_from_f32).collect()));
    }

    #[test]
    fn floats_are_finite_and_have_one_zero() {
        for (value, expected) in [
            (0.1, 0.1),
            (1e30, 1e30),
            (f32::INFINITY, f32::MAX),
            (f32::NEG_INFINITY, f32::MIN),
            (f32::NAN, 0.0),
        ] {
            assert_eq!(finite_f32(value), expected);
        }
        assert_eq!(finite_f32(-0.0).to_bits(), 0);
    }

    #[test]
    fn halves_widen_exactly_and_ids_are_no_floats() {
        let halves = Samples::Half(vec![f16::from_f32(0.5), f16::MAX]);
        assert_eq!(halves.floats().unwrap(), [0.5, 65504.0].as_slice());
        assert_eq!(halves.widened(), Samples::Float(vec![0.5, 65504.0]));
        assert_eq!(Samples::Uint(vec![1]).floats(), None);
    }

    #[test]
    fn channels_belong_to_layers() {
        for (channel, layer) in [
            ("A", "beauty"),
            ("Z", "depth"),
            ("normal.X", "normal"),
            ("backward.v", "motion"),
            ("crypto_object02.A", "crypto_object"),
            ("View.CryptoMaterial01.r", "View.CryptoMaterial"),
            ("cryptomatte00.red", "cryptomatte"),
            ("node_id", "node_id"),
            ("View.Combined.R", "View.Combined"),
        ] {
            assert_eq!(layer_of(channel), layer);
        }
    }
}
