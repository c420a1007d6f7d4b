//! Content of a frame's files: AOVs as channels, attributes, tone-mapped images.
//!
//! Works on a film and a frame, whatever rendered them. Does not know where files are written.

mod aov;
mod attributes;
mod band_files;
mod bitmap_font;
mod channels;
mod contact_sheet;
mod cryptomatte;
mod exposure;
mod exr_output;
mod files;
mod instance_ids;
mod labelled_sheet;
mod stamp;
mod sum_channels;

pub use aov::{Aov, AovSet};
pub use attributes::{SOFTWARE, frame_attributes, ndc_from_camera};
pub use band_files::ExrBandFiles;
pub use channels::summed_channels;
pub use channels::{DEPTH_WITHOUT_HIT, SCENE_CHANNELS};
pub use contact_sheet::ContactSheet;
pub use cryptomatte::matte_collisions;
pub use exposure::{
    AUTO_EXPOSURE_BOUNDS, auto_exposure_ev, covers_enough, emission_ev, measured_light_stops,
};
pub use exr_output::{ExrOutput, LightSamples};
pub use files::{ExrFiles, PreviewLook, display_image, exr_file, exr_files, exr_image, png_file};
pub use instance_ids::InstanceIds;
pub use labelled_sheet::{LabelledSheet, LabelledTile};
pub use stamp::run_stamp;
pub(crate) use stamp::{host_name, universal_time_now};
pub use sum_channels::{sum_channels, sum_flags, sums_of_image};
