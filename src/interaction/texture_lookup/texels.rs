//! Decoding of texels and their mean over the probes of a lookup.

use glam::Vec4;

use super::level_lookup::LevelLookup;
use crate::color;
use crate::scene::{Encoding, Texels};

const BYTE: f32 = 1.0 / 255.0;
const WORD: f32 = 1.0 / 65535.0;

/// Mean of the texels of one level over all probes of `lookup`.
pub(super) fn mean(texels: &Texels, lookup: &LevelLookup, encoding: Encoding) -> Vec4 {
    match (texels, encoding) {
        (Texels::Rgba8(texels), Encoding::Linear | Encoding::Normal) => {
            lookup.mean(texels, |texel| Vec4::from_array(texel.map(f32::from))) * BYTE
        }
        (Texels::Rgba16(texels), Encoding::Linear | Encoding::Normal) => {
            lookup.mean(texels, |texel| Vec4::from_array(texel.map(f32::from))) * WORD
        }
        (Texels::Rgba8(texels), Encoding::Srgb) => lookup.mean(texels, color8),
        (Texels::Rgba16(texels), Encoding::Srgb) => lookup.mean(texels, color16),
        (Texels::Rgba8(texels), Encoding::CoveredSrgb) => covered_mean(lookup, texels, color8),
        (Texels::Rgba16(texels), Encoding::CoveredSrgb) => covered_mean(lookup, texels, color16),
    }
}

#[inline(always)]
fn color8([r, g, b, a]: [u8; 4]) -> Vec4 {
    let table = color::srgb8_table();
    let [r, g, b] = [r, g, b].map(|code| table[usize::from(code)]);
    Vec4::new(r, g, b, f32::from(a) * BYTE)
}

#[inline(always)]
fn color16([r, g, b, a]: [u16; 4]) -> Vec4 {
    let [r, g, b] = [r, g, b].map(color::srgb16_to_linear);
    Vec4::new(r, g, b, f32::from(a) * WORD)
}

/// Colours are weighted by their alpha, so that transparent texels leave no fringe.
fn covered_mean<T: Copy>(lookup: &LevelLookup, texels: &[T], color: impl Fn(T) -> Vec4) -> Vec4 {
    let covered = lookup.mean(texels, |texel| {
        let color = color(texel);
        (color.truncate() * color.w).extend(color.w)
    });
    if covered.w > 0.0 {
        (covered.truncate() / covered.w).extend(covered.w)
    } else {
        lookup.mean(texels, color)
    }
}
