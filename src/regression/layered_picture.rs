//! A picture with all that its file holds, for comparisons: every channel by name, and which layer it belongs to.
//!
//! Layers are recognised by the names that our own files give them (README, "Layers"); channels of other programs make layers
//! named by what stands before their last dot.

use std::path::Path;

use super::flip::linear_from_srgb;
use crate::error::{Error, Result};
use crate::image_file::{ExrSamples, decode_exr_channels, decode_png_values, read_environment};

/// The name of the layer of R, G, B and A.
pub const BEAUTY: &str = "beauty";
/// Bytes that a decoded picture may take.
const MAX_MEMORY_BYTES: u64 = 4 << 30;

/// What the values of the colours mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueRange {
    /// Linear light without an upper bound, premultiplied with alpha.
    Light,
    /// sRGB values of a display between 0 and 1, straight alpha.
    Display,
}

/// The values of a channel, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues {
    /// Halves and floats alike.
    Numbers(Vec<f32>),
    /// Whole numbers that only count as equal or not.
    Ids(Vec<u32>),
}

/// One channel.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedChannel {
    /// As in the file: `R`, `normal.X`.
    pub name: String,
    /// One a pixel.
    pub values: ChannelValues,
}

/// A picture with its layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredPicture {
    /// Columns and rows of the whole picture.
    pub picture_size: (u32, u32),
    /// Column and row of the first pixel held.
    pub origin: (u32, u32),
    /// Columns and rows held.
    pub size: (u32, u32),
    /// What the colours mean.
    pub range: ValueRange,
    /// Sorted by name, each name once.
    pub channels: Vec<NamedChannel>,
}

impl LayeredPicture {
    /// A picture of colours alone.
    pub fn of_pixels(size: (u32, u32), range: ValueRange, pixels: &[[f32; 4]]) -> Self {
        let channel = |(component, name): (usize, &str)| NamedChannel {
            name: name.to_owned(),
            values: ChannelValues::Numbers(pixels.iter().map(|pixel| pixel[component]).collect()),
        };
        // In the order of their names.
        let channels = [(3, "A"), (2, "B"), (1, "G"), (0, "R")].into_iter().map(channel).collect();
        Self { picture_size: size, origin: (0, 0), size, range, channels }
    }

    /// Reads an OpenEXR, PNG or Radiance file; which it is is told by its first bytes.
    ///
    /// # Errors
    /// [`Error::Missing`] when it cannot be read, [`Error::Invalid`] when it is none of these or damaged,
    /// [`Error::Refused`] when it would take too much memory.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(Error::missing(path))?;
        if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            return from_exr(path, &bytes);
        }
        if bytes.starts_with(b"\x89PNG") {
            let picture = decode_png_values(path, &bytes, MAX_MEMORY_BYTES)?;
            return Ok(Self::of_pixels(picture.size, ValueRange::Display, &picture.pixels));
        }
        if bytes.starts_with(b"#?") {
            let picture = read_environment(path, &bytes, MAX_MEMORY_BYTES)?;
            let pixels: Vec<_> = picture.pixels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
            let size = (picture.width, picture.height);
            return Ok(Self::of_pixels(size, ValueRange::Light, &pixels));
        }
        if bytes.starts_with(b"version https://git-lfs") {
            return Err(Error::invalid(
                path,
                "",
                "only says where Git LFS keeps the picture; run git lfs pull",
            ));
        }
        Err(Error::invalid(path, "", "is neither an OpenEXR, a PNG nor a Radiance .hdr file"))
    }

    /// The channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&NamedChannel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// The names of all layers, each once, in the order of their first channels.
    pub fn layers(&self) -> Vec<&str> {
        let mut layers = Vec::new();
        for channel in &self.channels {
            let layer = layer_of(&channel.name);
            if !layers.contains(&layer) {
                layers.push(layer);
            }
        }
        layers
    }

    /// The channels of a layer.
    pub fn channels_of<'a>(&'a self, layer: &'a str) -> impl Iterator<Item = &'a NamedChannel> {
        self.channels.iter().filter(move |channel| layer_of(&channel.name) == layer)
    }

    /// Without the layers that are not named.
    #[must_use]
    pub fn with_layers(mut self, layers: &[String]) -> Self {
        self.channels.retain(|channel| layers.iter().any(|layer| layer == layer_of(&channel.name)));
        self
    }

    /// In linear light premultiplied with alpha, whatever it was before.
    #[must_use]
    pub fn in_light(mut self) -> Self {
        if self.range == ValueRange::Light {
            return self;
        }
        self.range = ValueRange::Light;
        let alpha = match self.channel("A").map(|channel| &channel.values) {
            Some(ChannelValues::Numbers(alpha)) => alpha.clone(),
            _ => Vec::new(),
        };
        for channel in self.channels.iter_mut().filter(|channel| channel.name != "A") {
            if let ChannelValues::Numbers(values) = &mut channel.values {
                for (at, value) in values.iter_mut().enumerate() {
                    *value = linear_from_srgb(*value) * alpha.get(at).copied().unwrap_or(1.0);
                }
            }
        }
        self
    }

    /// The colours as they are seen over black; a picture of `Y` alone is grey. `None` without colours.
    pub fn colors(&self) -> Option<Vec<[f32; 3]>> {
        let numbers = |name: &str| match self.channel(name).map(|channel| &channel.values) {
            Some(ChannelValues::Numbers(values)) => Some(values),
            _ => None,
        };
        let color = |name: &str| numbers(name).or_else(|| numbers("Y"));
        let (r, g, b) = (color("R")?, color("G")?, color("B")?);
        let opaque = Vec::new();
        let alpha = match self.range {
            ValueRange::Display => numbers("A").unwrap_or(&opaque),
            ValueRange::Light => &opaque,
        };
        let pixel = |at: usize| {
            let cover = alpha.get(at).copied().unwrap_or(1.0);
            [r[at] * cover, g[at] * cover, b[at] * cover]
        };
        Some((0..r.len()).map(pixel).collect())
    }
}

