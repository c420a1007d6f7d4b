//! Many frames: which ones, under which names, in which order, and what happens when one fails.
//!
//! A [`SequenceJob`] says what is meant. [`Plan::new`] finds everything that can go wrong without rendering, [`run`]
//! renders. The terminal is unknown here: progress leaves as [`SequenceEvent`]s.

mod event;
mod existing;
mod exposure;
mod film_of;
mod frame_loop;
mod frames;
mod job;
mod memory;
mod notes;
mod pattern;
mod plan;
mod posed_frames;
mod presentation;
mod rate;
mod render_hash;
mod shutter;
mod statistics;
mod writer;

pub use event::SequenceEvent;
pub use existing::ExistingFiles;
pub use exposure::exposure_ev;
pub use film_of::film_of;
pub use frame_loop::run;
pub use frames::FrameSpec;
pub use job::{Exposure, SequenceJob, duration_seconds, triangle_count};
pub use memory::check_picture;
pub use pattern::{OutputFormat, OutputPattern};
pub use plan::{Plan, PlannedFrame, ReplacedFile};
pub use presentation::{Presentation, find_look, present, shown};
pub use rate::FrameRate;
pub(crate) use render_hash::hex;
pub use render_hash::render_hash;
pub use shutter::Shutter;
pub use statistics::{AovFileReport, FailedFrame, FrameReport, Phases, RayReport, Summary, TreeReport};
