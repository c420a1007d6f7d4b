//! Images from files of any supported format, and to EXR files of values alone.

use std::path::Path;

use half::f16;

use super::display::refuse_animated_png;
use super::exr_color_names::unify_colors;
use super::exr_read::decode_exr_with_overscan;
use super::regular_file::{check_fetched, read_regular_file};
use super::{
    ExrCompression, FrameAttributes, decode_png_values, encode_exr, read_environment, write_atomically,
};
use crate::error::{Error, Result};
use crate::image::{BEAUTY, Channel, ColorEncoding, Image, Samples, half_from_f32, layer_of};

/// Most memory that a decoded image may take.
const MAX_MEMORY_BYTES: u64 = 4 << 30;

impl Image {
    /// Reads an OpenEXR, PNG or Radiance file. Its first bytes tell the format. Channels are sorted by name, and halves are
    /// widened to floats. There is alpha (A) where the file has it.
    ///
    /// # Errors
    /// [`Error::Missing`] when the file cannot be read, [`Error::Invalid`] when it is damaged or of another format,
    /// [`Error::Refused`] when it would take too much memory.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_within(path, MAX_MEMORY_BYTES)
    }

    /// Reads an image as [`Image::read`] does, in `max_memory_bytes`.
    ///
    /// # Errors
    /// Those of [`Image::read`].
    pub fn read_within(path: &Path, max_memory_bytes: u64) -> Result<Self> {
        refuse_animated_png(path)?;
        Self::decode_within(path, &read_regular_file(path, max_memory_bytes)?, max_memory_bytes)
    }

    /// Decodes `bytes` as [`Image::read`] does; errors name `path`.
    ///
    /// # Errors
    /// [`Error::Invalid`] and [`Error::Refused`] as of [`Image::read`].
    pub fn decode(path: &Path, bytes: &[u8]) -> Result<Self> {
        Self::decode_within(path, bytes, MAX_MEMORY_BYTES)
    }

    fn decode_within(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<Self> {
        if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            return from_exr(path, bytes, max_memory_bytes);
        }
        if bytes.starts_with(b"\x89PNG") {
            return decode_png_values(path, bytes, max_memory_bytes);
        }
        if bytes.starts_with(b"#?") {
            let image = read_environment(path, bytes, max_memory_bytes)?;
            let pixels: Vec<_> = image.pixels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
            let size = (image.width, image.height);
            return Ok(Self::from_rgba(size, ColorEncoding::Linear, &pixels).without_alpha());
        }
        check_fetched(path, "", bytes)?;
        Err(Error::invalid(path, "", "is neither an OpenEXR, a PNG nor a Radiance .hdr file"))
    }

    /// Writes an OpenEXR file of scene-linear light: colours as halves, ids as integers, everything else as floats. Creates
    /// missing folders.
    ///
    /// The file has no attributes that depend on time, place or settings, so that it changes only when its values do.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] or [`Error::WriteFailed`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut image = self.clone().into_linear();
        image.channels = image.channels.into_iter().map(stored_channel).collect();
        let bytes = encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown())?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| Error::CannotCreate {
                path: folder.to_owned(),
                message: error.to_string(),
            })?;
        }
        write_atomically(path, &bytes)
    }
}

fn from_exr(path: &Path, bytes: &[u8], max_memory_bytes: u64) -> Result<Image> {
    let mut image = decode_exr_with_overscan(path, bytes, max_memory_bytes)?;
    for channel in &mut image.channels {
        let samples = std::mem::replace(&mut channel.samples, Samples::Uint(Vec::new()));
        channel.samples = samples.widened();
    }
    unify_colors(&mut image.channels);
    image.channels.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(image)
}

