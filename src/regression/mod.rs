//! Pictures against pictures: measures of how they differ, limits on them, and a folder of scenes against references.
//!
//! [`compare`] compares two [`Image`]s and gives every measure with its [limit](Limits): [identity](are_identical),
//! [values](ChannelDifference), [mean squares](RootMeanSquare), [FLIP](FlipMap) and its [pools](PooledErrors), what is
//! [not finite](NonFinite), and the likely [cause](Cause).
//!
//! A [`suite`] is a folder of shots with references, which are rendered as on the command line, compared, and settled by a person.
//!
//! Nothing is printed here.

mod cause;
mod channel_difference;
mod comparison;
mod comparison_text;
mod exact;
mod flip;
mod heat_map;
mod non_finite;
mod pooling;
mod presets;
mod report_page;
mod root_mean_square;
mod sequence_files;
mod shift;
pub mod suite;

pub use crate::image::{BEAUTY, Channel, ColorEncoding, Image, Samples, layer_of};
pub use cause::{Cause, likely_cause};
pub use channel_difference::{ChannelDifference, ValueLimits, channel_difference};
pub use comparison::{Check, Comparison, LayerDifference, Mismatch, compare};
pub use exact::{are_identical, pixel_hash};
pub use flip::{ExposureRange, FlipMap, PIXELS_PER_DEGREE, flip_display, flip_light};
pub use heat_map::{heat_map, magma};
pub use non_finite::{NonFinite, non_finite};
pub use pooling::{PooledErrors, pool};
pub use presets::{Limits, Preset};
pub use report_page::{
    EncodedImage, FolderSummary, FrameCommands, FrameStatus, IMAGE_BUDGET_BYTES, ImageBudget, ReportPage,
    ReportedFrame, ReportedShot, check_report_place, write_report,
};
pub use root_mean_square::{RootMeanSquare, root_mean_square};
pub use sequence_files::{FilePair, PairedFiles, frame_number, is_sequence, pair_files};
pub use shift::{Shift, best_shift};
