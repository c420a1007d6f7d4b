//! Writing of OpenEXR files in bands of rows, for images that do not fit into memory at once.
//!
//! The file has the bytes that [`encode_exr`](super::encode_exr) gives for the whole image. Header and offset table come first in the file and
//! are complete last: their place is left empty, the chunks are written behind it, and the checksum is computed from the written file.

use std::fs::File;
use std::io::{Cursor, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use exr::block::{UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::image::write::layers::{LayersWriter as _, WritableLayers as _};
use exr::image::{AnyChannels, Encoding, FlatSamples, Layer};
use exr::meta::Headers;
use exr::meta::header::Header;
use exr::prelude::{Blocks, Compression, LineOrder};
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};

use super::atomic::{Replacement, begin_replacing};
use super::exr_checksum::{ZEROS, checksum_position};
use super::exr_deflate::ChunkCompressor;
use super::exr_write::{check_channels, exr_channels, internal, sort_attributes};
use super::{ExrCompression, FrameAttributes};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image::{Channel, Image, PixelWindow, Samples};
use crate::sha256::{hash_rest, hex};

/// Bytes of an entry of the offset table.
const OFFSET_BYTES: usize = 8;
/// Bytes that are hashed between two looks at the cancellation flag.
const HASHED_AT_ONCE: u64 = 16 << 20;

/// An OpenEXR file that takes an image in bands, from top to bottom. The file gets its name when it is finished; dropping it before leaves
/// nothing.
#[derive(Debug)]
pub struct ExrBands {
    path: PathBuf,
    temporary: Replacement,
    /// The whole image without its pixels.
    layout: Layout,
    headers: Headers,
    /// Bytes of the header and the offset table.
    start_bytes: usize,
    /// Positions of the chunks that are written.
    offsets: Vec<u64>,
    /// Bytes so far, with those of the start.
    length: u64,
}

/// A written file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenExr {
    /// Hexadecimal digits of the SHA-256 of the file.
    pub sha256: String,
    /// Bytes of the file.
    pub bytes: usize,
}

/// What decides the header of an image but for its attributes.
#[derive(Debug)]
struct Layout {
    display_window: PixelWindow,
    data_window: PixelWindow,
    encoding: Encoding,
    /// Channels without samples.
    channels: AnyChannels<FlatSamples>,
}

impl ExrBands {
    /// Begins the file of an image whose pixels are `window`. `band` has its channels.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] and [`Error::WriteFailed`] with the path; [`Error::Internal`] for attributes that cannot be stored.
    pub fn begin(
        path: &Path,
        window: PixelWindow,
        band: &Image,
        compression: ExrCompression,
        attributes: &FrameAttributes,
    ) -> Result<Self> {
        check_channels(band)?;
        let layout = Layout {
            display_window: band.display_window,
            data_window: window,
            encoding: Encoding {
                compression: compression.for_exr(),
                blocks: Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            },
            channels: without_samples(&band.channels, compression.for_exr()),
        };
        let headers = layout.headers(attributes);
        let start_bytes = start_of_file(&headers, &[])?.len();
        let mut temporary = begin_replacing(path)?;
        let at_chunks = temporary.file().seek(SeekFrom::Start(start_bytes as u64));
        at_chunks.map_err(|source| Error::WriteFailed { path: path.to_owned(), source })?;
        Ok(Self {
            path: path.to_owned(),
            temporary,
            layout,
            headers,
            start_bytes,
            offsets: Vec::new(),
            length: start_bytes as u64,
        })
    }

    /// Rows of a chunk. All bands but the last have a multiple of them.
    pub fn rows_of_chunks(compression: ExrCompression) -> u32 {
        compression.for_exr().scan_lines_per_block() as u32
    }

    /// Compresses and writes the next band, whose data window is the rows below the band before.
    ///
    /// # Errors
    /// [`Error::WriteFailed`]; [`Error::Internal`] for a band of other channels or rows.
    pub fn write(&mut self, band: Image) -> Result<()> {
        for chunk in self.compressed(band)? {
            self.offsets.push(self.length);
            self.temporary.file().write_all(&chunk).map_err(|source| self.failed(source))?;
            self.length += chunk.len() as u64;
        }
        Ok(())
    }

    /// The chunks of a band, in their order.
    fn compressed(&self, band: Image) -> Result<Vec<Vec<u8>>> {
        check_channels(&band)?;
        let (whole, window) = (self.layout.data_window, band.data_window);
        let first_row = window.y0.saturating_sub(whole.y0) as usize;
        let rows_of_chunks = self.layout.encoding.compression.scan_lines_per_block();
        let is_next = (window.x0, window.x1) == (whole.x0, whole.x1)
            && first_row == self.offsets.len() * rows_of_chunks
            && ((window.height() as usize).is_multiple_of(rows_of_chunks) || window.y1 == whole.y1);
        if !is_next
            || without_samples(&band.channels, self.layout.encoding.compression) != self.layout.channels
        {
            return Err(internal("a band does not continue the image"));
        }

        let size = (window.width() as usize, window.height() as usize);
        let layer = Layer::new(
            size,
            exr::prelude::LayerAttributes::default(),
            self.layout.encoding,
            exr_channels(band.channels, self.layout.encoding.compression),
        );
        let band_headers = layer.infer_headers(&self.headers[0].shared_attributes);
        let writer = layer.create_writer(&band_headers);
        let blocks: Vec<_> = enumerate_ordered_header_block_indices(&band_headers).collect();
        let compress = |compressor: &mut ChunkCompressor, (_, mut index): (usize, exr::block::BlockIndex)| {
            let data = writer.extract_uncompressed_block(&band_headers, index);
            index.pixel_position.1 += first_row;
            let chunk = compressor.compress(UncompressedBlock { index, data }, &self.headers)?;
            let mut bytes = Vec::new();
            chunk.write(&mut bytes, self.headers.len())?;
            Ok(bytes)
        };
        let chunks: exr::error::Result<_> =
            blocks.into_par_iter().map_init(ChunkCompressor::new, compress).collect();
        chunks.map_err(|error| internal(&error.to_string()))
    }

