//! How a file stores its content: sizes, formats and attributes, which the imported scene no longer shows.

/// Sizes and formats of a file's content as stored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileStorage {
    /// The program that wrote the file, as it names itself.
    pub generator: Option<String>,
    /// Bytes of the scene file and of every file that it names.
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

/// An encoded image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredImage {
    /// `PNG`, `JPEG`, `WebP` or `KTX2`.
    pub format: &'static str,
    /// Bytes of the encoded image.
    pub bytes: u64,
}
