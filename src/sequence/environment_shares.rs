//! What [`EnvSamples::Auto`] traces of the light of the environment: one value for a whole animation, whatever frames are rendered. By each frame alone, surfaces
//! would change their brightness as the camera comes to a window, or a door opens.

use rayon::prelude::*;

use crate::bvh::TriangleFlags;
use crate::cancel::{CancelFlag, Cancelled};
use crate::frame::Frame;
use crate::geometry::Aabb;
use crate::render::{EnvSamples, EnvironmentShares, Integrator, RenderSettings};
use crate::scene::Selection;

use super::SequenceJob;
use super::measured_scene::MeasuredScene;
use super::measured_times::{measured_seconds, measured_times, times_of};

/// Triangles of one task.
const TRIANGLES_PER_TASK: usize = 16_384;

/// The shares of every frame of `selection` with `settings`: those of the settings, or the mean of those at times of the whole animation. `None` where nothing moves, or
/// none are needed.
///
/// Takes the scene of [`SequenceJob::first_pose`], poses it anew, and leaves it there.
///
/// # Errors
/// [`Cancelled`] when `cancel` is raised.
pub(super) fn environment_shares(
    job: &SequenceJob,
    selection: &Selection,
    settings: &RenderSettings,
    cancel: &CancelFlag,
) -> Result<Option<EnvironmentShares>, Cancelled> {
    let is_measured = settings.integrator == Integrator::Whitted
        && settings.env_samples == EnvSamples::Auto
        && job.environment.is_lit()
        && measured_seconds(&job.scene, selection) > 0.0;
    if settings.environment_shares.is_some() || !is_measured {
        return Ok(settings.environment_shares);
    }
    if let Some(known) = job.known_shares.get(&job.scene, selection) {
        return Ok(Some(known));
    }
    let shares = measured(job, selection, cancel)?;
    job.known_shares.add(&job.scene, selection, shares);
    Ok(Some(shares))
}

fn measured(
    job: &SequenceJob,
    selection: &Selection,
    cancel: &CancelFlag,
) -> Result<EnvironmentShares, Cancelled> {
    let mut scene = MeasuredScene::new(job, selection);
    let mut bounds = bounds_of(scene.frame());
    let count = times_of(scene.frame().triangles.len(), 1);
    let mut shares = Vec::new();
    for time_seconds in measured_times(measured_seconds(&job.scene, selection), count) {
        cancel.check()?;
        if scene.pose(time_seconds) {
            bounds = bounds_of(scene.frame());
        }
        let position = scene.frame().camera.world_from_camera.w_axis.truncate();
        // Half of all directions lead away from a box.
        let is_outside = !bounds.contains(&Aabb::from_points(&[position]));
        shares.push(if is_outside {
            EnvironmentShares::ALL
        } else {
            EnvironmentShares::seen_from(scene.view(&job.environment, cancel)?, position)
        });
    }
    scene.leave_in(&job.first_pose);
    Ok(EnvironmentShares::mean(&shares))
}

/// The box around all triangles. A hidden one may have corners that are not finite.
fn bounds_of(frame: &Frame) -> Aabb {
    let triangles = frame.triangles.par_iter().zip(&frame.flags).with_min_len(TRIANGLES_PER_TASK);
    let visible = triangles.filter(|(_, flags)| !flags.has(TriangleFlags::HIDDEN));
    visible.map(|(triangle, _)| Aabb::from_points(&triangle.vertices)).reduce(|| Aabb::EMPTY, Aabb::union)
}
