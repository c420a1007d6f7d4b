//! Shadows of the environment in moving scenes with closed spaces: their share is that of the whole animation.

use std::path::Path;
use std::sync::Arc;

use glam::{Mat4, Vec3};
use rayframe::cancel::CancelFlag;
use rayframe::frame::Frame;
use rayframe::image::Image;
use rayframe::render::{EnvSamples, EnvironmentShares};
use rayframe::scene::{
    AnimationTarget, Environment, LocalTransform, Material, NodeIndex, Projection, SelectedCamera, Turntable,
};
use rayframe::sequence::{FrameRate, KnownShares, Plan, SequenceJob, render_hash, render_single_frame, run};

use crate::stage::{Stage, animate, lambert, rectangle, sequence_job};

const ALBEDO: f32 = 0.5;

/// World from camera space of one at `eye` that looks at `target`.
pub(crate) fn camera_at(eye: Vec3, target: Vec3) -> Mat4 {
    let backward = (eye - target).normalize();
    let (right, up) = backward.any_orthonormal_pair();
    Mat4::from_cols(right.extend(0.0), up.extend(0.0), backward.extend(0.0), eye.extend(1.0))
}

/// A garage of four metres with a wall that slides up to its ceiling from 0 s to 1 s, in white light. The camera in the middle looks at the floor.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn garage(output: &Path) -> SequenceJob {
    let mut stage = Stage::new();
    let walls = Material { double_sided: true, ..lambert(Vec3::splat(ALBEDO)) };
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    for (center, u, v) in [(z, x, y), (-z, x, y), (x, y, z), (-x, y, z), (y, x, z), (-y, x, z)] {
        stage.add(rectangle(center, u, v), walls.clone());
    }
    animate(&mut stage.scene, AnimationTarget::Translation(NodeIndex(0)), &[0.0; 3], &[0.0, 4.0, 0.0]);
    let world_from_camera = camera_at(Vec3::ZERO, Vec3::new(0.0, -2.0, -1.0));
    let projection =
        Projection::Perspective { fov_y_radians: 0.5, aspect_ratio: None, z_near: 0.0, z_far: None };
    let camera = SelectedCamera::Fixed { world_from_camera, projection };
    let mut job = sequence_job(stage.scene, camera, (4, 4), output);
    job.environment = Environment::Constant(Vec3::ONE);
    job.rate = FrameRate::parse("4").unwrap();
    job.render.samples = 256;
    job
}

/// Mean radiance of the image at `time_seconds`.
#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
pub(crate) fn brightness(job: &SequenceJob, time_seconds: f64) -> f32 {
    let frame = Frame::at(&job.scene, &job.selection, time_seconds);
    let (film, _) = render_single_frame(job, &frame, &job.render, &CancelFlag::new()).unwrap();
    film.pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / film.pixels.len() as f32
}

#[test]
fn an_opening_door_darkens_nothing() {
    let job = garage(Path::new("unused.exr"));
    let brightness = [0.0, 0.25, 0.5, 0.75, 1.0].map(|time| brightness(&job, time));
    assert!(brightness.is_sorted(), "{brightness:?}");
    // Some light arrives as if nothing were in between, and some only by the door.
    assert!(brightness[0] > 0.1 * ALBEDO && brightness[4] < 0.9 * ALBEDO, "{brightness:?}");
    assert!(brightness[4] > 1.03 * brightness[0], "{brightness:?}");
}

#[test]
fn scenes_that_do_not_move_are_seen_by_each_frame() {
    let mut job = garage(Path::new("unused.exr"));
    job.selection.clips.clear();
    assert!((brightness(&job, 0.0) - ALBEDO).abs() < 1e-5);
    // Settings may say what is traced.
    job.render.environment_shares = Some(EnvironmentShares::ALL);
    let all = brightness(&job, 0.0);
    job.render.environment_shares = None;
    job.render.env_samples = EnvSamples::Fixed(1);
    assert_eq!(all, brightness(&job, 0.0));
}

#[test]
fn a_turntable_changes_no_surface() {
    // The wall is open. The camera turns about the middle of the floor, from the opening to the opposite wall and back.
    let mut job = garage(Path::new("unused.exr"));
    job.selection.clips.clear();
    let node = &mut Arc::make_mut(&mut job.scene).nodes[0];
    node.local = LocalTransform::Matrix(Mat4::from_translation(Vec3::Y * 4.0));
    let SelectedCamera::Fixed { projection, .. } = job.selection.camera else {
        panic!("the camera is fixed");
    };
    let (start, center) = (camera_at(Vec3::Z * 1.9, Vec3::Y * -2.0), Vec3::Y * -2.0);
    let seen_by = |camera: SelectedCamera, time_seconds: f64| {
        let mut job = job.clone();
        job.selection.camera = camera;
        brightness(&job, time_seconds)
    };
    let turntable = Turntable { start, projection, center, axis: Vec3::Y, turn_seconds: 1.0 };
    let turned = [0.0, 0.25, 0.5, 0.75].map(|time| seen_by(SelectedCamera::Turntable(turntable), time));
    for brightness in turned {
        assert!((brightness - turned[0]).abs() < 0.01, "{turned:?}");
    }
    // Each alone differs, but not much: the walls are the same.
    let fixed = |world_from_camera| SelectedCamera::Fixed { world_from_camera, projection };
    let [first, opposite] = [0.0, 0.5].map(|time| seen_by(fixed(turntable.at(time)), 0.0));
    assert!(first != opposite && (0.6..1.7).contains(&(first / opposite)), "{first} {opposite}");
}

