//! Headers of OpenEXR files with one part of flat scan lines. Attributes are kept as bytes and compared by them.
//!
//! Source: the OpenEXR project, "OpenEXR File Layout". Pixels are not read.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read as _};
use std::path::Path;

use super::exr_attributes::{RENDER_HASH, SAMPLE_RANGE, STAMPS};
use super::exr_checksum::CHECKSUM;
use crate::error::Error;
use crate::image::PixelWindow;

/// First bytes of every OpenEXR file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Version bit of long names, which are read anyway. Files of one part of flat scan lines have no other bit set.
const LONG_NAMES: u32 = 0x400;
/// Version bit of one part of tiles.
const TILED: u32 = 0x200;
/// Longest name of an attribute or its type, bytes.
const LONGEST_NAME: usize = 255;
/// Most bytes of a header. Cryptomatte manifests stay far below.
const MOST_BYTES: usize = 1 << 28;
/// Beginning of the names of the channels of exact sums.
pub const SUM_LAYER: &str = "sums.";
/// Attributes of the layout of the file and of its samples, which differ between tiles of one image.
const LAYOUT: [&str; 6] = ["dataWindow", "lineOrder", "chunkCount", "type", SAMPLE_RANGE, CHECKSUM];

/// Type of the samples of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExrSampleType {
    /// 32-bit unsigned integers.
    Uint,
    /// 16-bit floating point.
    Half,
    /// 32-bit floating point.
    Float,
}

/// Header of a file with one part of flat scan lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrHeader {
    /// The whole image.
    pub display_window: PixelWindow<i64>,
    /// The pixels that the file holds.
    pub data_window: PixelWindow<i64>,
    /// Names and types of the channels, in the file's order.
    pub channels: Vec<(String, ExrSampleType)>,
    /// Index of the compression in OpenEXR's list.
    compression: u8,
    pub(super) attributes: Attributes,
}

/// Attributes, by name, that all tiles of one image share.
pub type SharedAttributes<'a> = BTreeMap<&'a str, &'a [u8]>;

impl ExrHeader {
    /// Reads the header of the file `path`.
    ///
    /// # Errors
    /// [`Error::Missing`] when it cannot be read, [`Error::Invalid`] when it is not such a file.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let missing = Error::missing(path);
        let metadata = std::fs::metadata(path).map_err(missing)?;
        if !metadata.is_file() {
            return Err(Error::invalid(path, "", "is not a regular file"));
        }
        let file = File::open(path).map_err(missing)?;
        Self::parse(&mut BufReader::new(file)).map_err(|why| Error::invalid(path, "", why))
    }

    /// Reads the header at the beginning of `reader`.
    ///
    /// # Errors
    /// One line that says what is wrong.
    pub fn parse(reader: &mut impl BufRead) -> Result<Self, String> {
        if read_version(reader)? & !LONG_NAMES != 2 {
            return Err(
                "is tiled, has several parts or deep pixels; one part of scan lines is needed".to_owned()
            );
        }
        let attributes = read_attributes(reader)?;
        let value = |name: &str, kind: &str| {
            let value = attributes.get(name).and_then(|value| value.strip_prefix(kind.as_bytes()));
            let value = value.and_then(|value| value.strip_prefix(b"\0"));
            value.ok_or_else(|| format!("not a readable OpenEXR file: the attribute {name} is missing"))
        };
        Ok(Self {
            display_window: window(value("displayWindow", "box2i")?)?,
            data_window: window(value("dataWindow", "box2i")?)?,
            channels: channels(value("channels", "chlist")?)?,
            compression: *value("compression", "compression")?.first().ok_or("it has no compression")?,
            attributes,
        })
    }

    /// The attributes that all tiles of one image share: all but the layout of the file and the stamp of the run.
    pub fn shared(&self) -> SharedAttributes<'_> {
        let shared = |name: &str| !LAYOUT.contains(&name) && !STAMPS.contains(&name);
        let attributes = self.attributes.iter().filter(|(name, _)| shared(name));
        attributes.map(|(name, value)| (name.as_str(), value.as_slice())).collect()
    }

    /// Names and types of the channels but for those of sums, in the file's order.
    pub fn channels_without_sums(&self) -> impl Iterator<Item = &(String, ExrSampleType)> {
        self.channels.iter().filter(|(name, _)| !name.starts_with(SUM_LAYER))
    }

    /// Hash of the scene, the settings and the version that the image was rendered from.
    pub fn render_hash(&self) -> Option<String> {
        self.text(RENDER_HASH)
    }

    /// The text attribute `name`.
    pub fn text(&self, name: &str) -> Option<String> {
        text(&self.attributes, name)
    }

    /// Frame number.
    pub fn frame(&self) -> Option<i64> {
        let value = self.attributes.get("frame")?.strip_prefix(b"int\0")?;
        Some(i64::from(i32::from_le_bytes(value.try_into().ok()?)))
    }

    /// Name of the compression, such as `zip`.
    pub fn compression_name(&self) -> &'static str {
        const NAMES: [&str; 10] =
            ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"];
        NAMES.get(usize::from(self.compression)).copied().unwrap_or("an unknown compression")
    }

    /// Whether compression changed samples, so that compressing them again would change them again.
    pub fn is_lossy(&self) -> bool {
        let holds = |wanted| self.channels.iter().any(|&(_, kind)| kind == wanted);
        match self.compression_name() {
            "none" | "rle" | "zips" | "zip" | "piz" => false,
            "pxr24" => holds(ExrSampleType::Float),
            "b44" | "b44a" => holds(ExrSampleType::Half),
            _ => true,
        }
    }

    /// Bytes of a pixel in memory, over all channels.
    pub fn pixel_bytes(&self) -> u64 {
        let bytes = |&(_, kind): &(String, ExrSampleType)| if kind == ExrSampleType::Half { 2 } else { 4 };
        self.channels.iter().map(bytes).sum()
    }
}

