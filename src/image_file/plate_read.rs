//! Decoding of image plates: PNG, JPEG and WebP files for displays, OpenEXR and Radiance files of scene-linear light.

use std::path::Path;

use super::environment_read::{hdr_bytes, hdr_pixel_aspect, read_environment};
use super::exr_rgba::{check_memory, decode_exr_window, exr_display_size};
use super::regular_file::check_fetched;
use super::texture_decode::{
    DecodedTexels, decode_upright_texels, image_header, png_size_refusal, size_refusal, upright_size,
};
use super::texture_format::{ImageFormat, image_format};
use crate::color::{srgb8_to_linear, srgb16_to_linear};
use crate::error::{Error, Result, over_limit};
use crate::image::RgbaImage;

/// Bytes of a linear pixel.
const BYTES_A_PIXEL: u64 = 16;

/// A decoded plate.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateImage {
    /// Linear pixels, premultiplied; finite.
    pub image: RgbaImage,
    /// Whether the file holds sRGB values for displays.
    pub is_display_referred: bool,
    /// Width of a pixel as a share of its height: 2 for anamorphic OpenEXR and Radiance files.
    pub pixel_aspect: f64,
}

/// Size, kind and memory of a plate, from its header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlateHeader {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Whether the file holds sRGB values for displays.
    pub is_display_referred: bool,
    /// Memory that decoding takes, bytes.
    pub decoded_bytes: u64,
}

/// Reads the header of `bytes`, the content of `path`. The first bytes tell the format.
///
/// # Errors
/// [`Error::Invalid`] for other formats, [`Error::Refused`] for decompression bombs, PNG files of more than 65,536 columns or rows, and images
/// that take more than `max_memory_bytes`.
pub fn plate_header(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<PlateHeader> {
    check_fetched(path, "", bytes)?;
    let invalid = |why: String| Error::invalid(path, "", why);
    let (size, is_display_referred, decoded_bytes) = match image_format(bytes) {
        ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP => {
            if let Some(why) = png_size_refusal(bytes) {
                return Err(Error::refused(path, "", why));
            }
            let header = image_header(bytes).map_err(invalid)?;
            if let Some(why) = size_refusal(&header, bytes.len()) {
                return Err(Error::refused(path, "", why));
            }
            // Decoders keep the texels of the file besides those that they return.
            let size = upright_size(bytes, &header).map_err(invalid)?;
            (size, true, pixels(size).saturating_mul(2 * header.texel_bytes + BYTES_A_PIXEL))
        }
        _ if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) => {
            check_memory(path, bytes, max_memory_bytes)?;
            let (size, data_bytes) = exr_display_size(bytes).map_err(invalid)?;
            (size, false, data_bytes.saturating_add(pixels(size).saturating_mul(BYTES_A_PIXEL)))
        }
        _ if bytes.starts_with(b"#?") => {
            let (size, bytes) = hdr_bytes(path, bytes)?;
            (size, false, bytes.saturating_add(pixels(size).saturating_mul(BYTES_A_PIXEL)))
        }
        _ => {
            let why = "is neither a PNG, JPEG, WebP, OpenEXR nor Radiance .hdr file; `background` plates are one of these";
            return Err(Error::invalid(path, "", why));
        }
    };
    if size.0 == 0 || size.1 == 0 {
        return Err(Error::invalid(path, "", "holds no pixels"));
    }
    if decoded_bytes > max_memory_bytes {
        let (width, height) = size;
        let excess = over_limit(decoded_bytes.into(), max_memory_bytes.into());
        let why = format!("{width}x{height} pixels need {excess}");
        return Err(Error::over_memory(path, "", why, Some("use a smaller image")));
    }
    Ok(PlateHeader { size, is_display_referred, decoded_bytes })
}

