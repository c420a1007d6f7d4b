//! Tests of whole frames: triangle ids, winding and flags.

use glam::{Mat4, Quat, Vec3};

use super::*;
use crate::bvh::TriangleFlags;
use crate::scene::{
    LocalTransform, Material, MaterialIndex, Mesh, MeshIndex, Node, NodeIndex, Primitive, Scene,
    SelectedCamera, Selection, Turntable,
};

fn triangle_primitive() -> Primitive {
    Primitive {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        material: MaterialIndex(0),
        ..Primitive::default()
    }
}

/// A scene of one triangle under one node for each scale.
fn scene_with_scales(scales: &[Vec3]) -> (Scene, Selection) {
    let local = |scale| LocalTransform::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale };
    let nodes = scales.iter().map(|&scale| Node {
        local: local(scale),
        mesh: Some(MeshIndex(0)),
        ..Default::default()
    });
    let order: Vec<_> = (0..scales.len() as u32).map(NodeIndex).collect();
    let scene = Scene {
        nodes: nodes.collect(),
        node_order: order.clone(),
        meshes: vec![Mesh { primitives: vec![triangle_primitive()], ..Default::default() }],
        materials: vec![Material::default()],
        ..Default::default()
    };
    let camera = SelectedCamera::Auto;
    (
        scene,
        Selection {
            roots: order,
            clips: Vec::new(),
            camera,
            camera_changes: crate::scene::CameraChanges::default(),
            image_light: None,
            variant: None,
        },
    )
}

#[test]
fn a_mirrored_triangle_keeps_its_front() {
    let (scene, selection) =
        scene_with_scales(&[Vec3::ONE, Vec3::new(1.0, 1.0, -1.0), Vec3::new(-1.0, 1.0, 1.0)]);
    let frame = Frame::at(&scene, &selection, 0.0);
    assert_eq!(frame.triangles[0].scaled_normal(), Vec3::Z);
    // The object-space normal +Z goes to −Z under a mirrored z; under a mirrored x it stays.
    assert_eq!(frame.triangles[1].scaled_normal(), Vec3::NEG_Z);
    assert_eq!(frame.triangles[2].scaled_normal(), Vec3::Z);
}

#[test]
fn overflowing_triangles_keep_their_id_and_are_hidden() {
    let (scene, selection) = scene_with_scales(&[Vec3::splat(1e30), Vec3::splat(f32::MAX), Vec3::ONE]);
    let mut scene = scene;
    scene.meshes[0].primitives[0].positions[1] = Vec3::splat(2.0);
    let frame = Frame::at(&scene, &selection, 0.0);
    let hidden: Vec<_> = frame.flags.iter().map(|flags| flags.has(TriangleFlags::HIDDEN)).collect();
    assert_eq!(hidden, [false, true, false]);
    assert_eq!(frame.instance_of_triangle, [0, 1, 2]);
}

#[test]
fn posing_again_equals_a_new_frame() {
    let (scene, selection) = scene_with_scales(&[Vec3::ONE, Vec3::splat(2.0)]);
    let (other, other_selection) = scene_with_scales(&[Vec3::splat(3.0); 5]);
    let mut frame = Frame::at(&other, &other_selection, 0.0);
    frame.pose(&scene, &selection, 0.0);
    let fresh = Frame::at(&scene, &selection, 0.0);
    assert_eq!(frame.triangles, fresh.triangles);
    assert_eq!(frame.vertices, fresh.vertices);
    assert_eq!(frame.instances, fresh.instances);
    assert_eq!(frame.camera, fresh.camera);
}

#[test]
fn only_the_camera_of_a_scene_without_clips_is_posed_again() {
    let (scene, mut selection) = scene_with_scales(&[Vec3::ONE, Vec3::splat(2.0)]);
    selection.camera = SelectedCamera::Turntable(Turntable {
        start: Mat4::from_translation(Vec3::Z),
        center: Vec3::ZERO,
        axis: Vec3::Y,
        turn_seconds: 2.0,
        projection: PosedCamera::default().projection,
    });
    let mut frame = Frame::at(&scene, &selection, 0.0);
    frame.pose_again(&scene, &selection, 0.25);
    let expected = Frame::at(&scene, &selection, 0.25);
    assert_eq!((frame.camera, frame.time_seconds), (expected.camera, 0.25));
    assert_eq!((&frame.triangles, &frame.vertices), (&expected.triangles, &expected.vertices));
}
