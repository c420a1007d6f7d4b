//! What the files of one frame contain: which pixels, which attributes, and how a preview is made from them.
//!
//! Knows a film and a frame, not how they came to be, and not where files go.

mod aov;
mod attributes;
mod channels;
mod contact_sheet;
mod cryptomatte;
mod exposure;
mod exr_output;
mod files;
mod instance_ids;
mod stamp;

pub use aov::{Aov, AovSet};
pub use attributes::{SOFTWARE, frame_attributes, ndc_from_camera};
pub use channels::DEPTH_OF_NOTHING;
pub use contact_sheet::ContactSheet;
pub use cryptomatte::matte_collisions;
pub use exposure::{auto_exposure_ev, covers_enough};
pub use exr_output::{ExrOutput, LightSamples};
pub use files::{ExrFiles, PreviewLook, display_image, exr_file, exr_files, png_file};
pub use instance_ids::InstanceIds;
pub use stamp::run_stamp;
