//! Compression of one chunk of an OpenEXR file.
//!
//! The `exr` crate encodes all methods. Of these, deflate is a tenth of a short frame and is done here by a faster library, at the
//! level that the crate and OpenEXR use.
//!
//! Source of the arrangement of bytes: *OpenEXR File Layout* and *Technical Introduction to OpenEXR* (Academy Software Foundation), ZIP.

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::error::Result;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::Compression;
use zlib_rs::{Deflate, DeflateFlush, Status};

/// OpenEXR's default level of deflate.
const DEFLATE_LEVEL: i32 = 4;
/// Binary logarithm of the largest distance that deflate refers back to.
const WINDOW_BITS: u8 = 15;

/// Compresses chunks one after the other, and keeps the memory for it.
pub(super) struct ChunkCompressor {
    deflate: Deflate,
    /// The bytes of a chunk in the order in which they are compressed.
    separated: Vec<u8>,
    differences: Vec<u8>,
    packed: Vec<u8>,
}

impl ChunkCompressor {
    pub(super) fn new() -> Self {
        let deflate = Deflate::new(DEFLATE_LEVEL, true, WINDOW_BITS);
        Self { deflate, separated: Vec::new(), differences: Vec::new(), packed: Vec::new() }
    }

    /// Compresses a block of a part by the method in that part's header.
    ///
    /// # Errors
    /// Those of [`UncompressedBlock::compress_to_chunk`], for other methods than deflate.
    pub(super) fn compress(&mut self, block: UncompressedBlock, headers: &[Header]) -> Result<Chunk> {
        let is_deflated = |header: &&Header| {
            matches!(header.compression, Compression::ZIP1 | Compression::ZIP16)
                && matches!(header.blocks, BlockDescription::ScanLines)
                // Samples have the machine's order of bytes, files have this one.
                && cfg!(target_endian = "little")
        };
        let Some(header) = headers.get(block.index.layer).filter(is_deflated) else {
            return block.compress_to_chunk(headers);
        };
        let UncompressedBlock { index, data } = block;
        let y_coordinate = index.pixel_position.y() as i32 + header.own_attributes.layer_position.y();
        // Readers recognise uncompressed chunks by their size.
        let compressed_pixels_le = match self.deflated(&data) {
            Some(packed) if packed.len() < data.len() => packed,
            _ => data,
        };
        let block = CompressedScanLineBlock { y_coordinate, compressed_pixels_le };
        Ok(Chunk { layer_index: index.layer, compressed_block: CompressedBlock::ScanLine(block) })
    }

    /// A zlib stream of differences between bytes; `None` where that is larger than the bytes.
    fn deflated(&mut self, data: &[u8]) -> Option<Vec<u8>> {
        separate_bytes(data, &mut self.separated);
        take_differences(&self.separated, &mut self.differences);
        self.deflate.reset();
        self.packed.resize(data.len(), 0);
        let status = self.deflate.compress(&self.differences, &mut self.packed, DeflateFlush::Finish);
        let length = self.deflate.total_out() as usize;
        // The library takes up to 4 GiB.
        let is_whole = self.deflate.total_in() == self.differences.len() as u64;
        (is_whole && matches!(status, Ok(Status::StreamEnd))).then(|| self.packed[..length].to_vec())
    }
}

/// All bytes at even positions, then those at odd ones: of halves, the low bytes and then the high ones.
fn separate_bytes(data: &[u8], separated: &mut Vec<u8>) {
    let (pairs, last) = data.as_chunks::<2>();
    separated.clear();
    separated.extend(pairs.iter().map(|[even, _]| even));
    separated.extend(last);
    separated.extend(pairs.iter().map(|[_, odd]| odd));
}

/// The first byte, then the difference of every other one to the byte before it, plus 128.
fn take_differences(bytes: &[u8], differences: &mut Vec<u8>) {
    differences.clear();
    differences.extend(bytes.first());
    let neighbors = bytes.iter().zip(bytes.iter().skip(1));
    differences.extend(neighbors.map(|(before, byte)| byte.wrapping_sub(*before).wrapping_add(128)));
}

