//! Where an OpenEXR file holds its colours. Renderers write them as plain channels, as a layer of channels (`ViewLayer.Combined.R`), or as a
//! part of their own.

use exr::meta::attribute::Text;
use exr::meta::header::Header;

use crate::image::{is_cryptomatte, is_finished_image};

/// A part of a file, and the beginning of the names of its colour channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ColorLayer {
    /// Index of the part.
    pub(super) part: usize,
    /// Up to the last dot and with it; empty for `R`, `G`, `B`.
    pub(super) prefix: String,
}

impl ColorLayer {
    /// The layer of the finished image among the parts of a file: that without a name or called as such, else the first with
    /// the channels R, G and B, or else Y.
    ///
    /// # Errors
    /// Which channels there are, when none are colours.
    pub(super) fn find(headers: &[Header]) -> Result<Self, String> {
        let layers = headers.iter().enumerate().flat_map(|(part, header)| {
            let layers = prefixes(header).into_iter().map(move |prefix| (part, prefix));
            layers.filter(move |(_, prefix)| {
                let is_matte = layer_name(headers, part, prefix).is_some_and(|name| is_cryptomatte(&name));
                has_colors(header, prefix) && !is_matte
            })
        });
        let best = layers.min_by_key(|(part, prefix)| rank(headers, *part, prefix));
        best.map(|(part, prefix)| Self { part, prefix: prefix.to_owned() }).ok_or_else(|| {
            let names = headers.iter().flat_map(|header| &header.channels.list);
            let names: Vec<_> = names.map(|channel| channel.name.to_string()).collect();
            format!("has the channels {}, but R, G, B or Y are needed", names.join(", "))
        })
    }

    /// Whether a channel of the part is this component of the layer, in either case.
    pub(super) fn has(&self, channel: &Text, component: &str) -> bool {
        is_component(channel, &self.prefix, component)
    }
}

/// Distinct beginnings of the names of channels, in their order.
fn prefixes(header: &Header) -> Vec<&str> {
    let mut found = Vec::new();
    for channel in &header.channels.list {
        let Ok(name) = std::str::from_utf8(channel.name.as_slice()) else { continue };
        let prefix = &name[..name.rfind('.').map_or(0, |dot| dot + 1)];
        if !found.contains(&prefix) {
            found.push(prefix);
        }
    }
    found
}

fn is_component(channel: &Text, prefix: &str, component: &str) -> bool {
    let rest = channel.as_slice().strip_prefix(prefix.as_bytes());
    rest.is_some_and(|rest| rest.eq_ignore_ascii_case(component.as_bytes()))
}

fn has(header: &Header, prefix: &str, component: &str) -> bool {
    header.channels.list.iter().any(|channel| is_component(&channel.name, prefix, component))
}

/// Whether there are R, G and B, or Y in place of those that are missing.
fn has_colors(header: &Header, prefix: &str) -> bool {
    has(header, prefix, "Y") || has_red_green_blue(header, prefix)
}

fn has_red_green_blue(header: &Header, prefix: &str) -> bool {
    ["R", "G", "B"].iter().all(|component| has(header, prefix, component))
}

/// The name of a layer, or that of its part; `None` for the plain channels of the only part.
fn layer_name(headers: &[Header], part: usize, prefix: &str) -> Option<String> {
    if let Some(layer) = prefix.strip_suffix('.') {
        return Some(layer.to_owned());
    }
    let name = headers[part].own_attributes.layer_name.as_ref().filter(|_| headers.len() > 1);
    name.map(ToString::to_string).filter(|name| !name.is_empty())
}

