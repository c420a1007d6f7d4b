//! Texture decoding: PNG, JPEG, WebP and KTX2 files to texels. Headers give the size before anything is decoded.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use image::codecs::{jpeg::JpegDecoder, png::PngDecoder, webp::WebPDecoder};
use image::metadata::Orientation;
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, Limits};

use super::ktx2;
use super::texture_format::{ImageFormat, ImageHeader, image_format};

/// Images up to this many texels are decoded whatever the size of their file.
const UNCHECKED_TEXELS: u64 = 8192 * 8192;
/// Largest number of texels per byte of the file for larger images.
const MAX_TEXELS_PER_BYTE: u64 = 64;

/// Largest number of texels per byte of a JPEG: each block of 64 samples takes a bit or more, and one sample stands for 16 texels at most.
const MAX_JPEG_TEXELS_PER_BYTE: u64 = 8 * 64 * 16;

/// Most texels along a side of an image.
const MAX_SIDE: u32 = 1 << 16;

/// Row-major RGBA texels, top row first, as stored in the file: sRGB values are not decoded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum DecodedTexels {
    /// Eight bits per channel.
    Rgba8(Vec<[u8; 4]>),
    /// Sixteen bits per channel.
    Rgba16(Vec<[u16; 4]>),
}

/// Error message for a PNG that is refused by its size, before its decoder is opened. The decoder's own limits would give less clear
/// messages.
pub(crate) fn png_size_refusal(bytes: &[u8]) -> Option<String> {
    // The first chunk is the header: 8 bytes of magic, length and name, then width and height.
    let field = |start: usize| -> Option<u32> {
        let bytes = bytes.get(start..)?.first_chunk::<4>()?;
        Some(u32::from_be_bytes(*bytes))
    };
    let header = ImageHeader { width: field(16)?, height: field(20)?, texel_bytes: 4, decoded_bytes: 0 };
    if image_format(bytes) == ImageFormat::Png { size_refusal(&header, bytes.len()) } else { None }
}

/// Reads the header of a PNG, JPEG, WebP or KTX2.
pub(crate) fn image_header(bytes: &[u8]) -> Result<ImageHeader, String> {
    if image_format(bytes) == ImageFormat::Ktx2 {
        return ktx2::header(bytes);
    }
    let (size, color) = with_decoder(bytes, |decoder| Ok((decoder.dimensions(), decoder.color_type())))?;
    let (width, height) = size;
    if width == 0 || height == 0 {
        return Err(format!("has {width}x{height} texels"));
    }
    let texels = u64::from(width).saturating_mul(u64::from(height));
    let max_jpeg_texels = (bytes.len() as u64).saturating_mul(MAX_JPEG_TEXELS_PER_BYTE);
    if image_format(bytes) == ImageFormat::Jpeg && texels > max_jpeg_texels {
        return Err(format!(
            "states {width}x{height} texels in {} bytes; the file is truncated",
            bytes.len()
        ));
    }
    let texel_bytes = if is_deep(color) { 8 } else { 4 };
    Ok(ImageHeader { width, height, texel_bytes, decoded_bytes: texels.saturating_mul(texel_bytes) })
}

/// Error message for an image that is refused by its size: a decompression bomb, which is large while its file is very small in comparison,
/// or one with too many texels along a side.
pub(crate) fn size_refusal(header: &ImageHeader, file_bytes: usize) -> Option<String> {
    let ImageHeader { width, height, .. } = *header;
    let texels = u64::from(width).saturating_mul(u64::from(height));
    let max_texels = (file_bytes as u64).saturating_mul(MAX_TEXELS_PER_BYTE);
    if texels > UNCHECKED_TEXELS && texels > max_texels {
        return Some(format!(
            "unpacks {file_bytes} bytes to {width}x{height} texels, which looks like a decompression bomb; store a smaller image"
        ));
    }
    (width.max(height) > MAX_SIDE).then(|| {
        format!(
            "has {width}x{height} texels, more than the limit of {MAX_SIDE} along a side; store a smaller image"
        )
    })
}

/// Decodes a PNG, JPEG, WebP or KTX2 as stored, whatever its EXIF orientation, which glTF ignores. A truncated file is an error.
pub(crate) fn decode_texels(bytes: &[u8]) -> Result<DecodedTexels, String> {
    if image_format(bytes) == ImageFormat::Ktx2 {
        return ktx2::decode(bytes).map(DecodedTexels::Rgba8);
    }
    decode_image(bytes).map(into_decoded)
}

/// Decodes a PNG, JPEG or WebP as viewers show it: upright by its EXIF orientation. A truncated file is an error.
pub(crate) fn decode_upright_texels(bytes: &[u8]) -> Result<DecodedTexels, String> {
    let mut image = decode_image(bytes)?;
    image.apply_orientation(orientation(bytes)?);
    Ok(into_decoded(image))
}

/// Columns and rows of what [`decode_upright_texels`] decodes from a file with `header`.
pub(crate) fn upright_size(bytes: &[u8], header: &ImageHeader) -> Result<(u32, u32), String> {
    Ok(match orientation(bytes)? {
        Orientation::Rotate90
        | Orientation::Rotate270
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => (header.height, header.width),
        _ => (header.width, header.height),
    })
}

/// The EXIF orientation of a PNG, JPEG or WebP. A file without one is upright.
fn orientation(bytes: &[u8]) -> Result<Orientation, String> {
    with_decoder(bytes, |decoder| match decoder {
        Decoder::Png(mut png) => png.orientation(),
        Decoder::Jpeg(mut jpeg) => jpeg.orientation(),
        Decoder::WebP(mut webp) => webp.orientation(),
    })
}