#[cfg(test)]
mod tests {
    use exr::block::enumerate_ordered_header_block_indices;
    use exr::image::write::layers::WritableLayers as _;
    use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
    use exr::meta::{MetaData, Requirements};
    use exr::prelude::{Blocks, ImageAttributes, LayerAttributes, LineOrder};
    use half::f16;

    use super::*;

    const SIZE: (usize, usize) = (21, 40);

    /// A layer with a channel of halves and one of floats, at (3, 5).
    fn headers(compression: Compression) -> Vec<Header> {
        let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let count = SIZE.0 * SIZE.1;
        let channels = [
            AnyChannel::new("A", FlatSamples::F16(vec![f16::ZERO; count])),
            AnyChannel::new("Z", FlatSamples::F32(vec![0.0; count])),
        ];
        let layer_position = exr::prelude::Vec2(3, 5);
        let attributes = LayerAttributes { layer_position, ..LayerAttributes::default() };
        let layer = Layer::new(SIZE, attributes, encoding, AnyChannels::sort(channels.into_iter().collect()));
        layer.infer_headers(&ImageAttributes::with_size(SIZE)).to_vec()
    }

    /// Bytes of three kinds: equal ones, smooth ones, and noise that no method makes smaller.
    fn kinds_of_bytes(count: usize) -> [Vec<u8>; 3] {
        let mut state = 1_u32;
        let noise = std::iter::repeat_with(|| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        });
        [vec![7; count], (0..count).map(|at| (at / 9) as u8).collect(), noise.take(count).collect()]
    }

    #[test]
    fn chunks_hold_the_bytes_that_the_crate_stores() {
        for compression in [Compression::ZIP1, Compression::ZIP16, Compression::RLE] {
            let headers = headers(compression);
            let requirements = Requirements {
                file_format_version: 2,
                is_single_layer_and_tiled: false,
                has_long_names: false,
                has_deep_data: false,
                has_multiple_layers: false,
            };
            let meta = MetaData { requirements, headers: headers.clone().into() };
            let mut compressor = ChunkCompressor::new();
            for (_, index) in enumerate_ordered_header_block_indices(&headers) {
                let [equal, smooth, noise] = kinds_of_bytes(index.pixel_size.area() * 6);
                for (data, is_smaller) in [(equal, true), (smooth, true), (noise, false)] {
                    let block = UncompressedBlock { index, data };
                    let expected = block.clone().compress_to_chunk(&headers).unwrap();
                    let chunk = compressor.compress(block.clone(), &headers).unwrap();
                    let rows = |chunk: &Chunk| match &chunk.compressed_block {
                        CompressedBlock::ScanLine(rows) => rows.clone(),
                        _ => unreachable!("only scan lines are written"),
                    };
                    let (rows, expected) = (rows(&chunk), rows(&expected));
                    assert_eq!(rows.y_coordinate, expected.y_coordinate);
                    if compression != Compression::RLE {
                        assert_eq!(rows.compressed_pixels_le.len() < block.data.len(), is_smaller);
                    }
                    let read = UncompressedBlock::decompress_chunk(chunk, &meta, true).unwrap();
                    assert_eq!(read.data, block.data, "{compression:?} {index:?}");
                }
            }
        }
    }

    #[test]
    fn a_chunk_does_not_depend_on_those_before_it() {
        let mut compressor = ChunkCompressor::new();
        for count in (0..100).flat_map(|index| [index * 37 + 5, 4000 - index * 31]) {
            for data in kinds_of_bytes(count) {
                assert_eq!(compressor.deflated(&data), ChunkCompressor::new().deflated(&data), "{count}");
            }
        }
    }

    #[test]
    fn an_odd_number_of_bytes_is_separated_and_subtracted() {
        let (mut separated, mut differences) = (Vec::new(), Vec::new());
        separate_bytes(&[1, 10, 2, 20, 5], &mut separated);
        assert_eq!(separated, [1, 2, 5, 10, 20]);
        take_differences(&separated, &mut differences);
        assert_eq!(differences, [1, 129, 131, 133, 138]);
    }
}
