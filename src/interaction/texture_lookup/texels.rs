//! One level of a texture: wrapping, decoding, and the two filters within it.

use glam::{Vec2, Vec4};

use super::mix;
use crate::color;
use crate::scene::{Encoding, Image, MipLevel, Sampler, Texels, WrapMode};

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

    pub(super) fn nearest(&self, sampler: &Sampler, uv: Vec2, encoding: Encoding) -> Vec4 {
        let (column, _) = whole_and_fraction(f64::from(uv.x) * f64::from(self.width));
        let (row, _) = whole_and_fraction(f64::from(uv.y) * f64::from(self.height));
        let x = wrap(sampler.wrap_u, column, self.width);
        let y = wrap(sampler.wrap_v, row, self.height);
        self.texel(x, y, encoding)
    }

    pub(super) fn bilinear(&self, sampler: &Sampler, uv: Vec2, encoding: Encoding) -> Vec4 {
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
