//! Reading and writing of image files: OpenEXR, PNG, Radiance, textures and movies.
//!
//! Only this module uses the `image`, `png` and `exr` crates. It knows pixels and attributes, not what they mean. Files are
//! written atomically: a final name holds a whole file or the file that was there before.

mod any_format;
mod atomic;
mod display;
mod environment_read;
mod existing_output;
mod exr_attributes;
mod exr_bands;
mod exr_checksum;
mod exr_chunks;
mod exr_color_layer;
mod exr_color_names;
mod exr_compression;
mod exr_condensed;
mod exr_deflate;
mod exr_dwa;
mod exr_error;
mod exr_header;
mod exr_join;
mod exr_read;
mod exr_rgba;
mod exr_write;
mod ffmpeg;
mod film_encoder;
mod frame_delays;
mod gif_frames;
mod isolated;
mod job_list;
mod ktx2;
mod movie;
mod movie_mark;
mod plate_read;
mod png_text;
mod png_write;
mod radiance_header;
mod regular_file;
mod stored_frame;
mod texture_decode;
mod texture_format;
mod webp_animation;

pub(crate) use atomic::check_new_names;
pub(crate) use atomic::{begin_replacing, hidden_prefix, process_mark, write_atomically_unless};
pub use atomic::{check_name, probe_folder, remove_stale_temporaries, write_atomically, write_single_file};
pub use display::{DisplayImage, decode_png, decode_png_values, over};
pub use environment_read::{EnvironmentPixels, read_environment};
pub use existing_output::{
    CONTACT_SHEET, FLIP_MAP, HEAT_MAP, OutputKind, PAGE_MARK, SUMMARY_MARK, THUMBNAIL, check_output,
    is_empty_file, is_marked_png, is_output, other_image,
};
pub(crate) use existing_output::{
    check_existing, damaged_other_image, is_own_exr, may_be_damaged_exr, may_be_damaged_png,
};
pub use exr_attributes::{FrameAttributes, RunStamp, SAMPLE_RANGE};
pub use exr_bands::{ExrBands, WrittenExr};
pub use exr_checksum::{ExrIntegrity, verify_exr};
pub use exr_compression::ExrCompression;
pub use exr_header::{ExrHeader, ExrSampleType, SUM_LAYER, SharedAttributes};
pub(crate) use exr_join::join_encoded_tiles;
pub use exr_join::{ExrTile, encode_exr_like, join_exr_tiles};
pub use exr_read::decode_exr;
pub use exr_rgba::decode_exr_rgba;
pub use exr_write::encode_exr;
pub use ffmpeg::has_ffmpeg;
pub use job_list::{JOB_LIST, job_files};
pub use movie::{MOVIE_ENDINGS, MovieFormat, MovieWriter};
pub use plate_read::{PlateHeader, PlateImage, plate_header, read_plate};
pub use png_text::{insert_preview_hash, inspect_png};
pub use png_write::encode_png;
pub use regular_file::read_regular_file;
pub(crate) use regular_file::{MAX_POINTER_BYTES, check_fetched, is_pointer};
pub use stored_frame::{StoredFrame, inspect_exr, saved_by};
pub(crate) use texture_decode::{DecodedTexels, decode_texels, image_header, png_size_refusal, size_refusal};
pub(crate) use texture_format::{ImageFormat, ImageHeader, image_format};
