//! Reading and writing images, and files that are either whole or not there.
//!
//! The only room that names the `image`, `png` and `exr` crates. It knows pixels and attributes, not what they mean.

mod atomic;
mod display;
mod environment_read;
mod exr_attributes;
mod exr_channels;
mod exr_header;
mod exr_join;
mod exr_picture;
mod exr_read;
mod exr_write;
mod ktx2;
mod movie;
mod png_text;
mod png_write;
mod texture_decode;

pub use atomic::{check_name, probe_folder, remove_stale_temporaries, write_atomically};
pub use display::{DisplayImage, DisplayValues, decode_png, decode_png_values};
pub use environment_read::{EnvironmentPixels, read_environment};
pub use exr_attributes::{FrameAttributes, RunStamp};
pub use exr_channels::decode_exr_channels;
pub use exr_header::{ExrHeader, ExrSampleType, ExrWindow, SharedAttributes};
pub use exr_join::{ExrTile, join_exr_tiles};
pub use exr_picture::{ExrChannel, ExrCompression, ExrPicture, ExrSamples, finite_f32, half_from_f32};
pub use exr_read::{ExrImage, decode_exr, inspect_exr};
pub use exr_write::{encode_exr, encode_exr_picture};
pub use movie::{MOVIE_ENDINGS, MovieFormat, MovieWriter, has_ffmpeg};
pub use png_text::inspect_png;
pub use png_write::encode_png;
pub use texture_decode::{
    DecodedTexels, ImageHeader, ImageKind, decode_texels, image_header, image_kind, oversized_png,
    unjustified,
};

/// A rectangle of linear pixels with premultiplied alpha, somewhere in a picture.
#[derive(Clone, Copy, Debug)]
pub struct RgbaPixels<'a> {
    /// Columns and rows of the whole picture (the EXR display window).
    pub picture_size: (u32, u32),
    /// Column and row of the first pixel held.
    pub origin: (u32, u32),
    /// Columns and rows held (the EXR data window).
    pub size: (u32, u32),
    /// Row-major R, G, B, A, top row first; `size.0 · size.1` of them.
    pub pixels: &'a [[f32; 4]],
}

/// What a whole file on disk says about itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredFrame {
    /// What it was made from; `None` when it does not say.
    pub render_hash: Option<String>,
    /// Columns and rows of the whole picture.
    pub picture_size: (u32, u32),
    /// Column and row of the first pixel held.
    pub origin: (i64, i64),
    /// Columns and rows held.
    pub size: (u32, u32),
}
