//! One OpenEXR file from parts of its picture.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use exr::image::read::read;
use exr::image::{AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::prelude::{Blocks, LineOrder, ReadChannels as _, ReadLayers as _, Vec2};
use rayon::prelude::*;

use super::exr_attributes::STAMPS;
use super::exr_write::{sort_attributes, write_compressing_in_parallel};
use super::{ExrHeader, ExrWindow};
use crate::error::{Error, Result};

/// A file that holds a part of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrTile {
    /// The file.
    pub path: PathBuf,
    /// What it said about itself when it was looked at.
    pub header: ExrHeader,
}

type Part = Image<Layer<AnyChannels<FlatSamples>>>;

/// The file of the whole picture whose parts `tiles` are, packed as they are and with the attributes that they share. Stamps
/// are left out: no one run made the picture.
///
/// The tiles must share all other attributes and fill the picture, each pixel once.
///
/// # Errors
/// [`Error::Missing`] and [`Error::Invalid`] for a tile that cannot be read, or is no longer what its header said;
/// [`Error::Unsupported`] when an attribute cannot be kept; [`Error::Internal`] when there are no tiles.
pub fn join_exr_tiles(tiles: &[ExrTile]) -> Result<Vec<u8>> {
    let parts: Vec<Part> = tiles.par_iter().map(decode_tile).collect::<Result<_>>()?;
    let (Some(first), Some(first_part)) = (tiles.first(), parts.first()) else {
        return Err(Error::Internal { message: "there are no tiles to join".to_owned() });
    };

    // Lay out the picture.
    let window = first.header.display_window;
    let (width, height) = window.size();
    let (width, height) = (width as usize, height as usize);
    let mut channels = first_part.layer_data.channel_data.clone();
    for (index, channel) in channels.list.iter_mut().enumerate() {
        channel.sample_data = empty_like(&channel.sample_data, width * height);
        for (tile, part) in tiles.iter().zip(&parts) {
            let samples = part.layer_data.channel_data.list.get(index).map(|channel| &channel.sample_data);
            let place = Place::new(tile.header.data_window, window, width);
            let is_copied = samples.is_some_and(|samples| copy(samples, &mut channel.sample_data, &place));
            if !is_copied {
                return Err(contradictory(tile, "its pixels are not those that its header tells of"));
            }
        }
    }

    // Pack it as its parts are.
    let mut attributes = first_part.layer_data.attributes.clone();
    attributes.layer_position = Vec2(window.x0 as i32, window.y0 as i32);
    attributes.capture_date = None;
    attributes.utc_offset = None;
    attributes.other.retain(|name, _| !STAMPS.contains(&name.to_string().as_str()));
    let encoding = Encoding {
        compression: first_part.layer_data.encoding.compression,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((width, height), attributes, encoding, channels);
    let image = Image::new(first_part.attributes.clone(), layer);
    drop(parts);
    encode(&image, first)
}

/// The file of the picture, with the attributes of `tile`. What the encoder takes amiss came from there.
fn encode(image: &Part, tile: &ExrTile) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = || write_compressing_in_parallel(image, &mut bytes);
    let why = match catch_unwind(AssertUnwindSafe(encoder)) {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(error.to_string()),
        Err(_) => Some("it contradicts itself".to_owned()),
    };
    if let Some(why) = why {
        return Err(contradictory(tile, &why));
    }
    sort_attributes(&mut bytes).ok_or_else(|| contradictory(tile, "its header cannot be followed"))?;
    check_attributes(tile, &bytes)?;
    Ok(bytes)
}

fn decode_tile(tile: &ExrTile) -> Result<Part> {
    let ExrTile { path, header } = tile;
    let bytes = std::fs::read(path).map_err(Error::missing(path))?;
    if ExrHeader::parse(&mut bytes.as_slice()).as_ref() != Ok(header) {
        return Err(Error::invalid(path, "", "was changed while it was merged"));
    }
    decode(path, &bytes)
}

fn decode(path: &Path, bytes: &[u8]) -> Result<Part> {
    let decoder = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel();
    // The decoder may panic over files that lie.
    let decoded = catch_unwind(AssertUnwindSafe(|| decoder.from_buffered(Cursor::new(bytes))));
    let why = match decoded {
        Ok(Ok(part)) => return Ok(part),
        Ok(Err(error)) => error.to_string(),
        Err(_) => "it contradicts itself".to_owned(),
    };
    Err(Error::invalid(path, "", format!("not a readable OpenEXR file: {why}")))
}

/// Where the rows of a part go.
struct Place {
    first: usize,
    row_length: usize,
    picture_width: usize,
}

impl Place {
    fn new(part: ExrWindow, picture: ExrWindow, picture_width: usize) -> Self {
        let (column, row) = ((part.x0 - picture.x0) as usize, (part.y0 - picture.y0) as usize);
        Self { first: row * picture_width + column, row_length: part.size().0 as usize, picture_width }
    }

    /// Whether all rows of `from` have their place in `to`.
    fn copy<T: Copy>(&self, from: &[T], to: &mut [T]) -> bool {
        let mut to = to.get_mut(self.first..).unwrap_or_default();
        for row in from.chunks(self.row_length.max(1)) {
            let Some(place) = to.get_mut(..row.len()) else {
                return false;
            };
            place.copy_from_slice(row);
            to = to.get_mut(self.picture_width..).unwrap_or_default();
        }
        true
    }
}

fn copy(from: &FlatSamples, to: &mut FlatSamples, place: &Place) -> bool {
    match (from, to) {
        (FlatSamples::F16(from), FlatSamples::F16(to)) => place.copy(from, to),
        (FlatSamples::F32(from), FlatSamples::F32(to)) => place.copy(from, to),
        (FlatSamples::U32(from), FlatSamples::U32(to)) => place.copy(from, to),
        _ => false,
    }
}

fn empty_like(samples: &FlatSamples, length: usize) -> FlatSamples {
    match samples {
        FlatSamples::F16(_) => FlatSamples::F16(vec![half::f16::ZERO; length]),
        FlatSamples::F32(_) => FlatSamples::F32(vec![0.0; length]),
        FlatSamples::U32(_) => FlatSamples::U32(vec![0; length]),
    }
}

/// The encoder must not have dropped or changed what it does not know.
fn check_attributes(tile: &ExrTile, joined: &[u8]) -> Result<()> {
    let joined = ExrHeader::parse(&mut &*joined).map_err(|why| contradictory(tile, &why))?;
    let (expected, kept) = (tile.header.shared(), joined.shared());
    match expected.iter().find(|(name, value)| kept.get(*name) != Some(*value)) {
        None => Ok(()),
        Some((name, _)) => {
            Err(Error::unsupported(&tile.path, "", format!("its attribute \"{name}\" cannot be kept")))
        }
    }
}

fn contradictory(tile: &ExrTile, why: &str) -> Error {
    Error::invalid(&tile.path, "", format!("cannot be merged: {why}"))
}
