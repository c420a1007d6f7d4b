//! Pictures as files: which kinds are read, and the one that is written.

use std::path::Path;

use super::{BEAUTY, ChannelValues, LayeredPicture, NamedChannel, ValueRange, layer_of};
use crate::error::{Error, Result};
use crate::image_file::{
    ExrChannel, ExrCompression, ExrPicture, ExrSamples, FrameAttributes, decode_exr_channels,
    decode_png_values, encode_exr_picture, half_from_f32, read_environment, write_atomically,
};

/// Bytes that a decoded picture may take.
const MAX_MEMORY_BYTES: u64 = 4 << 30;

impl LayeredPicture {
    /// Reads an OpenEXR, PNG or Radiance file; which it is is told by its first bytes.
    ///
    /// # Errors
    /// [`Error::Missing`] when it cannot be read, [`Error::Invalid`] when it is none of these or damaged,
    /// [`Error::Refused`] when it would take too much memory.
    pub fn read(path: &Path) -> Result<Self> {
        Self::decode(path, &std::fs::read(path).map_err(Error::missing(path))?)
    }

    /// The picture in the bytes of the file `path`, which is named in errors.
    ///
    /// # Errors
    /// Those of [`LayeredPicture::read`], but for reading.
    pub fn decode(path: &Path, bytes: &[u8]) -> Result<Self> {
        if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            return from_exr(path, bytes);
        }
        if bytes.starts_with(b"\x89PNG") {
            let picture = decode_png_values(path, bytes, MAX_MEMORY_BYTES)?;
            return Ok(Self::of_pixels(picture.size, ValueRange::Display, &picture.pixels));
        }
        if bytes.starts_with(b"#?") {
            let picture = read_environment(path, bytes, MAX_MEMORY_BYTES)?;
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

    /// Writes an OpenEXR file of the picture in light: colours as halves, ids as whole numbers, all else as floats. Folders are
    /// created.
    ///
    /// The file says nothing of when, where and from what it was made, so that it changes only when its values do.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] or [`Error::WriteFailed`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let light = self.clone().in_light();
        let channels = light.channels.into_iter().map(exr_channel).collect();
        let (picture_size, origin, size) = (light.picture_size, light.origin, light.size);
        let compression = ExrCompression::Zip;
        let picture = ExrPicture { picture_size, origin, size, channels, compression };
        let bytes = encode_exr_picture(picture, &FrameAttributes::unknown())?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| Error::CannotCreate {
                path: folder.to_owned(),
                message: error.to_string(),
            })?;
        }
        write_atomically(path, &bytes)
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

fn exr_channel(channel: NamedChannel) -> ExrChannel {
    let is_color = layer_of(&channel.name) == BEAUTY;
    // What is not finite stays so.
    let half = |value: f32| if value.is_finite() { half_from_f32(value) } else { half::f16::from_f32(value) };
    let samples = match channel.values {
        ChannelValues::Numbers(values) if is_color => {
            ExrSamples::Half(values.into_iter().map(half).collect())
        }
        ChannelValues::Numbers(values) => ExrSamples::Float(values),
        ChannelValues::Ids(values) => ExrSamples::Uint(values),
    };
    ExrChannel { name: channel.name, samples }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        std::fs::write(&path, encode_exr_picture(picture, &FrameAttributes::unknown()).unwrap()).unwrap();
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
    fn what_is_written_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("below/a.exr");
        let pixels = [[0.5, 0.25, f32::INFINITY, 1.0], [2.0, 65504.0, 0.0, 0.5]];
        let mut picture = LayeredPicture::of_pixels((1, 2), ValueRange::Light, &pixels);
        (picture.picture_size, picture.origin) = ((4, 3), (2, 1));
        // A float that no half holds, and an id.
        let depth = ChannelValues::Numbers(vec![0.1, f32::INFINITY]);
        picture.channels.push(NamedChannel { name: "Z".to_owned(), values: depth });
        let ids = ChannelValues::Ids(vec![7, u32::MAX]);
        picture.channels.push(NamedChannel { name: "node_id".to_owned(), values: ids });
        picture.write(&path).unwrap();
        assert_eq!(LayeredPicture::read(&path).unwrap(), picture);
        // The value of a display: 0.5 is 0.2140 of light.
        let display = LayeredPicture::of_pixels((1, 1), ValueRange::Display, &[[0.5, 0.5, 0.5, 0.5]]);
        display.write(&path).unwrap();
        let [[red, .., alpha]] = LayeredPicture::read(&path).unwrap().rgba().unwrap()[..] else { panic!() };
        assert!((red - 0.2140 * 0.5).abs() < 1e-4 && alpha == 0.5, "{red} {alpha}");
    }
}
