//! Encoding of 8-bit RGBA PNG files.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};

use super::png_text::insert_render_hash;
use crate::error::{Error, Result};

/// Encodes sRGB pixels with straight alpha, top row first, and the hash of what they were rendered from.
///
/// # Errors
/// [`Error::Internal`] when the number of pixels contradicts `size`.
pub fn encode_png(size: (u32, u32), pixels: &[[u8; 4]], render_hash: &str) -> Result<Vec<u8>> {
    let mut png = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Adaptive);
    if size.0 as usize * size.1 as usize != pixels.len() {
        return Err(internal("the number of pixels contradicts the image's size"));
    }
    encoder
        .write_image(pixels.as_flattened(), size.0, size.1, ExtendedColorType::Rgba8)
        .map_err(|error| internal(&error.to_string()))?;
    insert_render_hash(&mut png, render_hash);
    Ok(png)
}

fn internal(message: &str) -> Error {
    Error::Internal { message: format!("the PNG file could not be encoded: {message}") }
}
