//! Decoding of equirectangular environments from Radiance `.hdr` and OpenEXR files.

use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use image::codecs::hdr::{HdrDecoder, SIGNATURE};
use image::{DynamicImage, ImageDecoder as _};
use rayon::prelude::*;

use super::exr_rgba::{WindowedRgba, decode_exr_window, exr_display_size};
use super::isolated::isolated;
use super::radiance_header::RadianceValues;
use super::regular_file::check_fetched;
use crate::error::{Error, Result, Warning, over_limit};

/// Values that a task makes physical.
const VALUES_PER_TASK: usize = 1 << 16;

/// Pixels of an environment image, linear Rec.709, not projected yet.
#[derive(Clone, Debug)]
pub struct EnvironmentPixels {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major R, G, B, top row first; finite and not negative.
    pub pixels: Vec<[f32; 3]>,
    /// Warnings about values that were replaced, pixels that are missing, headers without a meaning, and images of other projections.
    pub warnings: Vec<Warning>,
}

/// Decodes `bytes`, the content of the file `path`. The first bytes tell the format, not the name.
///
/// # Errors
/// [`Error::Invalid`] when the file is of another format or damaged; [`Error::Refused`] when it would take more than
/// `max_memory_bytes`.
pub fn read_environment(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<EnvironmentPixels> {
    check_fetched(path, "", bytes)?;
    let mut environment = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        from_exr(path, bytes, max_memory_bytes)?
    } else if bytes.starts_with(b"#?") {
        from_hdr(path, bytes, max_memory_bytes)?
    } else {
        return Err(Error::invalid(
            path,
            "",
            "is neither a Radiance .hdr nor an OpenEXR file, which environments are, and backgrounds with a rotation",
        ));
    };
    make_physical(&mut environment);
    warn_of_other_projections(path, &mut environment);
    Ok(environment)
}