/// A job whose door opens from `start` to `end`, seconds.
fn garage_that_opens(start: f32, end: f32) -> SequenceJob {
    let mut job = garage(Path::new("unused.exr"));
    let channels = &mut Arc::make_mut(&mut job.scene).animations[0].channels;
    channels[0].keyframes.times_seconds = vec![start, end];
    job
}

#[test]
fn the_time_before_the_first_key_does_not_count() {
    let (at_once, late) = (garage_that_opens(0.0, 1.0), garage_that_opens(40.0, 41.0));
    for time_seconds in [0.0, 1.0] {
        let [at_once, late] =
            [(&at_once, 0.0), (&late, 40.0)].map(|(job, start)| brightness(job, start + time_seconds));
        // The noise stands still, but not over the times of a shot.
        assert!((at_once - late).abs() < 0.005, "{at_once} {late}");
    }
}

#[test]
fn what_comes_after_the_turn_does_not_count() {
    let mut job = garage_that_opens(10.0, 11.0);
    let SelectedCamera::Fixed { world_from_camera: start, projection } = job.selection.camera else {
        panic!("the camera is fixed");
    };
    let turntable = Turntable { start, projection, center: Vec3::ZERO, axis: Vec3::Y, turn_seconds: 1.0 };
    job.selection.camera = SelectedCamera::Turntable(turntable);
    assert!((brightness(&job, 0.5) - ALBEDO).abs() < 1e-5);
}

#[test]
fn given_shares_change_the_hash() {
    let job = garage(Path::new("unused.exr"));
    let mut given = job.clone();
    given.render.environment_shares = Some(EnvironmentShares::NONE);
    assert_ne!(render_hash(&job, 0), render_hash(&given, 0));
}

#[test]
fn a_frame_alone_is_that_of_the_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let rendered = |name: &str, frames: Vec<i64>| {
        let job = SequenceJob { frames, ..garage(&folder.path().join(name).join("a.####.exr")) };
        let plan = Plan::new(&job).unwrap();
        plan.prepare().unwrap();
        run(&job, &plan, &CancelFlag::new(), &|_| ()).outcome().unwrap();
        (job, std::fs::read(folder.path().join(name).join("a.0004.exr")).unwrap())
    };
    let (job, alone) = rendered("alone", vec![4]);
    assert!(alone == rendered("sequence", vec![0, 2, 4]).1);
    let image = Image::read(&folder.path().join("alone/a.0004.exr")).unwrap();
    let pixels = image.rgba().unwrap();
    let mean = pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / pixels.len() as f32;
    assert!((mean - brightness(&job, 1.0)).abs() < 1e-3);
}

#[test]
fn known_shares_are_those_of_one_scene_environment_and_selection() {
    let job = garage(Path::new("unused.exr"));
    let known = brightness(&job, 1.0);
    // What stands for the rest is as bright as the environment.
    let mut brighter = job.clone();
    brighter.environment = Environment::Constant(Vec3::splat(2.0));
    assert!((brightness(&brighter, 1.0) - 2.0 * known).abs() < 1e-5);
    // From outside all is traced, whatever the camera inside has found.
    let mut outside = job.clone();
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut outside.selection.camera else {
        panic!("the camera is fixed");
    };
    *world_from_camera = camera_at(Vec3::new(0.5, 0.5, 9.0), Vec3::Z * -2.0);
    let seen_from_outside = brightness(&outside, 1.0);
    outside.known_shares = KnownShares::default();
    assert_eq!(brightness(&outside, 1.0), seen_from_outside);
    // A door that hardly moves leaves the space closed, which all of the light reaches.
    let mut closed = job.clone();
    let channels = &mut Arc::make_mut(&mut closed.scene).animations[0].channels;
    channels[0].keyframes.values[4] = 1e-4;
    assert!((brightness(&closed, 1.0) - ALBEDO).abs() < 1e-5 && known < 0.9 * ALBEDO, "{known}");
}

#[test]
fn a_camera_outside_traces_all() {
    let mut job = garage(Path::new("unused.exr"));
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    *world_from_camera = camera_at(Vec3::new(0.5, 0.5, 9.0), Vec3::Z * -2.0);
    let open = brightness(&job, 1.0);
    job.render.env_samples = EnvSamples::Fixed(1);
    assert!((open - brightness(&job, 1.0)).abs() < 1e-3);
}
