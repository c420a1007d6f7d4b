//! Exposure of tone-mapped files: one value for the whole animation, whatever frames are rendered.

use crate::bvh::TriangleFlags;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, Film, PixelWindow};
use crate::frame::Frame;
use crate::output::{auto_exposure_ev, covers_enough};
use crate::render::{PathSettings, RenderSettings};
use crate::scene::Selection;
use crate::uneven::uneven_shares;

use super::job::duration_seconds;
use super::{Exposure, SequenceJob, render_single_frame};

/// Columns and rows of the renders that are measured.
const SIZE: (u32, u32) = (64, 36);
/// Fewest and most measured times of an animation, its first and last among them.
const TIMES: [usize; 2] = [5, 17];
/// Number of posed triangles up to which more than the fewest times are measured.
const POSED_TRIANGLES: usize = 4_000_000;
/// Times of all clips that share an exposure.
const SHARED_TIMES: usize = 16 * TIMES[1];

/// Exposure of tone-mapped files in stops. Automatic exposure renders a few small frames, unless the studio alone lights the
/// scene; [`super::run`] computes it once and hands it on.
///
/// # Errors
/// [`Cancelled`] when `cancel` is raised.
pub fn exposure_ev(job: &SequenceJob, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    match job.exposure {
        Exposure::Ev(ev) => Ok(ev),
        Exposure::Auto => match &job.shared_exposure {
            Some(shared) => shared.find(|| auto_exposure(job, &shared.selections, cancel)),
            None => auto_exposure(job, std::slice::from_ref(&job.selection), cancel),
        },
    }
}

/// Measures the light on the scene's surfaces; where these cover next to nothing, that of the background. An environment that
/// was made for an exposure and lights the scene alone decides instead.
fn auto_exposure(job: &SequenceJob, selections: &[Selection], cancel: &CancelFlag) -> Result<f32, Cancelled> {
    let has_lamps = job.render.light_scale > 0.0 && job.selection.has_lights(&job.scene);
    if let Some(ev) = job.environment.exposure_ev().filter(|_| !has_lamps) {
        return Ok(ev);
    }
    let surfaces = small_renders(job, selections, false, cancel)?;
    if covers_enough(&surfaces) || !job.render.show_background {
        return Ok(auto_exposure_ev(&surfaces));
    }
    Ok(auto_exposure_ev(&small_renders(job, selections, true, cancel)?))
}

fn small_renders(
    job: &SequenceJob,
    selections: &[Selection],
    show_background: bool,
    cancel: &CancelFlag,
) -> Result<Vec<Film>, Cancelled> {
    let settings = RenderSettings {
        resolution: SIZE,
        window: PixelWindow::full(SIZE.0, SIZE.1),
        samples: 1,
        adaptive: None,
        // Base colours and emission, which a background does not have.
        aovs: AovFlags { centers: !show_background, light: !show_background, ..AovFlags::NONE },
        show_background,
        // Shadows alone tell nothing about the light.
        ground: None,
        path: PathSettings { sample_range: None, ..job.render.path },
        ..job.render.clone()
    };
    job.first_pose.clear();
    let mut films = Vec::new();
    for selection in selections {
        let duration = f64::from(duration_seconds(&job.scene, selection));
        let mut measure = |time_seconds: f64| {
            let mut frame = Frame::at(&job.scene, selection, time_seconds);
            hide_shadow_catchers(&mut frame);
            films.push(render_single_frame(job, &frame, &settings, cancel)?.0);
            Ok(frame.triangles.len())
        };
        let triangles = measure(0.0)?;
        if duration > 0.0 {
            let [fewest, most] = TIMES;
            let most = (SHARED_TIMES / selections.len()).clamp(fewest, most);
            let count = (POSED_TRIANGLES / triangles.max(1)).clamp(fewest, most);
            // A lamp may have any period. Few times may still miss one.
            let shares = uneven_shares(count - 2).chain([1.0]);
            shares.map(|share| measure(duration * share)).collect::<Result<Vec<_>, _>>()?;
        }
    }
    Ok(films)
}

/// Hides shadow catchers, which reflect no light of their own to measure and would block the view of what does.
fn hide_shadow_catchers(frame: &mut Frame) {
    for (flags, &instance) in frame.flags.iter_mut().zip(&frame.instance_of_triangle) {
        let material = frame.instances[instance as usize].material;
        if frame.materials[material.index()].is_shadow_catcher {
            *flags = flags.with(TriangleFlags::HIDDEN);
        }
    }
}
