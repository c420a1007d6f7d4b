//! The exposure of tone-mapped files, fixed over the animation whatever frames are asked for.

use crate::bvh::Builder;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{LayerRequest, PixelWindow};
use crate::frame::Frame;
use crate::output::auto_exposure_ev;
use crate::render::{RenderInput, RenderSettings, render_frame};

use super::job::duration_seconds;
use super::{Exposure, SequenceJob};

/// Size of the renders that are looked at.
const LOOK_SIZE: (u32, u32) = (64, 36);
/// Times that are looked at, from the animation's first to its last.
const LOOK_TIMES: u32 = 5;

/// The exposure in stops.
pub(super) fn exposure_ev(job: &SequenceJob, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    match job.exposure {
        Exposure::Ev(ev) => Ok(ev),
        Exposure::Auto => auto_exposure(job, cancel),
    }
}

fn auto_exposure(job: &SequenceJob, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    let settings = RenderSettings {
        resolution: LOOK_SIZE,
        window: PixelWindow::full(LOOK_SIZE.0, LOOK_SIZE.1),
        samples: 1,
        layers: LayerRequest::NONE,
        ..job.render.clone()
    };
    let duration = f64::from(duration_seconds(&job.scene, &job.selection));
    let times = if duration > 0.0 { LOOK_TIMES } else { 1 };
    let mut builder = Builder::default();
    let mut films = Vec::new();
    for step in 0..times {
        let time_seconds = duration * f64::from(step) / f64::from(LOOK_TIMES - 1);
        let frame = Frame::at(&job.scene, &job.selection, time_seconds);
        let bvh = builder.build(&frame.triangles, &frame.flags, &job.build, cancel, None)?;
        let input =
            RenderInput { scene: &job.scene, frame: &frame, bvh: &bvh, environment: &job.environment };
        films.push(render_frame(&input, &settings, cancel, &|_| ())?.0);
    }
    Ok(auto_exposure_ev(&films))
}