/// The channel with colours as halves. Values that are not finite stay so.
fn stored_channel(channel: Channel) -> Channel {
    let is_color = layer_of(&channel.name) == BEAUTY;
    let half = |value: f32| if value.is_finite() { half_from_f32(value) } else { f16::from_f32(value) };
    let samples = match channel.samples {
        Samples::Float(values) if is_color => Samples::Half(values.into_iter().map(half).collect()),
        samples => samples.widened(),
    };
    Channel { name: channel.name, samples }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{PixelWindow, RenderedScene};

    const WINDOW: PixelWindow = PixelWindow { x0: 3, y0: 1, x1: 5, y1: 2 };

    #[test]
    fn files_beyond_the_limit_are_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        Image::from_rgba((8, 8), ColorEncoding::Linear, &[[0.5; 4]; 64]).write(&path).unwrap();
        assert!(Image::read_within(&path, 3_000_000).is_ok());
        // A hole behind the image.
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(4_000_000).unwrap();
        let error = Image::read_within(&path, 3_000_000).unwrap_err();
        let message = "the file has 4.0 MB, more than the limit of 3.0 MB; raise `max_memory`";
        assert!(error.exit_code() == 77 && error.to_string().ends_with(message), "{error}");
    }

    #[test]
    fn files_without_alpha_have_no_channel_for_it() {
        let names = |bytes: &[u8]| -> Vec<String> {
            let image = Image::decode(Path::new("a"), bytes).unwrap();
            image.channels.into_iter().map(|channel| channel.name).collect()
        };
        let png = |image: image::DynamicImage| {
            let mut bytes = std::io::Cursor::new(Vec::new());
            image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
            names(bytes.get_ref())
        };
        assert_eq!(png(image::DynamicImage::new_rgb8(2, 1)), ["B", "G", "R"]);
        assert_eq!(png(image::DynamicImage::new_luma16(2, 1)), ["B", "G", "R"]);
        assert_eq!(png(image::DynamicImage::new_rgba8(2, 1)), ["A", "B", "G", "R"]);
        let radiance = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80";
        assert_eq!(names(radiance), ["B", "G", "R"]);
    }

    #[test]
    fn damaged_windows_cost_no_memory() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        Image::from_rgba((8, 8), ColorEncoding::Linear, &[[0.5; 4]; 64]).write(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
            let start = bytes.windows(name.len()).position(|found| found == name).unwrap() + name.len();
            // After the length of the value and the two lower bounds.
            bytes[start + 12..start + 16].copy_from_slice(&4999_u32.to_le_bytes());
            bytes[start + 16..start + 20].copy_from_slice(&4999_u32.to_le_bytes());
        }
        let name = b"chunkCount\0int\0";
        let start = bytes.windows(name.len()).position(|found| found == name).unwrap() + name.len();
        bytes[start + 4..start + 8].copy_from_slice(&313_u32.to_le_bytes());
        let error = Image::decode(&path, &bytes).unwrap_err();
        assert_eq!(error.exit_code(), 65);
        assert!(error.to_string().contains("too short for the pixels"), "{error}");
    }

    #[test]
    fn channels_of_all_types_are_read_with_their_window() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let half = f16::from_f32;
        let image = Image {
            display_window: PixelWindow::full(6, 5),
            data_window: WINDOW,
            encoding: ColorEncoding::Linear,
            scene: RenderedScene::default(),
            channels: vec![
                Channel { name: "object_id".into(), samples: Samples::Uint(vec![7, u32::MAX]) },
                Channel { name: "R".into(), samples: Samples::Half(vec![half(0.5), half(f32::NAN)]) },
                Channel { name: "Z".into(), samples: Samples::Float(vec![1.5, f32::INFINITY]) },
            ],
        };
        let bytes = encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let back = Image::read(&path).unwrap();
        assert_eq!((back.display_window, back.data_window), (PixelWindow::full(6, 5), WINDOW));
        assert_eq!(back.layers(), [BEAUTY, "depth", "object_id"]);
        assert_eq!(back.channels[1].samples, Samples::Float(vec![1.5, f32::INFINITY]));
        assert_eq!(back.channels[2].samples, Samples::Uint(vec![7, u32::MAX]));
        assert!(back.colors().is_none());
        std::fs::write(&path, "hello").unwrap();
        assert_eq!(Image::read(&path).unwrap_err().exit_code(), 65);
    }

    #[test]
    fn a_written_image_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("below/a.exr");
        let pixels = [[0.5, 0.25, f32::INFINITY, 1.0], [2.0, 65504.0, 0.0, 0.5]];
        let mut image = Image::from_rgba((2, 1), ColorEncoding::Linear, &pixels);
        (image.display_window, image.data_window) = (PixelWindow::full(6, 3), WINDOW);
        // A float that no half holds, and an id.
        let depth = Samples::Float(vec![0.1, f32::INFINITY]);
        image.channels.push(Channel { name: "Z".to_owned(), samples: depth });
        let ids = Samples::Uint(vec![7, u32::MAX]);
        image.channels.push(Channel { name: "node_id".to_owned(), samples: ids });
        image.write(&path).unwrap();
        assert_eq!(Image::read(&path).unwrap(), image);
        // The sRGB value 0.5 is 0.2140 of linear light.
        let display = Image::from_rgba((1, 1), ColorEncoding::Srgb, &[[0.5, 0.5, 0.5, 0.5]]);
        display.write(&path).unwrap();
        let [[red, .., alpha]] = Image::read(&path).unwrap().rgba().unwrap()[..] else { panic!() };
        assert!((red - 0.2140 * 0.5).abs() < 1e-4 && alpha == 0.5, "{red} {alpha}");
    }
}
