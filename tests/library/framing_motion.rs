//! Cameras that frame what moves.

use glam::Vec3;
use rayframe::framing::resolve_camera;
use rayframe::scene::{AnimationTarget, NodeIndex, Scene, SelectedCamera, ViewRequest};

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

/// A house of 20 cubes, two metres wide.
fn house() -> Vec<(Vec3, f32)> {
    (0..20).map(|index| (Vec3::new(index as f32 * 0.05 - 0.5, 0.0, 0.0), 0.5)).collect()
}

#[test]
fn a_small_object_that_moves_far_is_no_backdrop() {
    for distance in [4.0, 6.0, 20.0, 200.0] {
        let mut scene = scene(0.3, &house());
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
    let content = reach(&scene(0.5, &house()), &[0.0]);
    // A sky that turns with the world, and a ground that scrolls by: both move by less than their size.
    for (half, center) in [(100.0, Vec3::ZERO), (50.0, Vec3::new(40.0, -52.0, 0.0))] {
        let mut scene = scene(half, &house());
        move_first(&mut scene, &[(0.0, center), (2.0, center + Vec3::X * 10.0)]);
        let reach = reach(&scene, &[0.0]);
        assert!(reach > 10.0 * content, "{half} m: {reach}");
    }
}
