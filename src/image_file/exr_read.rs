//! Decoding of OpenEXR files with all channels.

use std::io::Cursor;
use std::path::Path;

use exr::image::read::read;
use exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
use exr::math::Vec2;
use exr::meta::attribute::AttributeValue;
use exr::meta::header::LayerAttributes;
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use glam::DMat3;

use super::exr_rgba::{check_memory, to_rec709};
use super::isolated::isolated;
use crate::error::Error;
use crate::image::{
    Channel, ColorEncoding, Image, PartHashes, PixelWindow, RenderedScene, Samples, SceneContent,
};

/// Decodes the flat channels of all parts of `bytes`, the content of the file `path`.
///
/// Channels of a named part are called `part.channel` unless their own name begins so. All parts must cover the same
/// pixels. Values are those of the file, whatever its `chromaticities`, and those that are not finite are kept.
///
/// # Errors
/// [`Error::Invalid`] when it is not such a file; [`Error::Refused`] when the pixels would take more than
/// `max_memory_bytes`.
pub fn decode_exr(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<Image, Error> {
    Ok(decode_exr_with_primaries(path, bytes, max_memory_bytes)?.0)
}

/// Decodes what [`decode_exr`] does, and the matrix from colours of the file to Rec.709 where they are others.
pub(super) fn decode_exr_with_primaries(
    path: &Path,
    bytes: &[u8],
    max_memory_bytes: u64,
) -> Result<(Image, Option<DMat3>), Error> {
    check_memory(path, bytes, max_memory_bytes)?;
    isolated(|| decode(bytes)).map_err(|why| Error::invalid(path, "", why))
}

fn decode(bytes: &[u8]) -> Result<(Image, Option<DMat3>), String> {
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
    let matrix = image.attributes.chromaticities.and_then(to_rec709);
    let parts = image.layer_data;
    let first = parts.first().ok_or("the file holds no image")?;
    let (size, position) = (first.size, first.attributes.layer_position);
    if parts.iter().any(|part| part.size != size || part.attributes.layer_position != position) {
        return Err("has parts that cover different pixels, which is not supported".to_owned());
    }
    let origin = [position.0 - display.position.0, position.1 - display.position.1];
    let [Ok(x0), Ok(y0)] = origin.map(u32::try_from) else {
        return Err("has pixels outside its display window, which is not supported".to_owned());
    };
    let (width, height) = (size.0 as u32, size.1 as u32);
    let scene = rendered_scene(&first.attributes);
    let mut channels: Vec<Channel> = Vec::new();
    let has_layers = parts.len() > 1;
    for part in parts {
        // The name of an only part tells nothing apart.
        let prefix = prefix_of(&part).filter(|_| has_layers);
        for channel in part.channel_data.list {
            let channel = named_channel(channel, prefix.as_deref())?;
            if channels.iter().any(|other| other.name == channel.name) {
                return Err(format!("has two channels called {}", channel.name));
            }
            channels.push(channel);
        }
    }
    let image = Image {
        scene,
        display_window: PixelWindow::full(display.size.0 as u32, display.size.1 as u32),
        data_window: PixelWindow { x0, y0, x1: x0.saturating_add(width), y1: y0.saturating_add(height) },
        encoding: ColorEncoding::Linear,
        channels,
    };
    Ok((image, matrix))
}

/// What the attributes of the first part tell of the scene.
fn rendered_scene(attributes: &LayerAttributes) -> RenderedScene {
    // Files of images that no camera took have the identity.
    let has_lens = |ndc: &[f32; 16]| *ndc != glam::Mat4::IDENTITY.to_cols_array();
    let camera = attributes.world_to_camera.zip(attributes.world_to_normalized_device.filter(has_lens));
    let text = |attribute: &str| {
        attributes.other.iter().find_map(|(name, value)| match value {
            AttributeValue::Text(text) if *name == *attribute => Some(utf8(text)),
            _ => None,
        })
    };
    RenderedScene {
        camera: camera.map(|(camera, ndc)| [camera, ndc]),
        parts: text(PartHashes::ATTRIBUTE).and_then(|text| PartHashes::parse(&text)),
        content: text(SceneContent::ATTRIBUTE).and_then(|text| SceneContent::parse(&text)),
    }
}

/// The bytes of a text, which this program writes as UTF-8.
fn utf8(text: &exr::meta::attribute::Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// Beginning of the names of a part's channels.
fn prefix_of(part: &Layer<AnyChannels<FlatSamples>>) -> Option<String> {
    let name = part.attributes.layer_name.as_ref()?.to_string();
    (!name.is_empty()).then(|| format!("{name}."))
}

fn named_channel(channel: AnyChannel<FlatSamples>, prefix: Option<&str>) -> Result<Channel, String> {
    let name = channel.name.to_string();
    if channel.sampling != Vec2(1, 1) {
        return Err(format!("has fewer samples of {name} than pixels, which is not supported"));
    }
    let name = match prefix {
        Some(prefix) if !name.starts_with(prefix) => format!("{prefix}{name}"),
        _ => name,
    };
    let samples = match channel.sample_data {
        FlatSamples::F16(samples) => Samples::Half(samples),
        FlatSamples::F32(samples) => Samples::Float(samples),
        FlatSamples::U32(samples) => Samples::Uint(samples),
    };
    Ok(Channel { name, samples })
}
