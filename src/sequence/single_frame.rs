//! One posed frame rendered to a film in memory, outside the frame loop.

use crate::bvh::Builder;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::Film;
use crate::frame::Frame;
use crate::render::{RenderSettings, RenderStatistics, SceneView, render_frame};

use super::SequenceJob;
use super::environment_shares::environment_shares;

/// Renders `frame`, the scene of `job` at one time, with `settings` instead of the job's own. There is no shutter, and
/// pixel-centre samples are not recorded.
///
/// # Errors
/// [`Cancelled`] when `cancel` is raised.
pub fn render_single_frame(
    job: &SequenceJob,
    frame: &Frame,
    settings: &RenderSettings,
    cancel: &CancelFlag,
) -> Result<(Film, RenderStatistics), Cancelled> {
    let environment_shares = environment_shares(job, &job.selection, settings, cancel)?;
    if environment_shares.is_some() {
        // The measured scene, beside `frame`
        job.first_pose.clear();
    }
    let settings = RenderSettings { environment_shares, ..settings.clone() };
    let bvh = Builder::default().build(&frame.triangles, &frame.flags, &job.build, cancel, None)?;
    let SequenceJob { scene, environment, .. } = job;
    render_frame(&SceneView { scene, frame, bvh: &bvh, environment }, &settings, cancel, &|_| ())
}
