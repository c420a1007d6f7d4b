//! Decoding of texels and their mean over the probes of a lookup.

use glam::Vec4;

use super::level_lookup::WeightedTexels;
use crate::color;
use crate::scene::{Encoding, Texels};

const BYTE: f32 = 1.0 / 255.0;
const WORD: f32 = 1.0 / 65535.0;

/// Probes of one level, with linear filtering or the nearest texel of each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probes<'a> {
    pub(super) probes: &'a [WeightedTexels],
    pub(super) is_linear: bool,
}

impl Probes<'_> {
    /// Mean of the texels of one level over all probes.
    pub(super) fn mean(self, texels: &Texels, encoding: Encoding) -> Vec4 {
        match (texels, encoding) {
            (Texels::Rgba8(texels), Encoding::Linear | Encoding::Normal) => {
                Vec4::from_array(self.mean_of(texels, codes)) * BYTE
            }
            (Texels::Rgba16(texels), Encoding::Linear | Encoding::Normal) => {
                Vec4::from_array(self.mean_of(texels, codes)) * WORD
            }
            (Texels::Rgba8(texels), Encoding::Srgb) => Vec4::from_array(self.mean_of(texels, color8())),
            (Texels::Rgba16(texels), Encoding::Srgb) => Vec4::from_array(self.mean_of(texels, color16())),
            (Texels::Rgba8(texels), Encoding::CoveredSrgb) => self.covered_mean(texels, color8()),
            (Texels::Rgba16(texels), Encoding::CoveredSrgb) => self.covered_mean(texels, color16()),
        }
    }

    /// Mean of the decoded texels over all probes. In this form, with references to texels and all channels of a
    /// sum in one expression, the compiler keeps four channels in one register. `map` of arrays is a call for each probe.
    #[inline(always)]
    fn mean_of<T>(self, texels: &[T], decode: impl Fn(&T) -> [f32; 4]) -> [f32; 4] {
        let mut sum = [0.0; 4];
        if self.is_linear {
            for WeightedTexels { texels: [a, b, c, d], weights } in self.probes {
                let (a, b) = (decode(&texels[*a]), decode(&texels[*b]));
                let (c, d) = (decode(&texels[*c]), decode(&texels[*d]));
                let channel = |channel: usize| {
                    sum[channel]
                        + a[channel] * weights[0]
                        + b[channel] * weights[1]
                        + c[channel] * weights[2]
                        + d[channel] * weights[3]
                };
                sum = [channel(0), channel(1), channel(2), channel(3)];
            }
        } else {
            for probe in self.probes {
                let texel = decode(&texels[probe.texels[0]]);
                sum = [sum[0] + texel[0], sum[1] + texel[1], sum[2] + texel[2], sum[3] + texel[3]];
            }
        }
        let count = self.probes.len();
        if count > 1 {
            let share = 1.0 / count as f32;
            sum = [sum[0] * share, sum[1] * share, sum[2] * share, sum[3] * share];
        }
        sum
    }

    /// Colours are weighted by their alpha, so that transparent texels leave no fringe.
    fn covered_mean<T>(self, texels: &[T], color: impl Fn(&T) -> [f32; 4]) -> Vec4 {
        let covered = Vec4::from_array(self.mean_of(texels, |texel| {
            let [r, g, b, a] = color(texel);
            [r * a, g * a, b * a, a]
        }));
        if covered.w > 0.0 {
            (covered.truncate() / covered.w).extend(covered.w)
        } else {
            Vec4::from_array(self.mean_of(texels, color))
        }
    }
}

/// The channels of a texel as they are stored.
#[inline(always)]
fn codes<T: Copy + Into<f32>>(texel: &[T; 4]) -> [f32; 4] {
    [texel[0].into(), texel[1].into(), texel[2].into(), texel[3].into()]
}

#[inline(always)]
fn color8() -> impl Fn(&[u8; 4]) -> [f32; 4] {
    let table = color::srgb8_table();
    let linear = move |code: u8| table[usize::from(code)];
    move |texel| [linear(texel[0]), linear(texel[1]), linear(texel[2]), f32::from(texel[3]) * BYTE]
}

#[inline(always)]
fn color16() -> impl Fn(&[u16; 4]) -> [f32; 4] {
    let table = color::srgb16_table();
    let linear = move |code: u16| table[usize::from(code)];
    move |texel| [linear(texel[0]), linear(texel[1]), linear(texel[2]), f32::from(texel[3]) * WORD]
}
