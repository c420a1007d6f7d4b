//! RGBA half-float OpenEXR, scan lines in increasing order, ZIP over 16 lines, as bytes in memory.
//!
//! The same pixels and attributes always give the same bytes. Two habits of the `exr` crate stand against that and are
//! undone here: its default block order is not fixed, and attributes it has no field for come in hash-map order.

use std::io::Cursor;

use exr::block::writer::ChunksWriter as _;
use exr::image::write::layers::{LayersWriter as _, WritableLayers};
use exr::image::{Encoding, Image, Layer, SpecificChannels};
use exr::prelude::{Blocks, Compression, LineOrder, Vec2, WritableImage as _};
use half::f16;
use rayon::prelude::*;

use super::{FrameAttributes, RgbaPixels};
use crate::error::{Error, Result};

/// Encodes a picture as an OpenEXR file.
///
/// # Errors
/// [`Error::Internal`] when the picture's sizes contradict each other.
pub fn encode_exr(pixels: &RgbaPixels<'_>, attributes: &FrameAttributes) -> Result<Vec<u8>> {
    let (width, height) = (pixels.size.0 as usize, pixels.size.1 as usize);
    if width * height != pixels.pixels.len() {
        return Err(internal("the picture holds another number of pixels than its size says"));
    }
    let channels = SpecificChannels::rgba(|Vec2(x, y): Vec2<usize>| {
        let [r, g, b, a] = pixels.pixels[y * width + x].map(half_from_f32);
        (r, g, b, a)
    });
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((width, height), attributes.of_layer(pixels), encoding, channels);
    let image = Image::new(FrameAttributes::of_image(pixels), layer);

    let mut bytes = Vec::new();
    write_compressing_in_parallel(&image, &mut bytes).map_err(|error| internal(&error.to_string()))?;
    sort_attributes(&mut bytes)
        .ok_or_else(|| internal("the encoder wrote a header that cannot be followed"))?;
    Ok(bytes)
}

/// Compresses the blocks on the current rayon pool and writes them in their order. (The crate's own parallel writer
/// starts a pool of its own.)
fn write_compressing_in_parallel<'a, Layers: WritableLayers<'a>>(
    image: &'a Image<Layers>,
    bytes: &mut Vec<u8>,
) -> exr::error::UnitResult {
    let headers = image.write().infer_meta_data();
    let layers = image.layer_data.create_writer(&headers);
    exr::block::write(Cursor::new(bytes), headers, true, |meta, chunk_writer| {
        let blocks: Vec<_> = meta
            .collect_ordered_block_data(|index| layers.extract_uncompressed_block(&meta.headers, index))
            .collect();
        let chunks: Vec<_> = blocks
            .into_par_iter()
            .map(|(place, block)| block.compress_to_chunk(&meta.headers).map(|chunk| (place, chunk)))
            .collect();
        for chunk in chunks {
            let (place, chunk) = chunk?;
            chunk_writer.write_chunk(place, chunk)?;
        }
        Ok(())
    })
}

/// The nearest half-float. Values beyond ±65504 become ±65504, what is not a number becomes 0, and −0 becomes 0.
pub fn half_from_f32(value: f32) -> f16 {
    if value.is_nan() {
        return f16::ZERO;
    }
    let half = f16::from_f32(value.clamp(-65504.0, 65504.0));
    if half == f16::ZERO { f16::ZERO } else { half }
}

/// Brings the attributes of the only header into the order of their names, as OpenEXR's own library writes them.
fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
    const AFTER_MAGIC_AND_VERSION: usize = 8;
    let mut attributes = Vec::new();
    let mut start = AFTER_MAGIC_AND_VERSION;
    while *bytes.get(start)? != 0 {
        let end = attribute_end(bytes, start)?;
        attributes.push(bytes[start..end].to_vec());
        start = end;
    }
    // A name ends in a zero byte, so comparing whole attributes compares names; no two names are equal.
    attributes.sort();
    let sorted = attributes.concat();
    bytes[AFTER_MAGIC_AND_VERSION..start].copy_from_slice(&sorted);
    Some(())
}

/// Where the attribute at `start` ends: name, zero, type, zero, four bytes of size, value.
fn attribute_end(bytes: &[u8], start: usize) -> Option<usize> {
    let after_text = |from: usize| Some(from + bytes.get(from..)?.iter().position(|&byte| byte == 0)? + 1);
    let size_at = after_text(after_text(start)?)?;
    let size = bytes.get(size_at..size_at + 4)?.try_into().ok()?;
    let end = size_at + 4 + u32::from_le_bytes(size) as usize;
    (end < bytes.len()).then_some(end)
}

