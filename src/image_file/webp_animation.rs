//! Animated WebP, lossless: VP8L frames in the extended container.
//!
//! Source: Google, "WebP Container Specification" (RFC 9649, section 2). The frames are encoded by the crate `image`; this module
//! writes the chunks `VP8X`, `ANIM` and `ANMF` around them. Every frame covers the canvas and replaces the one before.

use std::io::{self, Cursor, Seek, SeekFrom, Write};

use image::ExtendedColorType;
use image::codecs::webp::WebPEncoder;

use super::movie_mark::webp_xmp_chunk;

/// Longest side of a VP8L image, pixels.
pub(super) const MAX_SIDE: u32 = 1 << 14;

/// Flags of `VP8X`.
const HAS_ANIMATION: u8 = 0x02;
const HAS_ALPHA: u8 = 0x10;
const HAS_XMP: u8 = 0x04;
/// Flag of `ANMF`: the frame replaces the canvas and is not blended with it.
const REPLACES: u8 = 0x02;
/// Bytes of the container before a single image.
const STILL_HEADER_BYTES: u64 = 12 + 8 + 10;
/// Bytes of the container before the first frame.
const HEADER_BYTES: u64 = STILL_HEADER_BYTES + 8 + 6;
/// Bytes of the RIFF and `VP8L` headers in front of the encoder's bit stream.
const ENCODED_HEADER_BYTES: usize = 12;

/// Writer of an animated WebP file that repeats for ever. A single frame becomes a WebP image without animation.
pub(super) struct WebpAnimation<W> {
    sink: W,
    size: (u32, u32),
    is_still: bool,
    bytes: u64,
    has_alpha: bool,
}

impl<W: Write + Seek> WebpAnimation<W> {
    /// Begins a file of `frames` frames.
    pub(super) fn new(mut sink: W, size: (u32, u32), frames: u32) -> io::Result<Self> {
        let is_still = frames == 1;
        let bytes = if is_still { STILL_HEADER_BYTES } else { HEADER_BYTES };
        // The header is written at the end, when the length is known.
        sink.write_all(&[0; HEADER_BYTES as usize][..bytes as usize])?;
        Ok(Self { sink, size, is_still, bytes, has_alpha: false })
    }

    /// Adds a frame that is shown for `milliseconds`.
    pub(super) fn add(&mut self, pixels: &[[u8; 4]], milliseconds: u32) -> io::Result<()> {
        let is_opaque = pixels.iter().all(|pixel| pixel[3] == 255);
        let encoded = encode(pixels, self.size, is_opaque)?;
        self.has_alpha |= !is_opaque;
        let Some(image) = encoded.get(ENCODED_HEADER_BYTES..) else {
            return Err(io::Error::other("the encoder wrote no image"));
        };
        if self.is_still {
            self.bytes += image.len() as u64;
            return self.sink.write_all(image);
        }
        let mut frame = Vec::with_capacity(24 + image.len());
        frame.extend_from_slice(b"ANMF");
        frame.extend_from_slice(&length_of(16 + image.len() as u64)?);
        // The frame begins in the canvas's corner.
        frame.extend_from_slice(&[0; 6]);
        frame.extend_from_slice(&bytes_24(self.size.0 - 1));
        frame.extend_from_slice(&bytes_24(self.size.1 - 1));
        frame.extend_from_slice(&bytes_24(milliseconds));
        frame.push(REPLACES);
        frame.extend_from_slice(image);
        self.bytes += frame.len() as u64;
        self.sink.write_all(&frame)
    }

