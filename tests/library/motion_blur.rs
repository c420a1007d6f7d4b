//! Motion blur: an open shutter records the mean over its time.

use glam::{Mat4, Vec3, Vec4};
use rayframe::cancel::CancelFlag;
use rayframe::regression::Image;
use rayframe::scene::{
    AnimationTarget, Material, Mesh, MeshIndex, Node, NodeIndex, Projection, Scene, SelectedCamera,
};
use rayframe::sequence::{FrameRate, Plan, Shutter, run};

use crate::stage::{animate, rectangle, sequence_job};

/// A white half plane x < 0 that moves by one metre along x from 0 s to 1 s.
fn moving_edge() -> Scene {
    let mut scene = Scene {
        nodes: vec![Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
        node_order: vec![NodeIndex(0)],
        meshes: vec![Mesh {
            primitives: vec![rectangle(Vec3::X * -4.5, Vec3::X * 4.5, Vec3::Y * 9.0)],
            ..Mesh::default()
        }],
        materials: vec![Material { base_color: Vec4::ONE, unlit: true, ..Material::default() }],
        ..Scene::default()
    };
    animate(&mut scene, AnimationTarget::Translation(NodeIndex(0)), &[0.0; 3], &[1.0, 0.0, 0.0]);
    scene
}

/// Renders eight pixels in a row from x = 0 to x = 1 m, of frame 1 at 2 fps: 0.5 s.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(shutter: Shutter, samples: u32) -> Vec<f32> {
    let folder = tempfile::tempdir().unwrap();
    let camera = SelectedCamera::Fixed {
        world_from_camera: Mat4::from_translation(Vec3::new(0.5, 0.0, 5.0)),
        projection: Projection::Orthographic { x_mag: 0.5, y_mag: 0.0625, z_near: 0.0, z_far: 10.0 },
    };
    let mut job = sequence_job(moving_edge(), camera, (8, 1), &folder.path().join("a.####.exr"));
    job.rate = FrameRate::parse("2").unwrap();
    job.shutter = shutter;
    job.render.samples = samples;
    let plan = Plan::new(&job).unwrap();
    plan.prepare().unwrap();
    run(&job, &plan, &CancelFlag::new(), &|_| ()).outcome().unwrap();
    let image = Image::read(&folder.path().join("a.0001.exr")).unwrap();
    image.rgba().unwrap().iter().map(|pixel| pixel[0]).collect()
}

#[test]
fn a_closed_shutter_shows_the_frames_own_time() {
    // The edge is at 0.5 m: four white pixels, four black ones.
    assert_eq!(render(Shutter::default(), 4), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn a_moving_edge_is_a_ramp_as_long_as_its_way() {
    // Open for one frame of half a second around 0.5 s the edge goes from 0.25 to 0.75 m: pixels 2 to 5. The pixel from x to
    // x + 1/8 is white as long as the edge is beyond it: 7/8, 5/8, 3/8 and 1/8 of the time on average.
    let expected = [1.0, 1.0, 0.875, 0.625, 0.375, 0.125, 0.0, 0.0];
    for (time_samples, samples) in [(64, 1), (16, 64)] {
        let seen = render(Shutter { open: 1.0, time_samples }, samples);
        for (pixel, (seen, expected)) in seen.iter().zip(expected).enumerate() {
            assert!(
                (seen - expected).abs() < 0.04,
                "{time_samples}: pixel {pixel}: {seen} is not {expected}"
            );
        }
    }
}
