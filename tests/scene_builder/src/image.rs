//! Small images from formulas, and their textures.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};

use crate::accessor::Use;
use crate::document::{Built, Gltf};
use crate::json::object;

/// An image; row 0 is the top row.
#[derive(Clone, Debug)]
pub struct Image {
    width: u32,
    height: u32,
    texels: Vec<[u8; 4]>,
}

/// Wrap mode of a sampler.
#[derive(Clone, Copy, Debug)]
pub enum Wrap {
    Repeat = 10497,
    MirroredRepeat = 33648,
    ClampToEdge = 33071,
}

/// Magnification and minification filters of a sampler.
#[derive(Clone, Copy, Debug)]
pub enum Filter {
    Nearest,
    Linear,
    /// Linear with linear mipmaps.
    Mipmapped,
}

impl Image {
    /// The image whose texel at column x and row y is `texel(x, y)`.
    pub fn new(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Self {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y));
        Self { width, height, texels: texels.collect() }
    }

    /// Squares of `cell` texels in two colours, `even` at the top left.
    pub fn chequer(size: u32, cell: u32, even: [u8; 3], odd: [u8; 3]) -> Self {
        Self::new(size, size, |x, y| opaque(if (x / cell + y / cell).is_multiple_of(2) { even } else { odd }))
    }

    /// A black letter F on a field whose corners are red, green, blue and yellow, clockwise from the top left. All its
    /// rotations and reflections differ.
    pub fn letter_f(size: u32) -> Self {
        Self::new(size, size, |x, y| {
            let (column, row) = (x * 8 / size, y * 8 / size);
            let stem = column == 2 && (1..7).contains(&row);
            let bars = row == 1 && (2..6).contains(&column) || row == 3 && (2..5).contains(&column);
            opaque(match (stem || bars, column < 4, row < 4) {
                (true, ..) => [16, 16, 16],
                (_, true, true) => [214, 74, 60],
                (_, false, true) => [80, 170, 84],
                (_, false, false) => [72, 104, 204],
                (_, true, false) => [226, 190, 70],
            })
        })
    }

    /// A tangent-space normal map from the slopes of a height field over the unit square.
    pub fn normal_map(size: u32, slope: impl Fn(f32, f32) -> [f32; 2]) -> Self {
        Self::new(size, size, |x, y| {
            let [du, dv] = slope((x as f32 + 0.5) / size as f32, (y as f32 + 0.5) / size as f32);
            // v runs down the image and the bitangent up, hence the sign of the second slope.
            let normal = glam::Vec3::new(-du, dv, 1.0).normalize();
            let [red, green, blue] = normal.to_array().map(|value| byte(value * 0.5 + 0.5));
            [red, green, blue, 255]
        })
    }

    /// Adds the image as a PNG file inside the buffer; returns its index.
    pub fn add_to(&self, gltf: &mut Gltf, name: &'static str) -> Built<usize> {
        let has_alpha = self.texels.iter().any(|texel| texel[3] != 255);
        let (bytes, color): (Vec<u8>, _) = if has_alpha {
            (self.texels.concat(), ExtendedColorType::Rgba8)
        } else {
            (
                self.texels.iter().flat_map(|texel| [texel[0], texel[1], texel[2]]).collect(),
                ExtendedColorType::Rgb8,
            )
        };
        let mut png = Vec::new();
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::NoFilter).write_image(
            &bytes,
            self.width,
            self.height,
            color,
        )?;
        let view = gltf.buffer_view(&png, Use::Other, None);
        Ok(gltf.add(
            "images",
            object([("name", name.into()), ("mimeType", "image/png".into()), ("bufferView", view.into())]),
        ))
    }

    /// Adds the image and a repeating texture of it; returns the index of the texture.
    pub fn texture(&self, gltf: &mut Gltf, name: &'static str, filter: Filter) -> Built<usize> {
        let image = self.add_to(gltf, name)?;
        Ok(texture(gltf, image, filter, [Wrap::Repeat; 2]))
    }
}

/// Adds a texture of an image.
pub fn texture(gltf: &mut Gltf, image: usize, filter: Filter, wrap: [Wrap; 2]) -> usize {
    let (magnify, minify) = match filter {
        Filter::Nearest => (9728, 9728),
        Filter::Linear => (9729, 9729),
        Filter::Mipmapped => (9729, 9987),
    };
    texture_with(gltf, image, [magnify, minify], wrap)
}

/// Adds a texture of an image with glTF's numbers for the magnification and minification filters.
pub fn texture_with(gltf: &mut Gltf, image: usize, [magnify, minify]: [usize; 2], wrap: [Wrap; 2]) -> usize {
    let sampler = gltf.add(
        "samplers",
        object([
            ("magFilter", magnify.into()),
            ("minFilter", minify.into()),
            ("wrapS", (wrap[0] as usize).into()),
            ("wrapT", (wrap[1] as usize).into()),
        ]),
    );
    gltf.add("textures", object([("sampler", sampler.into()), ("source", image.into())]))
}

/// The colour with an alpha of 255.
pub fn opaque([red, green, blue]: [u8; 3]) -> [u8; 4] {
    [red, green, blue, 255]
}

/// A value from 0 to 1 as a byte, rounded to nearest.
pub fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}
