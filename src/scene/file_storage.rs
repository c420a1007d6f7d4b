//! How a file stores its content: sizes, formats and attributes, which the imported scene no longer shows; and how its import used the asset cache.

use serde::Serialize;

/// Sizes and formats of a file's content as stored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileStorage {
    /// The program that wrote the file, as it names itself.
    pub generator: Option<String>,
    /// Bytes of the scene file and of the files that were read with it, each counted once.
    pub file_bytes: u64,
    /// Bytes of all buffers as stored, before decompression.
    pub buffer_bytes: u64,
    /// Bytes of the vertices, morph targets and indices of all meshes, in their stored formats, decompressed.
    pub geometry_bytes: u64,
    /// Bytes of all keyframes, in their stored formats, decompressed.
    pub keyframe_bytes: u64,
    /// Encoded images, by [`super::ImageIndex`].
    pub images: Vec<StoredImage>,
    /// Vertex attributes with their formats, such as `NORMAL int8 normalized`, by mesh and primitive of the file. Primitives of
    /// points and lines, which are not imported, have entries, too.
    pub attributes: Vec<Vec<Vec<String>>>,
}

/// How often an import found texels or mip levels in the asset cache. Images that are too small for it do not count.
/// Equal images share an entry, so that counts of a first run may depend on which thread comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct AssetCacheUse {
    /// Entries that were read.
    pub hits: u32,
    /// Entries that were not there, or damaged.
    pub misses: u32,
}

/// An encoded image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredImage {
    /// `PNG`, `JPEG`, `WebP` or `KTX2`.
    pub format: &'static str,
    /// Bytes of the encoded image.
    pub bytes: u64,
}
