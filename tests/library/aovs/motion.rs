//! Motion vectors against displacements that are derived by hand.

use glam::{Mat4, Vec2, Vec3};
use rayframe::film::PixelCenterSample;
use rayframe::scene::{
    AnimationTarget, Interpolation, LocalTransform, MorphTarget, Scene, Skin, SkinIndex, SkinInfluences,
};

use super::stage::{
    CAMERA, PARALLEL, PINHOLE, SPARE, SQUARE, on_plane, pixel_centers, rotation_y, square, translation,
};
use crate::stage::animate;

/// Tolerance of motion, pixels.
const TOLERANCE: f32 = 1e-3;

#[track_caller]
fn assert_motion(sample: &PixelCenterSample, forward: Vec2, back: Vec2) {
    let (ahead, behind) = (sample.motion_forward, sample.motion_back);
    assert!(ahead.abs_diff_eq(forward, TOLERANCE), "{ahead} is not {forward} in {sample:?}");
    assert!(behind.abs_diff_eq(back, TOLERANCE), "{behind} is not {back} in {sample:?}");
}

/// Asserts the motion of all pixels of the square, and none of the background. Both are visible.
#[track_caller]
fn assert_square_moves(scene: &Scene, frame: i32, forward: Vec2, back: Vec2) {
    let samples = pixel_centers(scene, frame);
    for sample in &samples {
        match sample.instance {
            Some(_) => assert_motion(sample, forward, back),
            None => assert_eq!(*sample, PixelCenterSample::default()),
        }
    }
    assert!(samples.iter().filter(|sample| sample.instance.is_some()).count() > 10);
    assert!(samples.iter().any(|sample| sample.instance.is_none()));
}

/// 0.3 m to the right and 0.1 m up from frame to frame.
const DISPLACEMENT: [f32; 3] = [1.2, 0.4, 0.0];

#[test]
fn a_moving_square_moves_by_its_displacement() {
    // Ten pixels a metre; y grows downwards.
    let mut scene = square(PARALLEL, 5.0);
    animate(&mut scene, AnimationTarget::Translation(SQUARE), &[0.0; 3], &DISPLACEMENT);
    assert_square_moves(&scene, 2, Vec2::new(3.0, -1.0), Vec2::new(-3.0, 1.0));
    // The clip ends at frame 4 and begins at frame 0: before and after, nothing moves.
    assert_square_moves(&scene, 4, Vec2::ZERO, Vec2::new(-3.0, 1.0));
    assert_square_moves(&scene, 0, Vec2::new(3.0, -1.0), Vec2::ZERO);

    // Two pixels a metre at five metres.
    let mut scene = square(PINHOLE, 5.0);
    animate(&mut scene, AnimationTarget::Translation(SQUARE), &[0.0; 3], &DISPLACEMENT);
    assert_square_moves(&scene, 2, Vec2::new(0.6, -0.2), Vec2::new(-0.6, 0.2));
}

#[test]
fn an_approaching_square_moves_outwards() {
    // Half a metre a frame, from 5 m on: a point that is 4 m away in frame 2 was 4.5 m and will be 3.5 m away.
    let mut scene = square(PINHOLE, 5.0);
    animate(&mut scene, AnimationTarget::Translation(SQUARE), &[0.0; 3], &[0.0, 0.0, 2.0]);
    let samples = pixel_centers(&scene, 2);
    for (point, sample) in on_plane(&samples).filter(|(_, sample)| sample.instance.is_some()) {
        let pixels = Vec2::new(point.x, -point.y) * 10.0;
        assert_motion(sample, pixels * (4.0 / 3.5 - 1.0), pixels * (4.0 / 4.5 - 1.0));
        assert!((sample.depth - 4.0).abs() < 1e-5);
    }
}

#[test]
fn a_moving_camera_moves_the_square_but_not_the_background() {
    for (projection, pixels_a_metre) in [(PARALLEL, 10.0), (PINHOLE, 2.0)] {
        let mut scene = square(projection, 5.0);
        animate(&mut scene, AnimationTarget::Translation(CAMERA), &[-0.6, -0.2, 0.0], &[0.6, 0.2, 0.0]);
        let forward = Vec2::new(-0.3, 0.1) * pixels_a_metre;
        assert_square_moves(&scene, 2, forward, -forward);
    }
}

#[test]
fn a_turning_camera_moves_everything_by_its_angle() {
    // Rotated by a around +Y, a pinhole sees the direction (x, y, −1) at ((x cos a + sin a), y) / (cos a − x sin a).
    let mut scene = square(PINHOLE, 5.0);
    animate(&mut scene, AnimationTarget::Rotation(CAMERA), &rotation_y(-0.2), &rotation_y(0.2));
    let seen = |point: Vec2, angle: f32| {
        let (sine, cosine) = (libm::sinf(angle), libm::cosf(angle));
        let there = Vec2::new(point.x * cosine + sine, point.y) / (cosine - point.x * sine);
        (there - point) * Vec2::new(10.0, -10.0)
    };
    // Frame 2 is half way, where the camera looks straight ahead.
    let samples = pixel_centers(&scene, 2);
    let mut surfaces = 0;
    for (point, sample) in on_plane(&samples) {
        assert_motion(sample, seen(point, 0.1), seen(point, -0.1));
        surfaces += u32::from(sample.instance.is_some());
    }
    assert!(surfaces > 10 && surfaces < 700, "{surfaces}");
}

