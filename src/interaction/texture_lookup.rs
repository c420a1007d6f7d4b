//! Texture lookups: transform, wrap, filter, decode (glTF 2.0, section 3.8; `KHR_texture_transform`).

use glam::{Vec2, Vec4};

use crate::color;
use crate::scene::{Filter, Image, Sampler, Scene, Texels, TextureRef, UvTransform, WrapMode};

/// How stored texels become numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Colours: RGB follow the sRGB transfer function, alpha is linear.
    Srgb,
    /// Everything else.
    Linear,
}

/// The value of a texture at `uv`, which is a coordinate of the set that `reference` names.
///
/// `footprint_uv` is the width of the ray's footprint in texture coordinates; it tells minification from magnification.
pub(super) fn sample(
    scene: &Scene,
    reference: &TextureRef,
    uv: Vec2,
    footprint_uv: f32,
    encoding: Encoding,
) -> Vec4 {
    let texture = &scene.textures[reference.texture.index()];
    let image = &scene.images[texture.image.index()];
    let uv = transformed(&reference.transform, uv);
    let scale = reference.transform.scale;
    let texels_across = footprint_uv
        * libm::sqrtf((scale.x * scale.y).abs())
        * libm::sqrtf(image.width as f32 * image.height as f32);
    let filter = if texels_across > 1.0 { texture.sampler.minify } else { texture.sampler.magnify };
    match filter {
        Filter::Nearest => nearest(image, texture.sampler, uv, encoding),
        Filter::Linear => bilinear(image, texture.sampler, uv, encoding),
    }
}

/// Translation · rotation · scale; the rotation is counter-clockwise in the picture, whose v runs downwards.
fn transformed(transform: &UvTransform, uv: Vec2) -> Vec2 {
    if *transform == UvTransform::default() {
        return uv;
    }
    let (sin, cos) = libm::sincosf(transform.rotation_radians);
    let scaled = uv * transform.scale;
    let rotated = Vec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x);
    transform.offset + rotated
}

fn nearest(image: &Image, sampler: Sampler, uv: Vec2, encoding: Encoding) -> Vec4 {
    let x = wrap(sampler.wrap_u, (f64::from(uv.x) * f64::from(image.width)).floor(), image.width);
    let y = wrap(sampler.wrap_v, (f64::from(uv.y) * f64::from(image.height)).floor(), image.height);
    texel(image, x, y, encoding)
}

fn bilinear(image: &Image, sampler: Sampler, uv: Vec2, encoding: Encoding) -> Vec4 {
    // Texel centres lie at half coordinates.
    let x = f64::from(uv.x) * f64::from(image.width) - 0.5;
    let y = f64::from(uv.y) * f64::from(image.height) - 0.5;
    let (column, row) = (x.floor(), y.floor());
    let (fx, fy) = ((x - column) as f32, (y - row) as f32);
    let [x0, x1] = [column, column + 1.0].map(|x| wrap(sampler.wrap_u, x, image.width));
    let [y0, y1] = [row, row + 1.0].map(|y| wrap(sampler.wrap_v, y, image.height));
    let top = mix(texel(image, x0, y0, encoding), texel(image, x1, y0, encoding), fx);
    let bottom = mix(texel(image, x0, y1, encoding), texel(image, x1, y1, encoding), fx);
    mix(top, bottom, fy)
}

fn mix(a: Vec4, b: Vec4, share: f32) -> Vec4 {
    a + (b - a) * share
}

/// The texel that stands at whole coordinate `position`, which may lie anywhere.
fn wrap(mode: WrapMode, position: f64, size: u32) -> u32 {
    let size = f64::from(size);
    let wrapped = match mode {
        WrapMode::Repeat => position - (position / size).floor() * size,
        WrapMode::MirroredRepeat => {
            let folded = position - (position / (2.0 * size)).floor() * 2.0 * size;
            if folded < size { folded } else { 2.0 * size - 1.0 - folded }
        }
        WrapMode::ClampToEdge => position,
    };
    // Rounding of far coordinates may leave the image by one.
    if wrapped > 0.0 { if wrapped < size { wrapped as u32 } else { size as u32 - 1 } } else { 0 }
}