/// The layer that a channel belongs to.
pub fn layer_of(channel: &str) -> &str {
    match (channel, channel.rsplit_once('.')) {
        ("R" | "G" | "B" | "A" | "Y" | "RY" | "BY", _) => BEAUTY,
        ("Z", _) => "depth",
        (_, Some(("forward" | "backward", _))) => "motion",
        (_, Some((layer, _))) if layer.starts_with("crypto_") => {
            layer.trim_end_matches(|character: char| character.is_ascii_digit())
        }
        (_, Some((layer, _))) => layer,
        (name, None) => name,
    }
}

fn from_exr(path: &Path, bytes: &[u8]) -> Result<LayeredPicture> {
    let picture = decode_exr_channels(path, bytes, MAX_MEMORY_BYTES)?;
    let mut channels: Vec<_> = picture
        .channels
        .into_iter()
        .map(|channel| NamedChannel {
            name: channel.name,
            values: match channel.samples {
                ExrSamples::Half(values) => {
                    ChannelValues::Numbers(values.into_iter().map(half::f16::to_f32).collect())
                }
                ExrSamples::Float(values) => ChannelValues::Numbers(values),
                ExrSamples::Uint(values) => ChannelValues::Ids(values),
            },
        })
        .collect();
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(LayeredPicture {
        picture_size: picture.picture_size,
        origin: picture.origin,
        size: picture.size,
        range: ValueRange::Light,
        channels,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::{ExrChannel, ExrCompression, ExrPicture, encode_exr_picture};
    use crate::regression::picture::attributes;

    #[test]
    fn all_kinds_of_channels_come_back_with_their_window() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let half = half::f16::from_f32;
        let picture = ExrPicture {
            picture_size: (6, 5),
            origin: (3, 1),
            size: (2, 1),
            channels: vec![
                ExrChannel { name: "object_id".into(), samples: ExrSamples::Uint(vec![7, u32::MAX]) },
                ExrChannel { name: "R".into(), samples: ExrSamples::Half(vec![half(0.5), half(f32::NAN)]) },
                ExrChannel { name: "Z".into(), samples: ExrSamples::Float(vec![1.5, f32::INFINITY]) },
            ],
            compression: ExrCompression::Zip,
        };
        std::fs::write(&path, encode_exr_picture(picture, &attributes(0, 0.0)).unwrap()).unwrap();
        let back = LayeredPicture::read(&path).unwrap();
        assert_eq!((back.picture_size, back.origin, back.size), ((6, 5), (3, 1), (2, 1)));
        assert_eq!(back.layers(), [BEAUTY, "depth", "object_id"]);
        assert_eq!(back.channels[1].values, ChannelValues::Numbers(vec![1.5, f32::INFINITY]));
        assert_eq!(back.channels[2].values, ChannelValues::Ids(vec![7, u32::MAX]));
        assert!(back.colors().is_none());
        std::fs::write(&path, "hello").unwrap();
        assert_eq!(LayeredPicture::read(&path).unwrap_err().exit_code(), 65);
    }

    #[test]
    fn channels_belong_to_layers() {
        for (channel, layer) in [
            ("A", "beauty"),
            ("Z", "depth"),
            ("normal.X", "normal"),
            ("backward.v", "motion"),
            ("crypto_object02.A", "crypto_object"),
            ("node_id", "node_id"),
            ("View.Combined.R", "View.Combined"),
        ] {
            assert_eq!(layer_of(channel), layer);
        }
    }
}
