//! Images of 8 bits a channel for displays, and decoding of PNG files.

use std::io::Cursor;
use std::path::Path;

use image::imageops::thumbnail;
use image::{ImageBuffer, ImageFormat, ImageReader, Rgba};

use super::isolated::isolated;
use crate::error::{Error, Result, over_limit};
use crate::image::{ColorEncoding, Image};

/// sRGB pixels of 8 bits a channel with straight alpha, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisplayImage {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Row-major.
    pub pixels: Vec<[u8; 4]>,
}

impl DisplayImage {
    /// The image in `size`, which is at most its own. Each new pixel is the mean of those that it covers.
    #[must_use]
    pub fn reduced(&self, size: (u32, u32)) -> Self {
        let bytes = self.pixels.as_flattened().to_vec();
        let Some(image) = ImageBuffer::<Rgba<u8>, _>::from_raw(self.size.0, self.size.1, bytes) else {
            return Self { size: (0, 0), pixels: Vec::new() };
        };
        let reduced = thumbnail(&image, size.0.max(1), size.1.max(1));
        Self { size: reduced.dimensions(), pixels: reduced.as_raw().as_chunks::<4>().0.to_vec() }
    }
}

/// Decodes a PNG file of any kind to 8 bits a channel.
///
/// # Errors
/// [`Error::Invalid`] when `bytes`, the content of `path`, are not a PNG file.
pub fn decode_png(path: &Path, bytes: &[u8]) -> Result<DisplayImage> {
    let reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let image = isolated(|| reader.decode().map_err(|error| error.to_string()))
        .map_err(|why| Error::invalid(path, "", format!("not a readable PNG file: {why}")))?
        .into_rgba8();
    Ok(DisplayImage { size: image.dimensions(), pixels: image.as_raw().as_chunks::<4>().0.to_vec() })
}

/// Decodes a PNG file of any kind to sRGB values between 0 and 1, with straight alpha where the file has any, in the file's precision.
///
/// # Errors
/// [`Error::Invalid`] when `bytes`, the content of `path`, are not a PNG file; [`Error::Refused`] when they would take more
/// than `max_memory_bytes`.
pub fn decode_png_values(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<Image> {
    let damaged =
        |error: image::ImageError| Error::invalid(path, "", format!("not a readable PNG file: {error}"));
    let reader = || ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let (width, height) = reader().into_dimensions().map_err(damaged)?;
    // At most eight bytes a pixel while decoding, and sixteen in the result.
    let needed = u64::from(width) * u64::from(height) * 24;
    if needed > max_memory_bytes {
        let excess = over_limit(needed.into(), max_memory_bytes.into());
        return Err(Error::refused(path, "", format!("decoding it needs up to {excess}")));
    }
    let decode = || reader().decode().map_err(|error| error.to_string());
    let image = isolated(decode)
        .map_err(|why| Error::invalid(path, "", format!("not a readable PNG file: {why}")))?;
    let has_alpha = image.color().has_alpha();
    let pixels = image.into_rgba32f();
    let image =
        Image::from_rgba(pixels.dimensions(), ColorEncoding::Srgb, pixels.as_raw().as_chunks::<4>().0);
    Ok(if has_alpha { image } else { image.without_alpha() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduced_images_are_means() {
        let pixels = (0..16_u8).map(|i| [i * 16, 0, 0, 255]).collect();
        let image = DisplayImage { size: (4, 4), pixels };
        let reduced = image.reduced((2, 2));
        assert_eq!(reduced.size, (2, 2));
        // 0, 16, 64, 80 have the mean 40; two columns on, 32 more; two rows down, 128 more.
        assert_eq!(reduced.pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>(), [40, 72, 168, 200]);
        assert_eq!(image.reduced((4, 4)), image);
    }
}
