//! The header of an OpenEXR file as it stands on disk: attributes by name, compared byte for byte.
//!
//! Source: the OpenEXR project, "OpenEXR File Layout". Files of one part of flat scan lines alone; pixels are not read.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read as _};
use std::path::Path;

use super::exr_attributes::{RENDER_HASH, STAMPS};
use crate::error::Error;

/// What a file begins with.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Bit of the version for long names, which changes nothing here; no other bit is set for one part of flat scan lines.
const LONG_NAMES: u32 = 0x400;
/// Longest name of an attribute or its type, bytes.
const LONGEST_NAME: usize = 255;
/// Most bytes of a header, which manifests of Cryptomattes stay far below.
const MOST_BYTES: usize = 1 << 28;
/// What tells how pixels are laid out in the file, not what they are.
const LAYOUT: [&str; 4] = ["dataWindow", "lineOrder", "chunkCount", "type"];

/// How the samples of a channel are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExrSampleType {
    /// Unsigned whole numbers of 32 bits.
    Uint,
    /// Floating point numbers of 16 bits.
    Half,
    /// Floating point numbers of 32 bits.
    Float,
}

/// Pixels from (x0, y0) up to but not including (x1, y1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the type says what they are")]
pub struct ExrWindow {
    pub x0: i64,
    pub y0: i64,
    pub x1: i64,
    pub y1: i64,
}

/// The header of a file of one part of flat scan lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrHeader {
    /// The whole picture.
    pub display_window: ExrWindow,
    /// The part of it that the file holds.
    pub data_window: ExrWindow,
    /// Names and types of the channels, in the file's order.
    pub channels: Vec<(String, ExrSampleType)>,
    /// Number of the compression in OpenEXR's list.
    compression: u8,
    /// Type and value of every attribute, the type with its closing zero.
    attributes: BTreeMap<String, Vec<u8>>,
}

/// What two files must have in common for being parts of one picture.
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
            return Err(Error::invalid(path, "", "is not a file with a picture"));
        }
        let file = File::open(path).map_err(missing)?;
        Self::parse(&mut BufReader::new(file)).map_err(|why| Error::invalid(path, "", why))
    }

    /// Reads the header at the beginning of `reader`.
    ///
    /// # Errors
    /// One line that says what it is instead.
    pub fn parse(reader: &mut impl BufRead) -> Result<Self, String> {
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

    /// What the parts of one picture have in common: all attributes but the place of the part, and when and where it was made.
    pub fn shared(&self) -> SharedAttributes<'_> {
        let shared = |name: &str| !LAYOUT.contains(&name) && !STAMPS.contains(&name);
        let attributes = self.attributes.iter().filter(|(name, _)| shared(name));
        attributes.map(|(name, value)| (name.as_str(), value.as_slice())).collect()
    }

    /// The attribute that says from what the picture was made.
    pub fn render_hash(&self) -> Option<String> {
        let value = self.attributes.get(RENDER_HASH)?.strip_prefix(b"string\0")?;
        Some(String::from_utf8_lossy(value).into_owned())
    }

    /// The attribute that holds the frame number.
    pub fn frame(&self) -> Option<i64> {
        let value = self.attributes.get("frame")?.strip_prefix(b"int\0")?;
        Some(i64::from(i32::from_le_bytes(value.try_into().ok()?)))
    }

    /// Such as `zip`.
    pub fn compression_name(&self) -> &'static str {
        const NAMES: [&str; 10] =
            ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"];
        NAMES.get(usize::from(self.compression)).copied().unwrap_or("an unknown compression")
    }

    /// Whether packing changed samples, so that packing them again would change them again.
    pub fn is_lossy(&self) -> bool {
        let holds = |wanted| self.channels.iter().any(|&(_, kind)| kind == wanted);
        match self.compression_name() {
            "none" | "rle" | "zips" | "zip" | "piz" => false,
            "pxr24" => holds(ExrSampleType::Float),
            "b44" | "b44a" => holds(ExrSampleType::Half),
            _ => true,
        }
    }

    /// Bytes of a pixel in memory.
    pub fn pixel_bytes(&self) -> u64 {
        let bytes = |&(_, kind): &(String, ExrSampleType)| if kind == ExrSampleType::Half { 2 } else { 4 };
        self.channels.iter().map(bytes).sum()
    }
}

impl ExrWindow {
    /// Columns and rows.
    pub fn size(self) -> (u64, u64) {
        ((self.x1 - self.x0) as u64, (self.y1 - self.y0) as u64)
    }
}