/// Decodes `bytes`, the content of `path`. Of an OpenEXR file the display window counts: what reaches beyond is cut off, what is missing
/// is transparent. PNG, JPEG and WebP files are turned upright by their EXIF orientation.
///
/// # Errors
/// Those of [`plate_header`], and [`Error::Invalid`] for damaged files.
pub fn read_plate(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<PlateImage> {
    let PlateHeader { size, is_display_referred, .. } = plate_header(path, bytes, max_memory_bytes)?;
    let mut pixel_aspect = 1.0;
    let mut pixels = if is_display_referred {
        let texels = decode_upright_texels(bytes).map_err(|why| Error::invalid(path, "", why))?;
        linear_pixels(&texels)
    } else if bytes.starts_with(b"#?") {
        let environment = read_environment(path, bytes, max_memory_bytes)?;
        pixel_aspect = hdr_pixel_aspect(bytes);
        environment.pixels.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
    } else {
        let windowed = decode_exr_window(path, bytes, max_memory_bytes)?;
        pixel_aspect = windowed.pixel_aspect;
        windowed.in_display_window(size)
    };
    for value in pixels.as_flattened_mut() {
        if !value.is_finite() {
            *value = if *value == f32::INFINITY { 65504.0 } else { 0.0 };
        }
    }
    Ok(PlateImage { image: RgbaImage { size, pixels }, is_display_referred, pixel_aspect })
}

fn pixels((width, height): (u32, u32)) -> u64 {
    u64::from(width).saturating_mul(u64::from(height))
}

/// sRGB texels with straight alpha in premultiplied linear light.
fn linear_pixels(texels: &DecodedTexels) -> Vec<[f32; 4]> {
    let premultiplied = |[r, g, b]: [f32; 3], alpha: f32| [r * alpha, g * alpha, b * alpha, alpha];
    match texels {
        DecodedTexels::Rgba8(texels) => texels
            .iter()
            .map(|&[r, g, b, a]| premultiplied([r, g, b].map(srgb8_to_linear), f32::from(a) / 255.0))
            .collect(),
        DecodedTexels::Rgba16(texels) => texels
            .iter()
            .map(|&[r, g, b, a]| premultiplied([r, g, b].map(srgb16_to_linear), f32::from(a) / 65535.0))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::exr_rgba::WindowedRgba;
    use super::*;
    use crate::image::{ColorEncoding, Image};
    use crate::image_file::{ExrCompression, FrameAttributes, encode_exr, encode_png};

    #[test]
    fn display_files_become_premultiplied_light() {
        let png = encode_png((2, 1), &[[255, 188, 0, 255], [255, 255, 0, 51]], "").unwrap();
        let plate = read_plate(Path::new("a.png"), &png, 1 << 20).unwrap();
        assert!(plate.is_display_referred);
        let linear = srgb8_to_linear(188);
        assert_eq!(plate.image.pixels, [[1.0, linear, 0.0, 1.0], [0.2, 0.2, 0.0, 0.2]]);
        assert_eq!(read_plate(Path::new("a.png"), &png, 8).unwrap_err().exit_code(), 77);
        assert_eq!(read_plate(Path::new("a.png"), b"hello", 1 << 20).unwrap_err().exit_code(), 65);
    }

    #[test]
    fn huge_headers_are_refused() {
        let mut png = encode_png((1, 1), &[[0; 4]], "").unwrap();
        png[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
        let error = plate_header(Path::new("a.png"), &png, u64::MAX).unwrap_err();
        assert_eq!(error.exit_code(), 77);
        assert!(error.to_string().contains("decompression bomb"), "{error}");
    }

    /// A JPEG of red over blue with an EXIF orientation.
    fn jpeg(size: (u32, u32), orientation: u8) -> Vec<u8> {
        let is_red = |index: u32| index < size.0 * size.1 / 2;
        let rgb =
            (0..size.0 * size.1).flat_map(|index| if is_red(index) { [255, 0, 0] } else { [0, 0, 255] });
        let (rgb, mut file) = (rgb.collect::<Vec<u8>>(), Vec::new());
        let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, 100);
        encoder.encode(&rgb, size.0, size.1, image::ExtendedColorType::Rgb8).unwrap();
        // APP1: a TIFF header, and a directory of one entry: tag 0x0112, type short, one value.
        let mut exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
        exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
        let mut segment = vec![0xff, 0xe1, 0, exif.len() as u8 + 2];
        segment.extend(exif);
        file.splice(2..2, segment);
        file
    }

    #[test]
    fn photos_stand_upright_and_textures_stay_as_stored() {
        let path = Path::new("photo.jpg");
        // Orientations 6 and 8: clockwise by a quarter turn and by three. 3: upside down.
        for (orientation, size, red, blue) in [
            (1, (16, 32), (8, 2), (8, 29)),
            (3, (16, 32), (8, 29), (8, 2)),
            (6, (32, 16), (29, 8), (2, 8)),
            (8, (32, 16), (2, 8), (29, 8)),
        ] {
            let file = jpeg((16, 32), orientation);
            assert_eq!(plate_header(path, &file, 1 << 20).unwrap().size, size, "{orientation}");
            let image = read_plate(path, &file, 1 << 20).unwrap().image;
            assert_eq!(image.size, size, "{orientation}");
            let at = |(x, y): (usize, usize)| image.pixels[y * size.0 as usize + x];
            assert!(at(red)[0] > 0.9 && at(red)[2] < 0.1, "{orientation}: {:?}", at(red));
            assert!(at(blue)[2] > 0.9 && at(blue)[0] < 0.1, "{orientation}: {:?}", at(blue));
            let stored = crate::image_file::decode_texels(&file);
            assert_eq!(stored, crate::image_file::decode_texels(&jpeg((16, 32), 1)), "{orientation}");
        }
    }

    #[test]
    fn pixels_of_exr_files_have_an_aspect_ratio() {
        let image = Image::from_rgba((2, 1), ColorEncoding::Linear, &[[0.5; 4]; 2]);
        let exr = encode_exr(image, ExrCompression::None, &FrameAttributes::unknown()).unwrap();
        let name = b"pixelAspectRatio\0float\0\x04\0\0\0";
        let at = exr.windows(name.len()).position(|part| part == name).unwrap() + name.len();
        for (stored, read) in [(1.0_f32, 1.0), (2.0, 2.0), (0.0, 1.0), (f32::NAN, 1.0)] {
            let mut exr = exr.clone();
            exr[at..at + 4].copy_from_slice(&stored.to_le_bytes());
            assert_eq!(read_plate(Path::new("a.exr"), &exr, 1 << 20).unwrap().pixel_aspect, read);
        }
    }

    #[test]
    fn the_display_window_counts() {
        let pixel = |value: f32| [value; 4];
        let image = RgbaImage { size: (3, 2), pixels: (1..=6).map(|value| pixel(value as f32)).collect() };
        let windowed = WindowedRgba { image, position: (-1, 1), pixel_aspect: 1.0 };
        let shifted = windowed.in_display_window((3, 2));
        assert_eq!(shifted, [pixel(0.0), pixel(0.0), pixel(0.0), pixel(2.0), pixel(3.0), pixel(0.0)]);
    }
}
