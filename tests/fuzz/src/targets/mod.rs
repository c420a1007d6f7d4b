//! What each target does with its input.

pub(crate) mod bvh;
pub(crate) mod compare;
pub(crate) mod decoders;
pub(crate) mod image_files;
pub(crate) mod render;
pub(crate) mod scene_files;
pub(crate) mod text_files;
