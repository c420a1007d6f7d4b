//! The automatic exposure of moving scenes, and of those that emissive surfaces light.

use std::path::Path;
use std::sync::Arc;

use glam::{Mat4, Quat, Vec3};
use rayframe::cancel::CancelFlag;
use rayframe::film::AovFlags;
use rayframe::frame::Frame;
use rayframe::framing::resolve_camera;
use rayframe::integrator::Integrator;
use rayframe::output::auto_exposure_ev;
use rayframe::render::RenderSettings;
use rayframe::scene::{
    AnimationIndex, AnimationTarget, BuiltInLight, Environment, LightIndex, LightKind, LightProperty,
    Material, NodeIndex, Projection, SelectedCamera, Selection, Turntable, ViewRequest,
};
use rayframe::sequence::{SequenceJob, SharedExposure, exposure_ev, render_hash, render_single_frame};

use crate::stage::{Stage, animate_by_keys, cuboid, lambert, rectangle, select_all, sequence_job};

/// The exposure of a floor below a lamp that pulses once a second for some whole seconds and is dark between them.
#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
fn exposure_of_pulses(seconds: u16) -> f32 {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z, Vec3::X), lambert(Vec3::splat(0.5)));
    stage.add_light(LightKind::Point, 60.0, Vec3::Y, Vec3::NEG_Y);
    let keys: Vec<(f32, [f32; 1])> = (0..=2 * seconds)
        .map(|half| (f32::from(half) * 0.5, [if half % 2 == 0 { 0.1 } else { 60.0 }]))
        .collect();
    let keys: Vec<(f32, &[f32])> = keys.iter().map(|(seconds, value)| (*seconds, value.as_slice())).collect();
    let target = AnimationTarget::Light(LightIndex(0), LightProperty::Intensity);
    animate_by_keys(&mut stage.scene, target, &keys);
    let selection = select_all(&stage.scene, SelectedCamera::Auto);
    let camera =
        resolve_camera(&stage.scene, selection, &ViewRequest::default(), 16.0 / 9.0).selection.camera;
    let job = sequence_job(stage.scene, camera, (16, 9), Path::new("unused.png"));
    exposure_ev(&job, &CancelFlag::new()).unwrap()
}

#[test]
fn the_length_of_a_clip_does_not_decide_about_a_pulsing_lamp() {
    // Three pulses at five even times were one exposure, four another, which saw the dark alone: 5 stops apart.
    let expected = exposure_of_pulses(30);
    for seconds in [2, 3, 4, 8, 12, 16, 32] {
        let exposure = exposure_of_pulses(seconds);
        assert!((exposure - expected).abs() < 0.7, "{seconds} s: {exposure}, 30 s: {expected}");
    }
}

/// A camera at eye level that looks along −Z over a floor with a panel above it, which emits `radiance`; with walls around both where it is closed.
fn beside_panel(
    radiance: f32,
    is_closed: bool,
    environment: Environment,
    integrator: Integrator,
) -> SequenceJob {
    let mut stage = Stage::new();
    let walls = Material { double_sided: true, ..lambert(Vec3::splat(0.5)) };
    if is_closed {
        stage.add(cuboid(Vec3::ZERO, Vec3::splat(2.0)), walls);
    } else {
        stage.add(rectangle(Vec3::Y * -2.0, Vec3::Z * 9.0, Vec3::X * 9.0), walls);
    }
    let emissive = Vec3::splat(radiance);
    let panel = Material { emissive, emissive_factor: emissive, ..lambert(Vec3::ZERO) };
    stage.add(rectangle(Vec3::Y * 1.9, Vec3::X * 0.5, Vec3::Z * 0.5), panel);
    let projection =
        Projection::Perspective { fov_y_radians: 1.2, aspect_ratio: None, z_near: 0.0, z_far: None };
    let world_from_camera = Mat4::from_translation(Vec3::Z * 1.8);
    let camera = SelectedCamera::Fixed { world_from_camera, projection };
    let mut job = sequence_job(stage.scene, camera, (16, 9), Path::new("unused.png"));
    job.environment = environment;
    job.render.integrator = integrator;
    job
}

#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
fn exposure_of(job: &SequenceJob) -> f32 {
    exposure_ev(job, &CancelFlag::new()).unwrap()
}