#[test]
fn a_surface_that_leaves_behind_the_camera_has_no_motion() {
    // Half a circle from frame 0 to frame 1.
    let mut scene = square(PINHOLE, 5.0);
    let node = &mut scene.nodes[CAMERA.index()];
    node.local = LocalTransform::default();
    animate(
        &mut scene,
        AnimationTarget::Rotation(CAMERA),
        &rotation_y(0.0),
        &rotation_y(std::f32::consts::PI),
    );
    scene.animations[0].channels[0].keyframes.interpolation = Interpolation::Step;
    scene.animations[0].channels[0].keyframes.times_seconds[1] = 0.25;
    assert_square_moves(&scene, 0, Vec2::ZERO, Vec2::ZERO);
}

#[test]
fn morphed_vertices_move_the_surface() {
    // A target that stretches along x: at weight w = time, X = x (1 + 0.8 w). What is at X in frame 2 moves by 0.2 X / 1.4 a
    // frame.
    let mut scene = square(PARALLEL, 5.0);
    let primitive = &mut scene.meshes[0].primitives[0];
    let stretch = primitive.positions.iter().map(|position| Vec3::X * position.x * 0.8).collect();
    primitive.targets = vec![MorphTarget { positions: Some(stretch), ..MorphTarget::default() }];
    animate(&mut scene, AnimationTarget::Weights(SQUARE), &[0.0], &[1.0]);
    let samples = pixel_centers(&scene, 2);
    for (point, sample) in on_plane(&samples).filter(|(_, sample)| sample.instance.is_some()) {
        let forward = Vec2::X * (point.x * 10.0 * 0.2 / 1.4);
        assert_motion(sample, forward, -forward);
    }
}

#[test]
fn skinned_vertices_move_the_surface() {
    // Three quarters of the joint's displacement.
    let mut scene = square(PARALLEL, 5.0);
    scene.skins.push(Skin {
        name: None,
        joints: vec![CAMERA, SPARE],
        inverse_bind_matrices: vec![Mat4::IDENTITY; 2],
    });
    scene.nodes[SQUARE.index()].skin = Some(SkinIndex(0));
    scene.meshes[0].primitives[0].influences =
        Some(SkinInfluences { per_vertex: 2, joints: [0, 1].repeat(4), weights: [0.25, 0.75].repeat(4) });
    animate(&mut scene, AnimationTarget::Translation(SPARE), &[0.0; 3], &DISPLACEMENT);
    assert_square_moves(&scene, 2, Vec2::new(2.25, -0.75), Vec2::new(-2.25, 0.75));
}

#[test]
fn instances_and_mirrored_squares_move_like_any_other() {
    // Turned inside out by a scale of −1 from frame 3 on, the point at X goes to −X.
    let mut scene = square(PARALLEL, 5.0);
    scene.materials[0].double_sided = true;
    scene.nodes[SQUARE.index()].instances =
        Some(vec![translation(0.0, 0.0, 0.0), translation(9.0, 0.0, 0.0)]);
    animate(&mut scene, AnimationTarget::Scale(SQUARE), &[1.0; 3], &[-1.0, 1.0, 1.0]);
    let keyframes = &mut scene.animations[0].channels[0].keyframes;
    keyframes.interpolation = Interpolation::Step;
    keyframes.times_seconds[1] = 0.75;
    let samples = pixel_centers(&scene, 2);
    for (point, sample) in on_plane(&samples).filter(|(_, sample)| sample.instance.is_some()) {
        assert_motion(sample, Vec2::X * (point.x * -20.0), Vec2::ZERO);
    }
}

#[test]
fn a_surface_that_is_hidden_in_the_other_frame_moves_all_the_same() {
    let hide = |scene: &mut Scene| {
        animate(scene, AnimationTarget::Visibility(SQUARE), &[1.0], &[0.0]);
        let keyframes = &mut scene.animations.last_mut().unwrap().channels[0].keyframes;
        keyframes.interpolation = Interpolation::Step;
        keyframes.times_seconds[1] = 0.75;
    };
    let mut scene = square(PARALLEL, 5.0);
    animate(&mut scene, AnimationTarget::Translation(SQUARE), &[0.0; 3], &DISPLACEMENT);
    hide(&mut scene);
    assert_square_moves(&scene, 2, Vec2::new(3.0, -1.0), Vec2::new(-3.0, 1.0));
    // As what stays does where the camera moves.
    let mut scene = square(PARALLEL, 5.0);
    animate(&mut scene, AnimationTarget::Translation(CAMERA), &[-0.6, -0.2, 0.0], &[0.6, 0.2, 0.0]);
    hide(&mut scene);
    assert_square_moves(&scene, 2, Vec2::new(-3.0, 1.0), Vec2::new(3.0, -1.0));
}

#[test]
fn pixel_centers_sample_the_surface() {
    let scene = square(PARALLEL, 5.0);
    let samples = pixel_centers(&scene, 0);
    for (point, sample) in on_plane(&samples) {
        let is_square = point.x.abs() < 1.0;
        assert_eq!(sample.instance, is_square.then_some(0));
        if is_square {
            assert_eq!(
                (sample.depth, sample.geometric_normal, sample.shading_normal),
                (5.0, Vec3::Z, Vec3::Z)
            );
            assert!(sample.position.abs_diff_eq(point.extend(-5.0), 1e-6));
            assert!(sample.albedo.abs_diff_eq(Vec3::new(0.2, 0.4, 0.6), 1e-6));
            // Texture coordinates from the left and from the top.
            let expected = (Vec2::new(point.x, -point.y) + 1.0) * 0.5;
            assert!(sample.uv.is_some_and(|uv| uv.abs_diff_eq(expected, 1e-6)));
        }
    }
}
