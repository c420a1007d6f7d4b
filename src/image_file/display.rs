//! Images of 8 bits a channel for displays, and decoding of PNG files.

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::ops::Range;
use std::path::Path;

use image::{ImageFormat, ImageReader, Limits};

use super::isolated::isolated;
use super::png_text::png_frames;
use super::texture_decode::{DecodedTexels, into_decoded};
use crate::color::{Srgb8Codes, srgb8_table};
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
    /// The image in `size`, which is at most its own. Each new pixel is the mean of those that it covers, in linear light, where colours
    /// count by their alpha.
    #[must_use]
    pub fn reduced(&self, size: (u32, u32)) -> Self {
        let size = (size.0.max(1), size.1.max(1));
        let rows = (0..size.1).map(|row| covered(row, size.1, self.size.1));
        let columns: Vec<_> = (0..size.0).map(|column| covered(column, size.0, self.size.0)).collect();
        let pixels =
            rows.flat_map(|rows| columns.iter().map(move |columns| self.mean(columns.clone(), rows.clone())));
        Self { size, pixels: pixels.collect() }
    }

    /// The mean of the pixels in `columns` and `rows`, rounded.
    fn mean(&self, columns: Range<usize>, rows: Range<usize>) -> [u8; 4] {
        let linear = srgb8_table();
        // Sums of equal colours are exact in double precision.
        let (mut light, mut alphas, mut count) = ([0.0_f64; 3], 0_u64, 0_u64);
        for row in rows {
            let start = row * self.size.0 as usize;
            let pixels = self.pixels.get(start + columns.start..start + columns.end).unwrap_or_default();
            for &[r, g, b, alpha] in pixels {
                for (sum, value) in light.iter_mut().zip([r, g, b]) {
                    *sum += f64::from(linear[usize::from(value)]) * f64::from(alpha);
                }
                alphas += u64::from(alpha);
            }
            count += pixels.len() as u64;
        }
        let [r, g, b] = light.map(|sum| Srgb8Codes::get().encode((sum / alphas.max(1) as f64) as f32));
        [r, g, b, ((alphas + count / 2) / count.max(1)) as u8]
    }
}

/// A pixel over an opaque ground, in linear light as everywhere else.
pub fn over([r, g, b, alpha]: [u8; 4], ground: [u8; 3]) -> [u8; 4] {
    let [r, g, b] = match (alpha, [r, g, b]) {
        (0, _) => ground,
        (255, color) => color,
        (_, color) => {
            let (share, linear) = (f32::from(alpha) / 255.0, srgb8_table());
            let light = |value: u8| linear[usize::from(value)];
            let blend = |front: u8, behind: u8| light(front) * share + light(behind) * (1.0 - share);
            std::array::from_fn(|channel| Srgb8Codes::get().encode(blend(color[channel], ground[channel])))
        }
    };
    [r, g, b, 255]
}