fn read_attributes(reader: &mut impl BufRead) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let unreadable = |error: io::Error| match error.kind() {
        io::ErrorKind::UnexpectedEof => "not a readable OpenEXR file: its header is cut short".to_owned(),
        _ => format!("not a readable OpenEXR file: {error}"),
    };
    let mut start = [0; 8];
    reader.read_exact(&mut start).map_err(unreadable)?;
    let [m0, m1, m2, m3, v0, v1, v2, v3] = start;
    if [m0, m1, m2, m3] != MAGIC {
        return Err("not an OpenEXR file".to_owned());
    }
    if u32::from_le_bytes([v0, v1, v2, v3]) & !LONG_NAMES != 2 {
        return Err(
            "has tiles of its own, several parts or deep pixels; one part of scan lines is needed".to_owned()
        );
    }
    let mut attributes = BTreeMap::new();
    let mut left = MOST_BYTES;
    loop {
        let name = read_text(reader).map_err(unreadable)?;
        if name.is_empty() {
            return Ok(attributes);
        }
        let mut value = read_text(reader).map_err(unreadable)?.into_bytes();
        value.push(0);
        let mut size = [0; 4];
        reader.read_exact(&mut size).map_err(unreadable)?;
        let size = u32::from_le_bytes(size) as usize;
        left = left.checked_sub(size).ok_or("not a readable OpenEXR file: its header is too long")?;
        // Grows with what is there, not with what the size says.
        let read = reader.take(size as u64).read_to_end(&mut value).map_err(unreadable)?;
        if read < size {
            return Err(unreadable(io::ErrorKind::UnexpectedEof.into()));
        }
        // Readers differ in which of two they believe.
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

/// Four corners, the last of them inclusive.
fn window(value: &[u8]) -> Result<ExrWindow, String> {
    let number = |at: usize| value.get(at..at + 4)?.try_into().ok().map(i32::from_le_bytes).map(i64::from);
    let (Some(x0), Some(y0), Some(x1), Some(y1)) = (number(0), number(4), number(8), number(12)) else {
        return Err("not a readable OpenEXR file: a window is cut short".to_owned());
    };
    if x1 < x0 || y1 < y0 {
        return Err("not a readable OpenEXR file: a window is empty".to_owned());
    }
    Ok(ExrWindow { x0, y0, x1: x1 + 1, y1: y1 + 1 })
}

/// For each channel its name, zero, type, four bytes about its perception, and the distances of its samples.
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
    use crate::image_file::{
        ExrChannel, ExrCompression, ExrPicture, ExrSamples, FrameAttributes, RunStamp, encode_exr_picture,
    };

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

    fn picture(origin: (u32, u32), compression: ExrCompression) -> ExrPicture {
        let channel = |name: &str, samples| ExrChannel { name: name.to_owned(), samples };
        ExrPicture {
            picture_size: (100, 90),
            origin,
            size: (4, 3),
            channels: vec![
                channel("R", ExrSamples::Half(vec![half::f16::ONE; 12])),
                channel("Z", ExrSamples::Float(vec![1.0; 12])),
                channel("id", ExrSamples::Uint(vec![7; 12])),
            ],
            compression,
        }
    }

    fn header(origin: (u32, u32), stamp: Option<RunStamp>) -> ExrHeader {
        let bytes = encode_exr_picture(picture(origin, ExrCompression::Piz), &attributes(stamp)).unwrap();
        ExrHeader::parse(&mut bytes.as_slice()).unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let header = header((3, 5), None);
        assert_eq!(header.display_window, ExrWindow { x0: 0, y0: 0, x1: 100, y1: 90 });
        assert_eq!(header.data_window, ExrWindow { x0: 3, y0: 5, x1: 7, y1: 8 });
        let names: Vec<_> = header.channels.iter().map(|(name, kind)| (name.as_str(), *kind)).collect();
        let expected = [("R", ExrSampleType::Half), ("Z", ExrSampleType::Float), ("id", ExrSampleType::Uint)];
        assert_eq!(names, expected);
        assert_eq!((header.frame(), header.render_hash().as_deref()), (Some(-3), Some("00ff")));
        // A half, a float and a whole number.
        assert_eq!((header.compression_name(), header.pixel_bytes()), ("piz", 2 + 4 + 4));
    }

    #[test]
    fn parts_of_a_picture_share_all_but_their_place_and_their_stamp() {
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
    fn packing_that_loses_is_known() {
        for compression in ExrCompression::ALL {
            let bytes = encode_exr_picture(picture((0, 0), compression), &attributes(None)).unwrap();
            let header = ExrHeader::parse(&mut bytes.as_slice()).unwrap();
            assert_eq!(header.compression_name(), compression.name());
            assert_eq!(header.is_lossy(), compression.is_lossy());
        }
    }

    #[test]
    fn headers_that_are_cut_short_or_lie_are_refused() {
        let bytes = encode_exr_picture(picture((0, 0), ExrCompression::Zip), &attributes(None)).unwrap();
        // The header ends before the table of offsets and one block: at most 300 bytes of the end.
        for length in 0..bytes.len() - 300 {
            assert!(ExrHeader::parse(&mut &bytes[..length]).is_err(), "{length}");
        }
        let mut several_parts = bytes.clone();
        several_parts[5] |= 0x10;
        assert!(ExrHeader::parse(&mut several_parts.as_slice()).unwrap_err().contains("several parts"));
        // The first attribute says that it holds four gigabytes.
        let mut lying = bytes[..8].to_vec();
        lying.extend_from_slice(b"a\0string\0\xff\xff\xff\xff");
        assert!(ExrHeader::parse(&mut lying.as_slice()).unwrap_err().contains("too long"));
        // The first attribute stands there twice.
        let first = b"a\0int\0\x04\0\0\0\x01\0\0\0";
        let twice = [&bytes[..8], first, first, &bytes[8..]].concat();
        assert!(ExrHeader::parse(&mut twice.as_slice()).unwrap_err().contains("two attributes"));
        let once = [&bytes[..8], first, &bytes[8..]].concat();
        assert!(ExrHeader::parse(&mut once.as_slice()).is_ok());
    }
}
