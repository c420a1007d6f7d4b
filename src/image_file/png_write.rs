//! Eight-bit RGBA PNG files as bytes in memory.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};

use super::png_text::insert_render_hash;
use crate::error::{Error, Result};

/// Encodes sRGB pixels with straight alpha, top row first, and what they were made from.
///
/// # Errors
/// [`Error::Internal`] when there is another number of pixels than `size` says.
pub fn encode_png(size: (u32, u32), pixels: &[[u8; 4]], render_hash: &str) -> Result<Vec<u8>> {
    let mut png = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Adaptive);
    if size.0 as usize * size.1 as usize != pixels.len() {
        return Err(internal("the picture holds another number of pixels than its size says"));
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
