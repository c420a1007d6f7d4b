//! OpenEXR pictures as linear RGBA, and a cheap look at whether a frame is whole and what it was made from.

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::Path;

use exr::image::read::read;
use exr::image::{AnyChannels, FlatSamples, Image, Layer};
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::Header;
use exr::prelude::{ReadChannels as _, ReadLayers as _};

use super::StoredFrame;
use super::exr_attributes::RENDER_HASH;
use crate::error::{Error, over_limit};

/// A decoded OpenEXR picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrImage {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Row-major R, G, B, A of the data window, top row first; 1 where the file has no alpha.
    pub pixels: Vec<[f32; 4]>,
}

/// Decodes the first flat layer with R, G and B, or with Y, and any numeric type, of the content `bytes` of the file
/// `path`.
///
/// # Errors
/// [`Error::Invalid`] when it is not such a picture; [`Error::Refused`] when the pixels would take more than
/// `max_memory_bytes`.
pub fn decode_exr(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<ExrImage, Error> {
    within_memory(path, bytes, max_memory_bytes)?;
    decode(bytes).map_err(|why| Error::invalid(path, "", why))
}

/// Refuses a file whose pixels would take more than `max_memory_bytes`, judged by its header alone.
pub(super) fn within_memory(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<(), Error> {
    let needed = decoded_bytes(bytes).map_err(|why| Error::invalid(path, "", why))?;
    if needed > u128::from(max_memory_bytes) {
        let message = format!(
            "decoding it needs up to {}; raise --max-memory",
            over_limit(needed, max_memory_bytes.into())
        );
        return Err(Error::refused(path, "", message));
    }
    Ok(())
}

fn decode(bytes: &[u8]) -> Result<ExrImage, String> {
    let layer = &read_first_layer(bytes)?.layer_data;
    Ok(ExrImage { size: (layer.size.0 as u32, layer.size.1 as u32), pixels: rgba(layer)? })
}

/// The first flat part with all its channels and attributes.
pub(super) fn read_first_layer(bytes: &[u8]) -> Result<Image<Layer<AnyChannels<FlatSamples>>>, String> {
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

/// What the EXR file at `path` says about itself, provided that it is whole: its header, its table of offsets and all its
/// chunks are there. Pixels are not decoded.
///
/// # Errors
/// One line that says what is missing or wrong.
pub fn inspect_exr(path: &Path) -> Result<StoredFrame, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let reader = exr::block::read(BufReader::new(file), true).map_err(|error| error.to_string())?;
    let header = reader.headers().first().ok_or("the file holds no picture")?;
    let stored = stored_frame(header);
    for chunk in reader.all_chunks(true).map_err(|error| error.to_string())? {
        chunk.map_err(|error| error.to_string())?;
    }
    Ok(stored)
}

fn stored_frame(header: &Header) -> StoredFrame {
    let display = header.shared_attributes.display_window;
    let position = header.own_attributes.layer_position;
    let hash = header.own_attributes.other.get(&Text::from(RENDER_HASH));
    StoredFrame {
        render_hash: hash.and_then(text),
        picture_size: (display.size.0 as u32, display.size.1 as u32),
        origin: (
            i64::from(position.0) - i64::from(display.position.0),
            i64::from(position.1) - i64::from(display.position.1),
        ),
        size: (header.layer_size.0 as u32, header.layer_size.1 as u32),
    }
}

/// What decoding needs, from the header alone, so that a lying size costs nothing.
fn decoded_bytes(bytes: &[u8]) -> Result<u128, String> {
    let reader = exr::block::read(Cursor::new(bytes), false)
        .map_err(|error| format!("not a readable OpenEXR file: {error}"))?;
    let needed = |header: &Header| {
        let (width, height) = (header.layer_size.0 as u128, header.layer_size.1 as u128);
        // At most four bytes a sample as decoded, and sixteen a pixel as handed on.
        width * height * (header.channels.list.len() as u128 * 4 + 16)
    };
    Ok(reader.headers().iter().map(needed).sum())
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

fn text(value: &AttributeValue) -> Option<String> {
    match value {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}
