//! Compression methods of OpenEXR files that this program writes.

use exr::prelude::Compression;

/// Compression method of an OpenEXR file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExrCompression {
    /// No compression.
    None,
    /// Run-length encoding of bytes.
    Rle,
    /// Deflate over single scan lines.
    Zips,
    /// Deflate over 16 scan lines.
    #[default]
    Zip,
    /// Wavelets and Huffman codes over 32 scan lines; good for grain.
    Piz,
    /// Cosine transform over 32 scan lines; small and lossy.
    Dwaa,
    /// Cosine transform over 256 scan lines; small and lossy.
    Dwab,
}

impl ExrCompression {
    /// All methods.
    pub const ALL: [Self; 7] =
        [Self::None, Self::Rle, Self::Zips, Self::Zip, Self::Piz, Self::Dwaa, Self::Dwab];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
            Self::Dwaa => "dwaa",
            Self::Dwab => "dwab",
        }
    }

    /// Whether decoded samples may differ from encoded ones.
    pub fn is_lossy(self) -> bool {
        matches!(self, Self::Dwaa | Self::Dwab)
    }

    pub(super) fn for_exr(self) -> Compression {
        match self {
            Self::None => Compression::Uncompressed,
            Self::Rle => Compression::RLE,
            Self::Zips => Compression::ZIP1,
            Self::Zip => Compression::ZIP16,
            Self::Piz => Compression::PIZ,
            // `None` is OpenEXR's default level, 45.
            Self::Dwaa => Compression::DWAA(None),
            Self::Dwab => Compression::DWAB(None),
        }
    }
}