#[test]
fn emissive_surfaces_that_light_a_scene_decide_instead_of_the_studio() {
    let studio = || Environment::BuiltIn(BuiltInLight::Studio);
    let closed =
        |radiance, environment| exposure_of(&beside_panel(radiance, true, environment, Integrator::Path));
    let (dim, bright) = (closed(20.0, studio()), closed(2000.0, studio()));
    // A factor of 100 is 6.64 stops.
    assert!((dim - bright - 6.64).abs() < 0.02, "{dim} {bright}");
    let alone = closed(2000.0, Environment::None);
    assert!((bright - alone).abs() < 0.02, "{bright} {alone}");
    // A lamp that brings less light than the studio does not, and Whitted's tree has no such lamps.
    assert_eq!(exposure_of(&beside_panel(0.5, false, studio(), Integrator::Path)), 0.0);
    assert_eq!(exposure_of(&beside_panel(200.0, true, studio(), Integrator::Whitted)), 0.0);
    // Nor does one where no surface is seen: above the open floor, the camera looks up.
    let mut away = beside_panel(200.0, false, studio(), Integrator::Path);
    let SelectedCamera::Fixed { world_from_camera, .. } = &mut away.selection.camera else {
        panic!("the camera is fixed");
    };
    *world_from_camera =
        Mat4::from_translation(Vec3::Y * 9.0) * Mat4::from_quat(Quat::from_axis_angle(Vec3::X, 1.5));
    assert_eq!(exposure_of(&away), 0.0);
}

#[test]
fn runs_that_share_the_exposure_of_their_selection_render_the_same_frames() {
    let mut job = beside_panel(20.0, true, Environment::None, Integrator::Path);
    let (hash, alone) = (render_hash(&job, 1), exposure_of(&job));
    job.shared_exposure =
        Some(Arc::new(SharedExposure::new(vec![job.selection.clone()], job.render.resolution)));
    assert_eq!((render_hash(&job, 1), exposure_of(&job)), (hash.clone(), alone));
    // With another selection it is another exposure.
    let other = Selection { camera: SelectedCamera::Auto, ..job.selection.clone() };
    for selections in [vec![other.clone()], vec![job.selection.clone(), other]] {
        job.shared_exposure = Some(Arc::new(SharedExposure::new(selections, job.render.resolution)));
        assert_ne!(render_hash(&job, 1), hash);
    }
}

/// A run that resumes may need the exposure for another of the sequences first.
#[test]
fn a_shared_exposure_has_one_shape_whichever_sequence_needs_it_first() {
    let wide = beside_panel(20.0, true, Environment::None, Integrator::Path);
    let mut tall = wide.clone();
    tall.render.resolution = (9, 16);
    tall.render.window = rayframe::film::PixelWindow::full(9, 16);
    let own = exposure_of(&wide);
    assert_ne!(own, exposure_of(&tall), "the shape decides");
    let share = |job: &SequenceJob, resolution| {
        let shared = SharedExposure::new(vec![wide.selection.clone()], resolution);
        SequenceJob { shared_exposure: Some(Arc::new(shared)), ..job.clone() }
    };
    for job in [&wide, &tall] {
        assert_eq!(exposure_of(&share(job, (16, 9))), own);
    }
    // Another shape is another exposure, and so another hash.
    let [of_wide, of_tall] = [(16, 9), (9, 16)].map(|resolution| render_hash(&share(&tall, resolution), 1));
    assert_ne!(of_wide, of_tall);
    assert_eq!(of_tall, render_hash(&tall, 1));
}

/// A view from above of a smooth metal that mirrors what is above it, and of a panel that emits light where `sees_panel`.
fn above_mirror(environment: Environment, sees_panel: bool) -> SequenceJob {
    let mut stage = Stage::new();
    let mirror = Material { metallic: 1.0, roughness: 0.0, ..lambert(Vec3::splat(0.5)) };
    stage.add(rectangle(Vec3::ZERO, Vec3::Z, Vec3::X), mirror);
    let emissive = Vec3::splat(0.9);
    let panel = Material { emissive, emissive_factor: emissive, double_sided: true, ..lambert(Vec3::ZERO) };
    let center = if sees_panel { Vec3::new(1.2, 0.5, 0.0) } else { Vec3::new(0.0, 9.0, 0.0) };
    stage.add(rectangle(center, Vec3::Z * 0.5, Vec3::X * 0.5), panel);
    let projection =
        Projection::Perspective { fov_y_radians: 0.6, aspect_ratio: None, z_near: 0.0, z_far: None };
    let world_from_camera = Mat4::from_cols(
        Vec3::X.extend(0.0),
        Vec3::NEG_Z.extend(0.0),
        Vec3::Y.extend(0.0),
        (Vec3::Y * 4.0).extend(1.0),
    );
    let camera = SelectedCamera::Fixed { world_from_camera, projection };
    let mut job = sequence_job(stage.scene, camera, (16, 9), Path::new("unused.png"));
    job.environment = environment;
    job
}

