//! Light of the environment in closed spaces, beside paths.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use rayframe::bvh::SimdLevel;
use rayframe::cancel::CancelFlag;
use rayframe::film::PixelWindow;
use rayframe::frame::Frame;
use rayframe::render::{EnvSamples, Integrator};
use rayframe::scene::{BuiltInLight, Environment, Material, Projection, SelectedCamera};
use rayframe::sequence::{SequenceJob, exposure_ev, render_single_frame};

use crate::environment_shares::{brightness, camera_at};
use crate::stage::{Stage, lambert, rectangle, sequence_job};

pub(crate) const ALBEDO: f32 = 0.5;
const SIZE: u32 = 32;

/// A camera below the middle of a closed box of four metres in white light, whose ceiling has a square hole of 2 `half` metres. On its floor lies a board.
pub(crate) fn box_with_hole(walls: &Material, board: &Material, half: f32) -> SequenceJob {
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
    let mut job = sequence_job(stage.scene, camera, (SIZE, SIZE), Path::new("unused.exr"));
    job.environment = Environment::Constant(Vec3::ONE);
    job.render.samples = 16;
    job
}

/// That box with all of one colour.
pub(crate) fn painted_box(color: Vec3, half: f32) -> SequenceJob {
    let paint = Material { double_sided: true, ..lambert(color) };
    box_with_hole(&paint, &paint, half)
}

/// Mean radiance of the pixels of an image for which `is_in` holds, by columns and rows.
#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
fn mean_of(job: &SequenceJob, is_in: impl Fn(u32, u32) -> bool) -> Vec3 {
    let frame = Frame::at(&job.scene, &job.selection, 0.0);
    let (film, _) = render_single_frame(job, &frame, &job.render, &CancelFlag::new()).unwrap();
    let inside = (0..SIZE * SIZE).zip(&film.pixels).filter(|(index, _)| is_in(index % SIZE, index / SIZE));
    let (sum, count) = inside.fold((Vec3::ZERO, 0.0), |(sum, count), (_, [r, g, b, ..])| {
        (sum + Vec3::new(*r, *g, *b), count + 1.0)
    });
    sum / count
}

/// The job with paths.
fn with_paths(job: &SequenceJob, samples: u32) -> SequenceJob {
    let mut job = job.clone();
    job.render.integrator = Integrator::Path;
    job.render.samples = samples;
    job.render.max_depth = 64;
    job
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
        let job = painted_box(Vec3::splat(albedo), half);
        let (found, expected) = (brightness(&job, 0.0), brightness(&with_paths(&job, 64), 0.0));
        // As if nothing were in between, all of them are several times too bright.
        assert!(albedo > 3.0 * expected, "{albedo} {half}: {expected}");
        assert!((found / expected - 1.0).abs() < 0.15, "{albedo} {half}: {found}, paths {expected}");
    }
}

#[test]
fn the_light_of_a_box_does_not_end_where_the_camera_sees_no_opening() {
    let mut job = painted_box(Vec3::splat(ALBEDO), 0.8);
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    // The hole is in the ceiling, which is seen from the side.
    *world_from_camera = camera_at(Vec3::new(1.9, 1.99, 1.9), Vec3::new(0.0, -1.0, -1.0));
    let (found, expected) = (brightness(&job, 0.0), brightness(&with_paths(&job, 64), 0.0));
    assert!((found / expected - 1.0).abs() < 0.3, "{found}, paths {expected}");
}

#[test]
fn walls_of_closed_boxes_colour_each_other() {
    let job = painted_box(Vec3::new(0.8, 0.4, 0.1), 0.8);
    let [found, expected] = [&job, &with_paths(&job, 64)].map(|job| mean_of(job, |_, _| true));
    // More saturated than the paint, whose red is twice its green and eight times its blue.
    for (found, expected) in
        [(found.x / found.y, expected.x / expected.y), (found.x / found.z, expected.x / expected.z)]
    {
        assert!((found / expected - 1.0).abs() < 0.2, "{found}, paths {expected}");
    }
    assert!(found.x > 2.5 * found.y && found.x > 12.0 * found.z, "{found}");
}

