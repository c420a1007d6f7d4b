//! Shadows of the environment in moving scenes with closed spaces: their share is that of the whole animation.

use std::path::Path;
use std::sync::Arc;

use glam::{Mat4, Vec3};
use rayframe::cancel::CancelFlag;
use rayframe::frame::Frame;
use rayframe::image::Image;
use rayframe::render::{EnvSamples, EnvironmentShares, Integrator};
use rayframe::scene::{
    AnimationTarget, BuiltInLight, Environment, LocalTransform, Material, NodeIndex, Projection,
    SelectedCamera, Turntable,
};
use rayframe::sequence::{FrameRate, Plan, SequenceJob, exposure_ev, render_hash, render_single_frame, run};

use crate::stage::{Stage, animate, lambert, rectangle, sequence_job};

const ALBEDO: f32 = 0.5;

/// World from camera space of one at `eye` that looks at `target`.
fn camera_at(eye: Vec3, target: Vec3) -> Mat4 {
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
fn brightness(job: &SequenceJob, time_seconds: f64) -> f32 {
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
    // Each alone differs.
    let fixed = |world_from_camera| SelectedCamera::Fixed { world_from_camera, projection };
    let [first, opposite] = [0.0, 0.5].map(|time| seen_by(fixed(turntable.at(time)), 0.0));
    assert!(first > 1.5 * opposite, "{first} {opposite}");
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
    // A copy with another scene knows nothing of the first.
    let mut other = job.clone();
    other.scene = Arc::new(garage(Path::new("unused.exr")).scene.as_ref().clone());
    other.selection.clips.clear();
    assert!((brightness(&other, 1.0) - ALBEDO).abs() < 1e-5);
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

/// A camera below the middle of a closed box of four metres in white light, whose ceiling has a square hole of 2 `half` metres. On its floor lies a board.
fn box_with_hole(walls: &Material, board: &Material, half: f32) -> SequenceJob {
    let mut stage = Stage::new();
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    for (center, u, v) in [(z, x, y), (-z, x, y), (x, y, z), (-x, y, z), (-y, x, z)] {
        stage.add(rectangle(center, u, v), walls.clone());
    }
    // The ceiling around the hole
    let (middle, width) = (1.0 + 0.5 * half, 1.0 - 0.5 * half);
    for side in [1.0, -1.0] {
        stage.add(rectangle(y + Vec3::X * middle * side, Vec3::X * width, z), walls.clone());
        let strip = rectangle(y + Vec3::Z * middle * side, Vec3::X * half, Vec3::Z * width);
        stage.add(strip, walls.clone());
    }
    stage.add(rectangle(Vec3::Y * -1.99, Vec3::Z, Vec3::X), board.clone());
    let projection =
        Projection::Perspective { fov_y_radians: 1.5, aspect_ratio: None, z_near: 0.0, z_far: None };
    let world_from_camera = camera_at(Vec3::new(0.0, 0.5, 1.5), Vec3::new(0.0, -1.0, -1.0));
    let camera = SelectedCamera::Fixed { world_from_camera, projection };
    let mut job = sequence_job(stage.scene, camera, (32, 32), Path::new("unused.exr"));
    job.environment = Environment::Constant(Vec3::ONE);
    job.render.samples = 16;
    job
}

/// That box with all of one colour.
fn painted_box(color: Vec3, half: f32) -> SequenceJob {
    let paint = Material { double_sided: true, ..lambert(color) };
    box_with_hole(&paint, &paint, half)
}

#[test]
fn white_boxes_are_as_bright_as_what_lights_them() {
    for half in [0.8, 1.2] {
        let brightness = brightness(&painted_box(Vec3::ONE, half), 0.0);
        assert!((brightness - 1.0).abs() < 0.02, "{half}: {brightness}");
    }
}

#[test]
fn closed_boxes_are_about_as_bright_as_with_paths() {
    for (albedo, half) in [(0.2, 0.8), (0.5, 0.8), (0.5, 1.2), (0.8, 0.8), (0.8, 1.2)] {
        let mut job = painted_box(Vec3::splat(albedo), half);
        let found = brightness(&job, 0.0);
        job.render.integrator = Integrator::Path;
        job.render.samples = 64;
        job.render.max_depth = 64;
        let expected = brightness(&job, 0.0);
        // As if nothing were in between, all of them are several times too bright.
        assert!(albedo > 3.0 * expected, "{albedo} {half}: {expected}");
        assert!((found / expected - 1.0).abs() < 0.3, "{albedo} {half}: {found}, paths {expected}");
    }
}

#[test]
fn the_light_of_a_box_does_not_end_where_the_camera_sees_no_opening() {
    let mut job = painted_box(Vec3::splat(ALBEDO), 0.8);
    let in_the_middle = brightness(&job, 0.0);
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    // The hole is in the ceiling, which is seen from the side.
    *world_from_camera = camera_at(Vec3::new(1.9, 1.99, 1.9), Vec3::new(0.0, -1.0, -1.0));
    let in_a_corner = brightness(&job, 0.0);
    let ratio = in_a_corner / in_the_middle;
    assert!((0.4..2.5).contains(&ratio), "{in_a_corner} {in_the_middle}");
}

#[test]
fn walls_of_closed_boxes_colour_each_other() {
    let mut job = painted_box(Vec3::new(0.8, 0.4, 0.1), 0.8);
    let channels = |job: &SequenceJob| {
        let frame = Frame::at(&job.scene, &job.selection, 0.0);
        let film = render_single_frame(job, &frame, &job.render, &CancelFlag::new());
        let sum = film.map(|(film, _)| {
            film.pixels.iter().fold(Vec3::ZERO, |sum, [r, g, b, ..]| sum + Vec3::new(*r, *g, *b))
        });
        sum.unwrap_or_default()
    };
    let found = channels(&job);
    job.render.integrator = Integrator::Path;
    job.render.samples = 64;
    let expected = channels(&job);
    // More saturated than the paint, whose red is twice its green and eight times its blue.
    for (found, expected) in
        [(found.x / found.y, expected.x / expected.y), (found.x / found.z, expected.x / expected.z)]
    {
        assert!((found / expected - 1.0).abs() < 0.2, "{found}, paths {expected}");
    }
    assert!(found.x > 2.5 * found.y && found.x > 12.0 * found.z, "{found}");
}

#[test]
fn unlit_domes_light_what_is_in_them() {
    let sky = Material { unlit: true, double_sided: true, ..lambert(Vec3::splat(0.4)) };
    let mut job = box_with_hole(&sky, &lambert(Vec3::splat(0.5)), 0.8);
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    // The board alone
    *world_from_camera = camera_at(Vec3::new(0.0, -1.5, 0.0), Vec3::Y * -2.0);
    let selected = job.selection.camera.clone();
    let found = brightness(&job, 0.0);
    job.render.integrator = Integrator::Path;
    job.render.samples = 256;
    let expected = brightness(&job, 0.0);
    assert!((found / expected - 1.0).abs() < 0.05, "{found}, paths {expected}");
    // Without any opening, the environment lights what is in it.
    let mut job = box_with_hole(&sky, &lambert(Vec3::splat(0.5)), 0.0);
    job.selection.camera = selected;
    let found = brightness(&job, 0.0);
    assert!((found - 0.5).abs() < 1e-3, "{found}");
}

#[test]
fn without_shadow_rays_the_whole_light_arrives() {
    let mut job = painted_box(Vec3::splat(ALBEDO), 0.8);
    job.render.env_samples = EnvSamples::Fixed(0);
    assert!((brightness(&job, 0.0) - ALBEDO).abs() < 1e-5);
}

#[test]
fn automatic_exposure_measures_closed_boxes_under_built_in_lights() {
    let exposure = |job: &SequenceJob| exposure_ev(job, &CancelFlag::new()).unwrap();
    let mut job = painted_box(Vec3::splat(ALBEDO), 0.8);
    job.environment = Environment::BuiltIn(BuiltInLight::Studio);
    let by_trees = exposure(&job);
    job.render.integrator = Integrator::Path;
    let by_paths = exposure(&job);
    assert!(by_trees > 1.0 && (by_trees - by_paths).abs() < 0.75, "{by_trees} {by_paths}");
    // Not where no shadows are asked for, and not in the open.
    job.render.integrator = Integrator::Whitted;
    job.render.env_samples = EnvSamples::Fixed(0);
    assert_eq!(exposure(&job), 0.0);
    job.render.env_samples = EnvSamples::Auto;
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    *world_from_camera = camera_at(Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO);
    assert_eq!(exposure(&job), 0.0);
}