fn texel(image: &Image, x: u32, y: u32, encoding: Encoding) -> Vec4 {
    let index = y as usize * image.width as usize + x as usize;
    match (&image.texels, encoding) {
        (Texels::Rgba8(texels), Encoding::Linear) => {
            Vec4::from_array(texels[index].map(|c| f32::from(c) / 255.0))
        }
        (Texels::Rgba16(texels), Encoding::Linear) => {
            Vec4::from_array(texels[index].map(|c| f32::from(c) / 65535.0))
        }
        (Texels::Rgba8(texels), Encoding::Srgb) => {
            let [r, g, b, a] = texels[index];
            let [r, g, b] = [r, g, b].map(color::srgb8_to_linear);
            Vec4::new(r, g, b, f32::from(a) / 255.0)
        }
        (Texels::Rgba16(texels), Encoding::Srgb) => {
            let [r, g, b, a] = texels[index];
            let [r, g, b] = [r, g, b].map(color::srgb16_to_linear);
            Vec4::new(r, g, b, f32::from(a) / 65535.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ImageIndex, Texture, TextureIndex};

    /// Four texels in a row with red 0, 1, 2, 3 (times 1/255).
    fn ramp(sampler: Sampler) -> Scene {
        let texels = Texels::Rgba8((0..4).map(|red| [red, 0, 0, 255]).collect());
        Scene {
            images: vec![Image { name: None, width: 4, height: 1, texels }],
            textures: vec![Texture { name: None, image: ImageIndex(0), sampler }],
            ..Default::default()
        }
    }

    fn red(sampler: Sampler, u: f32, footprint: f32) -> f32 {
        let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
        let value = sample(&ramp(sampler), &reference, Vec2::new(u, 0.5), footprint, Encoding::Linear);
        // Decoding and interpolating round the last bits away.
        (value.x * 255_000.0).round() / 1000.0
    }

    fn nearest_with(wrap_u: WrapMode) -> Sampler {
        Sampler { wrap_u, magnify: Filter::Nearest, ..Default::default() }
    }

    #[test]
    fn wrap_modes_continue_the_image() {
        let at = |mode, texel: f32| red(nearest_with(mode), (texel + 0.5) / 4.0, 0.0);
        for (texel, repeat, mirrored, clamped) in [
            (-5.0, 3.0, 3.0, 0.0),
            (-1.0, 3.0, 0.0, 0.0),
            (2.0, 2.0, 2.0, 2.0),
            (4.0, 0.0, 3.0, 3.0),
            (9.0, 1.0, 1.0, 3.0),
        ] {
            assert_eq!(at(WrapMode::Repeat, texel), repeat, "repeat {texel}");
            assert_eq!(at(WrapMode::MirroredRepeat, texel), mirrored, "mirrored {texel}");
            assert_eq!(at(WrapMode::ClampToEdge, texel), clamped, "clamped {texel}");
        }
    }

    #[test]
    fn linear_filtering_meets_texel_centres_and_wraps_between_the_ends() {
        let linear = Sampler::default();
        let at = |u| red(linear, u, 0.0);
        assert_eq!(at(1.5 / 4.0), 1.0);
        assert_eq!(at(2.0 / 4.0), 1.5);
        // Half way between texel 3 and texel 0 of the next repetition.
        assert_eq!(at(0.0), 1.5);
    }

    #[test]
    fn a_wide_footprint_uses_the_minifying_filter() {
        let sampler = Sampler { magnify: Filter::Nearest, minify: Filter::Linear, ..Default::default() };
        assert_eq!(red(sampler, 0.5, 0.01), 2.0);
        assert_eq!(red(sampler, 0.5, 1.0), 1.5);
    }

    #[test]
    fn a_quarter_turn_moves_u_to_minus_v() {
        // Rotation by 90° counter-clockwise: (u, v) → (v, −u), as the extension's sample viewers do.
        let quarter = UvTransform { rotation_radians: std::f32::consts::FRAC_PI_2, ..Default::default() };
        let turned = transformed(&quarter, Vec2::new(0.25, 0.75));
        assert!(turned.abs_diff_eq(Vec2::new(0.75, -0.25), 1e-6), "{turned}");
        // Scale comes before the turn, the offset after it.
        let all = UvTransform { offset: Vec2::new(1.0, 2.0), scale: Vec2::new(2.0, 4.0), ..quarter };
        assert!(transformed(&all, Vec2::new(0.25, 0.75)).abs_diff_eq(Vec2::new(4.0, 1.5), 1e-5));
    }

    #[test]
    fn far_and_infinite_coordinates_stay_inside() {
        for mode in [WrapMode::Repeat, WrapMode::MirroredRepeat, WrapMode::ClampToEdge] {
            for position in [1e30, -1e30, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
                assert!(wrap(mode, position, 4) < 4);
            }
        }
    }
}
