//! Rendering of frame sequences: the frame loop, and files that exist already. Frame ranges and names of files are in [`crate::settings`].
//!
//! A [`SequenceJob`] holds all inputs. [`Plan::new`] checks everything that can be checked without rendering, and [`run`]
//! renders. Progress leaves as [`SequenceEvent`]s; nothing is printed here.

mod assemble;
mod banded_frame;
mod bands;
mod checkpoint;
mod clip_checksum;
mod collisions;
mod environment_shares;
mod event;
mod exposure;
mod file_stamp;
mod first_pose;
mod frame_claim;
mod frame_loop;
mod frame_tracer;
mod frame_warnings;
mod job;
mod joint_files;
mod kept_preview;
mod known_shares;
mod manifest;
mod measured_scene;
mod measured_times;
mod memory;
mod movie_output;
mod movie_settings;
mod other_files;
mod panic;
mod pass_clock;
mod plan;
mod plates;
mod posed_frames;
mod render_hash;
mod render_hashes;
mod resume;
mod run_lock;
mod scene_content;
mod scene_parts;
mod sequence_outputs;
mod shared_exposure;
mod single_frame;
mod statistics;
mod stored_frame;
mod writer;

pub use crate::canonical_path::canonical;
pub use crate::sha256::{hex, sha256_of_file};
pub use assemble::{display_frame, write_sequence_outputs};
pub use bands::lowest_band;
pub(crate) use clip_checksum::clip_checksum;
pub use collisions::{UsedNames, is_plate, without_case};
pub use event::{FrameProgress, SequenceEvent};
pub use exposure::exposure_ev;
pub use first_pose::FirstPose;
pub use frame_loop::run;
pub(crate) use frame_tracer::{FrameStatistics, FrameTracer};
pub(crate) use frame_warnings::FrameWarnings;
pub use job::{SequenceJob, duration_seconds, triangle_count};
pub use known_shares::KnownShares;
pub use manifest::{ListedFile, Manifest};
pub use memory::{
    PixelMemory, check_framing_memory, check_image_memory, check_whole_frames, estimated_bytes,
};
pub use other_files::{check_other_files, prepare_other_files};
pub(crate) use pass_clock::FIRST_SAMPLES;
pub use plan::{Plan, PlannedFrame};
pub use plates::Plates;
pub(crate) use render_hashes::RenderHashes;
pub use render_hashes::render_hash;
pub use resume::ReplacedFile;
pub use run_lock::RunLock;
pub use sequence_outputs::SequenceOutputs;
pub use shared_exposure::SharedExposure;
pub use single_frame::render_single_frame;
pub use statistics::{AovFileReport, FailedFrame, FrameReport, Phases, RayReport, Summary, TreeReport};

pub use crate::settings::{
    ExistingFiles, Exposure, FrameRate, FrameSpec, OutputFormat, OutputPattern, Shutter, frames_text,
};
