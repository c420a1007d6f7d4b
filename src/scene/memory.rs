//! Memory of a scene's data, as its import estimates it.

/// Memory of the data of a scene.
///
/// Scenes that were not imported have none: whoever made them has allocated it already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneMemory {
    /// Texels, mip maps, meshes and keyframes, which stay while frames are rendered, bytes. Texels count also where only the headers of
    /// images were read.
    pub kept_bytes: u64,
    /// Most bytes at any time of the import: the files, what is decoded from them and what that takes, and what is kept.
    pub import_bytes: u64,
}
