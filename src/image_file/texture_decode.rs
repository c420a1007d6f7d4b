//! PNG, JPEG, WebP and KTX2 files to texels, with the size known before anything is decoded.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use image::codecs::{jpeg::JpegDecoder, png::PngDecoder, webp::WebPDecoder};
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, Limits};

use super::ktx2;

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_MAGIC: &[u8] = &[0xff, 0xd8, 0xff];

/// Images up to this many texels need no justification by the size of their file.
const FREE_TEXELS: u64 = 8192 * 8192;
/// Texels that each byte of a larger image's file justifies.
const TEXELS_PER_BYTE: u64 = 64;

/// What the first bytes of an image file say it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageKind {
    /// Portable network graphics.
    Png,
    /// JPEG, baseline or progressive.
    Jpeg,
    /// WebP, lossless or not; of an animation the first picture.
    WebP,
    /// KTX2; only Basis Universal data can be decoded.
    Ktx2,
    /// Recognized, by name, but not supported.
    Other(&'static str),
    /// Nothing that is known.
    Unknown,
}

/// Row-major RGBA texels, top row first, as the file stores them: not yet decoded from sRGB.
#[derive(Clone, Debug, PartialEq)]
pub enum DecodedTexels {
    /// Eight bits a channel.
    Rgba8(Vec<[u8; 4]>),
    /// Sixteen bits a channel.
    Rgba16(Vec<[u16; 4]>),
}

/// What the header of an image says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageHeader {
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes of a texel once decoded: 4, or 8 with sixteen bits a channel.
    pub texel_bytes: u64,
    /// Bytes that decoding takes.
    pub decoded_bytes: u64,
}

/// Tells what `bytes` are from their beginning; declared media types are often wrong.
pub fn image_kind(bytes: &[u8]) -> ImageKind {
    let at = |start: usize, magic: &[u8]| bytes.get(start..).is_some_and(|rest| rest.starts_with(magic));
    if at(0, PNG_MAGIC) {
        ImageKind::Png
    } else if at(0, JPEG_MAGIC) {
        ImageKind::Jpeg
    } else if at(0, b"RIFF") && at(8, b"WEBP") {
        ImageKind::WebP
    } else if at(0, b"\xabKTX 20\xbb\r\n\x1a\n") {
        ImageKind::Ktx2
    } else if at(0, b"DDS ") {
        ImageKind::Other("DDS")
    } else if at(4, b"ftypavif") {
        ImageKind::Other("AVIF")
    } else if at(0, b"GIF8") {
        ImageKind::Other("GIF")
    } else if at(0, b"BM") {
        ImageKind::Other("BMP")
    } else {
        ImageKind::Unknown
    }
}

/// Why `bytes` are not even opened: the decoder's own limit would otherwise tell it less clearly.
pub fn oversized_png(bytes: &[u8]) -> Option<String> {
    // The header chunk is always the first: 8 bytes of magic, length and name, then width and height.
    let field = |start: usize| -> Option<u32> {
        let bytes = bytes.get(start..)?.first_chunk::<4>()?;
        Some(u32::from_be_bytes(*bytes))
    };
    let header = ImageHeader { width: field(16)?, height: field(20)?, texel_bytes: 4, decoded_bytes: 0 };
    if image_kind(bytes) == ImageKind::Png { unjustified(&header, bytes.len()) } else { None }
}

/// Reads the header of a PNG, JPEG, WebP or KTX2.
pub fn image_header(bytes: &[u8]) -> Result<ImageHeader, String> {
    if image_kind(bytes) == ImageKind::Ktx2 {
        return ktx2::header(bytes);
    }
    let (size, color) = with_decoder(bytes, |decoder| Ok((decoder.dimensions(), decoder.color_type())))?;
    let (width, height) = size;
    if width == 0 || height == 0 {
        return Err(format!("has {width}x{height} texels"));
    }
    let texels = u64::from(width).saturating_mul(u64::from(height));
    let texel_bytes = if is_deep(color) { 8 } else { 4 };
    Ok(ImageHeader { width, height, texel_bytes, decoded_bytes: texels.saturating_mul(texel_bytes) })
}

/// Why an image of this size is not decoded, if its file is too small to justify it.
pub fn unjustified(header: &ImageHeader, file_bytes: usize) -> Option<String> {
    let texels = u64::from(header.width).saturating_mul(u64::from(header.height));
    let justified = (file_bytes as u64).saturating_mul(TEXELS_PER_BYTE);
    (texels > FREE_TEXELS && texels > justified).then(|| {
        format!(
            "unpacks {file_bytes} bytes to {}x{} texels, which looks like an attack on memory; store it smaller",
            header.width, header.height
        )
    })
}

