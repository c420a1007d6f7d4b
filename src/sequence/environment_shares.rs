//! What [`EnvSamples::Auto`] traces of the light of the environment, and what stands for the rest: one value for a whole animation, whatever frames are rendered. By each frame alone, surfaces
//! would change their brightness as the camera comes to a window, or a door opens.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;
use serde_json::json;

use crate::bvh::{TriangleFlags, is_traced};
use crate::cancel::{CancelFlag, Cancelled};
use crate::frame::Frame;
use crate::geometry::{Aabb, Triangle};
use crate::render::{EnvSamples, EnvironmentShares, Integrator, RenderSettings, SharesOfTime};
use crate::scene::{Environment, ImageLightPose, Selection};

use super::SequenceJob;
use super::measured_scene::MeasuredScene;
use super::measured_times::{MeasuredSpan, TIMES, times_of};

/// Triangles that are posed in all where more than the fewest times are measured.
const POSED_TRIANGLES: usize = 1_000_000;
/// Triangles of one task. Sums are taken in blocks of this size, whatever the number of threads.
const BLOCK: usize = 8192;
/// Number of this rule in render hashes.
const RULE: u32 = 5;
/// Share of all directions that surfaces cover at most where no ray has to find what is open.
const MOST_COVERED: f32 = 1.0 - EnvironmentShares::OPEN - 0.01;

/// The shares of every frame of `selection` with `settings`: those of the settings, or those of times of the whole animation together. `None` where nothing moves, or
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
    if !is_measured(job, selection, settings) {
        return Ok(settings.environment_shares.clone());
    }
    let lit_scene = (&job.scene, &job.environment);
    if let Some(known) = job.known_shares.get(lit_scene, selection) {
        return Ok(Some(known));
    }
    let shares = measured(job, selection, cancel)?;
    job.known_shares.add(lit_scene, selection, shares.clone());
    Ok(Some(shares))
}

/// Whether the shares are those of a whole animation, which scene, selection and environment decide.
fn is_measured(job: &SequenceJob, selection: &Selection, settings: &RenderSettings) -> bool {
    settings.environment_shares.is_none()
        && settings.integrator == Integrator::Whitted
        && settings.env_samples == EnvSamples::Auto
        && job.environment.is_lit()
        && MeasuredSpan::of(&job.scene, selection).moves()
}

/// What render hashes hold of measured shares; `None` where none are.
pub(super) fn measured_key(job: &SequenceJob) -> Option<serde_json::Value> {
    let SequenceJob { selection, render, .. } = job;
    let measured = || {
        if is_scaled(job, selection) {
            json!(["measured", RULE, "scaled"])
        } else {
            json!(["measured", RULE])
        }
    };
    is_measured(job, selection, render).then(measured)
}

/// Whether the environment is an image-based light whose intensity is animated.
fn is_scaled(job: &SequenceJob, selection: &Selection) -> bool {
    selection.scales_image_light(&job.scene) && job.environment.posed(&ImageLightPose::IDENTITY).is_some()
}

/// From 0 where the camera of `selection` is in the open, or in a space without any opening, to 1 where it is in a closed space, on average over its animation.
///
/// Takes and leaves the first pose as [`environment_shares`] does.
///
/// # Errors
/// [`Cancelled`] when `cancel` is raised.
pub(super) fn closed_share(
    job: &SequenceJob,
    selection: &Selection,
    cancel: &CancelFlag,
) -> Result<f32, Cancelled> {
    let shares = match job.known_shares.get((&job.scene, &job.environment), selection) {
        Some(known) => known,
        None => measured(job, selection, cancel)?,
    };
    Ok(shares.enclosed.map_or(0.0, |_| 1.0 - shares.occluded))
}

fn measured(
    job: &SequenceJob,
    selection: &Selection,
    cancel: &CancelFlag,
) -> Result<EnvironmentShares, Cancelled> {
    let mut scene = MeasuredScene::of_positions(job, selection);
    let span = MeasuredSpan::of(&job.scene, selection);
    let count =
        if span.moves() { times_of(scene.frame().triangles.len(), POSED_TRIANGLES, TIMES[1]) } else { 1 };
    let is_scaled = is_scaled(job, selection);
    let mut times = Vec::new();
    for time_seconds in span.times(count) {
        cancel.check()?;
        scene.pose(time_seconds);
        let position = scene.frame().camera.world_from_camera.w_axis.truncate();
        if is_open(scene.frame(), position) {
            times.push(SharesOfTime::ALL);
            continue;
        }
        let pose = scene.frame().image_light;
        let mut shares_in = |intensity: Option<f32>| -> Result<SharesOfTime, Cancelled> {
            let environment = posed_environment(&job.environment, pose, intensity);
            Ok(SharesOfTime::seen_from(scene.view(&environment, cancel)?, position))
        };
        times.push(if is_scaled {
            shares_in(Some(1.0))?.with_dark(shares_in(Some(0.0))?)
        } else {
            shares_in(None)?
        });
    }
    let shares = EnvironmentShares::of_times(&times);
    scene.leave_in(&job.first_pose);
    Ok(shares)
}

