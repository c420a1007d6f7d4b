//! Light of surfaces with emissive textures, by the path integrator.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use rayframe::scene::{
    Encoding, Filter, Image, ImageIndex, ImageMips, Material, MipFilter, Sampler, Texels, Texture,
    TextureIndex, TextureRef, UvTransform, mip_levels,
};

use super::path::{floor, middle, stage};
use crate::stage::{Stage, assert_close, lambert, rectangle};

const ALBEDO: f32 = 0.5;

/// A floor below a square lamp of half width `half_width` at height 1, which faces down. Its texels have the sRGB code
/// `code(column, row)`; their radiance is its linear value times `strength`.
fn lamp_above_floor(
    samples: u32,
    (half_width, side): (f32, u32),
    strength: f32,
    code: impl Fn(u32, u32) -> u8,
) -> Stage {
    let mut stage = stage(samples);
    stage.add(floor(9.0), lambert(Vec3::splat(ALBEDO)));
    let texels = (0..side * side).map(|texel| {
        let code = code(texel % side, texel / side);
        [code, code, code, 255]
    });
    let image = Image { name: None, width: side, height: side, texels: Texels::Rgba8(texels.collect()) };
    let mut mips = ImageMips::default();
    mips.set(Encoding::Srgb, mip_levels(&image, Encoding::Srgb).into());
    stage.scene.mips.push(mips);
    stage.scene.images.push(image);
    let sampler = Sampler {
        magnify: Filter::Nearest,
        minify: Filter::Nearest,
        mip: MipFilter::None,
        ..Sampler::default()
    };
    stage.scene.textures.push(Texture { name: None, image: ImageIndex(0), sampler });
    let texture = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
    let mut square = rectangle(Vec3::Y, Vec3::X * half_width, Vec3::Z * half_width);
    square.uvs = vec![vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]];
    let emissive_texture = Some(texture);
    stage.add(square, Material { emissive: Vec3::splat(strength), emissive_texture, ..lambert(Vec3::ZERO) });
    stage
}

/// The linear value of an sRGB code.
fn linear(code: u8) -> f32 {
    let encoded = f32::from(code) / 255.0;
    if encoded > 0.04045 { libm::powf((encoded + 0.055) / 1.055, 2.4) } else { encoded / 12.92 }
}

/// The radiance of the middle of that floor: the sum over 64 points of each texel.
fn expected((half_width, side): (f32, u32), strength: f32, code: impl Fn(u32, u32) -> u8) -> f32 {
    let steps = side * 8;
    let position = |step: u32| ((step as f32 + 0.5) / steps as f32 * 2.0 - 1.0) * half_width;
    let width = f64::from(2.0 * half_width / steps as f32);
    let area = width * width;
    let mut sum = 0.0;
    for (row, column) in (0..steps).flat_map(|row| (0..steps).map(move |column| (row, column))) {
        let radiance = f64::from(linear(code(column / 8, row / 8)));
        let squared_distance = f64::from(1.0 + position(column).powi(2) + position(row).powi(2));
        sum += radiance * area / (squared_distance * squared_distance);
    }
    ALBEDO * FRAC_1_PI * strength * sum as f32
}

#[test]
fn small_lit_texels_are_lamps() {
    // One lit texel of 64 x 64, and 5 x 5 squares of 10 x 10 texels in 256 x 256.
    let one = |column, row| if (column, row) == (20, 41) { 255 } else { 0 };
    let squares = |column: u32, row: u32| if column % 54 / 10 == 2 && row % 54 / 10 == 2 { 255 } else { 0 };
    // The part of the lamp around that texel has 32 texels.
    let lamp = lamp_above_floor(16_384, (0.5, 64), 4096.0, one);
    let light = expected((0.5, 64), 4096.0, one);
    assert_close(middle(&lamp), Vec3::splat(light), 0.1 * light);
    let lamp = lamp_above_floor(16_384, (0.5, 256), 50.0, squares);
    let light = expected((0.5, 256), 50.0, squares);
    assert_close(middle(&lamp), Vec3::splat(light), 0.03 * light);
}

#[test]
fn panels_of_any_texels_light_by_their_mean() {
    // Large, so that sampled rays find the light as well as shadow rays do.
    for (side, half_width) in [(1, 1.0), (2, 0.3), (16, 1.0), (16, 4.0)] {
        let code = |column: u32, row: u32| [255, 0, 90, 10, 190][((column * 7 + row * 3) % 5) as usize];
        let lamp = lamp_above_floor(16_384, (half_width, side), 5.0, code);
        let light = expected((half_width, side), 5.0, code);
        assert_close(middle(&lamp), Vec3::splat(light), 0.02 * light);
    }
}