/// Type, a zero byte and value of every attribute, by name.
pub(super) type Attributes = BTreeMap<String, Vec<u8>>;

fn text(attributes: &Attributes, name: &str) -> Option<String> {
    let value = attributes.get(name)?.strip_prefix(b"string\0")?;
    Some(String::from_utf8_lossy(value).into_owned())
}

/// What the header of an OpenEXR file of any layout tells of the program that saved it; of several parts, the first one's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SavingProgram {
    /// The name of the program.
    pub(super) software: Option<String>,
    /// Whether pixels are in tiles, which this program never writes.
    pub(super) is_tiled: bool,
}

impl SavingProgram {
    /// Reads the header of the file `path`; `None` where it is not readable.
    pub(super) fn of(path: &Path) -> Option<Self> {
        if !std::fs::metadata(path).ok()?.is_file() {
            return None;
        }
        let mut reader = BufReader::new(File::open(path).ok()?);
        let version = read_version(&mut reader).ok()?;
        let attributes = read_attributes(&mut reader).ok()?;
        // OpenImageIO has a capital letter.
        let software = ["software", "Software"].into_iter().find_map(|name| text(&attributes, name));
        // The bit alone may be a changed one.
        let has_tiles = attributes.get("tiles").is_some_and(|value| value.starts_with(b"tiledesc\0"));
        Some(Self { software, is_tiled: version & TILED != 0 && has_tiles })
    }
}

fn unreadable(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "not a readable OpenEXR file: its header is cut short".to_owned(),
        _ => format!("not a readable OpenEXR file: {error}"),
    }
}

/// Reads the first bytes. Returns the version, whose upper bits tell the layout.
fn read_version(reader: &mut impl BufRead) -> Result<u32, String> {
    let mut start = [0; 8];
    reader.read_exact(&mut start).map_err(|error| unreadable(&error))?;
    let [m0, m1, m2, m3, v0, v1, v2, v3] = start;
    if [m0, m1, m2, m3] != MAGIC {
        return Err("not an OpenEXR file".to_owned());
    }
    Ok(u32::from_le_bytes([v0, v1, v2, v3]))
}

