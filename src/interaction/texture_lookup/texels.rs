//! One level of a texture: wrapping, decoding, and the two filters within it.

use glam::{Vec2, Vec4};

use super::mix;
use crate::color;
use crate::scene::{Encoding, Filter, Image, MipLevel, Sampler, Texels, WrapMode};

/// Eight-bit values as fractions.
const FRACTIONS: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut code = 0;
    while code < 256 {
        table[code] = code as f32 / 255.0;
        code += 1;
    }
    table
};

/// Texels in rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level<'a> {
    width: u32,
    height: u32,
    texels: &'a Texels,
}

impl<'a> Level<'a> {
    pub(super) fn of_image(image: &'a Image) -> Self {
        Self { width: image.width, height: image.height, texels: &image.texels }
    }

    pub(super) fn of_mip(mip: &'a MipLevel) -> Self {
        Self { width: mip.width, height: mip.height, texels: &mip.texels }
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> Vec2 {
        Vec2::new(self.width as f32, self.height as f32)
    }

    #[inline]
    pub(super) fn nearest(&self, sampler: Sampler, uv: Vec2, encoding: Encoding) -> Vec4 {
        let (column, _) = whole_and_fraction(f64::from(uv.x) * f64::from(self.width));
        let (row, _) = whole_and_fraction(f64::from(uv.y) * f64::from(self.height));
        let x = wrap(sampler.wrap_u, column, self.width);
        let y = wrap(sampler.wrap_v, row, self.height);
        self.texel(x, y, encoding)
    }

    pub(super) fn bilinear(&self, sampler: Sampler, uv: Vec2, encoding: Encoding) -> Vec4 {
        // Texel centres lie at half coordinates.
        let (column, fx) = whole_and_fraction(f64::from(uv.x) * f64::from(self.width) - 0.5);
        let (row, fy) = whole_and_fraction(f64::from(uv.y) * f64::from(self.height) - 0.5);
        let [x0, x1] = [column, column.saturating_add(1)].map(|x| wrap(sampler.wrap_u, x, self.width));
        let [y0, y1] = [row, row.saturating_add(1)].map(|y| wrap(sampler.wrap_v, y, self.height));
        let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| self.texel(x, y, encoding));
        let plain = between(corners, fx, fy);
        if encoding != Encoding::CoveredSrgb || corners.iter().all(|texel| texel.w == corners[0].w) {
            return plain;
        }
        // Colours count as much as they cover, so that what is not there leaves no fringe.
        let covered = between(corners.map(|texel| (texel.truncate() * texel.w).extend(texel.w)), fx, fy);
        if covered.w > 0.0 { (covered.truncate() / covered.w).extend(covered.w) } else { plain }
    }

    /// The mean of lookups at the places of `line`.
    pub(super) fn mean_along(
        &self,
        line: &Line,
        sampler: Sampler,
        filter: Filter,
        encoding: Encoding,
    ) -> Vec4 {
        const BYTE: f32 = 1.0 / 255.0;
        const WORD: f32 = 1.0 / 65535.0;
        let walk = Walk::new(self, line, sampler, filter);
        match (self.texels, encoding) {
            (Texels::Rgba8(texels), Encoding::Linear | Encoding::Normal) => {
                walk.mean(texels, |texel| Vec4::from_array(texel.map(f32::from))) * BYTE
            }
            (Texels::Rgba8(texels), Encoding::Srgb) => {
                let table = color::srgb8_table();
                walk.mean(texels, |[r, g, b, a]| {
                    let [r, g, b] = [r, g, b].map(|code| table[usize::from(code)]);
                    Vec4::new(r, g, b, f32::from(a) * BYTE)
                })
            }
            (Texels::Rgba16(texels), Encoding::Linear | Encoding::Normal) => {
                walk.mean(texels, |texel| Vec4::from_array(texel.map(f32::from))) * WORD
            }
            (Texels::Rgba16(texels), Encoding::Srgb) => walk.mean(texels, |[r, g, b, a]| {
                let [r, g, b] = [r, g, b].map(color::srgb16_to_linear);
                Vec4::new(r, g, b, f32::from(a) * WORD)
            }),
            (_, Encoding::CoveredSrgb) => {
                let each = |place| match filter {
                    Filter::Nearest => self.nearest(sampler, place, encoding),
                    Filter::Linear => self.bilinear(sampler, place, encoding),
                };
                line.covered_mean(each)
            }
        }
    }