/// Decodes a PNG, JPEG, WebP or KTX2 completely; a file that ends early is an error.
pub fn decode_texels(bytes: &[u8]) -> Result<DecodedTexels, String> {
    if image_kind(bytes) == ImageKind::Ktx2 {
        return ktx2::decode(bytes).map(DecodedTexels::Rgba8);
    }
    let is_whole = match image_kind(bytes) {
        ImageKind::Jpeg => jpeg_is_whole(bytes),
        ImageKind::WebP => webp_is_whole(bytes),
        _ => true,
    };
    if !is_whole {
        return Err("ends early; the file is truncated".to_owned());
    }
    let picture = with_decoder(bytes, |decoder| match decoder {
        Decoder::Png(png) => DynamicImage::from_decoder(*png),
        Decoder::Jpeg(jpeg) => DynamicImage::from_decoder(*jpeg),
        Decoder::WebP(webp) => DynamicImage::from_decoder(*webp),
    })?;
    Ok(if is_deep(picture.color()) {
        DecodedTexels::Rgba16(into_texels(&picture.into_rgba16()))
    } else {
        DecodedTexels::Rgba8(into_texels(&picture.into_rgba8()))
    })
}

fn into_texels<T: Copy>(channels: &[T]) -> Vec<[T; 4]> {
    let (texels, _) = channels.as_chunks::<4>();
    texels.to_vec()
}

enum Decoder<'a> {
    Png(Box<PngDecoder<Cursor<&'a [u8]>>>),
    Jpeg(Box<JpegDecoder<Cursor<&'a [u8]>>>),
    WebP(Box<WebPDecoder<Cursor<&'a [u8]>>>),
}

impl Decoder<'_> {
    fn dimensions(&self) -> (u32, u32) {
        match self {
            Self::Png(png) => png.dimensions(),
            Self::Jpeg(jpeg) => jpeg.dimensions(),
            Self::WebP(webp) => webp.dimensions(),
        }
    }

    fn color_type(&self) -> ColorType {
        match self {
            Self::Png(png) => png.color_type(),
            Self::Jpeg(jpeg) => jpeg.color_type(),
            Self::WebP(webp) => webp.color_type(),
        }
    }
}

fn with_decoder<'a, T>(
    bytes: &'a [u8],
    use_decoder: impl FnOnce(Decoder<'a>) -> Result<T, ImageError>,
) -> Result<T, String> {
    let open = || {
        if image_kind(bytes) == ImageKind::Png {
            let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits())?;
            return Ok(Decoder::Png(Box::new(decoder)));
        }
        if image_kind(bytes) == ImageKind::WebP {
            let mut decoder = WebPDecoder::new(Cursor::new(bytes))?;
            decoder.set_limits(limits())?;
            return Ok(Decoder::WebP(Box::new(decoder)));
        }
        let mut decoder = JpegDecoder::new(Cursor::new(bytes))?;
        decoder.set_limits(limits())?;
        Ok(Decoder::Jpeg(Box::new(decoder)))
    };
    // Decoders are someone else's: what they cannot cope with must not end the program.
    match catch_unwind(AssertUnwindSafe(|| open().and_then(use_decoder))) {
        Ok(decoded) => decoded.map_err(|error: ImageError| {
            let text = error.to_string();
            format!("cannot be decoded: {}", text.lines().next().unwrap_or_default())
        }),
        Err(_) => Err("cannot be decoded".to_owned()),
    }
}

/// Sizes are checked by the caller from the header; these bound what decoders do besides.
fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(4 << 30);
    limits.max_image_width = Some(1 << 16);
    limits.max_image_height = Some(1 << 16);
    limits
}

fn is_deep(color: ColorType) -> bool {
    matches!(
        color,
        ColorType::L16
            | ColorType::La16
            | ColorType::Rgb16
            | ColorType::Rgba16
            | ColorType::Rgb32F
            | ColorType::Rgba32F
    )
}

/// Whether the entropy-coded data of a JPEG is followed by its end marker; decoders forgive a missing one and fill up
/// with grey.
fn jpeg_is_whole(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    let mut position = 2_usize;
    // Step over the marker segments in front of the first scan; thumbnails in them have end markers of their own.
    while let Some(&[0xff, marker, high, low]) =
        bytes.get(position..).and_then(|rest| rest.first_chunk::<4>())
    {
        if marker == 0xff {
            position = position.saturating_add(1);
            continue;
        }
        let length = usize::from(u16::from_be_bytes([high, low]));
        position = position.saturating_add(2).saturating_add(length);
        if marker == START_OF_SCAN {
            break;
        }
    }
    let scan = bytes.get(position..).unwrap_or_default();
    scan.windows(2).any(|pair| pair == END_OF_IMAGE)
}

