//! Encoding of OpenEXR files: one part, scan lines in increasing order.
//!
//! The same image and attributes always give the same bytes. Two behaviours of the `exr` crate prevent that and are undone
//! here: its default block order is not fixed, and it writes attributes that it has no field for in hash-map order. Lossy
//! compression is the exception: its tables come from the platform's mathematics and may differ between machines.

use std::collections::BTreeSet;
use std::io::Cursor;

use exr::block::writer::ChunksWriter as _;
use exr::block::{UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::image::write::layers::{LayersWriter as _, WritableLayers};
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer};
use exr::prelude::{Blocks, Compression, LineOrder, WritableImage as _};
use rayon::prelude::*;

use super::exr_attributes::byte_text;
use super::exr_checksum::seal;
use super::exr_deflate::ChunkCompressor;
use super::exr_dwa::with_finite_light;
use super::{ExrCompression, FrameAttributes};
use crate::error::{Error, Result};
use crate::image::{Channel, Image, Samples};

/// Encodes an image as an OpenEXR file, the channels in the order of their names. Samples are stored in their own type.
///
/// # Errors
/// [`Error::Internal`] when a channel does not fill the data window, there is no channel, or two share a name.
pub fn encode_exr(
    image: Image,
    compression: ExrCompression,
    attributes: &FrameAttributes,
) -> Result<Vec<u8>> {
    check_channels(&image)?;
    let (size, display_size) = (image.size(), image.display_window.size());
    let encoding = Encoding {
        compression: compression.for_exr(),
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (size.0 as usize, size.1 as usize);
    let layer_attributes = attributes.of_layer(image.position());
    let channels = exr_channels(image.channels, encoding.compression);
    let layer = Layer::new(size, layer_attributes, encoding, channels);
    let image = ExrImage::new(attributes.of_image(display_size), layer);

    let mut bytes = Vec::new();
    write_compressing_in_parallel(&image, &mut bytes).map_err(|error| internal(&error.to_string()))?;
    sort_attributes(&mut bytes)
        .and_then(|_| seal(&mut bytes))
        .ok_or_else(|| internal("the encoder wrote a header that cannot be parsed"))?;
    Ok(bytes)
}

/// Channels in the order of their names, with light that `compression` keeps finite.
pub(super) fn exr_channels(channels: Vec<Channel>, compression: Compression) -> AnyChannels<FlatSamples> {
    let channel = |channel: Channel| {
        let Channel { name, samples } = with_finite_light(channel, compression);
        AnyChannel::new(byte_text(&name), flat_samples(samples))
    };
    AnyChannels::sort(channels.into_iter().map(channel).collect())
}

/// Refuses images that the encoder would panic over or write wrongly.
pub(super) fn check_channels(image: &Image) -> Result<()> {
    if image.channels.is_empty() {
        return Err(internal("the image has no channels"));
    }
    let pixels = image.data_window.pixel_count();
    if image.channels.iter().any(|channel| channel.samples.len() != pixels) {
        return Err(internal("a channel does not fill the image's data window"));
    }
    let names: BTreeSet<_> = image.channels.iter().map(|channel| &channel.name).collect();
    if names.len() != image.channels.len() {
        return Err(internal("two channels of the image share a name"));
    }
    Ok(())
}

fn flat_samples(samples: Samples) -> FlatSamples {
    match samples {
        Samples::Half(samples) => FlatSamples::F16(samples),
        Samples::Float(samples) => FlatSamples::F32(samples),
        Samples::Uint(samples) => FlatSamples::U32(samples),
    }
}

/// Compresses the blocks on the current rayon pool and writes them in order. The crate's own parallel writer is not used: it
/// starts a thread pool of its own.
pub(super) fn write_compressing_in_parallel<'a, Layers: WritableLayers<'a>>(
    image: &'a ExrImage<Layers>,
    bytes: &mut Vec<u8>,
) -> exr::error::UnitResult {
    let headers = image.write().infer_meta_data();
    let layers = image.layer_data.create_writer(&headers);
    exr::block::write(Cursor::new(bytes), headers, true, |meta, chunk_writer| {
        let blocks: Vec<_> = enumerate_ordered_header_block_indices(&meta.headers).collect();
        let compress = |compressor: &mut ChunkCompressor, (chunk_index, index)| {
            let data = layers.extract_uncompressed_block(&meta.headers, index);
            let chunk = compressor.compress(UncompressedBlock { index, data }, &meta.headers);
            chunk.map(|chunk| (chunk_index, chunk))
        };
        let chunks: Vec<_> = blocks.into_par_iter().map_init(ChunkCompressor::new, compress).collect();
        for chunk in chunks {
            let (chunk_index, chunk) = chunk?;
            chunk_writer.write_chunk(chunk_index, chunk)?;
        }
        Ok(())
    })
}

/// Sorts the attributes of the only header by name, as OpenEXR's own library writes them. Returns the position behind the header.
///
/// `None` when the header cannot be parsed.
pub(super) fn sort_attributes(bytes: &mut [u8]) -> Option<usize> {
    const AFTER_MAGIC_AND_VERSION: usize = 8;
    let mut attributes = Vec::new();
    let mut start = AFTER_MAGIC_AND_VERSION;
    while *bytes.get(start)? != 0 {
        let end = attribute_end(bytes, start)?;
        attributes.push(bytes[start..end].to_vec());
        start = end;
    }
    // A name ends in a zero byte, so comparing whole attributes compares names; no two names are equal.
    attributes.sort();
    let sorted = attributes.concat();
    bytes[AFTER_MAGIC_AND_VERSION..start].copy_from_slice(&sorted);
    Some(start + 1)
}

/// End of the attribute at `start`: name, zero, type, zero, four bytes of size, value.
fn attribute_end(bytes: &[u8], start: usize) -> Option<usize> {
    let after_text = |from: usize| Some(from + bytes.get(from..)?.iter().position(|&byte| byte == 0)? + 1);
    let size_at = after_text(after_text(start)?)?;
    let size = bytes.get(size_at..size_at + 4)?.try_into().ok()?;
    let end = size_at + 4 + u32::from_le_bytes(size) as usize;
    (end < bytes.len()).then_some(end)
}

pub(super) fn internal(message: &str) -> Error {
    Error::Internal { message: format!("the EXR file could not be encoded: {message}") }
}

#[cfg(test)]
mod tests;