    fn texel(&self, x: u32, y: u32, encoding: Encoding) -> Vec4 {
        let index = y as usize * self.width as usize + x as usize;
        match (self.texels, encoding) {
            (Texels::Rgba8(texels), Encoding::Linear | Encoding::Normal) => {
                Vec4::from_array(texels[index].map(|code| FRACTIONS[usize::from(code)]))
            }
            (Texels::Rgba16(texels), Encoding::Linear | Encoding::Normal) => {
                Vec4::from_array(texels[index].map(|code| f32::from(code) / 65535.0))
            }
            (Texels::Rgba8(texels), Encoding::Srgb | Encoding::CoveredSrgb) => {
                let [r, g, b, a] = texels[index];
                let table = color::srgb8_table();
                let [r, g, b] = [r, g, b].map(|code| table[usize::from(code)]);
                Vec4::new(r, g, b, FRACTIONS[usize::from(a)])
            }
            (Texels::Rgba16(texels), Encoding::Srgb | Encoding::CoveredSrgb) => {
                let [r, g, b, a] = texels[index];
                let [r, g, b] = [r, g, b].map(color::srgb16_to_linear);
                Vec4::new(r, g, b, f32::from(a) / 65535.0)
            }
        }
    }
}

/// Evenly spaced places along a line of the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// Texture coordinates of its middle.
    pub(super) middle: Vec2,
    /// From one end to the other.
    pub(super) along: Vec2,
    /// How many places, at least one.
    pub(super) count: u32,
}

impl Line {
    /// The first place and the step to the next.
    fn start_and_step(&self) -> (Vec2, Vec2) {
        let step = self.along / self.count as f32;
        (self.middle - step * (0.5 * (self.count - 1) as f32), step)
    }

    /// The mean of values whose colours count as much as they cover.
    fn covered_mean(&self, value: impl Fn(Vec2) -> Vec4) -> Vec4 {
        let (start, step) = self.start_and_step();
        let (mut plain, mut covered) = (Vec4::ZERO, Vec4::ZERO);
        for index in 0..self.count {
            let value = value(start + step * index as f32);
            plain += value;
            covered += (value.truncate() * value.w).extend(value.w);
        }
        let scale = 1.0 / self.count as f32;
        let coverage = plain.w * scale;
        if covered.w > 0.0 { (covered.truncate() / covered.w).extend(coverage) } else { plain * scale }
    }
}

/// Bits of a texel's width in [`Walk`].
const FRACTION_BITS: u32 = 24;

/// The lookups of a line in one level: what does not change from place to place. Places are whole numbers, in fractions of a
/// texel; beyond 2³⁸ texels all places are one.
#[derive(Debug)]
struct Walk {
    /// From the middle of the first texel for linear lookups, from its edge for nearest ones.
    start: [i64; 2],
    step: [i64; 2],
    count: u32,
    columns: Axis,
    rows: Axis,
    is_linear: bool,
}

/// How one axis of a level continues.
#[derive(Clone, Copy, Debug)]
struct Axis {
    mode: WrapMode,
    size: u32,
    /// Where the axis repeats after a power of two, that less one.
    mask: Option<i64>,
}

impl Axis {
    fn new(mode: WrapMode, size: u32) -> Self {
        let is_easy = mode == WrapMode::Repeat && size.is_power_of_two();
        Self { mode, size, mask: is_easy.then(|| i64::from(size) - 1) }
    }

    fn wrap(self, position: i64) -> usize {
        match self.mask {
            Some(mask) => (position & mask) as usize,
            None => wrap(self.mode, position, self.size) as usize,
        }
    }
}

