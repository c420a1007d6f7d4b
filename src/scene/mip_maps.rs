//! Mip maps: copies of an image, each half as wide and high as the one before, down to one texel.
//!
//! Source: Williams, "Pyramidal Parametrics" (SIGGRAPH 1983). A texel is the mean of its area (a box filter) in linear
//! light. Odd sizes are halved and rounded down. A texel then covers parts of up to three texels a side, weighted by area.
//! Means pass from level to level as floats and are rounded once, to the bit depth of the image. A level takes four bytes
//! a texel for eight-bit images and eight for sixteen-bit ones. All levels of one use take about a third of the
//! image's memory, and all but as much as the image for one that is a texel wide or high.
//!
//! The mean depends on the encoding, so each pair of image and encoding has its own levels. This module does not select the
//! level of a lookup.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::mip_blocks::{self, RowPair, code_of, each, share_of};
use super::{Encoding, Image, Texels};
use crate::color::{self, Srgb8Codes};
use crate::geometry::vectorized;

/// One mip level below the full image.
#[derive(Clone, Debug, PartialEq)]
pub struct MipLevel {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major texels, encoded like those of the image.
    pub texels: Texels,
}

/// Mip levels of one image, for each encoding in use.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageMips {
    by_encoding: [Option<Arc<[MipLevel]>>; 4],
}

impl ImageMips {
    /// Levels for one encoding, the largest first; empty if none were built.
    pub fn levels(&self, encoding: Encoding) -> &[MipLevel] {
        self.by_encoding[encoding as usize].as_deref().unwrap_or_default()
    }

    /// Sets the levels for one encoding.
    pub fn set(&mut self, encoding: Encoding, levels: Arc<[MipLevel]>) {
        self.by_encoding[encoding as usize] = Some(levels);
    }

    /// Reuses the levels of one encoding for another one with equal means.
    pub fn share(&mut self, from: Encoding, to: Encoding) {
        let levels = self.by_encoding[from as usize].clone();
        self.by_encoding[to as usize] = levels;
    }
}