/// Reads the attributes of a header, behind the version.
fn read_attributes(reader: &mut impl BufRead) -> Result<Attributes, String> {
    let mut attributes = BTreeMap::new();
    let mut left = MOST_BYTES;
    loop {
        let name = read_text(reader).map_err(|error| unreadable(&error))?;
        if name.is_empty() {
            return Ok(attributes);
        }
        let mut value = read_text(reader).map_err(|error| unreadable(&error))?.into_bytes();
        value.push(0);
        let mut size = [0; 4];
        reader.read_exact(&mut size).map_err(|error| unreadable(&error))?;
        let size = u32::from_le_bytes(size) as usize;
        left = left.checked_sub(size).ok_or("not a readable OpenEXR file: its header is too long")?;
        // The buffer grows with the bytes that are there, not with the size that the file claims.
        let read = reader.take(size as u64).read_to_end(&mut value).map_err(|error| unreadable(&error))?;
        if read < size {
            return Err(unreadable(&io::ErrorKind::UnexpectedEof.into()));
        }
        // Readers differ in which of two equal names they take.
        if attributes.contains_key(&name) {
            return Err(format!(
                "not a readable OpenEXR file: two attributes are called \"{}\"",
                name.escape_debug()
            ));
        }
        attributes.insert(name, value);
    }
}

