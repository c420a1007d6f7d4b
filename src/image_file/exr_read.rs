//! Decoding of OpenEXR files with all channels.

use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

use exr::image::read::read;
use exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
use exr::math::Vec2;
use exr::meta::attribute::AttributeValue;
use exr::meta::header::LayerAttributes;
use exr::prelude::{ReadChannels as _, ReadLayers as _};

use super::exr_error::exr_error_text;
use super::exr_rgba::check_memory;
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
/// [`Error::Invalid`] when it is not such a file, or has pixels before the first column or row of its display window;
/// [`Error::Refused`] when the pixels would take more than `max_memory_bytes`.
pub fn decode_exr(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<Image, Error> {
    let image = decode_exr_with_overscan(path, bytes, max_memory_bytes)?;
    if (image.display_window.x0, image.display_window.y0) != (0, 0) {
        return Err(Error::invalid(
            path,
            "",
            "has pixels outside its display window, which is not supported",
        ));
    }
    Ok(image)
}

/// Decodes what [`decode_exr`] does, also with pixels before the first column or row of the display window.
pub(super) fn decode_exr_with_overscan(
    path: &Path,
    bytes: &[u8],
    max_memory_bytes: u64,
) -> Result<Image, Error> {
    check_memory(path, bytes, max_memory_bytes)?;
    isolated(|| decode(bytes)).map_err(|why| Error::invalid(path, "", why))
}

fn decode(bytes: &[u8]) -> Result<Image, String> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("not a readable OpenEXR file: {}", exr_error_text(&error)))?;
    let display = image.attributes.display_window;
    let parts = image.layer_data;
    let first = parts.first().ok_or("the file holds no image")?;
    let (size, position) = (first.size, first.attributes.layer_position);
    if parts.iter().any(|part| part.size != size || part.attributes.layer_position != position) {
        return Err("has parts that cover different pixels, which is not supported".to_owned());
    }
    let columns = spans((display.position.0, display.size.0), (position.0, size.0));
    let rows = spans((display.position.1, display.size.1), (position.1, size.1));
    let ([display_x, data_x], [display_y, data_y]) =
        columns.zip(rows).ok_or("the windows of the image are too large")?;
    let window =
        |x: Range<u32>, y: Range<u32>| PixelWindow { x0: x.start, y0: y.start, x1: x.end, y1: y.end };
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
    Ok(Image {
        scene,
        display_window: window(display_x, display_y),
        data_window: window(data_x, data_y),
        encoding: ColorEncoding::Linear,
        channels,
    })
}

/// Columns or rows of the display window and of the data window, each by start and length, from the first of both. `None` where they are too many.
fn spans(display: (i32, usize), data: (i32, usize)) -> Option<[Range<u32>; 2]> {
    let first = i64::from(display.0.min(data.0));
    let span = |(start, length): (i32, usize)| {
        let start = u32::try_from(i64::from(start) - first).ok()?;
        Some(start..start.checked_add(u32::try_from(length).ok()?)?)
    };
    Some([span(display)?, span(data)?])
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::{ExrCompression, FrameAttributes, encode_exr};

    const DISPLAY: (u32, u32) = (12, 8);

    /// A file whose data window begins at `position` of its display window of 12x8 pixels and has `size`. Red is `red` in the first pixel.
    fn file(position: (i64, i64), size: (u32, u32), red: f32) -> Vec<u8> {
        let mut pixels = vec![[0.25, 0.5, 0.75, 1.0]; size.0 as usize * size.1 as usize];
        pixels[0][0] = red;
        let mut image = Image::from_rgba(size, ColorEncoding::Linear, &pixels);
        let window = |x: i64, y: i64, (width, height): (u32, u32)| {
            let (x0, y0) = (x.max(0) as u32, y.max(0) as u32);
            PixelWindow { x0, y0, x1: x0 + width, y1: y0 + height }
        };
        image.display_window = window(-position.0, -position.1, DISPLAY);
        image.data_window = window(position.0, position.1, size);
        encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown()).unwrap()
    }

    fn read(bytes: &[u8]) -> Image {
        Image::decode(Path::new("a.exr"), bytes).unwrap()
    }

    #[test]
    fn pixels_beyond_all_sides_of_the_display_window_are_read() {
        for (position, size) in [
            ((0, 0), (15, 8)),
            ((-3, 0), (15, 8)),
            ((0, -2), (12, 10)),
            ((-1, -2), (14, 12)),
            ((2, 1), (3, 2)),
        ] {
            let image = read(&file(position, size, 0.5));
            assert_eq!(image.position(), position);
            assert_eq!((image.display_window.size(), image.size()), (DISPLAY, size));
            let reds = image.channel("R").unwrap().samples.floats().unwrap();
            assert_eq!((reds.len() as u32, reds[0], reds[1]), (size.0 * size.1, 0.5, 0.25));
        }
    }

    #[test]
    fn overscan_is_written_where_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let image = read(&file((-3, -1), (20, 10), 0.5));
        image.write(&path).unwrap();
        assert_eq!(Image::read(&path).unwrap(), image);
    }

    #[test]
    fn frames_of_this_program_have_no_pixels_before_the_display_window() {
        let decoded = |position| decode_exr(Path::new("a.exr"), &file(position, (12, 8), 0.5), 1 << 20);
        assert!(decoded((0, 0)).is_ok() && decoded((2, 1)).is_ok());
        let error = decoded((-1, 0)).unwrap_err();
        assert!(
            error.exit_code() == 65 && error.to_string().contains("outside its display window"),
            "{error}"
        );
    }

    #[test]
    fn windows_begin_at_the_first_of_both() {
        assert_eq!(spans((0, 12), (0, 12)), Some([0..12, 0..12]));
        assert_eq!(spans((5, 12), (7, 3)), Some([0..12, 2..5]));
        assert_eq!(spans((0, 12), (-3, 20)), Some([3..15, 0..20]));
        let far = (i32::MIN, 1);
        assert_eq!(spans(far, (i32::MAX, 1)), None);
        assert_eq!(spans((i32::MAX - 1, 1), far), Some([u32::MAX - 1..u32::MAX, 0..1]));
    }
}
