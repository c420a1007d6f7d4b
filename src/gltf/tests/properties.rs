//! Animated properties in posed frames: materials, lights, cameras, morph weights and visibility.

use glam::Vec3;
use serde_json::json;

use super::Document;
use super::pointers::{animatable, animate, animate_with};
use crate::frame::Frame;
use crate::scene::{Scene, Selection, SelectionRequest};

/// Poses the default selection of `scene`.
pub(super) fn frame(scene: &Scene, time_seconds: f64) -> Frame {
    let (selection, _) = Selection::resolve(&SelectionRequest::default(), scene).unwrap();
    Frame::at(scene, &selection, time_seconds)
}

#[test]
fn posed_frames_contain_animated_materials_lights_and_cameras() {
    let mut document = animatable();
    let strength = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
    animate(&mut document, strength, "LINEAR", "SCALAR", &[0.0, 8.0]);
    animate(&mut document, "/materials/0/emissiveFactor", "LINEAR", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.5, 0.0]);
    animate(
        &mut document,
        "/extensions/KHR_lights_punctual/lights/0/intensity",
        "LINEAR",
        "SCALAR",
        &[2.0, 6.0],
    );
    animate(&mut document, "/cameras/0/perspective/yfov", "LINEAR", "SCALAR", &[0.5, 1.5]);
    // A cubic spline that overshoots its keyframes of 1 is clamped to the range of colours.
    let base_color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    let (zero, one, steep) = ([0.0; 4], [1.0; 4], [9.0; 4]);
    animate(&mut document, base_color, "CUBICSPLINE", "VEC4", &[zero, one, steep, zero, one, zero].concat());
    let scene = document.import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let frame = frame(&scene, 0.5);
    // At half time: factor (1/2, 1/4, 0), strength 4, intensity 4, field of view 1.
    assert_eq!(frame.materials[0].emissive, Vec3::new(2.0, 1.0, 0.0));
    assert_eq!(frame.materials[0].base_color, glam::Vec4::ONE);
    assert_eq!(frame.lights[0].light.intensity, 4.0);
    let crate::scene::Projection::Perspective { fov_y_radians, .. } = frame.camera.projection else {
        panic!("perspective");
    };
    assert_eq!(fov_y_radians, 1.0);
    assert_eq!(scene.materials[0].emissive, Vec3::splat(2.0), "the scene itself stays");
}

#[test]
fn animated_thickness_and_image_light_rotation_reach_the_frame() {
    let mut document = animatable();
    document.json["meshes"][0]["primitives"][0]["material"] = json!(1);
    let thickness = "/materials/1/extensions/KHR_materials_volume/thicknessFactor";
    animate(&mut document, thickness, "STEP", "SCALAR", &[0.0, 2.0]);
    let lights = "/extensions/EXT_lights_image_based/lights/0";
    animate(&mut document, &format!("{lights}/intensity"), "LINEAR", "SCALAR", &[0.0, 4.0]);
    // Rotation by half a turn about +Y: a quarter turn at half time.
    let turn = [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
    animate(&mut document, &format!("{lights}/rotation"), "LINEAR", "VEC4", &turn);
    let scene = document.import().unwrap();
    assert!(
        scene.warnings.iter().all(|warning| !warning.message.contains("not animated")),
        "{:?}",
        scene.warnings
    );
    let is_volume = |time| frame(&scene, time).materials[1].is_volume();
    assert!(!is_volume(0.5) && is_volume(1.0));
    let pose = frame(&scene, 0.5).image_light.unwrap();
    assert_eq!(pose.intensity, 2.0);
    assert!(
        (pose.rotation.y - 0.5_f32.sqrt()).abs() < 1e-6 && (pose.rotation.w - 0.5_f32.sqrt()).abs() < 1e-6
    );
    // A quaternion of length zero is no rotation.
    let mut document = animatable();
    animate(&mut document, &format!("{lights}/rotation"), "LINEAR", "VEC4", &[0.0; 8]);
    assert!(document.error(65).contains("length zero"));
}

/// Triangle with two morph targets, which raise its vertices by 1 and by 10, with weights 1/2 and 1.
fn morphing() -> Document {
    let mut document = Document::triangle();
    let by = |height: f32| [0.0, 0.0, height].repeat(3);
    let targets = [document.floats("VEC3", &by(1.0)), document.floats("VEC3", &by(10.0))];
    document.json["meshes"][0]["primitives"][0]["targets"] =
        json!(targets.map(|index| json!({"POSITION": index})));
    document.json["meshes"][0]["weights"] = json!([0.5, 1.0]);
    document.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    document
}

#[test]
fn single_weights_do_not_change_the_other_weights() {
    let height = |document: &Document, time| {
        let scene = document.import().unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        frame(&scene, time).triangles[0].vertices[0].z
    };
    let mut document = morphing();
    assert_eq!(height(&document, 0.0), 10.5);
    // The mesh's second weight is animated to 0: 0.5 · 1 + 0.5 · 10 at half time.
    animate(&mut document, "/meshes/0/weights/1", "LINEAR", "SCALAR", &[1.0, 0.0]);
    assert_eq!(height(&document, 0.5), 5.5);
    // The node's first weight overrides the mesh's: 2 · 1 + 0.5 · 10.
    animate(&mut document, "/nodes/0/weights/0", "LINEAR", "SCALAR", &[1.0, 3.0]);
    assert_eq!(height(&document, 0.5), 7.0);
    // The node's own weights override the mesh's: 2 · 1 + 0.25 · 10.
    document.json["nodes"][0]["weights"] = json!([0.0, 0.25]);
    assert_eq!(height(&document, 0.5), 4.5);
}

#[test]
fn missing_or_twice_animated_single_weights_are_errors() {
    let mut document = morphing();
    animate(&mut document, "/nodes/0/weights/2", "LINEAR", "SCALAR", &[1.0, 0.0]);
    assert!(document.error(65).contains("no morph target 2"));
    let mut document = morphing();
    animate(&mut document, "/nodes/0/weights/1", "LINEAR", "SCALAR", &[1.0, 0.0]);
    let all = document.floats("SCALAR", &[0.0; 4]);
    let input = document.floats("SCALAR", &[0.0, 1.0]);
    let clip = &mut document.json["animations"][0];
    clip["samplers"].as_array_mut().unwrap().push(json!({"input": input, "output": all}));
    let named = json!({"sampler": 1, "target": {"node": 0, "path": "weights"}});
    clip["channels"].as_array_mut().unwrap().push(named);
    assert!(document.error(65).contains("another channel"));
}

#[test]
fn hidden_nodes_hide_their_subtree_but_not_the_camera() {
    let mut document = animatable();
    let switch = document.accessor(5121, "SCALAR", 2, &[1, 0]);
    animate_with(&mut document, "/nodes/0/extensions/KHR_node_visibility/visible", "STEP", switch);
    let scene = document.import().unwrap();
    let hidden = |time| frame(&scene, time).flags[0].has(crate::bvh::TriangleFlags::HIDDEN);
    assert!(!hidden(0.5) && hidden(1.0));
    assert_eq!((frame(&scene, 0.5).lights.len(), frame(&scene, 1.0).lights.len()), (1, 0));
    assert_eq!(frame(&scene, 0.5).camera, frame(&scene, 1.0).camera);
    // Hidden without animation, and an invalid value.
    let mut document = animatable();
    document.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(false);
    assert!(frame(&document.import().unwrap(), 0.0).lights.is_empty());
    document.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(0);
    assert!(document.error(65).contains("/nodes/0/extensions/KHR_node_visibility/visible"));
}
