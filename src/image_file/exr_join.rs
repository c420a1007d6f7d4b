//! Joining of EXR files that hold tiles of one image.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use exr::image::read::read;
use exr::image::{AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer};
use exr::meta::attribute::AttributeValue;
use exr::meta::header::LayerAttributes;
use exr::prelude::{Blocks, LineOrder, ReadChannels as _, ReadLayers as _, Vec2};
use rayon::prelude::*;

use super::ExrHeader;
use super::exr_attributes::{SAMPLE_RANGE, STAMPS, byte_text};
use super::exr_checksum::{CHECKSUM, ExrIntegrity, ZEROS, seal, verify_exr};
use super::exr_chunks::check_chunks;
use super::exr_error::exr_error_text;
use super::exr_write::{exr_channels, sort_attributes, write_compressing_in_parallel};
use super::isolated::isolated;
use crate::error::{Error, Result};
use crate::image::{Image, PixelWindow};

/// An EXR file that holds a rectangle of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrTile {
    /// Path of the file.
    pub path: PathBuf,
    /// Header at the time of planning, with hashes in place of long attributes.
    pub header: ExrHeader,
}

impl ExrTile {
    /// The file `path` with this header, of which it keeps what tells tiles apart.
    pub fn new(path: PathBuf, header: ExrHeader) -> Self {
        Self { path, header: header.condensed() }
    }
}

type TileImage = ExrImage<Layer<AnyChannels<FlatSamples>>>;

/// Joins `tiles` into the EXR file of the whole image, with the compression and the attributes that they share. Stamps are
/// left out, because several runs rendered the image.
///
/// The tiles must share all other attributes and cover the image, each pixel once.
///
/// # Errors
/// [`Error::Missing`] and [`Error::Invalid`] for a tile that cannot be read or was changed since planning;
/// [`Error::Unsupported`] when an attribute cannot be kept; [`Error::Internal`] when there are no tiles.
pub fn join_exr_tiles(tiles: &[ExrTile]) -> Result<Vec<u8>> {
    join_decoded(tiles, tiles.par_iter().map(decode_tile).collect::<Result<_>>()?)
}

/// The same of encoded tiles in memory. Errors name the path that each is given.
///
/// # Errors
/// Those of [`join_exr_tiles`].
pub(crate) fn join_encoded_tiles(encoded: Vec<(PathBuf, Vec<u8>)>) -> Result<Vec<u8>> {
    let tile = |(path, bytes): (PathBuf, Vec<u8>)| {
        let header = ExrHeader::parse(&mut bytes.as_slice());
        let header = header.map_err(|why| Error::invalid(&path, "", why))?;
        let image = decode(&path, &bytes)?;
        Ok((ExrTile::new(path, header), image))
    };
    let (tiles, decoded): (Vec<_>, _) =
        encoded.into_iter().map(tile).collect::<Result<Vec<_>>>()?.into_iter().unzip();
    join_decoded(&tiles, decoded)
}

