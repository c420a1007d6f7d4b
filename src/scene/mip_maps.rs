//! Mip maps: copies of an image, each half as wide and high as the one before, down to one texel.
//!
//! Source: Williams, "Pyramidal Parametrics" (SIGGRAPH 1983). A texel is the mean of its area (a box filter) in linear
//! light. Odd sizes are halved and rounded down. A texel then covers parts of up to three texels a side, weighted by area.
//! Means pass from level to level as floats and are rounded once, to the bit depth of the image. A level takes four bytes
//! a texel for eight-bit images and eight for sixteen-bit ones. All levels of one use take a third of the image's memory.
//!
//! The mean depends on the encoding, so each pair of image and encoding has its own levels. This module does not select the
//! level of a lookup.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{Encoding, Image, Texels};
use crate::color;

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

/// Memory of all levels of one encoding, in bytes.
pub(crate) fn mip_bytes(width: u32, height: u32, bytes_per_texel: u64) -> u64 {
    let (mut size, mut texels) = ((width, height), 0_u64);
    while let Some(smaller) = halved(size) {
        texels = texels.saturating_add(u64::from(smaller.0) * u64::from(smaller.1));
        size = smaller;
    }
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
    let mut levels = Vec::new();
    let Some(first) = halved(size) else {
        return levels;
    };
    let width = image.width as usize;
    let mut means = match &image.texels {
        Texels::Rgba8(texels) => {
            downsample(size, first, encoding, |x, y| decode8(texels[y * width + x], encoding))
        }
        Texels::Rgba16(texels) => {
            downsample(size, first, encoding, |x, y| decode16(texels[y * width + x], encoding))
        }
    };
    let mut size = first;
    loop {
        let texels = match &image.texels {
            Texels::Rgba8(_) => {
                Texels::Rgba8(means.par_iter().map(|mean| encode8(*mean, encoding)).collect())
            }
            Texels::Rgba16(_) => {
                Texels::Rgba16(means.par_iter().map(|mean| encode16(*mean, encoding)).collect())
            }
        };
        levels.push(MipLevel { width: size.0, height: size.1, texels });
        let Some(next) = halved(size) else {
            return levels;
        };
        let stride = size.0 as usize;
        means = downsample(size, next, encoding, |x, y| means[y * stride + x]);
        size = next;
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

/// Means of the next level's texels. `texel` returns a value of the previous level.
fn downsample(
    old: (u32, u32),
    new: (u32, u32),
    encoding: Encoding,
    texel: impl Fn(usize, usize) -> Vec4 + Sync,
) -> Vec<Vec4> {
    let (columns, rows) = (spans(old.0, new.0), spans(old.1, new.1));
    let mut means = vec![Vec4::ZERO; columns.len() * rows.len()];
    means.par_chunks_mut(columns.len()).zip(&rows).for_each(|(line, row)| {
        for (mean, column) in line.iter_mut().zip(&columns) {
            *mean = mean_of(*column, *row, encoding, &texel);
        }
    });
    means
}

fn mean_of(column: Span, row: Span, encoding: Encoding, texel: &impl Fn(usize, usize) -> Vec4) -> Vec4 {
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
    if encoding == Encoding::CoveredSrgb && plain.w > 0.0 {
        (covered / plain.w).extend(plain.w)
    } else {
        plain
    }
}

fn decode8(texel: [u8; 4], encoding: Encoding) -> Vec4 {
    let linear = texel.map(|code| f32::from(code) / 255.0);
    match encoding {
        Encoding::Linear => Vec4::from_array(linear),
        Encoding::Normal => direction(linear),
        Encoding::Srgb | Encoding::CoveredSrgb => {
            let [r, g, b, _] = texel.map(color::srgb8_to_linear);
            Vec4::new(r, g, b, linear[3])
        }
    }
}

fn decode16(texel: [u16; 4], encoding: Encoding) -> Vec4 {
    let linear = texel.map(|code| f32::from(code) / 65535.0);
    match encoding {
        Encoding::Linear => Vec4::from_array(linear),
        Encoding::Normal => direction(linear),
        Encoding::Srgb | Encoding::CoveredSrgb => {
            let [r, g, b, _] = texel.map(color::srgb16_to_linear);
            Vec4::new(r, g, b, linear[3])
        }
    }
}

/// The unit vector that a texel of a normal map encodes; zero for a texel without a direction.
fn direction([r, g, b, a]: [f32; 4]) -> Vec4 {
    (Vec3::new(r, g, b) * 2.0 - Vec3::ONE).normalize_or_zero().extend(a)
}

/// Linear channels of a mean, from 0 to 1, before rounding.
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

fn encode8(mean: Vec4, encoding: Encoding) -> [u8; 4] {
    let values = stored(mean, encoding);
    // Float-to-integer casts saturate.
    let linear = values.map(|value| (value * 255.0 + 0.5) as u8);
    match encoding {
        Encoding::Linear | Encoding::Normal => linear,
        Encoding::Srgb | Encoding::CoveredSrgb => {
            let [r, g, b, _] = values.map(color::linear_to_srgb8_by_table);
            [r, g, b, linear[3]]
        }
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
