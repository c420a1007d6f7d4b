//! Jobs of the shots of a suite.

use std::path::Path;

use super::Suite;
use crate::error::Result;
use crate::shot::{ShotJob, ShotRequest, shot_job};

/// The job of a shot file or a scene, with the settings that the suite has for all shots.
///
/// # Errors
/// Those of [`shot_job`].
pub(super) fn job_of(suite: &Suite, shot: &Path) -> Result<ShotJob> {
    shot_job(&ShotRequest { path: shot, suite: Some(&suite.file), overrides: &[] })
}
