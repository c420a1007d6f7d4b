//! Image comparison and regression suites.
//!
//! [`compare`] compares an [`Image`] with its reference. A [`Comparison`] holds every measure with its [limit](Limits):
//! [identity](are_identical), [differences of values](ChannelDifference), [root mean square error](RootMeanSquare),
//! [FLIP](FlipMap) and its [pooled errors](PooledErrors), values that are [not finite](NonFinite), and the likely [cause](Cause).
//!
//! A [`suite`] is a folder of shots with reference images. Its shots are rendered as by `rayframe render` and compared; a person
//! accepts or rejects the differences. A [`Verdict`] tells identical images from changed and failed ones. [`SuiteResult`] is the tree of results from which page, JSON and JUnit are written.
//!
//! Nothing here prints.

mod cause;
mod cause_materials;
mod changes;
mod channel_difference;
mod color_checks;
mod common_form;
mod compare;
mod comparison;
mod encoded_image;
mod exact;
mod flip;
mod folder_files;
mod heat_map;
mod layer_limits;
mod matte_difference;
mod non_finite;
mod pooling;
mod presets;
mod report_page;
mod result;
mod root_mean_square;
mod sequence_files;
mod shift;
pub mod suite;
mod thumbnail;
mod verdict;

pub use crate::image::{BEAUTY, Channel, ColorEncoding, Image, Samples, layer_of};
pub use cause::{Cause, likely_cause};
pub(crate) use channel_difference::renumbering;
pub use channel_difference::{ChannelDifference, LayerDifference, ValueLimits, channel_difference};
pub use compare::{compare, compare_with_each};
pub use comparison::{Check, Comparison, Mismatch};
pub use encoded_image::EncodedImage;
pub use exact::{are_identical, pixel_hash};
pub use flip::{Exposures, FlipMap, PIXELS_PER_DEGREE, flip_display};
pub use folder_files::all_files_below;
pub use heat_map::{heat_map, magma};
pub use non_finite::{NonFinite, non_finite};
pub use pooling::{ObjectError, PooledErrors, pool, pool_objects};
pub use presets::{Limits, Preset};
pub use report_page::{
    AssetChanges, ChangeGroup, ChangeRow, FolderSummary, FrameCommands, IMAGE_BUDGET_BYTES, ImageBudget,
    NamedCommand, ReportPage, check_report_place, write_report,
};
pub use result::{FrameResult, FrameStatus, ShotResult, SuiteResult};
pub use root_mean_square::{RootMeanSquare, root_mean_square};
pub use sequence_files::{
    FilePair, PairedFiles, frame_number, is_sequence, pair_files, readable_sequence_files, sequence_files,
};
pub use shift::{Shift, best_shift};
pub use thumbnail::{heat_map_thumbnail, thumbnail};
pub use verdict::{FailOn, Verdict, VerdictCounts};
