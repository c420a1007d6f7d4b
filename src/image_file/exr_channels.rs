//! All channels of an OpenEXR file, whatever they are called.

use std::io::Cursor;
use std::path::Path;

use exr::image::read::read;
use exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
use exr::math::Vec2;
use exr::prelude::{ReadChannels as _, ReadLayers as _};

use super::exr_read::within_memory;
use super::{ExrChannel, ExrCompression, ExrPicture, ExrSamples};
use crate::error::Error;

/// Decodes the flat channels of all parts of the content `bytes` of the file `path`. Channels of a part with a name are
/// called `part.channel` unless their own name begins so. All parts must cover the same pixels.
///
/// What is not finite is handed on as it is. The compression of the result says nothing about that of the file.
///
/// # Errors
/// [`Error::Invalid`] when it is not such a picture; [`Error::Refused`] when the pixels would take more than
/// `max_memory_bytes`.
pub fn decode_exr_channels(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<ExrPicture, Error> {
    within_memory(path, bytes, max_memory_bytes)?;
    decode(bytes).map_err(|why| Error::invalid(path, "", why))
}

fn decode(bytes: &[u8]) -> Result<ExrPicture, String> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("not a readable OpenEXR file: {error}"))?;
    let display = image.attributes.display_window;
    let parts = image.layer_data;
    let first = parts.first().ok_or("the file holds no picture")?;
    let (size, position) = (first.size, first.attributes.layer_position);
    if parts.iter().any(|part| part.size != size || part.attributes.layer_position != position) {
        return Err("has parts that cover different pixels, which is not supported".to_owned());
    }
    let origin = [position.0 - display.position.0, position.1 - display.position.1];
    let [Ok(x), Ok(y)] = origin.map(u32::try_from) else {
        return Err("has pixels outside its display window, which is not supported".to_owned());
    };
    let mut channels: Vec<ExrChannel> = Vec::new();
    for part in parts {
        let prefix = prefix_of(&part);
        for channel in part.channel_data.list {
            let channel = renamed(channel, prefix.as_deref())?;
            if channels.iter().any(|other| other.name == channel.name) {
                return Err(format!("has two channels called {}", channel.name));
            }
            channels.push(channel);
        }
    }
    Ok(ExrPicture {
        picture_size: (display.size.0 as u32, display.size.1 as u32),
        origin: (x, y),
        size: (size.0 as u32, size.1 as u32),
        channels,
        compression: ExrCompression::default(),
    })
}

fn prefix_of(part: &Layer<AnyChannels<FlatSamples>>) -> Option<String> {
    let name = part.attributes.layer_name.as_ref()?.to_string();
    (!name.is_empty()).then(|| format!("{name}."))
}

fn renamed(channel: AnyChannel<FlatSamples>, prefix: Option<&str>) -> Result<ExrChannel, String> {
    let name = channel.name.to_string();
    if channel.sampling != Vec2(1, 1) {
        return Err(format!("has fewer samples of {name} than pixels, which is not supported"));
    }
    let name = match prefix {
        Some(prefix) if !name.starts_with(prefix) => format!("{prefix}{name}"),
        _ => name,
    };
    let samples = match channel.sample_data {
        FlatSamples::F16(samples) => ExrSamples::Half(samples),
        FlatSamples::F32(samples) => ExrSamples::Float(samples),
        FlatSamples::U32(samples) => ExrSamples::Uint(samples),
    };
    Ok(ExrChannel { name, samples })
}
