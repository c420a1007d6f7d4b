//! Texture formats, recognised by the first bytes of a file, and the header of a texture.

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_MAGIC: &[u8] = &[0xff, 0xd8, 0xff];

/// Format of an image file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ImageFormat {
    /// PNG.
    Png,
    /// JPEG, baseline or progressive.
    Jpeg,
    /// WebP, lossless or lossy. Of an animation, the first frame.
    WebP,
    /// KTX2. Only Basis Universal data can be decoded.
    Ktx2,
    /// Recognised but unsupported; holds the name of the format.
    Other(&'static str),
    /// Unknown.
    Unknown,
}

impl ImageFormat {
    /// Name for reports.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::Ktx2 => "KTX2",
            Self::Other(name) => name,
            Self::Unknown => "unknown",
        }
    }
}

/// Header of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImageHeader {
    /// Columns.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// Bytes of a decoded texel: 4, or 8 with sixteen bits per channel.
    pub(crate) texel_bytes: u64,
    /// Memory that decoding takes, bytes.
    pub(crate) decoded_bytes: u64,
}

/// Recognises the format of `bytes` by their beginning. Declared media types are often wrong and are not used.
pub(crate) fn image_format(bytes: &[u8]) -> ImageFormat {
    let at = |start: usize, magic: &[u8]| bytes.get(start..).is_some_and(|rest| rest.starts_with(magic));
    if at(0, PNG_MAGIC) {
        ImageFormat::Png
    } else if at(0, JPEG_MAGIC) {
        ImageFormat::Jpeg
    } else if at(0, b"RIFF") && at(8, b"WEBP") {
        ImageFormat::WebP
    } else if at(0, b"\xabKTX 20\xbb\r\n\x1a\n") {
        ImageFormat::Ktx2
    } else if at(0, b"DDS ") {
        ImageFormat::Other("DDS")
    } else if at(4, b"ftypavif") {
        ImageFormat::Other("AVIF")
    } else if at(0, b"GIF8") {
        ImageFormat::Other("GIF")
    } else if at(0, b"BM") {
        ImageFormat::Other("BMP")
    } else {
        ImageFormat::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_recognised_by_the_first_bytes() {
        assert_eq!(image_format(b"RIFF\x10\0\0\0WEBPVP8 "), ImageFormat::WebP);
        assert_eq!(image_format(b"GIF89a"), ImageFormat::Other("GIF"));
        assert_eq!(image_format(&[0xff, 0xd8, 0xff, 0xe0]), ImageFormat::Jpeg);
        assert_eq!(image_format(b""), ImageFormat::Unknown);
        assert_eq!(image_format(b"<svg"), ImageFormat::Unknown);
    }
}
