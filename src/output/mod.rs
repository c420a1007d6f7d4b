//! What the files of one frame contain: which pixels, which attributes, and how a preview is made from them.
//!
//! Knows a film and a frame, not how they came to be, and not where files go.

mod attributes;
mod channels;
mod contact_sheet;
mod cryptomatte;
mod exposure;
mod exr_output;
mod layer;
mod picture;
mod shape_ids;
mod stamp;

pub use attributes::{SOFTWARE, frame_attributes, ndc_from_camera};
pub use channels::DEPTH_OF_NOTHING;
pub use contact_sheet::ContactSheet;
pub use cryptomatte::matte_collisions;
pub use exposure::{auto_exposure_ev, covers_enough};
pub use exr_output::{ExrOutput, LightSamples};
pub use layer::{Layer, LayerSet};
pub use picture::{ExrFiles, PreviewLook, display_picture, exr_file, exr_files, png_file};
pub use shape_ids::ShapeIds;
pub use stamp::run_stamp;
