//! Small display images of compared images, for summaries.

use super::encoded_image::EncodedImage;
use super::heat_map::magma;
use crate::color::{linear_to_srgb8, srgb_to_linear};
use crate::image::ColorEncoding;
use crate::image_file::DisplayImage;

/// The colours of `image` in at most `max_columns` columns, each pixel the mean of a square of pixels, in sRGB without a tone curve.
/// `None` where the pixels were dropped.
pub fn thumbnail(image: &EncodedImage, max_columns: u32) -> Option<DisplayImage> {
    let mut colors = image.unpacked_colors()?;
    if image.encoding == ColorEncoding::Srgb {
        colors.iter_mut().flatten().for_each(|value| *value = srgb_to_linear(*value));
    }
    let mean = |square: &[usize]| {
        let sum = square.iter().fold(glam::Vec3::ZERO, |sum, &at| sum + glam::Vec3::from_array(colors[at]));
        let [r, g, b] = (sum / square.len() as f32).to_array().map(linear_to_srgb8);
        [r, g, b, 255]
    };
    Some(reduced(image.size, max_columns, mean))
}

/// The heat map of FLIP in at most `max_columns` columns, each pixel the largest error of a square of pixels, so that small differences
/// stay visible. `None` where there is no map.
pub fn heat_map_thumbnail(image: &EncodedImage, max_columns: u32) -> Option<DisplayImage> {
    let errors = image.unpacked_errors()?;
    let largest = |square: &[usize]| {
        let step = square.iter().map(|&at| errors[at]).max().unwrap_or(0);
        let [r, g, b] = magma(f32::from(step) / 255.0);
        [r, g, b, 255]
    };
    Some(reduced(image.size, max_columns, largest))
}

/// An image whose pixels `pixel` makes from the indices of squares of pixels.
fn reduced(size: (u32, u32), max_columns: u32, pixel: impl Fn(&[usize]) -> [u8; 4]) -> DisplayImage {
    let (width, height) = size;
    let side = width.div_ceil(max_columns.max(1)).max(1);
    let small = (width.div_ceil(side), height.div_ceil(side));
    let mut pixels = Vec::with_capacity(small.0 as usize * small.1 as usize);
    let mut square = Vec::with_capacity(side as usize * side as usize);
    for y in (0..height).step_by(side as usize) {
        for x in (0..width).step_by(side as usize) {
            square.clear();
            for row in y..(y + side).min(height) {
                let start = row as usize * width as usize;
                square.extend((x..(x + side).min(width)).map(|column| start + column as usize));
            }
            pixels.push(pixel(&square));
        }
    }
    DisplayImage { size: small, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{FlipMap, Image};

    #[test]
    fn thumbnails_are_means_of_light_and_largest_errors() {
        // Columns of black and white light: their mean is 0.5, which is 188 in sRGB.
        let pixels: Vec<_> = (0..5 * 2).map(|at| [((at % 5) % 2) as f32; 4].map(|v| v.max(0.0))).collect();
        let opaque: Vec<_> = pixels.iter().map(|[v, ..]| [*v, *v, *v, 1.0]).collect();
        let image = Image::from_rgba((5, 2), ColorEncoding::Linear, &opaque);
        let errors = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let map = FlipMap { size: (5, 2), errors, exposures: None };
        let packed = EncodedImage::new(&image).unwrap().with_errors(&map);
        let small = thumbnail(&packed, 3).unwrap();
        assert_eq!(small.size, (3, 1));
        assert_eq!(small.pixels, [[188, 188, 188, 255], [188, 188, 188, 255], [0, 0, 0, 255]]);
        let heat = heat_map_thumbnail(&packed, 3).unwrap();
        assert_eq!(heat.pixels, [[0, 0, 4, 255], [252, 253, 191, 255], [0, 0, 4, 255]]);
        assert_eq!(thumbnail(&packed, 100).unwrap().size, (5, 2));
        assert!(thumbnail(&packed.without_pixels(), 3).is_none());
    }
}