    /// Completes the file and gives it its name. `attributes` may differ from those of the beginning in a stamp of the same length.
    ///
    /// # Errors
    /// [`Error::WriteFailed`]; [`Error::Internal`] where bands are missing; [`Error::Interrupted`] when `cancel` is raised.
    pub fn finish(mut self, attributes: &FrameAttributes, cancel: &CancelFlag) -> Result<WrittenExr> {
        let headers = self.layout.headers(attributes);
        if self.offsets.len() != headers[0].chunk_count {
            return Err(internal("bands of the image are missing"));
        }
        let mut start = start_of_file(&headers, &self.offsets)?;
        if start.len() != self.start_bytes {
            return Err(internal("its attributes changed their length"));
        }
        let at = checksum_position(&mut Cursor::new(start.as_slice())).ok().flatten();
        let at = at.ok_or_else(|| internal("the encoder wrote a header that cannot be parsed"))? as usize;
        let digits = self.hash(&start, cancel)?;
        start[at..at + ZEROS.len()].copy_from_slice(digits.as_bytes());
        let sha256 = self.hash(&start, cancel)?;

        let file = self.temporary.file();
        let written = file.rewind().and_then(|()| file.write_all(&start));
        written.map_err(|source| self.failed(source))?;
        self.temporary.commit(&self.path)?;
        Ok(WrittenExr { sha256, bytes: self.length as usize })
    }

    /// Digits of the SHA-256 of `start` and the chunks behind it.
    fn hash(&mut self, start: &[u8], cancel: &CancelFlag) -> Result<String> {
        let (mut hash, length) = (Sha256::new_with_prefix(start), self.length);
        let path = self.path.clone();
        let failed = |source| Error::WriteFailed { path: path.clone(), source };
        let file: &mut File = self.temporary.file();
        let mut position = file.seek(SeekFrom::Start(start.len() as u64)).map_err(failed)?;
        while position < length {
            cancel.check()?;
            let part = HASHED_AT_ONCE.min(length - position);
            hash_rest(&mut file.take(part), &mut hash).map_err(failed)?;
            position += part;
        }
        Ok(hex(&hash.finalize()))
    }

    fn failed(&self, source: std::io::Error) -> Error {
        Error::WriteFailed { path: self.path.clone(), source }
    }
}

impl Layout {
    /// The only header of the file.
    fn headers(&self, attributes: &FrameAttributes) -> Headers {
        let (window, display_size) = (self.data_window, self.display_window.size());
        let size = (window.width() as usize, window.height() as usize);
        let own = attributes.of_layer((window.x0.into(), window.y0.into()));
        let layer = Layer::new(size, own, self.encoding, self.channels.clone());
        layer.infer_headers(&attributes.of_image(display_size))
    }
}

/// The header with sorted attributes, and the table of `offsets`, filled up with zeros.
fn start_of_file(headers: &Headers, offsets: &[u64]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // The crate writes headers only together with chunks, of which there are none yet.
    let written = exr::block::write(Cursor::new(&mut bytes), headers.clone(), true, |_, _| {
        Err(exr::error::Error::Aborted)
    });
    match written {
        Err(exr::error::Error::Aborted) => {}
        Err(error) => return Err(internal(&error.to_string())),
        Ok(()) => return Err(internal("the encoder wrote a file without chunks")),
    }
    let parsed = sort_attributes(&mut bytes);
    let header_bytes = parsed.ok_or_else(|| internal("the encoder wrote a header that cannot be parsed"))?;
    bytes.truncate(header_bytes);
    bytes.extend(offsets.iter().flat_map(|offset| offset.to_le_bytes()));
    let chunks = headers.iter().map(|header: &Header| header.chunk_count).sum::<usize>();
    bytes.resize(header_bytes + chunks * OFFSET_BYTES, 0);
    Ok(bytes)
}

/// The channels in the order of their names, without samples.
fn without_samples(channels: &[Channel], compression: Compression) -> AnyChannels<FlatSamples> {
    let empty = |channel: &Channel| Channel {
        name: channel.name.clone(),
        samples: match channel.samples {
            Samples::Half(_) => Samples::Half(Vec::new()),
            Samples::Float(_) => Samples::Float(Vec::new()),
            Samples::Uint(_) => Samples::Uint(Vec::new()),
        },
    };
    exr_channels(channels.iter().map(empty).collect(), compression)
}

#[cfg(test)]
mod tests;