/// Whether a WebP is as long as it says; the last byte may be missing, which only pads.
fn webp_is_whole(bytes: &[u8]) -> bool {
    let length = bytes.get(4..).and_then(|rest| rest.first_chunk::<4>());
    let length = length.map_or(u32::MAX, |length| u32::from_le_bytes(*length)) as usize;
    length.saturating_add(8) <= bytes.len().saturating_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ExtendedColorType, ImageEncoder};

    fn png(width: u32, height: u32, channels: &[u8], color: ExtendedColorType) -> Vec<u8> {
        let mut file = Vec::new();
        image::codecs::png::PngEncoder::new(&mut file).write_image(channels, width, height, color).unwrap();
        file
    }

    fn jpeg(width: u32, height: u32, rgb: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        image::codecs::jpeg::JpegEncoder::new(&mut file)
            .write_image(rgb, width, height, ExtendedColorType::Rgb8)
            .unwrap();
        file
    }

    #[test]
    fn eight_and_sixteen_bits_keep_their_depth() {
        let file = png(2, 1, &[1, 2, 3, 4, 5, 6, 7, 8], ExtendedColorType::Rgba8);
        assert_eq!(decode_texels(&file), Ok(DecodedTexels::Rgba8(vec![[1, 2, 3, 4], [5, 6, 7, 8]])));
        // One 16-bit grey texel; opaque.
        let file = png(1, 1, &0x1234_u16.to_ne_bytes(), ExtendedColorType::L16);
        assert_eq!(decode_texels(&file), Ok(DecodedTexels::Rgba16(vec![[0x1234, 0x1234, 0x1234, 0xffff]])));
        let file = png(1, 1, &[9], ExtendedColorType::L8);
        assert_eq!(decode_texels(&file), Ok(DecodedTexels::Rgba8(vec![[9, 9, 9, 255]])));
    }

    #[test]
    fn truncated_files_are_errors_at_every_length() {
        let noise: Vec<u8> = (0..32_u32 * 32 * 3).map(|i| (i.wrapping_mul(2654435761) >> 24) as u8).collect();
        for file in [png(32, 32, &noise, ExtendedColorType::Rgb8), jpeg(32, 32, &noise)] {
            assert!(decode_texels(&file).is_ok());
            for length in (3..file.len() - 13).step_by(97) {
                assert!(decode_texels(&file[..length]).is_err(), "{length} of {}", file.len());
            }
        }
    }

    #[test]
    fn webp_is_decoded_with_and_without_loss() {
        let lossless = include_bytes!("../../tests/make_scenes/streams/chequer.webp");
        let header = image_header(lossless).unwrap();
        assert_eq!((header.width, header.height, header.decoded_bytes), (32, 16, 2048));
        let Ok(DecodedTexels::Rgba8(texels)) = decode_texels(lossless) else {
            panic!("not eight bits");
        };
        assert_eq!(
            [texels[0], texels[4], texels[511]],
            [[233, 200, 125, 255], [59, 92, 142, 255], [233, 200, 125, 255]]
        );
        let lossy = include_bytes!("../../tests/make_scenes/streams/lossy.webp");
        let Ok(DecodedTexels::Rgba8(near)) = decode_texels(lossy) else {
            panic!("not eight bits");
        };
        let difference = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).map(|i| a[i].abs_diff(b[i])).max().unwrap();
        let mean: f32 = texels.iter().zip(&near).map(|pair| f32::from(difference(pair))).sum::<f32>() / 512.0;
        assert!(mean < 30.0, "{mean}");
        for file in [&lossless[..], lossy] {
            for length in 12..file.len() - 1 {
                assert!(decode_texels(&file[..length]).is_err(), "{length} of {}", file.len());
            }
        }
    }

    #[test]
    fn headers_are_read_without_decoding() {
        let file = png(3, 2, &[0; 18], ExtendedColorType::Rgb8);
        let header = image_header(&file).unwrap();
        assert_eq!((header.width, header.height, header.decoded_bytes), (3, 2, 24));
        let bomb = ImageHeader { width: 16000, height: 8000, texel_bytes: 4, decoded_bytes: 512_000_000 };
        assert!(unjustified(&bomb, 500_000).is_some());
        assert!(unjustified(&bomb, 5_000_000).is_none());
    }

    #[test]
    fn kinds_come_from_the_first_bytes() {
        assert_eq!(image_kind(b"RIFF\x10\0\0\0WEBPVP8 "), ImageKind::WebP);
        assert_eq!(image_kind(b"GIF89a"), ImageKind::Other("GIF"));
        assert_eq!(image_kind(&[0xff, 0xd8, 0xff, 0xe0]), ImageKind::Jpeg);
        assert_eq!(image_kind(b""), ImageKind::Unknown);
        assert_eq!(image_kind(b"<svg"), ImageKind::Unknown);
    }
}
