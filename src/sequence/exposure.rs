//! The exposure of tone-mapped files, fixed over the animation whatever frames are asked for.

use crate::bvh::TriangleFlags;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, Film, PixelWindow};
use crate::frame::Frame;
use crate::output::{auto_exposure_ev, covers_enough};
use crate::render::RenderSettings;

use super::job::duration_seconds;
use super::{Exposure, SequenceJob, film_of};

/// Size of the renders that are looked at.
const LOOK_SIZE: (u32, u32) = (64, 36);
/// Times that are looked at, from the animation's first to its last.
const LOOK_TIMES: u32 = 5;

/// The exposure of tone-mapped files in stops.
///
/// # Errors
/// [`Cancelled`] when `cancel` was raised.
pub fn exposure_ev(job: &SequenceJob, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    match job.exposure {
        Exposure::Ev(ev) => Ok(ev),
        Exposure::Auto => auto_exposure(job, cancel),
    }
}

/// What is drawn decides, whatever is behind it, unless that is most of what there is to see.
fn auto_exposure(job: &SequenceJob, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    let drawn = look(job, false, cancel)?;
    if covers_enough(&drawn) || !job.render.show_background {
        return Ok(auto_exposure_ev(&drawn));
    }
    Ok(auto_exposure_ev(&look(job, true, cancel)?))
}

/// Small pictures of the animation.
fn look(job: &SequenceJob, show_background: bool, cancel: &CancelFlag) -> Result<Vec<Film>, Cancelled> {
    let settings = RenderSettings {
        resolution: LOOK_SIZE,
        window: PixelWindow::full(LOOK_SIZE.0, LOOK_SIZE.1),
        samples: 1,
        aovs: AovFlags::NONE,
        show_background,
        ..job.render.clone()
    };
    let duration = f64::from(duration_seconds(&job.scene, &job.selection));
    let times = if duration > 0.0 { LOOK_TIMES } else { 1 };
    let mut films = Vec::new();
    for step in 0..times {
        let time_seconds = duration * f64::from(step) / f64::from(LOOK_TIMES - 1);
        let mut frame = Frame::at(&job.scene, &job.selection, time_seconds);
        hide_shadow_catchers(&mut frame);
        films.push(film_of(job, &frame, &settings, cancel)?.0);
    }
    Ok(films)
}

/// Catchers have no light of their own to measure, and stand in nobody's way.
fn hide_shadow_catchers(frame: &mut Frame) {
    for (flags, &instance) in frame.flags.iter_mut().zip(&frame.instance_of_triangle) {
        let material = frame.instances[instance as usize].material;
        if frame.materials[material.index()].is_shadow_catcher {
            *flags = flags.with(TriangleFlags::HIDDEN);
        }
    }
}