#[test]
fn what_faces_an_opening_is_brighter_than_what_is_beside_it() {
    // The camera looks down at the floor below the hole.
    let mut job = painted_box(Vec3::splat(ALBEDO), 0.8);
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    *world_from_camera = camera_at(Vec3::Y * 0.2, Vec3::Y * -2.0);
    let is_in_the_middle = |x: u32, y: u32| (12..20).contains(&x) && (12..20).contains(&y);
    let is_at_the_edge = |x: u32, y: u32| !(3..29).contains(&x) || !(3..29).contains(&y);
    let ratio = |job: &SequenceJob| mean_of(job, is_in_the_middle).x / mean_of(job, is_at_the_edge).x;
    let (found, expected) = (ratio(&job), ratio(&with_paths(&job, 256)));
    assert!(expected > 1.3 && (found / expected - 1.0).abs() < 0.2, "{found}, paths {expected}");
}

#[test]
fn surfaces_outside_are_as_bright_as_in_the_open() {
    // Through the hole the camera sees a board in the open, which hides little of the light from the box.
    let mut job = painted_box(Vec3::splat(ALBEDO), 0.8);
    let board = rectangle(Vec3::new(0.0, 7.0, 0.0), Vec3::X, Vec3::Z);
    let mut stage = Stage::new();
    stage.scene = job.scene.as_ref().clone();
    stage.add(board, Material { double_sided: true, ..lambert(Vec3::splat(ALBEDO)) });
    job.scene = Arc::new(stage.scene);
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    *world_from_camera = camera_at(Vec3::Y * -1.9, Vec3::Y * 7.0);
    let is_outside = |x: u32, y: u32| (15..17).contains(&x) && (15..17).contains(&y);
    let [found, expected] = [&job, &with_paths(&job, 1024)].map(|job| mean_of(job, is_outside).x);
    assert!((found / expected - 1.0).abs() < 0.35, "{found}, paths {expected}");
}

#[test]
fn black_boxes_are_black() {
    let job = painted_box(Vec3::ZERO, 0.8);
    let is_floor = |x: u32, y: u32| (8..24).contains(&x) && y > 20;
    assert_eq!(mean_of(&job, is_floor), Vec3::ZERO);
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

#[test]
fn a_camera_at_an_opening_sees_the_light_of_the_space() {
    // It is 80 cm below a hole of 160 cm, and sees the environment in a sixth of all directions.
    let mut job = painted_box(Vec3::splat(ALBEDO), 0.8);
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
        panic!("the camera is fixed");
    };
    *world_from_camera = camera_at(Vec3::Y * 1.2, Vec3::Y * -2.0);
    let (found, expected) = (brightness(&job, 0.0), brightness(&with_paths(&job, 64), 0.0));
    assert!((found / expected - 1.0).abs() < 0.3, "{found}, paths {expected}");
}

#[test]
fn threads_instructions_and_crops_change_no_pixel() {
    let pixels = |threads: usize, simd: SimdLevel, window: PixelWindow| {
        let mut job = painted_box(Vec3::new(0.8, 0.4, 0.1), 0.8);
        (job.render.window, job.render.samples, job.build.simd) = (window, 4, simd);
        let frame = Frame::at(&job.scene, &job.selection, 0.0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let render = || render_single_frame(&job, &frame, &job.render, &CancelFlag::new());
        pool.install(render).unwrap().0.pixels
    };
    let whole = PixelWindow::full(SIZE, SIZE);
    let expected = pixels(1, SimdLevel::Scalar, whole);
    assert_eq!(pixels(3, SimdLevel::best(), whole), expected);
    let rows = [13, 17].map(|row| (row * SIZE) as usize);
    let window = PixelWindow { y0: 13, y1: 17, ..whole };
    assert_eq!(pixels(2, SimdLevel::best(), window), expected[rows[0]..rows[1]]);
}
