//! What [`EnvSamples::Auto`] traces of the light of the environment: one value for a whole animation, whatever frames are rendered. By each frame alone, surfaces
//! would change their brightness as the camera comes to a window, or a door opens.

use rayon::prelude::*;

use crate::bvh::{BuildSettings, Builder, TriangleFlags};
use crate::cancel::{CancelFlag, Cancelled};
use crate::frame::Frame;
use crate::geometry::Aabb;
use crate::render::{EnvSamples, EnvironmentShares, Integrator, SceneView};
use crate::scene::Selection;

use super::SequenceJob;
use super::job::duration_seconds;
use super::measured_times::{measured_times, times_of};

/// Triangles of one task.
const TRIANGLES_PER_TASK: usize = 16_384;

/// The shares of every frame of `selection`: those of the settings, or the mean of those at times of the whole animation. `None` where nothing moves, or none are needed.
///
/// Takes the scene of [`SequenceJob::first_pose`], poses it anew, and leaves it there.
///
/// # Errors
/// [`Cancelled`] when `cancel` is raised.
pub(super) fn environment_shares(
    job: &SequenceJob,
    selection: &Selection,
    cancel: &CancelFlag,
) -> Result<Option<EnvironmentShares>, Cancelled> {
    let given = job.render.environment_shares;
    if given.is_some() || !is_measured(job, selection) {
        return Ok(given);
    }
    if let Some(known) = job.known_shares.get(&job.scene, selection) {
        return Ok(Some(known));
    }
    let shares = measured(job, selection, cancel)?;
    job.known_shares.add(&job.scene, selection, shares);
    Ok(Some(shares))
}

/// Whether the camera may see more or less of an environment with the time.
fn is_measured(job: &SequenceJob, selection: &Selection) -> bool {
    job.render.integrator == Integrator::Whitted
        && job.render.env_samples == EnvSamples::Auto
        && job.environment.is_lit()
        && duration_seconds(&job.scene, selection) > 0.0
}

fn measured(
    job: &SequenceJob,
    selection: &Selection,
    cancel: &CancelFlag,
) -> Result<EnvironmentShares, Cancelled> {
    let scene = &job.scene;
    let first = job.first_pose.take(scene, selection, 0.0);
    let mut frame = first.unwrap_or_else(|| Frame::at(scene, selection, 0.0));
    let mut bounds = bounds_of(&frame);
    let (mut builder, mut recycled, mut bvh) = (Builder::default(), None, None);
    let mut shares = Vec::new();
    let count = times_of(frame.triangles.len(), 1);
    for time_seconds in measured_times(f64::from(duration_seconds(scene, selection)), count) {
        cancel.check()?;
        if frame.pose_again(scene, selection, time_seconds) {
            bounds = bounds_of(&frame);
            recycled = bvh.take().or(recycled);
        }
        let position = frame.camera.world_from_camera.w_axis.truncate();
        // Half of all directions lead away from a box.
        if !bounds.contains(&Aabb::from_points(&[position])) {
            shares.push(EnvironmentShares::ALL);
            continue;
        }
        let built = match bvh.take() {
            Some(bvh) => bvh,
            // The few rays pay for no better tree.
            None => builder.build(
                &frame.triangles,
                &frame.flags,
                &BuildSettings { expected_rays: 0, ..job.build },
                cancel,
                recycled.take(),
            )?,
        };
        let view = SceneView { scene, frame: &frame, bvh: &built, environment: &job.environment };
        shares.push(EnvironmentShares::seen_from(view, position));
        bvh = Some(built);
    }
    job.first_pose.put(frame, scene, selection);
    Ok(EnvironmentShares::mean(&shares))
}

/// The box around all triangles. A hidden one may have corners that are not finite.
fn bounds_of(frame: &Frame) -> Aabb {
    let triangles = frame.triangles.par_iter().zip(&frame.flags).with_min_len(TRIANGLES_PER_TASK);
    let visible = triangles.filter(|(_, flags)| !flags.has(TriangleFlags::HIDDEN));
    visible.map(|(triangle, _)| Aabb::from_points(&triangle.vertices)).reduce(|| Aabb::EMPTY, Aabb::union)
}