#[test]
fn mirror_images_of_emitters_do_not_decide() {
    for sees_panel in [true, false] {
        let mut job = above_mirror(Environment::None, sees_panel);
        assert_eq!(exposure_of(&job), 0.0);
        // A lamp that is off
        let mut stage = Stage { scene: (*job.scene).clone(), ..Stage::new() };
        stage.add_light(LightKind::Point, 0.0, Vec3::Y, Vec3::NEG_Y);
        job.selection.roots.clone_from(&stage.scene.node_order);
        job.scene = Arc::new(stage.scene);
        assert_eq!(exposure_of(&job), 0.0);
    }
}

#[test]
fn one_time_without_an_emitter_decides_nothing() {
    let mut job = above_mirror(Environment::None, true);
    let scene = Arc::make_mut(&mut job.scene);
    animate_by_keys(
        scene,
        AnimationTarget::Translation(NodeIndex(1)),
        &[(0.0, &[0.0; 3]), (1.0, &[0.0, 8.5, 0.0])],
    );
    job.selection.clips = vec![AnimationIndex(0)];
    assert_eq!(exposure_of(&job), 0.0);
}

#[test]
fn small_emitters_at_night_are_as_large_ones() {
    for (radiance, expected) in [(0.9, 0.0), (16.0, -4.0)] {
        let exposures = [4.0, 40.0].map(|distance| {
            let mut job = above_mirror(Environment::None, true);
            let SelectedCamera::Fixed { world_from_camera, .. } = &mut job.selection.camera else {
                panic!("the camera is fixed");
            };
            world_from_camera.w_axis.y = distance;
            let panel = &mut Arc::make_mut(&mut job.scene).materials[1];
            (panel.emissive, panel.emissive_factor) = (Vec3::splat(radiance), Vec3::splat(radiance));
            exposure_of(&job)
        });
        // Pixels on the edges of a small one hold less of it.
        assert!(exposures.iter().all(|exposure| (exposure - expected).abs() < 0.1), "{exposures:?}");
    }
}

#[test]
fn lamps_that_mirrors_alone_show_are_measured() {
    // The mirror shows a lit wall above the camera, and the panel.
    let job = above_mirror(Environment::None, true);
    let mut stage = Stage { scene: (*job.scene).clone(), ..Stage::new() };
    stage.add(rectangle(Vec3::Y * 9.0, Vec3::X * 9.0, Vec3::Z * 9.0), lambert(Vec3::splat(0.8)));
    stage.add_light(LightKind::Point, 9000.0, Vec3::Y * 5.0, Vec3::Y);
    let mut lit = job.clone();
    lit.selection.roots.clone_from(&stage.scene.node_order);
    lit.scene = Arc::new(stage.scene);
    let exposure = exposure_of(&lit);
    assert!((-10.0..-4.0).contains(&exposure), "{exposure}");
}

#[test]
fn turntables_are_measured_over_their_turn() {
    // A lamp lights one side of a cube. The view of either side comes first.
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::ZERO, Vec3::ONE), lambert(Vec3::splat(0.5)));
    stage.add_light(LightKind::Point, 400.0, Vec3::Z * 9.0, Vec3::NEG_Z);
    let projection =
        Projection::Perspective { fov_y_radians: 0.5, aspect_ratio: None, z_near: 0.0, z_far: None };
    let exposures = [0.0, 0.5].map(|turns| {
        let start = Mat4::from_translation(Vec3::Z * 6.0);
        let turntable =
            |start| Turntable { start, projection, center: Vec3::ZERO, axis: Vec3::Y, turn_seconds: 1.0 };
        let camera = SelectedCamera::Turntable(turntable(turntable(start).at(turns)));
        exposure_of(&sequence_job(stage.scene.clone(), camera, (16, 9), Path::new("unused.png")))
    });
    assert!((exposures[0] - exposures[1]).abs() < 0.5, "{exposures:?}");
}

#[test]
fn mirror_images_of_a_bright_environment_decide() {
    for sees_panel in [true, false] {
        let exposure = exposure_of(&above_mirror(Environment::Constant(Vec3::splat(50.0)), sees_panel));
        assert!((-6.0..-4.5).contains(&exposure), "{exposure}");
    }
}

#[test]
fn noise_of_paths_hardly_darkens_the_exposure() {
    let job = beside_panel(20.0, true, Environment::None, Integrator::Path);
    let settings = RenderSettings {
        resolution: (64, 36),
        window: rayframe::film::PixelWindow::full(64, 36),
        samples: 1024,
        aovs: AovFlags { centers: true, light: true, ..AovFlags::NONE },
        ..job.render.clone()
    };
    let frame = Frame::at(&job.scene, &job.selection, 0.0);
    let (film, _) = render_single_frame(&job, &frame, &settings, &CancelFlag::new()).unwrap();
    let (found, expected) = (exposure_of(&job), auto_exposure_ev(&[film]));
    assert!((found - expected).abs() < 0.15, "{found} for {expected}");
}
