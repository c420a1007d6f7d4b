//! Decoding of OpenEXR images to interleaved RGBA pixels.

use std::io::Cursor;
use std::path::Path;

use exr::compression::Compression;
use exr::image::read::read;
use exr::image::{AnyChannels, FlatSamples, Image as ExrImage, Layer};
use exr::meta::attribute::Chromaticities as ExrChromaticities;
use exr::meta::header::{Header, ImageAttributes};
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::exr_chunks::check_chunks;
use super::exr_color_layer::ColorLayer;
use super::exr_error::exr_error_text;
use super::isolated::isolated;
use crate::color::Chromaticities;
use crate::error::{Error, over_limit};
use crate::image::RgbaImage;

/// Decodes the data window of the finished image in `bytes`, the content of the file `path`, as linear Rec.709. It has the channels R, G and B, or Y, of any
/// numeric type: those without a layer, of a layer such as Blender's `ViewLayer.Combined`, or else the first ones. Alpha is 1 without a channel A. Colours of other `chromaticities` are converted,
/// those of a file without the attribute, or with chromaticities that no colours have, are Rec.709.
///
/// # Errors
/// [`Error::Invalid`] when there are no such channels; [`Error::Refused`] when the pixels would take more than
/// `max_memory_bytes`.
pub fn decode_exr_rgba(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<RgbaImage, Error> {
    Ok(decode_exr_window(path, bytes, max_memory_bytes)?.image)
}

/// Pixels of a data window and its place in the display window.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WindowedRgba {
    pub(super) image: RgbaImage,
    /// Column and row of the first pixel in the display window.
    pub(super) position: (i64, i64),
    /// Width of a pixel as a share of its height.
    pub(super) pixel_aspect: f64,
}

impl WindowedRgba {
    /// Whether the data window is the display window of `size`.
    pub(super) fn fills(&self, size: (u32, u32)) -> bool {
        (self.image.size, self.position) == (size, (0, 0))
    }

    /// Columns and rows that are in the display window of `size`; none of both where they do not overlap.
    pub(super) fn overlap(&self, (width, height): (u32, u32)) -> (u32, u32) {
        let within = |start: i64, count: u32, whole: u32| {
            let end = (start + i64::from(count)).min(whole.into());
            u32::try_from(end - start.max(0)).unwrap_or(0)
        };
        let columns = within(self.position.0, self.image.size.0, width);
        let rows = within(self.position.1, self.image.size.1, height);
        if columns == 0 || rows == 0 { (0, 0) } else { (columns, rows) }
    }

    /// The pixels of the display window of `size`, where zeros stand for what is missing.
    pub(super) fn in_display_window(self, (width, height): (u32, u32)) -> Vec<[f32; 4]> {
        if self.fills((width, height)) {
            return self.image.pixels;
        }
        let Self { image, position, .. } = self;
        let mut pixels = vec![[0.0; 4]; width as usize * height as usize];
        let first = position.0.max(0);
        let end = (position.0 + i64::from(image.size.0)).min(i64::from(width));
        for row in 0..i64::from(image.size.1) {
            let y = row + position.1;
            if first < end && (0..i64::from(height)).contains(&y) {
                let from = (row * i64::from(image.size.0) + first - position.0) as usize;
                let to = (y * i64::from(width) + first) as usize;
                let count = (end - first) as usize;
                pixels[to..to + count].copy_from_slice(&image.pixels[from..from + count]);
            }
        }
        pixels
    }
}

/// Decodes what [`decode_exr_rgba`] does, with its place in the display window.
pub(super) fn decode_exr_window(
    path: &Path,
    bytes: &[u8],
    max_memory_bytes: u64,
) -> Result<WindowedRgba, Error> {
    check_memory(path, bytes, max_memory_bytes)?;
    let decoded = || {
        let color_layer = ColorLayer::find(&headers(bytes)?)?;
        let (attributes, layer) = read_part(bytes, color_layer.part)?;
        let size = (layer.size.0 as u32, layer.size.1 as u32);
        let (start, origin) = (layer.attributes.layer_position, attributes.display_window.position);
        let offset = |start: i32, origin: i32| i64::from(start) - i64::from(origin);
        let mut pixels = rgba(&layer, &color_layer)?;
        if let Some(matrix) = attributes.chromaticities.and_then(to_rec709) {
            pixels.par_iter_mut().for_each(|pixel| *pixel = converted(*pixel, &matrix));
        }
        let image = RgbaImage { size, pixels };
        let position = (offset(start.0, origin.0), offset(start.1, origin.1));
        Ok(WindowedRgba { image, position, pixel_aspect: plausible_aspect(attributes.pixel_aspect) })
    };
    isolated(decoded).map_err(|why| Error::invalid(path, "", why))
}

/// A ratio of pixels that lenses have; 1 in place of any other, such as 0.
pub(super) fn plausible_aspect(ratio: f32) -> f64 {
    if (0.1..=10.0).contains(&ratio) { ratio.into() } else { 1.0 }
}