/// The environment with its animated image-based light at `pose`, if it has one, but with the `intensity` that is given.
fn posed_environment(
    environment: &Environment,
    pose: Option<ImageLightPose>,
    intensity: Option<f32>,
) -> Environment {
    let posed = pose.and_then(|pose| {
        let intensity = intensity.unwrap_or(pose.intensity);
        environment.posed(&ImageLightPose { intensity, ..pose })
    });
    posed.unwrap_or_else(|| environment.clone())
}

/// Whether triangles cover so little around `point` that no ray has to find what is open.
fn is_open(frame: &Frame, point: Vec3) -> bool {
    is_outside(frame, point) || covered_share(frame, point) < MOST_COVERED
}

/// Whether `point` is outside of the box of all triangles, which then cover half of all directions at most.
fn is_outside(frame: &Frame, point: Vec3) -> bool {
    let of_block = |(triangles, flags): (&[Triangle], &[TriangleFlags])| {
        let traced = triangles.iter().zip(flags).filter(|(triangle, flags)| is_traced(triangle, **flags));
        traced.fold(Aabb::EMPTY, |bounds, (triangle, _)| bounds.union(triangle.bounds()))
    };
    let blocks = frame.triangles.par_chunks(BLOCK).zip(frame.flags.par_chunks(BLOCK));
    let bounds = blocks.map(of_block).reduce(|| Aabb::EMPTY, Aabb::union);
    !bounds.contains(&Aabb { min: point, max: point })
}

/// Share of all directions around `point` that triangles cover, or more where some cover the same.
fn covered_share(frame: &Frame, point: Vec3) -> f32 {
    let blocks = frame.triangles.par_chunks(BLOCK).zip(frame.flags.par_chunks(BLOCK));
    let solid_angle = |(triangle, flags): (&Triangle, &TriangleFlags)| {
        if is_traced(triangle, *flags) { triangle.signed_solid_angle(point).abs() } else { 0.0 }
    };
    let of_block = |(triangles, flags): (&[Triangle], &[TriangleFlags])| -> f32 {
        triangles.iter().zip(flags).map(solid_angle).sum()
    };
    let covered: Vec<f32> = blocks.map(of_block).collect();
    covered.iter().sum::<f32>() / (4.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_cover_their_solid_angles() {
        let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        let square = |corners: [Vec3; 4]| {
            let [a, b, c, d] = corners;
            [[a, b, c], [a, c, d]].map(|vertices| Triangle { vertices })
        };
        let mut frame = Frame::default();
        // A floor of two kilometres, one metre below: almost half.
        let far = 1000.0;
        let floor = [(-far, -far), (far, -far), (far, far), (-far, far)];
        frame.triangles.extend(square(floor.map(|(x, z)| corner(x, -1.0, z))));
        frame.flags = vec![TriangleFlags::default(); 2];
        let covered = covered_share(&frame, Vec3::ZERO);
        assert!((covered - 0.5).abs() < 0.001, "{covered}");
        // A face of a cube around the point, many times: a sixth each, whichever side is seen.
        let face = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| corner(x, y, 1.0));
        let back = [face[3], face[2], face[1], face[0]];
        for _ in 0..BLOCK {
            frame.triangles.extend(square(face).into_iter().chain(square(back)));
        }
        frame.flags.resize(frame.triangles.len(), TriangleFlags::default());
        let covered = covered_share(&frame, Vec3::ZERO);
        assert!((covered / (0.5 + BLOCK as f32 / 3.0) - 1.0).abs() < 0.001, "{covered}");
        frame.flags.fill(TriangleFlags::HIDDEN);
        assert_eq!(covered_share(&frame, Vec3::ZERO), 0.0);
    }

    #[test]
    fn points_are_outside_of_the_box_of_what_is_traced() {
        let triangle =
            |z: f32| Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + z) };
        let mut frame = Frame::default();
        frame.triangles = vec![triangle(0.0), triangle(2.0)];
        frame.flags = vec![TriangleFlags::default(); 2];
        let is_outside =
            |frame: &Frame| [-0.1, 0.0, 0.5, 2.5, 3.1].map(|x| is_outside(frame, Vec3::splat(x)));
        assert_eq!(is_outside(&frame), [true, false, false, true, true]);
        frame.flags[1] = TriangleFlags::HIDDEN;
        assert_eq!(is_outside(&frame), [true, false, true, true, true]);
        assert_eq!(is_outside(&Frame::default()), [true; 5]);
    }
}