/// Sizes of all levels below an image, the largest first.
pub(crate) fn mip_sizes(size: (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    std::iter::successors(halved(size), |size| halved(*size))
}

/// Memory of all levels of one encoding, in bytes.
pub(crate) fn mip_bytes(width: u32, height: u32, bytes_per_texel: u64) -> u64 {
    let texels = |(width, height): (u32, u32)| u64::from(width) * u64::from(height);
    let texels = mip_sizes((width, height)).map(texels).fold(0_u64, u64::saturating_add);
    texels.saturating_mul(bytes_per_texel)
}

/// Temporary memory of [`mip_levels`], in bytes.
pub(crate) fn mip_working_bytes(width: u32, height: u32) -> u64 {
    mip_bytes(width, height, size_of::<Vec4>() as u64)
}

/// Builds all mip levels of `image` for one encoding, in parallel on the current rayon pool. The result does not depend on the
/// number of threads.
pub fn mip_levels(image: &Image, encoding: Encoding) -> Vec<MipLevel> {
    let size = (image.width, image.height);
    match &image.texels {
        Texels::Rgba8(texels) => {
            let table = color::srgb8_table();
            let codes = Srgb8Codes::get();
            let linear = |code: u8| table[usize::from(code)];
            let decode_color =
                |[r, g, b, a]: [u8; 4]| Vec4::new(linear(r), linear(g), linear(b), share_of(a));
            let encode_color = |mean: Vec4| {
                let [r, g, b, a] = mean.to_array();
                [codes.encode(r), codes.encode(g), codes.encode(b), code_of(a)]
            };
            let decode_normal = |texel| direction(linear8(texel));
            let encode_linear = |mean: Vec4| stored(mean, Encoding::Linear).map(code_of);
            let encode_normal = |mean: Vec4| stored(mean, Encoding::Normal).map(code_of);
            let simd = fearless_simd::Level::new();
            // Each encoding has its own loops over the texels.
            let levels = match encoding {
                Encoding::Linear => levels_of(size, texels, encoding, (linear8, encode_linear), |rows| {
                    vectorized!(simd, rows.fill_blocks(mip_blocks::shares, mip_blocks::codes))
                }),
                Encoding::Normal => {
                    levels_of(size, texels, encoding, (decode_normal, encode_normal), |rows| {
                        vectorized!(
                            simd,
                            rows.fill_blocks(mip_blocks::directions, mip_blocks::direction_codes)
                        )
                    })
                }
                Encoding::Srgb => levels_of(size, texels, encoding, (decode_color, encode_color), |rows| {
                    let decode = |texels: &_| each(texels, |texel| decode_color(texel).to_array());
                    let encode = |means: &_| each(means, |mean| encode_color(Vec4::from_array(mean)));
                    vectorized!(simd, rows.fill_blocks(decode, encode))
                }),
                Encoding::CoveredSrgb => {
                    levels_of(size, texels, encoding, (decode_color, encode_color), |_| 0)
                }
            };
            mip_levels_of(levels, Texels::Rgba8)
        }
        Texels::Rgba16(texels) => {
            let decode = |texel| decode16(texel, encoding);
            let encode = |mean| encode16(mean, encoding);
            mip_levels_of(levels_of(size, texels, encoding, (decode, encode), |_| 0), Texels::Rgba16)
        }
    }
}

/// Size and texels of a level.
type Level<T> = ((u32, u32), Vec<T>);

fn mip_levels_of<T>(levels: Vec<Level<T>>, texels_of: impl Fn(Vec<T>) -> Texels) -> Vec<MipLevel> {
    let level = |((width, height), texels)| MipLevel { width, height, texels: texels_of(texels) };
    levels.into_iter().map(level).collect()
}

/// The levels of an image. `decode` and `encode` convert its texels. `fill_blocks` fills the start of a row of the first level and returns the number
/// of its texels; it is called only where both sizes are even, and gives the bits that the other texels get.
fn levels_of<T: Copy + Default + Send + Sync>(
    size: (u32, u32),
    texels: &[T],
    encoding: Encoding,
    (decode, encode): (impl Fn(T) -> Vec4 + Sync, impl Fn(Vec4) -> T + Sync),
    fill_blocks: impl Fn(RowPair<'_, T>) -> usize + Sync,
) -> Vec<Level<T>> {
    let mut levels = Vec::new();
    let Some(mut next) = halved(size) else {
        return levels;
    };
    let stride = size.0 as usize;
    let texel = |x: usize, y: usize| decode(texels[y * stride + x]);
    let fill = |row: usize, means: &mut [Vec4], encoded: &mut [T]| {
        let [above, below] = [row, row + 1].map(|row| &texels[row * stride..(row + 1) * stride]);
        fill_blocks(RowPair { above, below, means, encoded })
    };
    let (mut means, mut encoded) = downsample(size, next, encoding, (texel, &encode), fill);
    loop {
        levels.push((next, encoded));
        let size = next;
        let Some(smaller) = halved(size) else {
            return levels;
        };
        next = smaller;
        let stride = size.0 as usize;
        let mean = |x: usize, y: usize| means[y * stride + x];
        (means, encoded) = downsample(size, next, encoding, (mean, &encode), |_, _, _| 0);
    }
}

/// Size of the next level; `None` after a single texel.
fn halved((width, height): (u32, u32)) -> Option<(u32, u32)> {
    let half = |side: u32| if side > 1 { side / 2 } else { 1 };
    (width > 1 || height > 1).then(|| (half(width), half(height)))
}

/// Extent of one texel along one axis: up to three texels of the previous level, with their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    first: usize,
    shares: [f32; 3],
}

/// Spans of `new` equal cells over `old` equal cells. `new` is `old` halved and rounded down, or one.
fn spans(old: u32, new: u32) -> Vec<Span> {
    let (old, new) = (u64::from(old), u64::from(new));
    (0..new)
        .map(|cell| {
            // Positions in units of 1 / (old · new).
            let (start, end) = (cell * old, (cell + 1) * old);
            let first = start / new;
            let share = |texel: u64| {
                let (low, high) = (start.max(texel * new), end.min((texel + 1) * new));
                high.saturating_sub(low) as f32 / old as f32
            };
            Span { first: first as usize, shares: [share(first), share(first + 1), share(first + 2)] }
        })
        .collect()
}

/// Means of the next level's texels, and their encoded form. `texel` returns a value of the previous level. `fill` fills the start of a row and returns
/// the number of its texels; it is called only where both sizes are even.
fn downsample<T: Copy + Default + Send>(
    old: (u32, u32),
    new: (u32, u32),
    encoding: Encoding,
    (texel, encode): (impl Fn(usize, usize) -> Vec4 + Sync, impl Fn(Vec4) -> T + Sync),
    fill: impl Fn(usize, &mut [Vec4], &mut [T]) -> usize + Sync,
) -> (Vec<Vec4>, Vec<T>) {
    let is_covered = encoding == Encoding::CoveredSrgb;
    let is_even = old == (new.0 * 2, new.1 * 2);
    let (columns, rows) = (spans(old.0, new.0), spans(old.1, new.1));
    let mut means = vec![Vec4::ZERO; columns.len() * rows.len()];
    let mut encoded = vec![T::default(); means.len()];
    let lines = means.par_chunks_mut(columns.len()).zip(encoded.par_chunks_mut(columns.len()));
    lines.zip(&rows).for_each(|((means, encoded), row)| {
        if is_even {
            let filled = fill(row.first, means, encoded);
            let texels = means.iter_mut().zip(encoded).enumerate().skip(filled);
            for (column, (mean, encoded)) in texels {
                *mean = mean_of_four([column * 2, row.first], is_covered, &texel);
                *encoded = encode(*mean);
            }
        } else {
            for ((mean, encoded), column) in means.iter_mut().zip(encoded).zip(&columns) {
                *mean = mean_of(*column, *row, is_covered, &texel);
                *encoded = encode(*mean);
            }
        }
    });
    (means, encoded)
}

/// [`mean_of`] where both sizes are even: four texels of equal weight.
#[inline(always)]
fn mean_of_four([x, y]: [usize; 2], is_covered: bool, texel: &impl Fn(usize, usize) -> Vec4) -> Vec4 {
    let values = [texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)];
    let mut plain = Vec4::ZERO;
    for value in values {
        plain += value * 0.25;
    }
    if !is_covered || plain.w <= 0.0 {
        return plain;
    }
    let mut covered = Vec3::ZERO;
    for value in values {
        covered += value.truncate() * (value.w * 0.25);
    }
    (covered / plain.w).extend(plain.w)
}