/// Size of the display window, and the bytes that decoding the file takes.
pub(super) fn exr_display_size(bytes: &[u8]) -> Result<((u32, u32), u64), String> {
    let headers = headers(bytes)?;
    let header = headers.first().ok_or("the file holds no image")?;
    let size = header.shared_attributes.display_window.size;
    let size = u32::try_from(size.0).ok().zip(u32::try_from(size.1).ok()).ok_or("the image is too large")?;
    Ok((size, u64::try_from(decoded_bytes(bytes)?).unwrap_or(u64::MAX)))
}

/// Refuses a file whose pixels would take more than `max_memory_bytes`, and one that has not all its chunks. Decodes nothing.
pub(super) fn check_memory(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<(), Error> {
    let needed = isolated(|| decoded_bytes(bytes)).map_err(|why| Error::invalid(path, "", why))?;
    if needed > u128::from(max_memory_bytes) {
        let message = format!("decoding it needs up to {}", over_limit(needed, max_memory_bytes.into()));
        return Err(Error::over_memory(path, "", message, None));
    }
    let damaged = |why| Error::invalid(path, "", format!("not a readable OpenEXR file: {why}"));
    check_chunks(&mut Cursor::new(bytes)).map_err(damaged)
}

/// The matrix from colours of `chromaticities` to Rec.709, unless they are Rec.709. Chromaticities that no colours have are taken for those:
/// some programs write zeros.
pub(super) fn to_rec709(chromaticities: ExrChromaticities) -> Option<DMat3> {
    let ExrChromaticities { red, green, blue, white } = chromaticities;
    let [red, green, blue, white] = [red, green, blue, white].map(|xy| glam::Vec2::new(xy.0, xy.1));
    let chromaticities = Chromaticities { red, green, blue, white };
    if chromaticities.is_rec709() { None } else { chromaticities.to_rec709() }
}

/// A pixel in other primaries. Greys are the same in all, and one that is not finite is kept: sums of its channels are not a number.
pub(super) fn converted([r, g, b, a]: [f32; 4], matrix: &DMat3) -> [f32; 4] {
    let color = DVec3::new(r.into(), g.into(), b.into());
    if !color.is_finite() || (r == g && g == b) {
        return [r, g, b, a];
    }
    let [r, g, b] = (*matrix * color).as_vec3().to_array();
    [r, g, b, a]
}

type Part = Layer<AnyChannels<FlatSamples>>;

fn headers(bytes: &[u8]) -> Result<Vec<Header>, String> {
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(|error| unreadable(&error))?;
    Ok(reader.headers().to_vec())
}

fn unreadable(error: &exr::error::Error) -> String {
    format!("not a readable OpenEXR file: {}", exr_error_text(error))
}

/// The flat part with this index and the attributes of the file.
fn read_part(bytes: &[u8], part: usize) -> Result<(ImageAttributes, Part), String> {
    if part == 0 {
        let ExrImage { attributes, layer_data } = read_first_part(bytes)?;
        return Ok((attributes, layer_data));
    }
    let parts = read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    let image = parts
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| unreadable(&error))?;
    let layer = image.layer_data.into_iter().nth(part).ok_or("the file holds no image")?;
    Ok((image.attributes, layer))
}

/// The first flat part with all its channels and attributes.
pub(super) fn read_first_part(bytes: &[u8]) -> Result<ExrImage<Part>, String> {
    read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| unreadable(&error))
}

/// Memory that decoding needs, from the header alone, so that a false size costs nothing. A file too short for the pixels that it states
/// is an error.
fn decoded_bytes(bytes: &[u8]) -> Result<u128, String> {
    let headers = headers(bytes)?;
    if headers.iter().map(least_bytes).sum::<u128>() > bytes.len() as u128 {
        return Err(
            "is too short for the pixels that its header states; the file is damaged or truncated".to_owned()
        );
    }
    let needed = |header: &Header| {
        let (width, height) = (header.layer_size.0 as u128, header.layer_size.1 as u128);
        // At most four bytes a sample while decoding, and sixteen a pixel in the result.
        width * height * (header.channels.list.len() as u128 * 4 + 16)
    };
    Ok(headers.iter().map(needed).sum())
}

/// The fewest bytes of a file with the pixels of `header`: those of the pixels at the strongest compression.
fn least_bytes(header: &Header) -> u128 {
    let pixels = header.layer_size.0 as u128 * header.layer_size.1 as u128;
    let sampled = header.channels.list.iter().map(|channel| {
        let samples = pixels / (channel.sampling.0.max(1) as u128 * channel.sampling.1.max(1) as u128);
        samples * channel.sample_type.bytes_per_sample() as u128
    });
    // Deflate reaches 1032. PIZ codes runs of 255 equal values in some ten bits. DWA deflates one value of a block of 64 pixels.
    let strongest = match header.compression {
        Compression::Uncompressed => 1,
        Compression::RLE => 64,
        Compression::B44 | Compression::B44A => 32,
        Compression::ZIP1 | Compression::ZIP16 | Compression::PXR24 => 2 * 1032,
        Compression::PIZ => 4096,
        _ => 128 * 1032,
    };
    sampled.sum::<u128>() / strongest
}

