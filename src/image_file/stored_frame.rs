//! Inspection of a frame's EXR file: whether it is complete, and what it was rendered from.

use std::fs::File;
use std::io::{self, BufReader, Seek as _};
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::Header;

use super::exr_attributes::{RENDER_HASH, SAMPLE_RANGE};
use super::exr_checksum::{ExrIntegrity, verify_exr};
use super::exr_chunks::check_chunks;
use super::exr_header::SavingProgram;
use super::isolated::isolated;
use crate::image::PixelWindow;

/// Facts about a complete frame on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredFrame {
    /// Hash of the scene, the settings and the version that it was rendered from; `None` in files of other programs.
    pub render_hash: Option<String>,
    /// Hash of the frame and the tone mapping that a preview shows; `None` in other files.
    pub preview_hash: Option<String>,
    /// Columns and rows of the whole image.
    pub size: (u32, u32),
    /// The samples that the file holds, where these are not all: `0-63/256`.
    pub sample_range: Option<String>,
    /// The pixels that the file holds, relative to the whole image.
    pub data_window: PixelWindow<i64>,
}

/// Inspects the EXR file at `path`, whose bytes must match its checksum. Pixels are not decoded. Files of other programs have no
/// checksum, nor a `render_hash`.
///
/// # Errors
/// One line that says what is missing or wrong.
pub fn inspect_exr(path: &Path) -> Result<StoredFrame, String> {
    let text = |error: io::Error| error.to_string();
    let mut file = BufReader::new(File::open(path).map_err(text)?);
    let integrity = verify_exr(&mut file).map_err(text)?;
    if integrity == ExrIntegrity::Damaged {
        return Err(match saved_by(path) {
            None => "its bytes do not match its checksum".to_owned(),
            Some(program) => format!("{program} has saved it since it was rendered"),
        });
    }
    check_chunks(&mut file)?;
    file.rewind().map_err(text)?;
    let stored = isolated(|| inspect(file))?;
    match &stored.render_hash {
        Some(_) if integrity == ExrIntegrity::NoChecksum => match saved_by(path) {
            // It has copied the hash and not the checksum.
            Some(_) => Ok(StoredFrame { render_hash: None, ..stored }),
            None => Err("it has no checksum".to_owned()),
        },
        _ => Ok(stored),
    }
}

/// The other program that has saved an EXR file of this one, by the attribute `software`. Such programs copy the checksum, too. A name in
/// which bits have changed is no other program's. Tiles are another program's, whatever the name.
pub fn saved_by(path: &Path) -> Option<String> {
    const OWN: &[u8] = b"rayframe";
    let SavingProgram { software, is_tiled } = SavingProgram::of(path)?;
    let unnamed = || is_tiled.then(|| "another program".to_owned());
    let Some(software) = software else { return unnamed() };
    let same = software.bytes().zip(OWN).filter(|(letter, own)| letter == *own).count();
    (same < OWN.len() / 2 && !software.is_empty()).then_some(software).or_else(unnamed)
}

fn inspect(file: BufReader<File>) -> Result<StoredFrame, String> {
    let reader = exr::block::read(file, true).map_err(|error| error.to_string())?;
    Ok(stored_frame(reader.headers().first().ok_or("the file holds no image")?))
}

fn stored_frame(header: &Header) -> StoredFrame {
    let display = header.shared_attributes.display_window;
    let position = header.own_attributes.layer_position;
    let hash = header.own_attributes.other.get(&Text::from(RENDER_HASH));
    let x0 = i64::from(position.0) - i64::from(display.position.0);
    let y0 = i64::from(position.1) - i64::from(display.position.1);
    let (width, height) = (header.layer_size.0 as i64, header.layer_size.1 as i64);
    StoredFrame {
        render_hash: hash.and_then(text),
        preview_hash: None,
        sample_range: header.own_attributes.other.get(&Text::from(SAMPLE_RANGE)).and_then(text),
        size: (display.size.0 as u32, display.size.1 as u32),
        data_window: PixelWindow { x0, y0, x1: x0 + width, y1: y0 + height },
    }
}

fn text(value: &AttributeValue) -> Option<String> {
    match value {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}