fn join_decoded(tiles: &[ExrTile], decoded: Vec<TileImage>) -> Result<Vec<u8>> {
    let (Some(first), Some(first_image)) = (tiles.first(), decoded.first()) else {
        return Err(Error::Internal { message: "there are no tiles to join".to_owned() });
    };

    // Copy the tiles into the whole image.
    let window = first.header.display_window;
    let (width, height) = window.size();
    let (width, height) = (width as usize, height as usize);
    let mut channels = first_image.layer_data.channel_data.clone();
    for (index, channel) in channels.list.iter_mut().enumerate() {
        channel.sample_data = empty_like(&channel.sample_data, width * height);
        for (tile, image) in tiles.iter().zip(&decoded) {
            let samples = image.layer_data.channel_data.list.get(index).map(|channel| &channel.sample_data);
            let target = TileRows::new(tile.header.data_window, window, width);
            let is_copied = samples.is_some_and(|samples| copy(samples, &mut channel.sample_data, &target));
            if !is_copied {
                return Err(cannot_merge(tile, "its pixels do not match its header"));
            }
        }
    }

    // Encode it like the tiles.
    let mut attributes = first_image.layer_data.attributes.clone();
    attributes.layer_position = Vec2(window.x0 as i32, window.y0 as i32);
    remove_run_attributes(&mut attributes);
    let encoding = Encoding {
        compression: first_image.layer_data.encoding.compression,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((width, height), attributes, encoding, channels);
    let image = ExrImage::new(first_image.attributes.clone(), layer);
    drop(decoded);
    encode(&image, first)
}

/// Encodes `image` with the compression and the attributes of `tile`, but for stamps and its sample range.
///
/// # Errors
/// Those of [`join_exr_tiles`].
pub fn encode_exr_like(tile: &ExrTile, image: Image) -> Result<Vec<u8>> {
    let decoded = decode_tile(tile)?;
    let mut attributes = decoded.layer_data.attributes;
    remove_run_attributes(&mut attributes);
    let encoding = Encoding {
        compression: decoded.layer_data.encoding.compression,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let channels = exr_channels(image.channels, encoding.compression);
    let layer = Layer::new(decoded.layer_data.size, attributes, encoding, channels);
    encode(&ExrImage::new(decoded.attributes, layer), tile)
}

/// Removes what the runs that rendered parts of an image do not share, and makes space for a checksum.
fn remove_run_attributes(attributes: &mut LayerAttributes) {
    attributes.capture_date = None;
    attributes.utc_offset = None;
    let is_of_run = |name: &str| name == SAMPLE_RANGE || STAMPS.contains(&name);
    attributes.other.retain(|name, _| !is_of_run(name.to_string().as_str()));
    attributes.other.insert(byte_text(CHECKSUM), AttributeValue::Text(byte_text(ZEROS)));
}

/// Encodes the joined image. Its attributes come from `tile`, so that encoder errors are errors of that file.
fn encode(image: &TileImage, tile: &ExrTile) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = || write_compressing_in_parallel(image, &mut bytes);
    let why = match catch_unwind(AssertUnwindSafe(encoder)) {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(exr_error_text(&error)),
        Err(_) => Some("its content is inconsistent".to_owned()),
    };
    if let Some(why) = why {
        return Err(cannot_merge(tile, &why));
    }
    sort_attributes(&mut bytes).ok_or_else(|| cannot_merge(tile, "its header cannot be parsed"))?;
    check_attributes(tile, &bytes)?;
    seal(&mut bytes).ok_or_else(|| cannot_merge(tile, "its header cannot be parsed"))?;
    Ok(bytes)
}

fn decode_tile(tile: &ExrTile) -> Result<TileImage> {
    let ExrTile { path, header } = tile;
    let bytes = std::fs::read(path).map_err(Error::missing(path))?;
    if ExrHeader::parse(&mut bytes.as_slice()).map(ExrHeader::condensed).as_ref() != Ok(header) {
        return Err(Error::invalid(path, "", "was changed while it was merged"));
    }
    if verify_exr(&mut Cursor::new(&bytes)).is_ok_and(|integrity| integrity == ExrIntegrity::Damaged) {
        return Err(Error::invalid(
            path,
            "",
            "is damaged: its bytes do not match its checksum; render it again",
        ));
    }
    decode(path, &bytes)
}

fn decode(path: &Path, bytes: &[u8]) -> Result<TileImage> {
    let decoder = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel();
    let decode = || decoder.from_buffered(Cursor::new(bytes)).map_err(|error| exr_error_text(&error));
    isolated(|| check_chunks(&mut Cursor::new(bytes)).and_then(|()| decode()))
        .map_err(|why| Error::invalid(path, "", format!("not a readable OpenEXR file: {why}")))
}

/// Position of a tile's rows in the whole image.
struct TileRows {
    first: usize,
    row_length: usize,
    image_width: usize,
}

impl TileRows {
    fn new(tile: PixelWindow<i64>, display: PixelWindow<i64>, image_width: usize) -> Self {
        let (column, row) = ((tile.x0 - display.x0) as usize, (tile.y0 - display.y0) as usize);
        Self { first: row * image_width + column, row_length: tile.size().0 as usize, image_width }
    }

    /// Copies the rows of `from` into `to`. Returns false where they do not fit.
    fn copy<T: Copy>(&self, from: &[T], to: &mut [T]) -> bool {
        let mut to = to.get_mut(self.first..).unwrap_or_default();
        for row in from.chunks(self.row_length.max(1)) {
            let Some(target) = to.get_mut(..row.len()) else {
                return false;
            };
            target.copy_from_slice(row);
            to = to.get_mut(self.image_width..).unwrap_or_default();
        }
        true
    }
}

fn copy(from: &FlatSamples, to: &mut FlatSamples, target: &TileRows) -> bool {
    match (from, to) {
        (FlatSamples::F16(from), FlatSamples::F16(to)) => target.copy(from, to),
        (FlatSamples::F32(from), FlatSamples::F32(to)) => target.copy(from, to),
        (FlatSamples::U32(from), FlatSamples::U32(to)) => target.copy(from, to),
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

/// Refuses a joined file in which the encoder dropped or changed an attribute.
fn check_attributes(tile: &ExrTile, joined: &[u8]) -> Result<()> {
    let joined = ExrHeader::parse(&mut &*joined).map_err(|why| cannot_merge(tile, &why))?.condensed();
    if joined.channels_without_sums().ne(tile.header.channels_without_sums()) {
        return Err(cannot_merge(tile, "its channels cannot be kept"));
    }
    let (mut expected, kept) = (tile.header.shared(), joined.shared());
    // Those of sums are left out where they are added up.
    expected.remove("channels");
    match expected.iter().find(|(name, value)| kept.get(*name) != Some(*value)) {
        None => Ok(()),
        Some((name, _)) => {
            Err(Error::unsupported(&tile.path, "", format!("its attribute \"{name}\" cannot be kept")))
        }
    }
}

fn cannot_merge(tile: &ExrTile, why: &str) -> Error {
    Error::invalid(&tile.path, "", format!("cannot be merged: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ColorEncoding;
    use crate::image_file::{ExrCompression, FrameAttributes, encode_exr};

    #[test]
    fn encoder_errors_are_told_in_the_words_of_reader_errors() {
        let image = Image::from_rgba((4, 4), ColorEncoding::Linear, &[[0.5; 4]; 16]);
        let bytes = encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown()).unwrap();
        let path = PathBuf::from("a.exr");
        let tile = ExrTile::new(path.clone(), ExrHeader::parse(&mut bytes.as_slice()).unwrap());
        let mut image = decode(&path, &bytes).unwrap();
        image.attributes.pixel_aspect = 0.0;
        let error = encode(&image, &tile).unwrap_err().to_string();
        assert_eq!(error, "a.exr: cannot be merged: its content is inconsistent (pixel aspect ratio)");
    }
}
