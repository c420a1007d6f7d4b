//! Images in memory: named channels of samples, and the windows that they cover.
//!
//! [`Image`] is what EXR files are encoded from and decoded to, and what comparisons work on. A rendered frame is a
//! [`crate::film::Film`] until it is stored. Files are the concern of [`crate::image_file`].

mod channel;
mod plate;
mod rendered_scene;
mod scene_content;
mod window;

use std::borrow::Cow;

use crate::color::srgb_to_linear;

use channel::without_rank;
pub use channel::{
    BEAUTY, Channel, Samples, finite_f32, half_from_f32, halves_from_f32, is_cryptomatte, is_finished_image,
    layer_of,
};
pub use plate::{Plate, PlateFit, over, resample};
pub use rendered_scene::{CameraOrigin, PartHashes, RenderedScene};
pub use scene_content::{ContentChange, ContentNames, SceneContent};
pub(crate) use scene_content::{DURATION, content_text, quoted};
pub use window::PixelWindow;

/// Meaning of the values of an image's colour channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorEncoding {
    /// Scene-linear light without an upper bound, premultiplied with alpha.
    Linear,
    /// sRGB values between 0 and 1 with straight alpha.
    Srgb,
}

/// Image of any channels over a rectangle of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The whole image (OpenEXR's display window). It begins at (0, 0), or where the data window begins before it, further on.
    pub display_window: PixelWindow,
    /// The pixels that the channels hold (OpenEXR's data window). Those of this program lie inside the display window.
    pub data_window: PixelWindow,
    /// Meaning of the colour channels.
    pub encoding: ColorEncoding,
    /// The channels, each name once.
    pub channels: Vec<Channel>,
    /// What it was rendered from, as the attributes of its file tell.
    pub scene: RenderedScene,
}