fn internal(message: &str) -> Error {
    Error::Internal { message: format!("the EXR file could not be encoded: {message}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::{StoredFrame, decode_exr, inspect_exr};
    use exr::meta::header::LayerAttributes;

    fn attributes() -> FrameAttributes {
        FrameAttributes {
            software: "rayframe test".to_owned(),
            render_hash: "00ff".to_owned(),
            frame: -3,
            time_seconds: -0.125,
            frames_per_second: (24000, 1001),
            world_to_camera: [0.5; 16],
            world_to_ndc: [0.25; 16],
        }
    }

    /// Every value is a multiple of 1/64 below 32, which a half holds exactly (11 significant bits).
    fn gradient(width: u32, height: u32) -> Vec<[f32; 4]> {
        (0..width * height)
            .map(|i| [(i % 1024) as f32 / 64.0, (i / 1024) as f32, -((i % 7) as f32), 1.0])
            .collect()
    }

    fn encode(size: (u32, u32)) -> Vec<u8> {
        let pixels = gradient(size.0, size.1);
        let picture = RgbaPixels { picture_size: (100, 90), origin: (3, 5), size, pixels: &pixels };
        encode_exr(&picture, &attributes()).unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        // 37 rows: two whole blocks of sixteen scan lines and one part of a block.
        let image = decode_exr("a.exr".as_ref(), &encode((61, 37)), u64::MAX).unwrap();
        assert_eq!(image.size, (61, 37));
        assert_eq!(image.pixels, gradient(61, 37));
    }

    #[test]
    fn bytes_do_not_depend_on_threads_or_on_the_run() {
        // With attributes left in hash-map order, 20 runs agree with probability (1/6)^19.
        let expected = encode((61, 37));
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for _ in 0..5 {
                assert!(pool.install(|| encode((61, 37))) == expected);
            }
        }
    }

    #[test]
    fn blocks_compressed_in_parallel_are_those_of_the_plain_writer() {
        let channels =
            || SpecificChannels::rgba(|Vec2(x, y): Vec2<usize>| (x as f32, y as f32, 0.5_f32, 1.0_f32));
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let layer = Layer::new((33, 50), LayerAttributes::default(), encoding, channels());
        let image = Image::from_layer(layer);
        let (mut parallel, mut plain) = (Vec::new(), Vec::new());
        write_compressing_in_parallel(&image, &mut parallel).unwrap();
        image.write().non_parallel().to_buffered(Cursor::new(&mut plain)).unwrap();
        assert!(parallel == plain);
    }

    #[test]
    fn attributes_stand_in_the_order_of_their_names() {
        let bytes = encode((2, 2));
        let mut names = Vec::new();
        let mut start = 8;
        while bytes[start] != 0 {
            let length = bytes[start..].iter().position(|&byte| byte == 0).unwrap();
            names.push(String::from_utf8(bytes[start..start + length].to_vec()).unwrap());
            start = attribute_end(&bytes, start).unwrap();
        }
        assert!(names.is_sorted(), "{names:?}");
        for name in [
            "chromaticities",
            "frame",
            "framesPerSecond",
            "renderHash",
            "software",
            "timeSeconds",
            "worldToNDC",
        ] {
            assert!(names.iter().any(|n| n == name), "{name} is missing");
        }
    }

    #[test]
    fn a_truncated_file_is_not_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let bytes = encode((61, 37));
        std::fs::write(&path, &bytes).unwrap();
        let expected = StoredFrame {
            render_hash: Some("00ff".to_owned()),
            picture_size: (100, 90),
            origin: (3, 5),
            size: (61, 37),
        };
        assert_eq!(inspect_exr(&path).unwrap(), expected);
        for length in [0, 3, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(inspect_exr(&path).is_err(), "{length} of {} bytes", bytes.len());
        }
    }

    #[test]
    fn halves_are_finite_and_have_one_zero() {
        // 65504 is the largest half; 65520 and up would round to infinity.
        for (value, expected) in [
            (0.1, 0.099_975_586),
            (70000.0, 65504.0),
            (f32::INFINITY, 65504.0),
            (f32::NEG_INFINITY, -65504.0),
            (f32::NAN, 0.0),
        ] {
            assert_eq!(half_from_f32(value).to_f32(), expected);
        }
        assert_eq!(half_from_f32(-0.0).to_bits(), 0);
        assert_eq!(half_from_f32(-1e-12).to_bits(), 0);
    }
}
