//! OpenEXR in one part, scan lines in increasing order, as bytes in memory.
//!
//! The same picture and attributes always give the same bytes. Two habits of the `exr` crate stand against that and are
//! undone here: its default block order is not fixed, and attributes it has no field for come in hash-map order. Lossy
//! compression is the exception: its tables come from the platform's mathematics and may differ between machines.

use std::io::Cursor;

use exr::block::writer::ChunksWriter as _;
use exr::block::{UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::image::write::layers::{LayersWriter as _, WritableLayers};
use exr::image::{AnyChannel, AnyChannels, Encoding, Image, Layer};
use exr::meta::attribute::Text;
use exr::prelude::{Blocks, LineOrder, WritableImage as _};
use rayon::prelude::*;

use super::{ExrChannel, ExrCompression, ExrPicture, ExrSamples, FrameAttributes, RgbaPixels, half_from_f32};
use crate::error::{Error, Result};

/// Encodes a picture as an OpenEXR file of the channels R, G, B and A as halves.
///
/// # Errors
/// [`Error::Internal`] when the picture's sizes contradict each other.
pub fn encode_exr(pixels: &RgbaPixels<'_>, attributes: &FrameAttributes) -> Result<Vec<u8>> {
    let channel = |(component, name): (usize, &str)| ExrChannel {
        name: name.to_owned(),
        samples: ExrSamples::Half(
            pixels.pixels.par_iter().map(|pixel| half_from_f32(pixel[component])).collect(),
        ),
    };
    let picture = ExrPicture {
        picture_size: pixels.picture_size,
        origin: pixels.origin,
        size: pixels.size,
        channels: ["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect(),
        compression: ExrCompression::Zip,
    };
    encode_exr_picture(picture, attributes)
}

/// Encodes any channels as an OpenEXR file, the channels in the order of their names.
///
/// # Errors
/// [`Error::Internal`] when the picture's sizes contradict each other, there is no channel, or two share a name.
pub fn encode_exr_picture(picture: ExrPicture, attributes: &FrameAttributes) -> Result<Vec<u8>> {
    let ExrPicture { picture_size, origin, size, channels, compression } = picture;
    check_channels(size, &channels)?;
    let size = (size.0 as usize, size.1 as usize);
    let list = channels
        .into_iter()
        .map(|channel| AnyChannel::new(named(&channel.name), channel.samples.for_exr()))
        .collect();
    let encoding = Encoding {
        compression: compression.for_exr(),
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(size, attributes.of_layer(origin), encoding, AnyChannels::sort(list));
    let image = Image::new(attributes.of_image(picture_size), layer);

    let mut bytes = Vec::new();
    write_compressing_in_parallel(&image, &mut bytes).map_err(|error| internal(&error.to_string()))?;
    sort_attributes(&mut bytes)
        .ok_or_else(|| internal("the encoder wrote a header that cannot be followed"))?;
    Ok(bytes)
}

/// Refuses what the encoder would panic over or write wrongly.
fn check_channels(size: (u32, u32), channels: &[ExrChannel]) -> Result<()> {
    if channels.is_empty() {
        return Err(internal("the picture has no channels"));
    }
    let pixels = size.0 as usize * size.1 as usize;
    if channels.iter().any(|channel| channel.samples.len() != pixels) {
        return Err(internal("the picture holds another number of pixels than its size says"));
    }
    let names: std::collections::BTreeSet<_> = channels.iter().map(|channel| &channel.name).collect();
    if names.len() != channels.len() {
        return Err(internal("two channels of the picture share a name"));
    }
    Ok(())
}

fn named(name: &str) -> Text {
    Text::from_slice_unchecked(name.as_bytes())
}

/// Compresses the blocks on the current rayon pool and writes them in their order. (The crate's own parallel writer
/// starts a pool of its own.)
pub(super) fn write_compressing_in_parallel<'a, Layers: WritableLayers<'a>>(
    image: &'a Image<Layers>,
    bytes: &mut Vec<u8>,
) -> exr::error::UnitResult {
    let headers = image.write().infer_meta_data();
    let layers = image.layer_data.create_writer(&headers);
    exr::block::write(Cursor::new(bytes), headers, true, |meta, chunk_writer| {
        let blocks: Vec<_> = enumerate_ordered_header_block_indices(&meta.headers).collect();
        let pack = |(place, index)| {
            let data = layers.extract_uncompressed_block(&meta.headers, index);
            let block = UncompressedBlock { index, data };
            block.compress_to_chunk(&meta.headers).map(|chunk| (place, chunk))
        };
        let chunks: Vec<_> = blocks.into_par_iter().map(pack).collect();
        for chunk in chunks {
            let (place, chunk) = chunk?;
            chunk_writer.write_chunk(place, chunk)?;
        }
        Ok(())
    })
}

/// Brings the attributes of the only header into the order of their names, as OpenEXR's own library writes them.
pub(super) fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
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
    Some(())
}

/// Where the attribute at `start` ends: name, zero, type, zero, four bytes of size, value.
fn attribute_end(bytes: &[u8], start: usize) -> Option<usize> {
    let after_text = |from: usize| Some(from + bytes.get(from..)?.iter().position(|&byte| byte == 0)? + 1);
    let size_at = after_text(after_text(start)?)?;
    let size = bytes.get(size_at..size_at + 4)?.try_into().ok()?;
    let end = size_at + 4 + u32::from_le_bytes(size) as usize;
    (end < bytes.len()).then_some(end)
}

fn internal(message: &str) -> Error {
    Error::Internal { message: format!("the EXR file could not be encoded: {message}") }
}

#[cfg(test)]
mod tests;
