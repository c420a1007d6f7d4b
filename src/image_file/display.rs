//! Eight-bit pictures for displays: smaller ones, and those that PNG files hold.

use std::io::Cursor;

use image::imageops::thumbnail;
use image::{ImageFormat, ImageReader, RgbaImage};

use crate::error::{Error, Result, over_limit};

/// sRGB pixels with straight alpha, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisplayImage {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Row-major.
    pub pixels: Vec<[u8; 4]>,
}

/// sRGB values between 0 and 1 with straight alpha, top row first, as finely as the file holds them.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayValues {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Row-major.
    pub pixels: Vec<[f32; 4]>,
}

impl DisplayImage {
    /// The picture in `size`, which is at most its own; each new pixel is the mean of what it covers.
    #[must_use]
    pub fn reduced(&self, size: (u32, u32)) -> Self {
        let bytes = self.pixels.as_flattened().to_vec();
        let Some(picture) = RgbaImage::from_raw(self.size.0, self.size.1, bytes) else {
            return Self { size: (0, 0), pixels: Vec::new() };
        };
        let reduced = thumbnail(&picture, size.0.max(1), size.1.max(1));
        Self { size: reduced.dimensions(), pixels: reduced.as_raw().as_chunks::<4>().0.to_vec() }
    }
}

/// The picture of a PNG file of ours.
///
/// # Errors
/// [`Error::Invalid`] when `bytes`, the content of `path`, are none.
pub fn decode_png(path: &std::path::Path, bytes: &[u8]) -> Result<DisplayImage> {
    let reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let picture = reader
        .decode()
        .map_err(|error| Error::invalid(path, "", format!("not a readable PNG file: {error}")))?
        .into_rgba8();
    Ok(DisplayImage { size: picture.dimensions(), pixels: picture.as_raw().as_chunks::<4>().0.to_vec() })
}

/// The values of a PNG file of any kind, those of 16 bits as they are.
///
/// # Errors
/// [`Error::Invalid`] when `bytes`, the content of `path`, are none; [`Error::Refused`] when they would take more than
/// `max_memory_bytes`.
pub fn decode_png_values(
    path: &std::path::Path,
    bytes: &[u8],
    max_memory_bytes: u64,
) -> Result<DisplayValues> {
    let damaged =
        |error: image::ImageError| Error::invalid(path, "", format!("not a readable PNG file: {error}"));
    let reader = || ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let (width, height) = reader().into_dimensions().map_err(damaged)?;
    // At most eight bytes a pixel as decoded, and sixteen as handed on.
    let needed = u64::from(width) * u64::from(height) * 24;
    if needed > max_memory_bytes {
        let excess = over_limit(needed.into(), max_memory_bytes.into());
        return Err(Error::refused(path, "", format!("decoding it needs up to {excess}")));
    }
    let picture = reader().decode().map_err(damaged)?.into_rgba32f();
    Ok(DisplayValues { size: picture.dimensions(), pixels: picture.as_raw().as_chunks::<4>().0.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduced_pictures_are_means() {
        let pixels = (0..16_u8).map(|i| [i * 16, 0, 0, 255]).collect();
        let picture = DisplayImage { size: (4, 4), pixels };
        let reduced = picture.reduced((2, 2));
        assert_eq!(reduced.size, (2, 2));
        // 0, 16, 64, 80 have the mean 40; two columns on, 32 more; two rows down, 128 more.
        assert_eq!(reduced.pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>(), [40, 72, 168, 200]);
        assert_eq!(picture.reduced((4, 4)), picture);
    }
}