/// The rows or columns of `length` that row or column `index` of `count` covers: those that begin in it, and one at least.
fn covered(index: u32, count: u32, length: u32) -> Range<usize> {
    let edge = |index: u64| (index * u64::from(length)).div_ceil(u64::from(count)) as usize;
    let first = edge(index.into()).min((length as usize).saturating_sub(1));
    first..edge(u64::from(index) + 1).max(first + 1)
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
/// [`Error::Invalid`] when `bytes`, the content of `path`, are not a PNG file, or an animated one of several frames; [`Error::Refused`] when
/// they would take more than `max_memory_bytes`.
pub fn decode_png_values(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<Image> {
    refuse_movie(path, png_frames(&mut Cursor::new(bytes)).unwrap_or(1))?;
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
    let decode = || {
        let mut reader = reader();
        // The decoder's own limit may be less than what was admitted. Texts and profiles count, too.
        let mut limits = Limits::default();
        limits.max_alloc = limits.max_alloc.max(Some(needed));
        reader.limits(limits);
        reader.decode().map_err(|error| error.to_string())
    };
    let image = isolated(decode)
        .map_err(|why| Error::invalid(path, "", format!("not a readable PNG file: {why}")))?;
    let has_alpha = image.color().has_alpha();
    // The conversion of the image crate to floats gives greys other bits than equal colours.
    let pixels: Vec<[f32; 4]> = match into_decoded(image) {
        DecodedTexels::Rgba8(codes) => codes.iter().map(|code| code.map(|c| f32::from(c) / 255.0)).collect(),
        DecodedTexels::Rgba16(codes) => {
            codes.iter().map(|code| code.map(|c| f32::from(c) / 65535.0)).collect()
        }
    };
    let image = Image::from_rgba((width, height), ColorEncoding::Srgb, &pixels);
    Ok(if has_alpha { image } else { image.without_alpha() })
}

/// Refuses the file at `path` where its first chunks say that it is an animated PNG file of several frames. The rest is not read.
///
/// # Errors
/// [`Error::Invalid`] for a movie. Errors of reading are those of the reader of the whole file.
pub(super) fn refuse_animated_png(path: &Path) -> Result<()> {
    // Devices and pipes may never end.
    let is_file = std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file());
    let frames = || png_frames(&mut BufReader::new(File::open(path)?));
    refuse_movie(path, if is_file { frames().unwrap_or(1) } else { 1 })
}

fn refuse_movie(path: &Path, frames: u32) -> Result<()> {
    if frames > 1 {
        let why = format!("is a movie of {frames} frames; compare its frames as files");
        return Err(Error::invalid(path, "", why));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn animated_files_are_no_images() {
        let encoded = |frames: u32| {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
            encoder.set_animated(frames, 0).unwrap();
            let mut writer = encoder.write_header().unwrap();
            (0..frames).for_each(|frame| writer.write_image_data(&[frame as u8]).unwrap());
            writer.finish().unwrap();
            bytes
        };
        let decoded = |frames: u32| decode_png_values(Path::new("a.png"), &encoded(frames), 1 << 20);
        let error = decoded(6).unwrap_err();
        assert_eq!(error.exit_code(), 65);
        assert!(error.to_string().contains("is a movie of 6 frames"), "{error}");
        assert_eq!(decoded(1).unwrap().size(), (1, 1));
        // The first chunks tell it, however long the file is and whatever follows them.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("long.apng");
        std::fs::write(&path, &encoded(6)[..80]).unwrap();
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(1 << 34).unwrap();
        let error = Image::read(&path).unwrap_err().to_string();
        assert!(error.contains("is a movie of 6 frames"), "{error}");
    }

    #[test]
    fn greys_have_the_bits_of_equal_colours() {
        let decoded = |image: image::DynamicImage| {
            let mut bytes = Cursor::new(Vec::new());
            image.write_to(&mut bytes, ImageFormat::Png).unwrap();
            decode_png_values(Path::new("a.png"), bytes.get_ref(), 1 << 30).unwrap()
        };
        let codes = || (0..=u8::MAX).map(|code| [code, 200]);
        let grey = image::GrayAlphaImage::from_raw(256, 1, codes().flatten().collect()).unwrap();
        let of_colors = codes().flat_map(|[code, alpha]| [code, code, code, alpha]).collect();
        let colors = image::RgbaImage::from_raw(256, 1, of_colors).unwrap();
        assert_eq!(decoded(grey.into()), decoded(colors.into()));

        let grey: Vec<u16> = (0..=u16::MAX).collect();
        let colors: Vec<u16> = grey.iter().flat_map(|&code| [code; 3]).collect();
        let grey = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(256, 256, grey).unwrap();
        let colors = image::ImageBuffer::<image::Rgb<u16>, _>::from_raw(256, 256, colors).unwrap();
        let grey = decoded(grey.into());
        assert_eq!(grey, decoded(colors.into()));
        let reds = grey.channel("R").unwrap().samples.floats().unwrap();
        assert!(reds.iter().zip(0..=u16::MAX).all(|(red, code)| *red == f32::from(code) / 65535.0));
    }

    #[test]
    fn small_files_may_have_long_texts() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
        encoder.add_text_chunk("XML:com.adobe.xmp".to_owned(), "x".repeat(70_000)).unwrap();
        encoder.write_header().unwrap().write_image_data(&[9]).unwrap();
        assert_eq!(decode_png_values(Path::new("a.png"), &bytes, 1 << 20).unwrap().size(), (1, 1));
    }

    #[test]
    fn transparent_pixels_are_blended_in_linear_light() {
        for pixel in [[200, 100, 50, 255], [0, 255, 7, 255]] {
            assert_eq!(over(pixel, [24; 3]), pixel);
        }
        assert_eq!(over([200, 100, 50, 0], [24, 30, 7]), [24, 30, 7, 255]);
        // Half of white is 0.5 in linear light, which is 188, and over 188 it is 0.75, which is 225.
        assert_eq!(over([255, 255, 255, 128], [0; 3]), [188, 188, 188, 255]);
        assert_eq!(over([255, 255, 0, 128], [188, 0, 188]), [225, 188, 137, 255]);
    }

    #[test]
    fn reduced_images_are_means() {
        let pixels = (0..16_u8).map(|i| [i * 16, 0, 0, 255]).collect();
        let image = DisplayImage { size: (4, 4), pixels };
        let reduced = image.reduced((2, 2));
        assert_eq!(reduced.size, (2, 2));
        // The linear light of 0, 16, 64 and 80 is 0, 0.0052, 0.0513 and 0.0802. Their mean, 0.0342, is 51.9 in sRGB.
        assert_eq!(reduced.pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>(), [52, 80, 172, 204]);
        assert_eq!(image.reduced((4, 4)), image);
        // Five columns in two: three and two.
        let pixels = [10, 20, 60, 100, 101].map(|value| [value, 0, 0, 255]).to_vec();
        let uneven = DisplayImage { size: (5, 1), pixels }.reduced((2, 1));
        assert_eq!(uneven.pixels, [[37, 0, 0, 255], [101, 0, 0, 255]]);
        // Fine stripes of black and white are as bright as half of white, which is 188.
        let pixels = [[0, 0, 0, 255], [255; 4]].repeat(8);
        let stripes = DisplayImage { size: (16, 1), pixels }.reduced((4, 1));
        assert_eq!(stripes.pixels, [[188, 188, 188, 255]; 4]);
    }

    #[test]
    fn colours_of_transparent_pixels_do_not_count() {
        let reduced = |pixels: &[[u8; 4]]| {
            let size = (pixels.len() as u32, 1);
            DisplayImage { size, pixels: pixels.to_vec() }.reduced((1, 1)).pixels[0]
        };
        // The edge of a white object is white.
        assert_eq!(reduced(&[[255; 4], [0; 4]]), [255, 255, 255, 128]);
        // (0.5776 · 255 + 0.0802 · 51) / (255 + 51) is 0.4947 of linear light, which is 187, and the alpha is the mean of 255 and 51.
        assert_eq!(reduced(&[[200, 0, 7, 255], [80, 0, 7, 51]]), [187, 0, 7, 153]);
        assert_eq!(reduced(&[[9, 9, 9, 0], [8, 8, 8, 0]]), [0; 4]);
        assert_eq!(reduced(&[[9, 99, 199, 1]]), [9, 99, 199, 1]);
    }
}
