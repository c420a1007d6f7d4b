//! A picture with all that its file holds, for comparisons: every channel by name, and which layer it belongs to.
//!
//! Layers are recognised by the names that our own files give them (README, "Layers"); channels of other programs make layers
//! named by what stands before their last dot.

use super::flip::linear_from_srgb;
use crate::film::Film;
use crate::image_file::half_from_f32;

/// The name of the layer of R, G, B and A.
pub const BEAUTY: &str = "beauty";

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

    /// The colours of a film.
    pub fn of_film(film: &Film) -> Self {
        let window = film.window;
        let held = Self::of_pixels((window.width(), window.height()), ValueRange::Light, &film.pixels);
        Self { picture_size: film.resolution, origin: (window.x0, window.y0), ..held }
    }

    /// The picture that an OpenEXR file of halves holds: each number becomes the nearest half. What is not finite stays, so that a
    /// comparison sees it.
    #[must_use]
    pub fn as_halves(mut self) -> Self {
        for channel in &mut self.channels {
            if let ChannelValues::Numbers(values) = &mut channel.values {
                for value in values.iter_mut().filter(|value| value.is_finite()) {
                    *value = half_from_f32(*value).to_f32();
                }
            }
        }
        self
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

    fn numbers(&self, name: &str) -> Option<&Vec<f32>> {
        match &self.channel(name)?.values {
            ChannelValues::Numbers(values) => Some(values),
            ChannelValues::Ids(_) => None,
        }
    }

    /// R, G, B and A of each pixel as they are; without A all is opaque. `None` without colours.
    pub fn rgba(&self) -> Option<Vec<[f32; 4]>> {
        let (r, g, b) = (self.numbers("R")?, self.numbers("G")?, self.numbers("B")?);
        let alpha = self.numbers("A");
        let alpha = |at: usize| alpha.and_then(|alpha| alpha.get(at)).copied().unwrap_or(1.0);
        Some((0..r.len()).map(|at| [r[at], g[at], b[at], alpha(at)]).collect())
    }

    /// The colours as they are seen over black; a picture of `Y` alone is grey. `None` without colours.
    pub fn colors(&self) -> Option<Vec<[f32; 3]>> {
        let color = |name| self.numbers(name).or_else(|| self.numbers("Y"));
        let (r, g, b) = (color("R")?, color("G")?, color("B")?);
        let opaque = Vec::new();
        let alpha = match self.range {
            ValueRange::Display => self.numbers("A").unwrap_or(&opaque),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PixelWindow;

    #[test]
    fn films_become_colours_in_their_window() {
        let mut film = Film::new((6, 5), PixelWindow { x0: 3, y0: 1, x1: 5, y1: 2 });
        film.pixels = vec![[0.1, 0.2, 0.3, 1.0], [f32::INFINITY, 1e6, 0.0, 0.5]];
        let picture = LayeredPicture::of_film(&film);
        assert_eq!((picture.picture_size, picture.origin, picture.size), ((6, 5), (3, 1), (2, 1)));
        assert_eq!(picture.rgba().unwrap(), film.pixels);
        // Halves have 11 bits, 2⁻¹⁴ apart at 0.1: 1638 · 2⁻¹⁴. The largest one is 65504.
        let stored = picture.as_halves().rgba().unwrap();
        assert_eq!((stored[0][0], stored[0][3]), (1638.0 / 16384.0, 1.0));
        assert_eq!(stored[1], [f32::INFINITY, 65504.0, 0.0, 0.5]);
    }

    #[test]
    fn without_alpha_all_is_opaque_and_without_colours_there_is_nothing() {
        let mut picture = LayeredPicture::of_pixels((1, 1), ValueRange::Light, &[[0.1, 0.2, 0.3, 0.4]]);
        picture.channels.retain(|channel| channel.name != "A");
        assert_eq!(picture.rgba().unwrap(), [[0.1, 0.2, 0.3, 1.0]]);
        picture.channels.retain(|channel| channel.name != "G");
        assert_eq!(picture.rgba(), None);
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
