//! What an OpenEXR file of several channels holds, before it is packed.

use exr::image::FlatSamples;
use exr::prelude::Compression;
use half::f16;

/// How the samples of a file are packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExrCompression {
    /// Not at all.
    None,
    /// Runs of equal bytes.
    Rle,
    /// Deflate over single scan lines.
    Zips,
    /// Deflate over sixteen scan lines.
    #[default]
    Zip,
    /// Wavelets and Huffman codes over 32 scan lines; good for grain.
    Piz,
    /// Cosine transform over 32 scan lines; small and lossy.
    Dwaa,
    /// The same over 256 scan lines.
    Dwab,
}

impl ExrCompression {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::None, Self::Rle, Self::Zips, Self::Zip, Self::Piz, Self::Dwaa, Self::Dwab];

    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
            Self::Dwaa => "dwaa",
            Self::Dwab => "dwab",
        }
    }

    /// Whether samples may come back changed.
    pub fn is_lossy(self) -> bool {
        matches!(self, Self::Dwaa | Self::Dwab)
    }

    pub(super) fn for_exr(self) -> Compression {
        match self {
            Self::None => Compression::Uncompressed,
            Self::Rle => Compression::RLE,
            Self::Zips => Compression::ZIP1,
            Self::Zip => Compression::ZIP16,
            Self::Piz => Compression::PIZ,
            // The level is that of OpenEXR where none is given: 45.
            Self::Dwaa => Compression::DWAA(None),
            Self::Dwab => Compression::DWAB(None),
        }
    }
}

/// The samples of one channel, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum ExrSamples {
    /// Sixteen bits each.
    Half(Vec<f16>),
    /// Thirty-two bits each.
    Float(Vec<f32>),
    /// Unsigned whole numbers, for ids.
    Uint(Vec<u32>),
}

impl ExrSamples {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Half(samples) => samples.len(),
            Self::Float(samples) => samples.len(),
            Self::Uint(samples) => samples.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn for_exr(self) -> FlatSamples {
        match self {
            Self::Half(samples) => FlatSamples::F16(samples),
            Self::Float(samples) => FlatSamples::F32(samples),
            Self::Uint(samples) => FlatSamples::U32(samples),
        }
    }
}

/// One channel of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrChannel {
    /// Such as `R` or `normal.X`; up to 31 bytes of ASCII, so that every reader takes it.
    pub name: String,
    /// One a pixel.
    pub samples: ExrSamples,
}

/// A rectangle of named channels somewhere in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrPicture {
    /// Columns and rows of the whole picture (the display window).
    pub picture_size: (u32, u32),
    /// Column and row of the first pixel held.
    pub origin: (u32, u32),
    /// Columns and rows held (the data window).
    pub size: (u32, u32),
    /// Channels in any order, each name once.
    pub channels: Vec<ExrChannel>,
    /// How they are packed.
    pub compression: ExrCompression,
}

/// The nearest half-float. Values beyond ±65504 become ±65504, what is not a number becomes 0, and −0 becomes 0.
pub fn half_from_f32(value: f32) -> f16 {
    if value.is_nan() {
        return f16::ZERO;
    }
    let half = f16::from_f32(value.clamp(-65504.0, 65504.0));
    if half == f16::ZERO { f16::ZERO } else { half }
}

/// What a float channel holds: infinities become the largest floats, what is not a number becomes 0, and −0 becomes 0.
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
}