impl Walk {
    fn new(level: &Level<'_>, line: &Line, sampler: Sampler, filter: Filter) -> Self {
        let (start, step) = line.start_and_step();
        let is_linear = filter == Filter::Linear;
        let shift = if is_linear { 0.5 } else { 0.0 };
        // Casts saturate, and take what is no number to zero.
        let fixed = |texels: f64| ((texels * f64::from(1 << FRACTION_BITS)) as i64).clamp(-1 << 62, 1 << 62);
        let (width, height) = (f64::from(level.width), f64::from(level.height));
        Self {
            start: [fixed(f64::from(start.x) * width - shift), fixed(f64::from(start.y) * height - shift)],
            step: [fixed(f64::from(step.x) * width), fixed(f64::from(step.y) * height)],
            count: line.count,
            columns: Axis::new(sampler.wrap_u, level.width),
            rows: Axis::new(sampler.wrap_v, level.height),
            is_linear,
        }
    }

    /// The mean of the decoded texels around all places.
    #[inline(always)]
    fn mean<T: Copy>(&self, texels: &[T], decode: impl Fn(T) -> Vec4) -> Vec4 {
        const FRACTION: i64 = (1 << FRACTION_BITS) - 1;
        let stride = self.columns.size as usize;
        let fraction = |place: i64| (place & FRACTION) as i32 as f32 * (1.0 / (1 << FRACTION_BITS) as f32);
        let [mut x, mut y] = self.start;
        let mut sum = Vec4::ZERO;
        for _ in 0..self.count {
            let (column, row) = (x >> FRACTION_BITS, y >> FRACTION_BITS);
            let (top, left) = (self.rows.wrap(row) * stride, self.columns.wrap(column));
            if self.is_linear {
                let (right_share, lower_share) = (fraction(x), fraction(y));
                let (bottom, right) = (self.rows.wrap(row + 1) * stride, self.columns.wrap(column + 1));
                let (left_share, upper_share) = (1.0 - right_share, 1.0 - lower_share);
                sum += decode(texels[top + left]) * (left_share * upper_share);
                sum += decode(texels[top + right]) * (right_share * upper_share);
                sum += decode(texels[bottom + left]) * (left_share * lower_share);
                sum += decode(texels[bottom + right]) * (right_share * lower_share);
            } else {
                sum += decode(texels[top + left]);
            }
            x = x.wrapping_add(self.step[0]);
            y = y.wrapping_add(self.step[1]);
        }
        if self.count == 1 { sum } else { sum * (1.0 / self.count as f32) }
    }
}

/// Between the corners of a square: top left, top right, bottom left, bottom right.
fn between([a, b, c, d]: [Vec4; 4], right: f32, down: f32) -> Vec4 {
    mix(mix(a, b, right), mix(c, d, right), down)
}

/// The largest whole number that is not above `position`, and what is left. Nothing is left of numbers that no texture has.
fn whole_and_fraction(position: f64) -> (i64, f32) {
    /// Beyond it floats are whole.
    const LARGEST: f64 = (1_u64 << 52) as f64;
    if !position.is_finite() || position.abs() >= LARGEST {
        return (0, 0.0);
    }
    let towards_zero = position as i64;
    let whole = if towards_zero as f64 > position { towards_zero - 1 } else { towards_zero };
    (whole, (position - whole as f64) as f32)
}

/// The texel that stands at whole coordinate `position`, which may lie anywhere.
pub(super) fn wrap(mode: WrapMode, position: i64, size: u32) -> u32 {
    let size = i64::from(size);
    if (0..size).contains(&position) {
        return position as u32;
    }
    let wrapped = match mode {
        WrapMode::Repeat => modulo(position, size),
        WrapMode::MirroredRepeat => {
            let folded = modulo(position, 2 * size);
            if folded < size { folded } else { 2 * size - 1 - folded }
        }
        WrapMode::ClampToEdge => position.clamp(0, size - 1),
    };
    wrapped as u32
}

/// The remainder that is not negative; without a division for powers of two.
fn modulo(position: i64, size: i64) -> i64 {
    if size & (size - 1) == 0 { position & (size - 1) } else { position.rem_euclid(size) }
}
