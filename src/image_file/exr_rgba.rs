//! Decoding of OpenEXR images to interleaved RGBA pixels.

use std::io::Cursor;
use std::path::Path;

use exr::compression::Compression;
use exr::image::read::read;
use exr::image::{AnyChannels, FlatSamples, Image as ExrImage, Layer};
use exr::meta::header::Header;
use exr::prelude::{ReadChannels as _, ReadLayers as _};

use super::exr_chunks::check_chunks;
use super::isolated::isolated;
use crate::error::{Error, over_limit};
use crate::image::RgbaImage;

/// Decodes the data window of the first flat part of `bytes`, the content of the file `path`. The part must have the
/// channels R, G and B, or Y, of any numeric type. Alpha is 1 without a channel A.
///
/// # Errors
/// [`Error::Invalid`] when there is no such part; [`Error::Refused`] when the pixels would take more than
/// `max_memory_bytes`.
pub fn decode_exr_rgba(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<RgbaImage, Error> {
    check_memory(path, bytes, max_memory_bytes)?;
    isolated(|| decode(bytes)).map_err(|why| Error::invalid(path, "", why))
}

/// Pixels of a data window and its place in the display window.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WindowedRgba {
    pub(super) image: RgbaImage,
    /// Column and row of the first pixel in the display window.
    pub(super) position: (i64, i64),
}

/// Decodes what [`decode_exr_rgba`] does, with its place in the display window.
pub(super) fn decode_exr_window(
    path: &Path,
    bytes: &[u8],
    max_memory_bytes: u64,
) -> Result<WindowedRgba, Error> {
    check_memory(path, bytes, max_memory_bytes)?;
    let decoded = || {
        let part = read_first_part(bytes)?;
        let (display, layer) = (part.attributes.display_window, part.layer_data);
        let size = (layer.size.0 as u32, layer.size.1 as u32);
        let (start, origin) = (layer.attributes.layer_position, display.position);
        let offset = |start: i32, origin: i32| i64::from(start) - i64::from(origin);
        let image = RgbaImage { size, pixels: rgba(&layer)? };
        Ok(WindowedRgba { image, position: (offset(start.0, origin.0), offset(start.1, origin.1)) })
    };
    isolated(decoded).map_err(|why| Error::invalid(path, "", why))
}

/// Size of the display window, and the bytes that decoding the file takes.
pub(super) fn exr_display_size(bytes: &[u8]) -> Result<((u32, u32), u64), String> {
    let reader = exr::block::read(Cursor::new(bytes), false)
        .map_err(|error| format!("not a readable OpenEXR file: {error}"))?;
    let header = reader.headers().first().ok_or("the file holds no image")?;
    let size = header.shared_attributes.display_window.size;
    let size = u32::try_from(size.0).ok().zip(u32::try_from(size.1).ok()).ok_or("the image is too large")?;
    Ok((size, u64::try_from(decoded_bytes(bytes)?).unwrap_or(u64::MAX)))
}

/// Refuses a file whose pixels would take more than `max_memory_bytes`, and one that has not all its chunks. Decodes nothing.
pub(super) fn check_memory(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<(), Error> {
    let needed = isolated(|| decoded_bytes(bytes)).map_err(|why| Error::invalid(path, "", why))?;
    if needed > u128::from(max_memory_bytes) {
        let message = format!(
            "decoding it needs up to {}; raise `max_memory`",
            over_limit(needed, max_memory_bytes.into())
        );
        return Err(Error::refused(path, "", message));
    }
    let damaged = |why| Error::invalid(path, "", format!("not a readable OpenEXR file: {why}"));
    check_chunks(&mut Cursor::new(bytes)).map_err(damaged)
}

fn decode(bytes: &[u8]) -> Result<RgbaImage, String> {
    let layer = &read_first_part(bytes)?.layer_data;
    Ok(RgbaImage { size: (layer.size.0 as u32, layer.size.1 as u32), pixels: rgba(layer)? })
}

/// The first flat part with all its channels and attributes.
pub(super) fn read_first_part(bytes: &[u8]) -> Result<ExrImage<Layer<AnyChannels<FlatSamples>>>, String> {
    read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("not a readable OpenEXR file: {error}"))
}

/// Memory that decoding needs, from the header alone, so that a false size costs nothing. A file too short for the pixels that it states
/// is an error.
fn decoded_bytes(bytes: &[u8]) -> Result<u128, String> {
    let reader = exr::block::read(Cursor::new(bytes), false)
        .map_err(|error| format!("not a readable OpenEXR file: {error}"))?;
    if reader.headers().iter().map(least_bytes).sum::<u128>() > bytes.len() as u128 {
        return Err(
            "is too short for the pixels that its header states; the file is damaged or truncated".to_owned()
        );
    }
    let needed = |header: &Header| {
        let (width, height) = (header.layer_size.0 as u128, header.layer_size.1 as u128);
        // At most four bytes a sample while decoding, and sixteen a pixel in the result.
        width * height * (header.channels.list.len() as u128 * 4 + 16)
    };
    Ok(reader.headers().iter().map(needed).sum())
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

fn rgba(layer: &Layer<AnyChannels<FlatSamples>>) -> Result<Vec<[f32; 4]>, String> {
    let channels = &layer.channel_data.list;
    let named = |name: &str| channels.iter().find(|channel| channel.name.eq_case_insensitive(name));
    let [r, g, b] = ["R", "G", "B"].map(|name| named(name).or_else(|| named("Y")));
    let (Some(r), Some(g), Some(b)) = (r, g, b) else {
        let names: Vec<_> = channels.iter().map(|channel| channel.name.to_string()).collect();
        return Err(format!("has the channels {}, but R, G, B or Y are needed", names.join(", ")));
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
