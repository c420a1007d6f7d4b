//! Import options.

use std::path::PathBuf;

use crate::asset_cache::AssetCache;

/// Options of an import.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportOptions {
    /// Memory limit of the imported scene, posed triangles included, bytes. A scene that needs more is refused before
    /// the memory is allocated.
    pub max_memory_bytes: u64,
    /// How far the images of textures are loaded.
    pub images: ImageLoading,
    /// Folders outside the scene's own whose files it may refer to.
    pub allowed_folders: Vec<PathBuf>,
}

/// How far the images of textures are loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImageLoading {
    /// Decode the images.
    #[default]
    Texels,
    /// Read headers only, and check that decoding would stay within the memory limit.
    Budget,
    /// Read headers only. Sizes are known, texels are not.
    Headers,
}

/// Where texels come from.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageSource<'a> {
    /// How far images are loaded.
    pub(super) loading: ImageLoading,
    /// Keeps what was decoded.
    pub(super) cache: Option<&'a AssetCache>,
}

impl Default for ImportOptions {
    /// Limit of four gibibytes; images are decoded.
    fn default() -> Self {
        Self { max_memory_bytes: 4 << 30, images: ImageLoading::Texels, allowed_folders: Vec::new() }
    }
}