fn rgba(layer: &Part, color_layer: &ColorLayer) -> Result<Vec<[f32; 4]>, String> {
    let channels = &layer.channel_data.list;
    let named = |name: &str| channels.iter().find(|channel| color_layer.has(&channel.name, name));
    let [r, g, b] = ["R", "G", "B"].map(|name| named(name).or_else(|| named("Y")));
    let (Some(r), Some(g), Some(b)) = (r, g, b) else {
        return Err("has no channels R, G, B or Y".to_owned());
    };
    let mut pixels = vec![[0.0, 0.0, 0.0, 1.0]; layer.size.0 * layer.size.1];
    for (component, channel) in [Some(r), Some(g), Some(b), named("A")].into_iter().enumerate() {
        let Some(channel) = channel else { continue };
        for (pixel, value) in pixels.iter_mut().zip(channel.sample_data.values_as_f32()) {
            pixel[component] = value;
        }
    }
    Ok(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{ColorEncoding, Image};
    use crate::image_file::{ExrCompression, FrameAttributes, encode_exr, read_environment, read_plate};

    /// Red, green, blue and white of ACES2065-1.
    const AP0: [f32; 8] = [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767];

    /// A file of one row with `chromaticities`.
    fn file(pixels: &[[f32; 4]], chromaticities: [f32; 8]) -> Vec<u8> {
        let image = Image::from_rgba((pixels.len() as u32, 1), ColorEncoding::Linear, pixels);
        let bytes = encode_exr(image, ExrCompression::None, &FrameAttributes::unknown()).unwrap();
        with_chromaticities(bytes, chromaticities)
    }

    fn with_chromaticities(mut bytes: Vec<u8>, chromaticities: [f32; 8]) -> Vec<u8> {
        let name = b"chromaticities\0chromaticities\0";
        let found = bytes.windows(name.len()).position(|found| found == name).unwrap();
        // After the length of the value.
        let start = found + name.len() + 4;
        for (index, value) in chromaticities.into_iter().enumerate() {
            bytes[start + 4 * index..start + 4 * index + 4].copy_from_slice(&value.to_le_bytes());
        }
        bytes
    }

    fn assert_near(pixel: [f32; 4], expected: [f32; 4]) {
        let is_near = |channel: usize| (pixel[channel] - expected[channel]).abs() < 1e-5;
        assert!((0..4).all(is_near), "{pixel:?} is not {expected:?}");
    }

    #[test]
    fn plates_and_environments_of_other_primaries_become_rec709() {
        let path = Path::new("aces.exr");
        let bytes = file(&[[1.0; 4], [0.2, 0.4, 0.6, 0.5], [f32::INFINITY, 1.0, 1.0, 1.0]], AP0);
        let plate = read_plate(path, &bytes, 1 << 20).unwrap().image.pixels;
        assert_near(plate[0], [1.0; 4]);
        // The published matrix gives 2.521686 · 0.2 − 1.134131 · 0.4 − 0.387555 · 0.6 in red, and so on.
        assert_near(plate[1], [-0.181_848, 0.436_048, 0.636_746, 0.5]);
        // Infinity is no colour.
        assert_eq!(plate[2], [65504.0, 1.0, 1.0, 1.0]);
        let environment = read_environment(path, &bytes, 1 << 20).unwrap();
        // Radiance is not negative.
        let [r, g, b] = environment.pixels[1];
        assert_near([r, g, b, 0.0], [0.0, 0.436_048, 0.636_746, 0.0]);
        assert!(environment.warnings[0].message.starts_with("2 values"), "{:?}", environment.warnings);
    }

    #[test]
    fn greys_are_read_to_the_bit() {
        let pixels = [[0.1; 4], [0.7, 0.7, 0.7, 1.0]];
        let plate = read_plate(Path::new("a.exr"), &file(&pixels, AP0), 1 << 20).unwrap();
        assert_eq!(plate.image.pixels, pixels);
    }

    #[test]
    fn rec709_is_read_to_the_bit() {
        let pixels = [[0.2, 0.4, 0.6, 0.5], [-0.1, 70000.0, 1e-9, 1.0]];
        let rounded = [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.31271, 0.32902];
        let plate = read_plate(Path::new("a.exr"), &file(&pixels, rounded), 1 << 20).unwrap();
        assert_eq!(plate.image.pixels, pixels);
    }

    #[test]
    fn chromaticities_that_no_colours_have_are_taken_for_rec709() {
        let pixels = [[0.2, 0.4, 0.6, 0.5]];
        for malformed in [[0.0; 8], [f32::NAN; 8], [0.64, 0.33, 0.64, 0.33, 0.15, 0.06, 0.3127, 0.329]] {
            let plate = read_plate(Path::new("a.exr"), &file(&pixels, malformed), 1 << 20).unwrap();
            assert_eq!(plate.image.pixels, pixels, "{malformed:?}");
        }
    }
}
