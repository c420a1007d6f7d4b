//! The automatic camera on the scenes of `scenes/showcase/`.

#![expect(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::collections::BTreeSet;
use std::path::Path;

use glam::{Mat4, Vec2, Vec3};
use rayframe::bvh::{BuildSettings, Builder, TraversalCounters};
use rayframe::cancel::CancelFlag;
use rayframe::frame::Frame;
use rayframe::framing::{CameraRule, ResolvedCamera, resolve_camera};
use rayframe::geometry::Ray;
use rayframe::gltf::{ImportOptions, import};
use rayframe::scene::{NodeIndex, Scene, SelectedCamera, ViewRequest};

use crate::framing::image_bounds;
use crate::stage::select_all;

const ASPECT_RATIO: f32 = 16.0 / 9.0;

fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/showcase").join(name);
    import(&path, &ImportOptions::default()).unwrap()
}

fn automatic(scene: &Scene) -> ResolvedCamera {
    resolve_camera(scene, select_all(scene, SelectedCamera::Auto), &ViewRequest::default(), ASPECT_RATIO)
}

fn world_from_camera(camera: &ResolvedCamera) -> Mat4 {
    let SelectedCamera::Fixed { world_from_camera, .. } = camera.selection.camera else { panic!() };
    world_from_camera
}

/// Names of the nodes that rays through an image of 48 by 27 pixels hit first.
fn visible_nodes(scene: &Scene, camera: &ResolvedCamera) -> BTreeSet<String> {
    let frame = Frame::at(scene, &camera.selection, 0.0);
    let settings = BuildSettings::default();
    let bvh = Builder::default()
        .build(&frame.triangles, &frame.flags, &settings, &CancelFlag::new(), None)
        .unwrap();
    let world_from_camera = frame.camera.world_from_camera;
    let half = frame.camera.projection.half_size(ASPECT_RATIO);
    let mut names = BTreeSet::new();
    for (row, column) in (0..27).flat_map(|row| (0..48).map(move |column| (row, column))) {
        let share = Vec2::new((column as f32 + 0.5) / 48.0, (row as f32 + 0.5) / 27.0);
        let image = (share * 2.0 - 1.0) * Vec2::new(1.0, -1.0) * half;
        let direction = world_from_camera.transform_vector3(image.extend(-1.0));
        let ray = Ray::new(world_from_camera.w_axis.truncate(), direction);
        if let Some(hit) = bvh.closest_hit(&ray, None, |_| true, &mut TraversalCounters::default()) {
            let instance = frame.instance_of_triangle[hit.triangle as usize];
            let node = frame.instances[instance as usize].node;
            names.extend(scene.nodes[node.index()].name.clone());
        }
    }
    names
}

#[test]
fn the_apartment_is_seen_from_inside() {
    let scene = scene("apartment.gltf");
    let camera = automatic(&scene);
    assert_eq!(camera.rule, CameraRule::Inside);
    let position = world_from_camera(&camera).w_axis.truncate();
    assert!(position.abs().cmplt(Vec3::new(5.0, 2.7, 3.5)).all(), "{position}");
    let names = visible_nodes(&scene, &camera);
    let furniture =
        ["sofa", "armchair", "coffee table", "shelf", "chair", "dining table", "rug", "floor lamp"];
    assert!(names.len() >= 12, "{names:?}");
    assert!(furniture.iter().filter(|name| names.contains(**name)).count() >= 5, "{names:?}");
}

#[test]
fn joints_are_framed_by_their_skin() {
    let scene = scene("character.gltf");
    let node = |name: &str| scene.nodes.iter().position(|node| node.name.as_deref() == Some(name)).unwrap();
    let framed = |name| {
        let node = Some(NodeIndex(node(name) as u32));
        let request = ViewRequest { node, ..ViewRequest::default() };
        let selection = select_all(&scene, SelectedCamera::Auto);
        world_from_camera(&resolve_camera(&scene, selection, &request, ASPECT_RATIO)).w_axis.truncate()
    };
    let (head, all) = (framed("head"), world_from_camera(&automatic(&scene)).w_axis.truncate());
    let skull = Frame::at(&scene, &select_all(&scene, SelectedCamera::Auto), 0.0);
    let skull = skull.node_position(NodeIndex(node("head") as u32)).unwrap();
    assert!(head.distance(skull) < 0.5 * all.distance(skull), "{head} {all} {skull}");
    // The hips hold the whole body.
    assert!(framed("hips").distance(all) < 0.2 * all.distance(skull));
}

#[test]
fn the_level_is_framed_as_without_its_dome() {
    let mut scene = scene("level.gltf");
    let with_dome = automatic(&scene);
    let dome = scene.nodes.iter_mut().find(|node| node.name.as_deref() == Some("sky dome")).unwrap();
    dome.mesh = None;
    let without_dome = automatic(&scene);
    assert_eq!((with_dome.rule, without_dome.rule), (CameraRule::Outside, CameraRule::Outside));
    let [with_dome, without_dome] = [&with_dome, &without_dome].map(world_from_camera);
    assert!(with_dome.abs_diff_eq(without_dome, 1e-3), "{with_dome} {without_dome}");
}

#[test]
fn the_character_fills_the_image_in_all_frames() {
    let scene = scene("character.gltf");
    let camera = automatic(&scene);
    let frames = (camera.selection.duration_seconds(&scene) * 24.0) as u32;
    assert!(frames >= 24);
    for frame in 0..=frames {
        let [min, max] = image_bounds(&scene, &camera, ASPECT_RATIO, f64::from(frame) / 24.0);
        let filled = (max - min).max_element() / 2.0;
        assert!((0.25..=0.85).contains(&filled), "frame {frame}: {min} to {max}");
        assert!(
            min.cmpgt(Vec2::splat(-1.0)).all() && max.cmplt(Vec2::ONE).all(),
            "frame {frame}: {min} to {max}"
        );
    }
}