fn mean_of(column: Span, row: Span, is_covered: bool, texel: &impl Fn(usize, usize) -> Vec4) -> Vec4 {
    let (mut plain, mut covered) = (Vec4::ZERO, Vec3::ZERO);
    for (y, row_share) in row.shares.into_iter().enumerate() {
        for (x, column_share) in column.shares.into_iter().enumerate() {
            let share = row_share * column_share;
            if share > 0.0 {
                let value = texel(column.first + x, row.first + y);
                plain += value * share;
                covered += value.truncate() * (value.w * share);
            }
        }
    }
    // Without any coverage all colours count equally.
    if is_covered && plain.w > 0.0 { (covered / plain.w).extend(plain.w) } else { plain }
}

/// The channels of a texel as shares of the largest code.
#[inline(always)]
fn linear8(texel: [u8; 4]) -> Vec4 {
    Vec4::from_array(texel.map(share_of))
}

fn decode16(texel: [u16; 4], encoding: Encoding) -> Vec4 {
    let linear = texel.map(|code| f32::from(code) / 65535.0);
    match encoding {
        Encoding::Linear => Vec4::from_array(linear),
        Encoding::Normal => direction(Vec4::from_array(linear)),
        Encoding::Srgb | Encoding::CoveredSrgb => {
            let [r, g, b, _] = texel.map(color::srgb16_to_linear);
            Vec4::new(r, g, b, linear[3])
        }
    }
}

/// The unit vector that a texel of a normal map encodes; zero for a texel without a direction.
#[inline(always)]
fn direction(linear: Vec4) -> Vec4 {
    (linear.truncate() * 2.0 - Vec3::ONE).normalize_or_zero().extend(linear.w)
}

/// Linear channels of a mean, from 0 to 1, before rounding.
#[inline(always)]
fn stored(mean: Vec4, encoding: Encoding) -> [f32; 4] {
    match encoding {
        Encoding::Normal => {
            // A mean direction is stored at unit length, which eight bits resolve best.
            let normal = mean.truncate().normalize_or(Vec3::Z);
            (normal * 0.5 + Vec3::splat(0.5)).extend(mean.w).to_array()
        }
        Encoding::Linear | Encoding::Srgb | Encoding::CoveredSrgb => mean.to_array(),
    }
}

fn encode16(mean: Vec4, encoding: Encoding) -> [u16; 4] {
    let values = stored(mean, encoding);
    let linear = values.map(|value| (value * 65535.0 + 0.5) as u16);
    match encoding {
        Encoding::Linear | Encoding::Normal => linear,
        Encoding::Srgb | Encoding::CoveredSrgb => {
            let [r, g, b, _] = values.map(color::linear_to_srgb16);
            [r, g, b, linear[3]]
        }
    }
}

#[cfg(test)]
mod tests;