/// Floating-point RGBA pixels, interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbaImage {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Row-major R, G, B, A, top row first.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    /// An image of the channels A, B, G and R of `pixels`, which fill its display window.
    pub fn from_rgba((width, height): (u32, u32), encoding: ColorEncoding, pixels: &[[f32; 4]]) -> Self {
        let channel = |(component, name): (usize, &str)| Channel {
            name: name.to_owned(),
            samples: Samples::Float(pixels.iter().map(|pixel| pixel[component]).collect()),
        };
        // In the order of their names.
        let channels = [(3, "A"), (2, "B"), (1, "G"), (0, "R")].into_iter().map(channel).collect();
        let window = PixelWindow::full(width, height);
        let scene = RenderedScene::default();
        Self { display_window: window, data_window: window, encoding, channels, scene }
    }

    /// Columns and rows of the data window.
    pub fn size(&self) -> (u32, u32) {
        self.data_window.size()
    }

    /// Column and row of the first pixel in the display window; negative for pixels before it.
    pub fn position(&self) -> (i64, i64) {
        let from = |first: u32, display: u32| i64::from(first) - i64::from(display);
        let (data, display) = (self.data_window, self.display_window);
        (from(data.x0, display.x0), from(data.y0, display.y0))
    }

    /// The channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Names of all layers, each once, in the order of their first channels.
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

    /// Channels of a layer.
    pub fn channels_of<'a>(&'a self, layer: &'a str) -> impl Iterator<Item = &'a Channel> {
        self.channels.iter().filter(move |channel| layer_of(&channel.name) == layer)
    }

    /// The image with the channels of `layers` alone.
    #[must_use]
    pub fn with_layers(mut self, layers: &[String]) -> Self {
        self.channels
            .retain(|channel| layers.iter().any(|layer| without_rank(layer) == layer_of(&channel.name)));
        self
    }

    /// The image without the channel A: all of it is opaque.
    #[must_use]
    pub fn without_alpha(mut self) -> Self {
        self.channels.retain(|channel| channel.name != "A");
        self
    }

    /// The image as an EXR file of halves stores it: each float becomes the nearest half. Values that are not finite stay, so
    /// that a comparison finds them.
    #[must_use]
    pub fn rounded_to_halves(mut self) -> Self {
        for channel in &mut self.channels {
            if let Samples::Float(values) = &mut channel.samples {
                for value in values.iter_mut().filter(|value| value.is_finite()) {
                    *value = half_from_f32(*value).to_f32();
                }
            }
        }
        self
    }

    /// The image in scene-linear light premultiplied with alpha.
    #[must_use]
    pub fn into_linear(mut self) -> Self {
        if self.encoding == ColorEncoding::Linear {
            return self;
        }
        self.encoding = ColorEncoding::Linear;
        let alpha = self.floats("A").map(Cow::into_owned).unwrap_or_default();
        for channel in self.channels.iter_mut().filter(|channel| channel.name != "A") {
            if let Samples::Float(values) = &mut channel.samples {
                for (at, value) in values.iter_mut().enumerate() {
                    *value = srgb_to_linear(*value) * alpha.get(at).copied().unwrap_or(1.0);
                }
            }
        }
        self
    }

    /// R, G, B and A of each pixel as stored; alpha is 1 without a channel A. `None` without colours.
    pub fn rgba(&self) -> Option<Vec<[f32; 4]>> {
        let (r, g, b) = (self.floats("R")?, self.floats("G")?, self.floats("B")?);
        let alpha = self.floats("A");
        let alpha = |at: usize| alpha.as_ref().and_then(|alpha| alpha.get(at)).copied().unwrap_or(1.0);
        Some((0..r.len()).map(|at| [r[at], g[at], b[at], alpha(at)]).collect())
    }

    /// Colours over black of the [`color_layer`](Image::color_layer). `None` without colours.
    pub fn colors(&self) -> Option<Vec<[f32; 3]>> {
        self.colors_of(self.color_layer()?)
    }

    /// The layer that the image shows: [`BEAUTY`], one that other programs call so, or the first other one with colours.
    pub fn color_layer(&self) -> Option<&str> {
        let layers =
            self.layers().into_iter().filter(|layer| self.has_colors(layer) && !is_cryptomatte(layer));
        layers.min_by_key(|layer| (*layer != BEAUTY, !is_finished_image(layer)))
    }

    /// Whether a layer has the channels R, G and B. [`BEAUTY`] may have `Y` alone, which is grey.
    pub fn has_colors(&self, layer: &str) -> bool {
        ["R", "G", "B"].into_iter().all(|name| self.component(layer, name).is_some())
    }

    /// Colours over black of a layer. `None` without colours.
    pub fn colors_of(&self, layer: &str) -> Option<Vec<[f32; 3]>> {
        let color = |name| self.component(layer, name);
        let (r, g, b) = (color("R")?, color("G")?, color("B")?);
        let alpha = match self.encoding {
            ColorEncoding::Srgb => self.coverage_of(layer).unwrap_or_default(),
            ColorEncoding::Linear => Cow::default(),
        };
        let pixel = |at: usize| {
            let cover = alpha.get(at).copied().unwrap_or(1.0);
            [r[at] * cover, g[at] * cover, b[at] * cover]
        };
        Some((0..r.len()).map(pixel).collect())
    }

    /// The channel A of a layer.
    pub fn coverage_of(&self, layer: &str) -> Option<Cow<'_, [f32]>> {
        self.component(layer, "A")
    }

    fn component(&self, layer: &str, name: &str) -> Option<Cow<'_, [f32]>> {
        if layer != BEAUTY {
            return self.floats(&format!("{layer}.{name}"));
        }
        self.floats(name).or_else(|| self.floats("Y").filter(|_| name != "A"))
    }

    fn floats(&self, name: &str) -> Option<Cow<'_, [f32]>> {
        self.channel(name)?.samples.floats()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_have_11_bits_and_keep_infinity() {
        let pixels = [[0.1, 0.2, 0.3, 1.0], [f32::INFINITY, 1e6, 0.0, 0.5]];
        let image = Image::from_rgba((2, 1), ColorEncoding::Linear, &pixels);
        assert_eq!(image.rgba().unwrap(), pixels);
        // They are 2⁻¹⁴ apart at 0.1: 1638 · 2⁻¹⁴. The largest one is 65504.
        let stored = image.rounded_to_halves().rgba().unwrap();
        assert_eq!((stored[0][0], stored[0][3]), (1638.0 / 16384.0, 1.0));
        assert_eq!(stored[1], [f32::INFINITY, 65504.0, 0.0, 0.5]);
    }

    #[test]
    fn without_alpha_all_is_opaque_and_without_colours_there_is_nothing() {
        let mut image = Image::from_rgba((1, 1), ColorEncoding::Linear, &[[0.1, 0.2, 0.3, 0.4]]);
        image.channels.retain(|channel| channel.name != "A");
        assert_eq!(image.rgba().unwrap(), [[0.1, 0.2, 0.3, 1.0]]);
        image.channels.retain(|channel| channel.name != "G");
        assert_eq!(image.rgba(), None);
    }
}
