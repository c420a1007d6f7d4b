//! A posed scene as a film in memory.

use crate::bvh::Builder;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::Film;
use crate::frame::Frame;
use crate::render::{RenderSettings, RenderStatistics, SceneView, render_frame};

use super::SequenceJob;

/// Renders `frame`, the scene of `job` at one time, with `settings` in place of the job's own. No shutter is open, and what the
/// middles of pixels show is not recorded.
///
/// # Errors
/// [`Cancelled`] when `cancel` was raised.
pub fn film_of(
    job: &SequenceJob,
    frame: &Frame,
    settings: &RenderSettings,
    cancel: &CancelFlag,
) -> Result<(Film, RenderStatistics), Cancelled> {
    let bvh = Builder::default().build(&frame.triangles, &frame.flags, &job.build, cancel, None)?;
    let input = SceneView { scene: &job.scene, frame, bvh: &bvh, environment: &job.environment };
    render_frame(&input, settings, cancel, &|_| ())
}