fn read_text(reader: &mut impl BufRead) -> io::Result<String> {
    let mut text = Vec::new();
    reader.take(LONGEST_NAME as u64 + 1).read_until(0, &mut text)?;
    if text.pop() != Some(0) {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// Parses a box: x and y of the first and of the last pixel.
fn window(value: &[u8]) -> Result<PixelWindow<i64>, String> {
    let number = |at: usize| value.get(at..at + 4)?.try_into().ok().map(i32::from_le_bytes).map(i64::from);
    let (Some(x0), Some(y0), Some(x1), Some(y1)) = (number(0), number(4), number(8), number(12)) else {
        return Err("not a readable OpenEXR file: a window is cut short".to_owned());
    };
    if x1 < x0 || y1 < y0 {
        return Err("not a readable OpenEXR file: a window is empty".to_owned());
    }
    Ok(PixelWindow { x0, y0, x1: x1 + 1, y1: y1 + 1 })
}

/// Parses a channel list: name, zero, type, four bytes of hints, and the sampling distances of each channel.
fn channels(mut value: &[u8]) -> Result<Vec<(String, ExrSampleType)>, String> {
    const AFTER_NAME: usize = 16;
    let mut channels = Vec::new();
    while let Some(length) = value.iter().position(|&byte| byte == 0)
        && length > 0
    {
        let name = String::from_utf8_lossy(&value[..length]).into_owned();
        let facts = value.get(length + 1..length + 1 + AFTER_NAME);
        let facts = facts.ok_or("not a readable OpenEXR file: its channels are cut short")?;
        let kind = match facts[..4] {
            [0, 0, 0, 0] => ExrSampleType::Uint,
            [1, 0, 0, 0] => ExrSampleType::Half,
            [2, 0, 0, 0] => ExrSampleType::Float,
            _ => return Err(format!("the channel {name} is of an unknown type")),
        };
        if facts[8..] != [1, 0, 0, 0, 1, 0, 0, 0] {
            return Err(format!("the channel {name} has no sample for some pixels"));
        }
        channels.push((name, kind));
        value = &value[length + 1 + AFTER_NAME..];
    }
    if channels.is_empty() {
        return Err("has no channels".to_owned());
    }
    Ok(channels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Channel, ColorEncoding, Image, RenderedScene, Samples};
    use crate::image_file::{ExrCompression, FrameAttributes, RunStamp, encode_exr};

    fn attributes(stamp: Option<RunStamp>) -> FrameAttributes {
        FrameAttributes {
            software: "rayframe test".to_owned(),
            render_hash: "00ff".to_owned(),
            frame: -3,
            time_seconds: 0.5,
            frames_per_second: (24, 1),
            world_to_camera: [0.5; 16],
            world_to_ndc: [0.25; 16],
            time_code: None,
            texts: Vec::new(),
            stamp,
        }
    }

    fn encoded((x0, y0): (u32, u32), compression: ExrCompression, stamp: Option<RunStamp>) -> Vec<u8> {
        let channel = |name: &str, samples| Channel { name: name.to_owned(), samples };
        let image = Image {
            display_window: PixelWindow::full(100, 90),
            data_window: PixelWindow { x0, y0, x1: x0 + 4, y1: y0 + 3 },
            encoding: ColorEncoding::Linear,
            scene: RenderedScene::default(),
            channels: vec![
                channel("R", Samples::Half(vec![half::f16::ONE; 12])),
                channel("Z", Samples::Float(vec![1.0; 12])),
                channel("id", Samples::Uint(vec![7; 12])),
            ],
        };
        encode_exr(image, compression, &attributes(stamp)).unwrap()
    }

    fn header(origin: (u32, u32), stamp: Option<RunStamp>) -> ExrHeader {
        let bytes = encoded(origin, ExrCompression::Piz, stamp);
        ExrHeader::parse(&mut bytes.as_slice()).unwrap()
    }

    #[test]
    fn a_written_header_is_read_back() {
        let header = header((3, 5), None);
        assert_eq!(header.display_window, PixelWindow { x0: 0, y0: 0, x1: 100, y1: 90 });
        assert_eq!(header.data_window, PixelWindow { x0: 3, y0: 5, x1: 7, y1: 8 });
        let names: Vec<_> = header.channels.iter().map(|(name, kind)| (name.as_str(), *kind)).collect();
        let expected = [("R", ExrSampleType::Half), ("Z", ExrSampleType::Float), ("id", ExrSampleType::Uint)];
        assert_eq!(names, expected);
        assert_eq!((header.frame(), header.render_hash().as_deref()), (Some(-3), Some("00ff")));
        // A half, a float and an integer.
        assert_eq!((header.compression_name(), header.pixel_bytes()), ("piz", 2 + 4 + 4));
    }

    #[test]
    fn tiles_share_all_attributes_but_layout_and_stamp() {
        let stamp = RunStamp {
            capture_date: "2026:11:21 18:57:00".to_owned(),
            host: Some("farm7".to_owned()),
            render_seconds: 1.5,
        };
        let (plain, stamped) = (header((3, 5), None), header((0, 0), Some(stamp)));
        assert_ne!(plain, stamped);
        assert_eq!(plain.shared(), stamped.shared());
        assert!(plain.shared().contains_key("worldToNDC") && plain.shared().contains_key("compression"));
    }

    #[test]
    fn lossy_compression_is_recognised() {
        for compression in ExrCompression::ALL {
            let bytes = encoded((0, 0), compression, None);
            let header = ExrHeader::parse(&mut bytes.as_slice()).unwrap();
            assert_eq!(header.compression_name(), compression.name());
            assert_eq!(header.is_lossy(), compression.is_lossy());
        }
    }

    #[test]
    fn truncated_and_false_headers_are_refused() {
        let bytes = encoded((0, 0), ExrCompression::Zip, None);
        // The header ends before the table of offsets and one block: at most 300 bytes of the end.
        for length in 0..bytes.len() - 300 {
            assert!(ExrHeader::parse(&mut &bytes[..length]).is_err(), "{length}");
        }
        let mut several_parts = bytes.clone();
        several_parts[5] |= 0x10;
        assert!(ExrHeader::parse(&mut several_parts.as_slice()).unwrap_err().contains("several parts"));
        // The first attribute claims to hold four gigabytes.
        let mut oversized = bytes[..8].to_vec();
        oversized.extend_from_slice(b"a\0string\0\xff\xff\xff\xff");
        assert!(ExrHeader::parse(&mut oversized.as_slice()).unwrap_err().contains("too long"));
        // The first attribute occurs twice.
        let first = b"a\0int\0\x04\0\0\0\x01\0\0\0";
        let twice = [&bytes[..8], first, first, &bytes[8..]].concat();
        assert!(ExrHeader::parse(&mut twice.as_slice()).unwrap_err().contains("two attributes"));
        let once = [&bytes[..8], first, &bytes[8..]].concat();
        assert!(ExrHeader::parse(&mut once.as_slice()).is_ok());
    }
}
