//! A shot as it is rendered for a suite: its file's settings over the suite's.

use std::path::Path;

use crate::error::{Error, Result, Warning};
use crate::sequence::SequenceJob;

/// Which shot is meant, and what is said about it elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct ShotRequest<'a> {
    /// A shot file `.toml`, or a scene.
    pub path: &'a Path,
    /// A suite file, whose table `[shot]` holds settings that count where the shot says nothing.
    pub suite: Option<&'a Path>,
    /// `KEY=VALUE`, which count before the shot's own.
    pub overrides: &'a [String],
}

/// What is to be rendered, and what is to be said about it.
#[derive(Debug)]
pub struct ShotJob {
    /// What `rayframe render` would do.
    pub sequence: SequenceJob,
    /// What is not honoured. Under `strict` these are errors.
    pub warnings: Vec<Warning>,
}

/// Reads a shot file or a scene, and understands all settings as `rayframe render` does.
///
/// # Errors
/// Those of a command line, of a shot file, and of loading the scene.
pub fn shot_job(request: &ShotRequest<'_>) -> Result<ShotJob> {
    Err(Error::Internal { message: format!("{} is not read yet", request.path.display()) })
}
