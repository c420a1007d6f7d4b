//! Shots: a scene with settings, from a shot file, a suite or the command line, resolved into a [`SequenceJob`].
//!
//! [`ShotSettings::merge`] merges the levels of [`crate::settings`], [`resolve()`] loads the scene and the environment and
//! decides what depends on them. docs/shots.md describes shot files.
//!
//! [`SequenceJob`]: crate::sequence::SequenceJob

mod camera_path;
mod catchers;
pub(crate) mod default_views;
pub mod environment;
mod import_options;
mod ineffective;
mod job;
pub mod memory_limit;
mod named_images;
mod outline;
mod render_settings;
mod resolve;
mod resolved_settings;
mod sequence_names;
mod shot_settings;
mod view;

pub use environment::LoadedEnvironments;
pub use job::{
    ShotJob, ShotRequest, ViewSettings, check_suite_settings, scene_of_shot, shot_job, shot_jobs,
    shot_outlines,
};
pub use named_images::NamedImages;
pub use outline::{SequenceOutline, ShotOutline};
pub use resolve::{RenderJob, check_shot, resolve, resolve_each};
pub(crate) use resolve::{load_scene, resolve_scene};
pub use resolved_settings::resolved_settings;
pub use sequence_names::SequenceNames;
pub(crate) use shot_settings::check_warnings;
pub use shot_settings::{ShotSettings, is_shot, refusal};
