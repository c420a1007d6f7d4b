//! Cameras that frame what moves.

use glam::Vec3;
use rayframe::framing::{ground_below, resolve_camera};
use rayframe::scene::{
    AnimationIndex, AnimationTarget, Interpolation, NodeIndex, Scene, SelectedCamera, Selection, ViewRequest,
};

use crate::framing::image_bounds;
use crate::stage::{Stage, animate_by_keys, cuboid, lambert, select_all};

/// Cubes of all but the first node, by centre and half edge, and a first cube of this half edge at the origin.
fn scene(half: f32, others: &[(Vec3, f32)]) -> Scene {
    let mut stage = Stage::new();
    for &(center, half) in [(Vec3::ZERO, half)].iter().chain(others) {
        stage.add(cuboid(center, Vec3::splat(half)), lambert(Vec3::ONE));
    }
    stage.scene
}

/// Moves the first node from point to point, each at its time in seconds.
fn move_first(scene: &mut Scene, keys: &[(f32, Vec3)]) {
    let keys: Vec<(f32, [f32; 3])> =
        keys.iter().map(|(seconds, point)| (*seconds, point.to_array())).collect();
    let keys: Vec<(f32, &[f32])> = keys.iter().map(|(seconds, point)| (*seconds, point.as_slice())).collect();
    animate_by_keys(scene, AnimationTarget::Translation(NodeIndex(0)), &keys);
}

/// How far the corners reach from the middle of the automatic camera's image at some times; 1 is its edge.
fn reach(scene: &Scene, times: &[f64]) -> f32 {
    let selection = select_all(scene, SelectedCamera::Auto);
    let camera = resolve_camera(scene, selection, &ViewRequest::default(), 1.0);
    let reaches = times.iter().map(|&seconds| {
        let [min, max] = image_bounds(scene, &camera, 1.0, seconds);
        max.max(-min).max_element()
    });
    reaches.fold(0.0, f32::max)
}

/// A building of 20 cubes, two metres wide.
fn building() -> Vec<(Vec3, f32)> {
    (0..20).map(|index| (Vec3::new(index as f32 * 0.05 - 0.5, 0.0, 0.0), 0.5)).collect()
}

#[test]
fn a_small_object_that_moves_far_is_no_backdrop() {
    for distance in [4.0, 6.0, 20.0] {
        let mut scene = scene(0.3, &building());
        let end = Vec3::new(distance, 0.0, 1.5);
        move_first(&mut scene, &[(0.0, end * Vec3::new(-1.0, 0.0, 1.0)), (2.0, end)]);
        let reach = reach(&scene, &[0.0, 1.0, 2.0]);
        assert!((reach - 0.8).abs() < 1e-3, "{distance} m: {reach}");
    }
}

#[test]
fn few_triangles_that_come_near_are_framed_along_their_whole_path() {
    // A flyby of 12 of 4,812 triangles.
    let many: Vec<_> =
        (0..400).map(|index| (Vec3::new(index as f32 * 0.0025 - 0.5, 0.0, 0.0), 0.5)).collect();
    for distance in [5.0, 20.0] {
        let mut scene = scene(0.3, &many);
        move_first(
            &mut scene,
            &[(0.0, Vec3::new(-distance, 1.0, 0.0)), (2.0, Vec3::new(distance, 1.0, 0.0))],
        );
        let reach = reach(&scene, &[0.0, 1.0, 2.0]);
        assert!((reach - 0.8).abs() < 1e-3, "{distance} m: {reach}");
    }
}

#[test]
fn what_is_parked_far_away_or_flies_off_is_left_out() {
    let (near, far) = (Vec3::new(0.0, 0.9, 0.0), Vec3::new(0.0, -1000.0, 0.0));
    let after = |seconds: f32, jump: f32| [(0.0, near), (seconds, near), (seconds + jump, far), (10.0, far)];
    let blink = [(0.0, near), (5.03, near), (5.031, far), (5.07, far), (5.071, near), (10.0, near)];
    let flight = [(0.0, near), (10.0, Vec3::new(200.0, 0.9, 0.0))];
    for keys in [after(4.0, 0.001).to_vec(), blink.to_vec(), flight.to_vec()] {
        let mut scene = scene(0.3, &building());
        move_first(&mut scene, &keys);
        // At first the part is near.
        let reach = reach(&scene, &[0.0]);
        assert!(reach > 0.5, "{keys:?}: {reach}");
    }
}

#[test]
fn a_planet_on_an_orbit_is_no_sky() {
    let mut scene = scene(0.8, &[(Vec3::ZERO, 1.0)]);
    let keys: Vec<(f32, Vec3)> = (0..=32_u8)
        .map(|step| {
            let angle = f32::from(step) * std::f32::consts::TAU / 32.0;
            (
                f32::from(step) / 8.0,
                13.0 * Vec3::new(libm::cosf(angle), 0.5 * libm::sinf(angle), libm::sinf(angle)),
            )
        })
        .collect();
    move_first(&mut scene, &keys);
    let reach = reach(&scene, &[0.0, 1.0, 2.0, 3.0, 4.0]);
    assert!((0.7..0.801).contains(&reach), "{reach}");
}