/// The order in which layers are preferred, the first of equals.
fn rank(headers: &[Header], part: usize, prefix: &str) -> [bool; 3] {
    let header = &headers[part];
    let is_vector = has(header, prefix, "X");
    let is_finished = layer_name(headers, part, prefix).is_none_or(|name| is_finished_image(&name));
    [is_vector, !is_finished, !has_red_green_blue(header, prefix)]
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
        LayerAttributes, WritableImage as _,
    };

    use crate::error::Result;
    use crate::image_file::{decode_exr_rgba, read_environment, read_plate};

    /// A file of 2x1 pixels with these parts, by name, and their channels. Every value of a channel is its number in the file.
    fn file(parts: &[(&str, &[&str])]) -> Vec<u8> {
        let mut number = 0_u8;
        let layers = parts.iter().map(|(part, channels)| {
            let channels = channels.iter().map(|name| {
                number += 1;
                AnyChannel::new(*name, FlatSamples::F32(vec![f32::from(number); 2]))
            });
            let channels = AnyChannels::sort(channels.collect());
            let attributes =
                if part.is_empty() { LayerAttributes::default() } else { LayerAttributes::named(*part) };
            Layer::new((2, 1), attributes, Encoding::UNCOMPRESSED, channels)
        });
        let layers = layers.collect::<Vec<_>>();
        let window = IntegerBounds::from_dimensions((2, 1));
        let mut bytes = Cursor::new(Vec::new());
        let image = Image::from_layers(ImageAttributes::new(window), layers);
        image.write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn first_pixel(parts: &[(&str, &[&str])]) -> Result<[f32; 4]> {
        decode_exr_rgba(Path::new("a.exr"), &file(parts), 1 << 20).map(|image| image.pixels[0])
    }

    #[test]
    fn the_finished_image_is_found_among_layers_and_parts() {
        for (parts, expected) in [
            (&[("", &["A", "B", "G", "R"][..])][..], [4.0, 3.0, 2.0, 1.0]),
            (&[("", &["Y"])], [1.0, 1.0, 1.0, 1.0]),
            // Blender: the layers of one part, in the order of the alphabet
            (
                &[(
                    "",
                    &[
                        "ViewLayer.AO.B",
                        "ViewLayer.AO.G",
                        "ViewLayer.AO.R",
                        "ViewLayer.Combined.A",
                        "ViewLayer.Combined.B",
                        "ViewLayer.Combined.G",
                        "ViewLayer.Combined.R",
                        "ViewLayer.Depth.Z",
                    ],
                )],
                [7.0, 6.0, 5.0, 4.0],
            ),
            // A part for each layer
            (&[("depth", &["Z"]), ("rgba", &["B", "G", "R"])], [4.0, 3.0, 2.0, 1.0]),
            (
                &[("ViewLayer.AO", &["B", "G", "R"]), ("ViewLayer.Combined", &["B", "G", "R"])],
                [6.0, 5.0, 4.0, 1.0],
            ),
            // A Cryptomatte holds no colours.
            (&[("crypto_object00", &["B", "G", "R"]), ("light", &["B", "G", "R"])], [6.0, 5.0, 4.0, 1.0]),
            // Views behind the names of layers
            (&[("AO.left", &["B", "G", "R"]), ("Combined.left", &["B", "G", "R"])], [6.0, 5.0, 4.0, 1.0]),
            // A flat vector, and grey beside colours
            (&[("", &["motion.X", "motion.Y", "render.B", "render.G", "render.R"])], [5.0, 4.0, 3.0, 1.0]),
            (&[("", &["fog.Y", "render.B", "render.G", "render.R"])], [4.0, 3.0, 2.0, 1.0]),
            // No name that is known: the first colours
            (&[("normal", &["X", "Y", "Z"]), ("light", &["B", "G", "R"])], [6.0, 5.0, 4.0, 1.0]),
            (&[("", &["key.B", "key.G", "key.R", "rim.B", "rim.G", "rim.R"])], [3.0, 2.0, 1.0, 1.0]),
            // Plain channels before layers
            (&[("", &["B", "Combined.B", "Combined.G", "Combined.R", "G", "R"])], [6.0, 5.0, 1.0, 1.0]),
        ] {
            assert_eq!(first_pixel(parts).unwrap(), expected, "{parts:?}");
        }
    }

    #[test]
    fn environments_and_plates_take_the_same_layer() {
        let bytes = file(&[("depth", &["Z"]), ("sky.Combined", &["B", "G", "R"])]);
        let environment = read_environment(Path::new("a.exr"), &bytes, 1 << 20).unwrap();
        assert_eq!(environment.pixels, [[4.0, 3.0, 2.0]; 2]);
        let plate = read_plate(Path::new("a.exr"), &bytes, 1 << 20).unwrap();
        assert_eq!(plate.image.pixels, [[4.0, 3.0, 2.0, 1.0]; 2]);
    }

    #[test]
    fn files_without_colours_tell_their_channels() {
        let error = first_pixel(&[("depth", &["Z"]), ("id", &["R", "G"])]).unwrap_err();
        assert_eq!(error.exit_code(), 65);
        let said = error.to_string();
        assert!(said.contains("has the channels Z, G, R, but R, G, B or Y are needed"), "{said}");
    }
}
