//! What the files of one frame contain: which pixels, which attributes, and how a preview is made from them.
//!
//! Knows a film and a frame, not how they came to be, and not where files go.

mod attributes;
mod contact_sheet;
mod exposure;
mod picture;

pub use attributes::{SOFTWARE, frame_attributes, ndc_from_camera};
pub use contact_sheet::ContactSheet;
pub use exposure::{auto_exposure_ev, covers_enough};
pub use picture::{PreviewLook, display_picture, exr_file, png_file};