fn decode_image(bytes: &[u8]) -> Result<DynamicImage, String> {
    let is_complete = match image_format(bytes) {
        ImageFormat::Jpeg => jpeg_is_complete(bytes),
        ImageFormat::WebP => webp_is_complete(bytes),
        _ => true,
    };
    if !is_complete {
        return Err("ends early; the file is truncated".to_owned());
    }
    with_decoder(bytes, |decoder| match decoder {
        Decoder::Png(png) => DynamicImage::from_decoder(*png),
        Decoder::Jpeg(jpeg) => DynamicImage::from_decoder(*jpeg),
        Decoder::WebP(webp) => DynamicImage::from_decoder(*webp),
    })
}

/// The texels of an image in its precision, as codes.
pub(super) fn into_decoded(image: DynamicImage) -> DecodedTexels {
    if is_deep(image.color()) {
        DecodedTexels::Rgba16(into_texels(&image.into_rgba16()))
    } else {
        DecodedTexels::Rgba8(into_texels(&image.into_rgba8()))
    }
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
        if image_format(bytes) == ImageFormat::Png {
            let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits())?;
            return Ok(Decoder::Png(Box::new(decoder)));
        }
        if image_format(bytes) == ImageFormat::WebP {
            let mut decoder = WebPDecoder::new(Cursor::new(bytes))?;
            decoder.set_limits(limits())?;
            return Ok(Decoder::WebP(Box::new(decoder)));
        }
        let mut decoder = JpegDecoder::new(Cursor::new(bytes))?;
        decoder.set_limits(limits())?;
        Ok(Decoder::Jpeg(Box::new(decoder)))
    };
    // Third-party decoders may panic. Turn that into an error.
    match catch_unwind(AssertUnwindSafe(|| open().and_then(use_decoder))) {
        Ok(decoded) => decoded.map_err(|error: ImageError| {
            let text = error.to_string();
            format!("cannot be decoded: {}", text.lines().next().unwrap_or_default())
        }),
        Err(_) => Err("cannot be decoded".to_owned()),
    }
}

/// Limits of the decoders. Callers have checked the image size in the header; these bound all other memory.
fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(4 << 30);
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
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

/// Whether an end marker follows the entropy-coded data of a JPEG. Decoders accept a file without one and fill the rest
/// with grey.
fn jpeg_is_complete(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    let mut position = 2_usize;
    // Skip the marker segments before the first scan. Thumbnails in them have their own end markers.
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

/// Whether a WebP has the length that its header states. The last byte, which is padding, may be missing.
fn webp_is_complete(bytes: &[u8]) -> bool {
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
    fn eight_and_sixteen_bit_images_keep_their_depth() {
        let file = png(2, 1, &[1, 2, 3, 4, 5, 6, 7, 8], ExtendedColorType::Rgba8);
        assert_eq!(decode_texels(&file), Ok(DecodedTexels::Rgba8(vec![[1, 2, 3, 4], [5, 6, 7, 8]])));
        // One opaque 16-bit grey texel.
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
    fn lossless_and_lossy_webp_are_decoded() {
        let lossless = include_bytes!("../../tests/streams/chequer.webp");
        let header = image_header(lossless).unwrap();
        assert_eq!((header.width, header.height, header.decoded_bytes), (32, 16, 2048));
        let Ok(DecodedTexels::Rgba8(texels)) = decode_texels(lossless) else {
            panic!("not eight bits");
        };
        assert_eq!(
            [texels[0], texels[4], texels[511]],
            [[233, 200, 125, 255], [59, 92, 142, 255], [233, 200, 125, 255]]
        );
        let lossy = include_bytes!("../../tests/streams/lossy.webp");
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
    fn the_size_of_a_jpeg_is_bounded_by_its_data() {
        let mut file = jpeg(8, 8, &[128; 192]);
        assert!(image_header(&file).is_ok());
        // The frame header holds its length, the precision, then height and width.
        let frame = file.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
        file[frame + 5..frame + 9].copy_from_slice(&[0x04, 0x00, 0xff, 0xff]);
        let refusal = image_header(&file).unwrap_err();
        assert!(refusal.contains("65535x1024") && refusal.contains("truncated"), "{refusal}");
    }

    #[test]
    fn headers_are_read_without_decoding() {
        let file = png(3, 2, &[0; 18], ExtendedColorType::Rgb8);
        let header = image_header(&file).unwrap();
        assert_eq!((header.width, header.height, header.decoded_bytes), (3, 2, 24));
        let bomb = ImageHeader { width: 16000, height: 8000, texel_bytes: 4, decoded_bytes: 512_000_000 };
        assert!(size_refusal(&bomb, 500_000).is_some_and(|why| why.contains("decompression bomb")));
        assert_eq!(size_refusal(&bomb, 5_000_000), None);
    }

    #[test]
    fn long_images_are_refused_with_size_and_limit() {
        for (width, height, is_refused) in [(65536, 1, false), (65537, 1, true), (1, 70000, true)] {
            let file = png(width, height, &vec![9; (width * height) as usize], ExtendedColorType::L8);
            let size = format!("has {width}x{height} texels, more than the limit of 65536");
            let refusal = png_size_refusal(&file);
            assert_eq!(refusal.is_some_and(|why| why.contains(&size)), is_refused, "{size}");
            assert_eq!(decode_texels(&file).is_err(), is_refused);
        }
    }
}