    /// Writes the header.
    pub(super) fn finish(mut self) -> io::Result<()> {
        let mark = webp_xmp_chunk();
        self.sink.write_all(&mark)?;
        self.bytes += mark.len() as u64;
        let alpha = if self.has_alpha { HAS_ALPHA } else { 0 };
        let animation = if self.is_still { 0 } else { HAS_ANIMATION };
        let mut header = Vec::with_capacity(HEADER_BYTES as usize);
        header.extend_from_slice(b"RIFF");
        header.extend_from_slice(&length_of(self.bytes - 8)?);
        header.extend_from_slice(b"WEBPVP8X\x0a\0\0\0");
        header.extend_from_slice(&[animation | alpha | HAS_XMP, 0, 0, 0]);
        header.extend_from_slice(&bytes_24(self.size.0 - 1));
        header.extend_from_slice(&bytes_24(self.size.1 - 1));
        if !self.is_still {
            // A transparent ground, and no end of the repetitions.
            header.extend_from_slice(b"ANIM\x06\0\0\0\0\0\0\0\0\0");
        }
        self.sink.seek(SeekFrom::Start(0))?;
        self.sink.write_all(&header)?;
        self.sink.flush()
    }
}

/// One image as a WebP file of its own.
fn encode(pixels: &[[u8; 4]], size: (u32, u32), is_opaque: bool) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let encoder = WebPEncoder::new_lossless(Cursor::new(&mut file));
    let encoded = if is_opaque {
        let colors: Vec<u8> = pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        encoder.encode(&colors, size.0, size.1, ExtendedColorType::Rgb8)
    } else {
        encoder.encode(pixels.as_flattened(), size.0, size.1, ExtendedColorType::Rgba8)
    };
    encoded.map_err(io::Error::other)?;
    Ok(file)
}

/// The length of a chunk in 32 bits.
fn length_of(bytes: u64) -> io::Result<[u8; 4]> {
    let length = u32::try_from(bytes).map_err(|_| {
        io::Error::other("a WebP file holds at most 4 GiB; write .mp4 or .apng, or fewer frames")
    })?;
    Ok(length.to_le_bytes())
}

/// The lowest 24 bits.
fn bytes_24(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::webp::WebPDecoder;
    use image::{AnimationDecoder as _, ImageDecoder as _};

    fn file(frames: &[Vec<[u8; 4]>]) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let mut animation = WebpAnimation::new(&mut file, (3, 2), frames.len() as u32).unwrap();
        for (index, frame) in frames.iter().enumerate() {
            animation.add(frame, 40 + index as u32).unwrap();
        }
        animation.finish().unwrap();
        file.into_inner()
    }

    fn decoder(bytes: &[u8]) -> WebPDecoder<Cursor<&[u8]>> {
        WebPDecoder::new(Cursor::new(bytes)).unwrap()
    }

    #[test]
    fn frames_are_exact_and_keep_their_durations() {
        let frame = |seed: u8, alpha: u8| (0..6).map(|i| [seed, 37 * i, 255 - seed, alpha]).collect();
        let frames: [Vec<[u8; 4]>; 3] = [frame(1, 255), frame(90, 128), frame(200, 0)];
        let bytes = file(&frames);
        assert_eq!(bytes.len() as u64, 8 + u64::from(u32::from_le_bytes(bytes[4..8].try_into().unwrap())));
        let decoded = decoder(&bytes).into_frames().collect_frames().unwrap();
        assert_eq!(decoded.len(), 3);
        for (index, (decoded, frame)) in decoded.iter().zip(&frames).enumerate() {
            assert_eq!(decoded.buffer().as_raw().as_slice(), frame.as_flattened());
            assert_eq!(decoded.delay().numer_denom_ms(), (40 + index as u32, 1));
        }
        assert!(decoder(&bytes).color_type().has_alpha());
    }

    #[test]
    fn opaque_frames_make_an_opaque_file_and_one_frame_an_image() {
        let opaque = vec![[9, 8, 7, 255]; 6];
        let two = file(&[opaque.clone(), opaque.clone()]);
        assert!(decoder(&two).has_animation() && !decoder(&two).color_type().has_alpha());
        let one = file(&[opaque]);
        assert!(!decoder(&one).has_animation());
        assert_eq!(&one[30..34], b"VP8L");
    }
}