/// The display window counts, as it does for plates: what reaches beyond is cut off, what is missing is black.
fn from_exr(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<EnvironmentPixels> {
    let windowed = decode_exr_window(path, bytes, max_memory_bytes)?;
    let (size, decoded_bytes) = exr_display_size(bytes).map_err(|why| Error::invalid(path, "", why))?;
    let mut warnings = Vec::new();
    if !windowed.fills(size) {
        check_window(path, &windowed, size)?;
        let needed = needed_bytes(size).saturating_add(decoded_bytes);
        if needed > max_memory_bytes {
            let needed = over_limit(needed.into(), max_memory_bytes.into());
            let message = format!("its display window of {}x{} pixels needs {needed}", size.0, size.1);
            return Err(Error::over_memory(path, "", message, Some("use a smaller image")));
        }
        warnings.extend(lost_pixels(path, &windowed, size));
    }
    let pixels = windowed.in_display_window(size);
    let pixels = pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
    Ok(EnvironmentPixels { width: size.0, height: size.1, pixels, warnings })
}

/// Refuses display windows that hold nothing of the image, or that a small file makes large.
fn check_window(path: &Path, windowed: &WindowedRgba, (width, height): (u32, u32)) -> Result<()> {
    const MOST_PIXELS: u64 = 64;
    let (columns, rows) = windowed.image.size;
    let window = format!("its display window of {width}x{height} pixels");
    if windowed.overlap((width, height)) == (0, 0) {
        let message = format!("none of its {columns}x{rows} pixels is in {window}; reset the window");
        return Err(Error::invalid(path, "", message));
    }
    let (stored, shown) =
        (u64::from(columns) * u64::from(rows), u64::from(width).saturating_mul(height.into()));
    if shown / MOST_PIXELS > stored {
        let message = format!("{window} has more than {MOST_PIXELS} times its {columns}x{rows} pixels");
        return Err(Error::invalid(path, "", message));
    }
    Ok(())
}

/// Tells which pixels are missing, and that most are cut off.
fn lost_pixels(path: &Path, windowed: &WindowedRgba, size: (u32, u32)) -> Vec<Warning> {
    let (columns, rows) = windowed.overlap(size);
    let pixels = |(width, height): (u32, u32)| u64::from(width) * u64::from(height);
    let (stored, kept) = (windowed.image.size, pixels((columns, rows)));
    let mut told = Vec::new();
    if kept < pixels(size) {
        told.push(format!(
            "holds {columns}x{rows} pixels of its display window of {}x{}, which is the sphere; the rest is black",
            size.0, size.1
        ));
    }
    if kept * 2 < pixels(stored) {
        told.push(format!(
            "holds {}x{} pixels, of which the {columns}x{rows} in its display window are the sphere; the others are cut off",
            stored.0, stored.1
        ));
    }
    told.into_iter().map(|what| Warning::of_file(format!("{} {what}", path.display()))).collect()
}

/// Warns of images that are too narrow or too wide for latitudes and longitudes, such as light probes, crosses and strips of cube faces. Images of
/// few rows are made by hand and may have any shape.
fn warn_of_other_projections(path: &Path, environment: &mut EnvironmentPixels) {
    const FEWEST_ROWS: u32 = 16;
    let EnvironmentPixels { width, height, .. } = *environment;
    let ratio = f64::from(width) / f64::from(height);
    if height >= FEWEST_ROWS && !(1.5..=2.5).contains(&ratio) {
        environment.warnings.push(Warning::of_file(format!(
            "{} is read as latitudes and longitudes, but {width}x{height} pixels are not about twice as wide as high; convert light \
             probes and cube maps",
            path.display()
        )));
    }
}

fn from_hdr(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<EnvironmentPixels> {
    let damaged =
        |error: image::ImageError| Error::invalid(path, "", format!("not a readable .hdr file: {error}"));
    let decoder = hdr_decoder(bytes).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let values = RadianceValues::of(&decoder.metadata());
    let needed = needed_bytes((width, height));
    if needed > max_memory_bytes {
        let message =
            format!("{width}x{height} pixels need {}", over_limit(needed.into(), max_memory_bytes.into()));
        return Err(Error::over_memory(path, "", message, Some("use a smaller image")));
    }
    let decode = || DynamicImage::from_decoder(decoder).map_err(|error| error.to_string());
    let image = isolated(decode)
        .map_err(|why| Error::invalid(path, "", format!("not a readable .hdr file: {why}")))?
        .into_rgb32f();
    let (pixels, _) = image.as_raw().as_chunks::<3>();
    // In parallel, since most of the time goes into fresh memory.
    let mut pixels: Vec<_> = pixels.par_iter().copied().collect();
    values.make_light(&mut pixels);
    Ok(EnvironmentPixels { width, height, pixels, warnings: values.warnings(path) })
}

/// Width of a pixel of a Radiance file as a share of its height; 1 where the header does not tell.
pub(super) fn hdr_pixel_aspect(bytes: &[u8]) -> f64 {
    hdr_decoder(bytes).map_or(1.0, |decoder| RadianceValues::of(&decoder.metadata()).pixel_aspect)
}

/// Size of a Radiance file, and the bytes that decoding it takes.
pub(super) fn hdr_bytes(path: &Path, bytes: &[u8]) -> Result<((u32, u32), u64)> {
    let decoder = hdr_decoder(bytes)
        .map_err(|error| Error::invalid(path, "", format!("not a readable .hdr file: {error}")))?;
    let size = decoder.dimensions();
    Ok((size, needed_bytes(size)))
}

/// The decoder of a Radiance file. Files begin with `#?RADIANCE` or with `#?RGBE`, the signature of Greg Ward's library, which the decoder takes
/// only if it is lenient with all of the header. So it gets the other one.
fn hdr_decoder(bytes: &[u8]) -> image::ImageResult<HdrDecoder<impl Read>> {
    let (signature, rest): (&[u8], &[u8]) = match bytes.strip_prefix(b"#?RGBE") {
        Some(rest) => (SIGNATURE, rest),
        None => (b"", bytes),
    };
    HdrDecoder::new(signature.chain(rest))
}

fn needed_bytes((width, height): (u32, u32)) -> u64 {
    u64::from(width).saturating_mul(u64::from(height)).saturating_mul(28)
}

/// Makes all radiance finite and not negative. Infinity, such as an overflowed sun, becomes the largest half; NaN and
/// negative values become 0.
fn make_physical(environment: &mut EnvironmentPixels) {
    let changed = AtomicUsize::new(0);
    environment.pixels.as_flattened_mut().par_chunks_mut(VALUES_PER_TASK).for_each(|values| {
        let mut of_chunk = 0;
        for value in values {
            if !(0.0..=f32::MAX).contains(value) {
                *value = if *value == f32::INFINITY { 65504.0 } else { 0.0 };
                of_chunk += 1;
            }
        }
        changed.fetch_add(of_chunk, Ordering::Relaxed);
    });
    let changed = changed.into_inner();
    if changed > 0 {
        environment.warnings.push(Warning::of_file(format!(
            "{changed} values of the environment are infinite, negative or not a number: infinite ones count as 65504, \
             the others as 0"
        )));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{ColorEncoding, Image, PixelWindow};
    use crate::image_file::{ExrCompression, FrameAttributes, encode_exr};

    /// An image of 2x1 pixels in the flat form of the Radiance format: (128, 64, 0, e) is (0.5, 0.25, 0) · 2^(e − 128).
    const TINY_HDR: &[u8] =
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\x00\x80\x80\x40\x00\x81";

    #[test]
    fn radiance_pixels_have_known_values() {
        let environment = read_environment(Path::new("a.hdr"), TINY_HDR, 1 << 20).unwrap();
        assert_eq!((environment.width, environment.height), (2, 1));
        assert_eq!(environment.pixels, [[0.5, 0.25, 0.0], [1.0, 0.5, 0.0]]);
    }

    /// A file with a display window of 32x16 pixels, of which `window` is stored: red grows with columns and green with rows, and the lower half is black.
    fn exr(window: PixelWindow) -> Vec<u8> {
        let pixel =
            |x: u32, y: u32| if y < 8 { [x as f32, y as f32, 1.0, 1.0] } else { [0.0, 0.0, 0.0, 1.0] };
        let pixels: Vec<_> =
            (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| pixel(x, y))).collect();
        let size = (window.width(), window.height());
        let mut image = Image::from_rgba(size, ColorEncoding::Linear, &pixels);
        image.data_window = window;
        image.display_window = PixelWindow::full(32, 16);
        encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown()).unwrap()
    }

    fn read(window: PixelWindow) -> Result<EnvironmentPixels> {
        read_environment(Path::new("a.exr"), &exr(window), 1 << 20)
    }

    #[test]
    fn the_display_window_of_an_exr_file_is_the_sphere() {
        let whole = read(PixelWindow::full(32, 16)).unwrap();
        assert_eq!((whole.width, whole.height, whole.warnings.len()), (32, 16, 0));
        // Black rows cut off, and pixels beyond two edges
        let cropped = read(PixelWindow { x0: 0, y0: 0, x1: 32, y1: 8 }).unwrap();
        assert_eq!((cropped.width, cropped.height), (32, 16));
        assert!(cropped.pixels == whole.pixels);
        let said = cropped.warnings[0].to_string();
        assert!(said.contains("a.exr holds 32x8 pixels of its display window of 32x16"), "{said}");
        let overscan = read(PixelWindow { x0: 0, y0: 0, x1: 40, y1: 17 }).unwrap();
        assert!(overscan.pixels == whole.pixels && overscan.warnings.is_empty());
        // A shifted part, of which 10x6 pixels are inside
        let part = read(PixelWindow { x0: 22, y0: 2, x1: 60, y1: 8 }).unwrap();
        for (index, (pixel, of_whole)) in part.pixels.iter().zip(&whole.pixels).enumerate() {
            let is_inside = index % 32 >= 22 && (2..8).contains(&(index / 32));
            assert_eq!(*pixel, if is_inside { *of_whole } else { [0.0; 3] }, "pixel {index}");
        }
        let said: Vec<_> = part.warnings.iter().map(ToString::to_string).collect();
        assert!(
            said[0].contains("holds 10x6 pixels of") && said[1].contains("38x6 pixels, of which the 10x6")
        );
    }

    #[test]
    fn windows_without_the_image_and_windows_far_larger_than_it_are_refused() {
        let outside = read(PixelWindow { x0: 32, y0: 0, x1: 40, y1: 16 }).unwrap_err();
        assert!(outside.to_string().contains("none of its 8x16 pixels"), "{outside}");
        let tiny = read(PixelWindow { x0: 0, y0: 0, x1: 7, y1: 1 }).unwrap_err();
        assert!(tiny.to_string().contains("more than 64 times its 7x1 pixels"), "{tiny}");
        assert!(read(PixelWindow { x0: 0, y0: 0, x1: 8, y1: 1 }).is_ok());
        let bytes = exr(PixelWindow { x0: 0, y0: 0, x1: 32, y1: 8 });
        assert_eq!(read_environment(Path::new("a.exr"), &bytes, 16 << 10).unwrap_err().exit_code(), 77);
    }

    #[test]
    fn images_of_other_projections_are_told() {
        let warnings = |width: u32, height: u32| {
            let pixels = vec![[1.0; 3]; width as usize * height as usize];
            let mut environment = EnvironmentPixels { width, height, pixels, warnings: Vec::new() };
            warn_of_other_projections(Path::new("a.hdr"), &mut environment);
            environment.warnings.len()
        };
        for (width, height) in [(64, 32), (60, 32), (1, 1), (4, 1), (2, 2)] {
            assert_eq!(warnings(width, height), 0, "{width}x{height}");
        }
        for (width, height) in [(32, 32), (36, 48), (192, 32), (16, 64)] {
            assert_eq!(warnings(width, height), 1, "{width}x{height}");
        }
    }

    #[test]
    fn radiance_files_have_either_signature() {
        let renamed = [b"#?RGBE", &TINY_HDR[b"#?RADIANCE".len()..]].concat();
        let environment = read_environment(Path::new("a.hdr"), &renamed, 1 << 20).unwrap();
        assert_eq!(environment.pixels, [[0.5, 0.25, 0.0], [1.0, 0.5, 0.0]]);
        // Neither makes the reader lenient.
        for damaged in [
            &b"#?XYZ\n\n-Y 1 +X 2\n\x80\x40\x00\x80\x80\x40\x00\x81"[..],
            b"#?RGBE\nEXPOSURE=bright\n\n-Y 1 +X 2\n\x80\x40\x00\x80\x80\x40\x00\x81",
        ] {
            assert_eq!(read_environment(Path::new("a.hdr"), damaged, 1 << 20).unwrap_err().exit_code(), 65);
        }
    }

    #[test]
    fn other_formats_and_too_large_images_have_their_own_exit_codes() {
        let path = Path::new("a");
        assert_eq!(read_environment(path, b"hello", 1 << 20).unwrap_err().exit_code(), 65);
        assert_eq!(read_environment(path, &TINY_HDR[..50], 1 << 20).unwrap_err().exit_code(), 65);
        assert_eq!(read_environment(path, TINY_HDR, 8).unwrap_err().exit_code(), 77);
    }

    #[test]
    fn unphysical_values_are_replaced_with_a_warning() {
        let mut environment = EnvironmentPixels {
            width: 1,
            height: 1,
            pixels: vec![[f32::INFINITY, f32::NAN, -1.0]],
            warnings: Vec::new(),
        };
        make_physical(&mut environment);
        assert_eq!(environment.pixels, [[65504.0, 0.0, 0.0]]);
        assert!(environment.warnings[0].message.starts_with("3 values"));
    }
}
