//! Pictures against pictures: measures of how they differ, limits on them, and a folder of scenes against references.
//!
//! [`judge`] compares two [`LayeredPicture`]s and gives every measure with its [limit](Limits): [identity](are_identical),
//! [values](ChannelDifference), [mean squares](RootMeanSquare), [FLIP](FlipMap) and its [pools](PooledErrors), what is
//! [not finite](NonFinite), and the likely [cause](Cause).
//!
//! [`run`] finds the [`Shot`]s of a [`Suite`], renders each and compares it with its reference by [`compare`]. A missing,
//! different or dangling reference is a failure; so is an accepted one, so that a run that wrote something never passes
//! for one that checked it. A picture that differs is written beside its difference to the suite's report folder.
//!
//! Nothing is printed here, and time, if a clip moves, is frame / 24 s as on the command line.

mod cause;
mod channel_difference;
mod compare;
mod exact;
mod flip;
mod heat_map;
mod judgement;
mod layered_picture;
mod non_finite;
mod picture;
mod pooling;
mod presets;
mod render;
mod report_page;
mod root_mean_square;
mod sequence_files;
mod shift;
mod shots;
pub mod suite;
mod surroundings;

pub use cause::{Cause, likely_cause};
pub use channel_difference::{ChannelDifference, ValueLimits, channel_difference};
pub use compare::{Differences, Tolerance, Verdict, compare};
pub use exact::{are_identical, pixel_hash};
pub use flip::{ExposureRange, FlipMap, PIXELS_PER_DEGREE, flip_display, flip_light};
pub use heat_map::{heat_map, magma};
pub use judgement::{Check, Fault, Judgement, LayerDifference, judge};
pub use layered_picture::{BEAUTY, ChannelValues, LayeredPicture, NamedChannel, ValueRange, layer_of};
pub use non_finite::{NonFinite, non_finite};
pub use picture::Picture;
pub use pooling::{PooledErrors, pool};
pub use presets::{Limits, Preset};
pub use render::SceneRenderer;
pub use report_page::{
    EncodedPicture, FolderSummary, FrameStatus, PICTURE_BUDGET_BYTES, ReportPage, ReportedFrame,
    ReportedShot, write_report,
};
pub use root_mean_square::{RootMeanSquare, root_mean_square};
pub use sequence_files::{FilePair, PairedFiles, frame_number, is_sequence, pair_files};
pub use shift::{Shift, best_shift};
pub use shots::{Shot, discover};

/// Frames a second of all suites.
const FRAMES_PER_SECOND: i32 = 24;