#[test]
fn skies_and_grounds_that_move_are_left_out() {
    let content = reach(&scene(0.5, &building()), &[0.0]);
    // A sky that turns with the world, and a ground that scrolls by: both move by less than their size.
    for (half, center) in [(100.0, Vec3::ZERO), (50.0, Vec3::new(40.0, -52.0, 0.0))] {
        let mut scene = scene(half, &building());
        move_first(&mut scene, &[(0.0, center), (2.0, center + Vec3::X * 10.0)]);
        let reach = reach(&scene, &[0.0]);
        assert!(reach > 10.0 * content, "{half} m: {reach}");
    }
}

/// Key times and points of a pendulum that swings two metres to both sides.
fn swings(clip_seconds: u16, period_seconds: f32) -> Vec<(f32, Vec3)> {
    let frames = 0..=clip_seconds * 24;
    let keys = frames.map(|frame| {
        let seconds = f32::from(frame) / 24.0;
        let angle = std::f32::consts::TAU * seconds / period_seconds;
        (seconds, Vec3::new(2.0 * libm::sinf(angle), 0.0, 0.0))
    });
    keys.collect()
}

#[test]
fn motion_of_any_period_stays_in_the_image() {
    // Of 65 even times of 32 s, all are in the middle of swings of 1 s.
    for (clip, period) in [(32, 1.0), (16, 0.25), (64, 2.0), (5, 1.0), (64, 0.5)] {
        let mut scene = scene(0.15, &[]);
        move_first(&mut scene, &swings(clip, period));
        let quarter = f64::from(period) / 4.0;
        let reach = reach(&scene, &[0.0, quarter, 3.0 * quarter]);
        assert!((0.75..0.83).contains(&reach), "{clip} s, {period} s: {reach}");
    }
}

#[test]
fn short_motion_stays_in_the_image() {
    // A jump of half a second after 1001 frames, and a landing of a quarter of a second within a minute.
    let jump = [(41.7, 0.0), (41.95, 4.0), (42.2, 0.0)];
    let landing = [(0.0, 2.0), (30.8, 2.0), (31.3, 0.0), (31.55, 0.0), (32.05, 2.0), (60.0, 2.0)];
    for (keys, times) in [(jump.as_slice(), [0.0, 41.95]), (landing.as_slice(), [0.0, 31.4])] {
        let keys: Vec<_> = keys.iter().map(|&(seconds, height)| (seconds, Vec3::Y * height)).collect();
        let mut scene = scene(0.15, &[]);
        move_first(&mut scene, &keys);
        let reach = reach(&scene, &times);
        assert!((0.75..0.83).contains(&reach), "{times:?}: {reach}");
        // The ground lies just below the lowest point.
        let selection = select_all(&scene, SelectedCamera::Auto);
        let ground = ground_below(&scene, &selection, &ViewRequest::default(), false);
        let height = ground.map_or(f32::NAN, |ground| ground.height);
        assert!((height + 0.15).abs() < 1e-2, "{times:?}: {height}");
    }
}

#[test]
fn what_is_seen_between_even_times_alone_is_framed() {
    let mut scene = scene(0.3, &building());
    let far = [10.0, 0.0, 0.0];
    animate_by_keys(&mut scene, AnimationTarget::Translation(NodeIndex(0)), &[(0.0, &far), (64.0, &far)]);
    // Visible from 10.2 to 10.7 s; the even times are whole seconds.
    let keys: [(f32, &[f32]); 4] = [(0.0, &[0.0]), (10.2, &[1.0]), (10.7, &[0.0]), (64.0, &[0.0])];
    animate_by_keys(&mut scene, AnimationTarget::Visibility(NodeIndex(0)), &keys);
    for animation in &mut scene.animations {
        for channel in &mut animation.channels {
            channel.keyframes.interpolation = Interpolation::Step;
        }
    }
    let reach = reach(&scene, &[10.5]);
    assert!((reach - 0.8).abs() < 1e-3, "{reach}");
}

#[test]
fn each_of_many_clips_is_framed() {
    let mut scene = scene(0.15, &[]);
    for _ in 0..30 {
        move_first(&mut scene, &swings(4, 0.5));
    }
    let measured_clips: Vec<AnimationIndex> = (0..30).map(AnimationIndex).collect();
    let selection = Selection { clips: vec![AnimationIndex(7)], ..select_all(&scene, SelectedCamera::Auto) };
    let request = ViewRequest { measured_clips, ..ViewRequest::default() };
    let camera = resolve_camera(&scene, selection, &request, 1.0);
    let [min, max] = image_bounds(&scene, &camera, 1.0, 0.125);
    let reach = max.max(-min).max_element();
    assert!((0.75..0.83).contains(&reach), "{reach}");
}
