//! Light that the surfaces of hollows in the open send to each other, beside paths.

use std::path::Path;

use glam::Vec3;
use rayframe::cancel::CancelFlag;
use rayframe::frame::Frame;
use rayframe::render::Integrator;
use rayframe::scene::{BuiltInLight, Environment, Material, Projection, SelectedCamera};
use rayframe::sequence::{SequenceJob, render_single_frame};

use crate::environment_shares::camera_at;
use crate::stage::{Stage, lambert, rectangle, sequence_job};

const SIZE: u32 = 32;

/// A camera above an open box of two metres, `depth` metres deep, in white light. The middle of the image shows its floor and a wall.
fn open_box(color: Vec3, depth: f32) -> SequenceJob {
    let mut stage = Stage::new();
    let paint = Material { double_sided: true, ..lambert(color) };
    let (x, half, z) = (Vec3::X, Vec3::Y * (0.5 * depth), Vec3::Z);
    for (center, u, v) in [(z, x, half), (-z, x, half), (x, half, z), (-x, half, z), (-half, x, z)] {
        stage.add(rectangle(center, u, v), paint.clone());
    }
    let projection =
        Projection::Perspective { fov_y_radians: 0.3, aspect_ratio: None, z_near: 0.0, z_far: None };
    let world_from_camera = camera_at(Vec3::new(0.0, 6.0, 1.0), -half);
    let camera = SelectedCamera::Fixed { world_from_camera, projection };
    let mut job = sequence_job(stage.scene, camera, (SIZE, SIZE), Path::new("unused.exr"));
    job.environment = Environment::Constant(Vec3::ONE);
    job.render.samples = 16;
    job
}

/// Mean radiance of the pixels in the middle.
#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
fn inside(job: &SequenceJob) -> Vec3 {
    let frame = Frame::at(&job.scene, &job.selection, 0.0);
    let (film, _) = render_single_frame(job, &frame, &job.render, &CancelFlag::new()).unwrap();
    let is_inside = |index: u32| (8..24).contains(&(index % SIZE)) && (8..24).contains(&(index / SIZE));
    let pixels = (0..SIZE * SIZE).zip(&film.pixels).filter(|(index, _)| is_inside(*index));
    let (sum, count) = pixels.fold((Vec3::ZERO, 0.0), |(sum, count), (_, [r, g, b, ..])| {
        (sum + Vec3::new(*r, *g, *b), count + 1.0)
    });
    sum / count
}

fn inside_with_paths(job: &SequenceJob, max_depth: u32) -> Vec3 {
    let mut job = job.clone();
    job.render.integrator = Integrator::Path;
    job.render.samples = 64;
    job.render.max_depth = max_depth;
    inside(&job)
}

#[test]
fn white_hollows_are_as_bright_as_what_lights_them() {
    for depth in [1.0, 2.0, 4.0] {
        let found = inside(&open_box(Vec3::ONE, depth)).x;
        assert!((found - 1.0).abs() < 0.04, "{depth}: {found}");
    }
}

#[test]
fn hollows_are_as_bright_as_with_paths() {
    for (albedo, depth) in [(0.2, 2.0), (0.5, 1.0), (0.5, 4.0), (0.8, 1.0), (0.8, 2.0), (0.8, 4.0)] {
        let job = open_box(Vec3::splat(albedo), depth);
        let (found, expected) = (inside(&job).x, inside_with_paths(&job, 64).x);
        assert!((found / expected - 1.0).abs() < 0.06, "{albedo} {depth}: {found}, paths {expected}");
    }
}

#[test]
fn suns_are_reflected_more_than_once() {
    let mut job = open_box(Vec3::splat(0.8), 2.0);
    job.environment = Environment::BuiltIn(BuiltInLight::Outdoor);
    let (found, expected) = (inside(&job).x, inside_with_paths(&job, 64).x);
    let once = inside_with_paths(&job, 1).x;
    assert!(once < 0.8 * expected, "{once} {expected}");
    assert!((found / expected - 1.0).abs() < 0.1, "{found}, paths {expected}");
}

#[test]
fn hollows_are_more_saturated_than_their_paint() {
    let job = open_box(Vec3::new(0.8, 0.4, 0.1), 2.0);
    let (found, expected) = (inside(&job), inside_with_paths(&job, 64));
    for (found, expected) in
        [(found.x / found.y, expected.x / expected.y), (found.x / found.z, expected.x / expected.z)]
    {
        assert!((found / expected - 1.0).abs() < 0.1, "{found}, paths {expected}");
    }
    assert!(found.x > 2.1 * found.y, "{found}");
}

#[test]
fn a_moving_camera_changes_no_hollow() {
    let job = |step: f32| {
        let mut job = open_box(Vec3::splat(0.8), 2.0);
        if let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera {
            *world_from_camera = camera_at(Vec3::new(0.01 * step, 6.0, 1.0), Vec3::NEG_Y);
        }
        job
    };
    let brightness: Vec<f32> = (0..4).map(|step| inside(&job(step as f32)).x).collect();
    for pair in brightness.windows(2) {
        assert!((pair[0] / pair[1] - 1.0).abs() < 0.004, "{brightness:?}");
    }
}
