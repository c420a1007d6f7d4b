//! Animated properties, visibility and instances.

use glam::Vec3;
use serde_json::{Value, json};

use super::{Document, ImportOptions, import};
use crate::frame::Frame;
use crate::scene::{
    AnimationTarget, CameraIndex, CameraProperty, LightIndex, LightProperty, MaterialIndex, MaterialProperty,
    MeshIndex, NodeIndex, Scene, Selection, SelectionRequest, TextureSlot,
};

/// A triangle with everything that pointers can name.
fn stage() -> Document {
    let mut document = Document::triangle();
    let transform = json!({"index": 0, "extensions": {"KHR_texture_transform": {}}});
    document.json["images"] = json!([{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}]);
    document.json["textures"] = json!([{"source": 0}]);
    document.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorTexture": transform},
        "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}}
    }]);
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    document.attribute("TEXCOORD_0", "VEC2", &[0.0; 6]);
    document.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    document.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "spot": {}, "range": 4}
    ]}});
    document.json["nodes"] = json!([
        {"mesh": 0, "children": [1], "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]);
    document.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    document
}

/// Adds a clip that moves `pointer` from time 0 to 1.
fn moves(document: &mut Document, pointer: &str, interpolation: &str, shape: &str, values: &[f32]) {
    let output = document.floats(shape, values);
    moves_by(document, pointer, interpolation, output);
}

fn moves_by(document: &mut Document, pointer: &str, interpolation: &str, output: usize) {
    let input = document.floats("SCALAR", &[0.0, 1.0]);
    let clip = json!({
        "channels": [{"sampler": 0, "target": {
            "path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}
        }}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
    });
    document.push("animations", clip);
}

fn frame(scene: &Scene, time_seconds: f64) -> Frame {
    let (selection, _) = Selection::resolve(&SelectionRequest::default(), scene).unwrap();
    Frame::at(scene, &selection, time_seconds)
}

#[test]
fn pointers_name_properties_of_every_kind() {
    let material = |property| AnimationTarget::Material(MaterialIndex(0), property);
    let light = |property| AnimationTarget::Light(LightIndex(0), property);
    let slot = TextureSlot::BaseColor;
    for (pointer, shape, width, expected) in [
        ("/nodes/0/translation", "VEC3", 3, AnimationTarget::Translation(NodeIndex(0))),
        ("/nodes/1/rotation", "VEC4", 4, AnimationTarget::Rotation(NodeIndex(1))),
        (
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            "VEC4",
            4,
            material(MaterialProperty::BaseColor),
        ),
        (
            "/materials/0/pbrMetallicRoughness/roughnessFactor",
            "SCALAR",
            1,
            material(MaterialProperty::Roughness),
        ),
        ("/materials/0/emissiveFactor", "VEC3", 3, material(MaterialProperty::EmissiveFactor)),
        (
            "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength",
            "SCALAR",
            1,
            material(MaterialProperty::EmissiveStrength),
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset",
            "VEC2",
            2,
            material(MaterialProperty::TextureOffset(slot)),
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/rotation",
            "SCALAR",
            1,
            material(MaterialProperty::TextureRotation(slot)),
        ),
        ("/extensions/KHR_lights_punctual/lights/0/color", "VEC3", 3, light(LightProperty::Color)),
        ("/extensions/KHR_lights_punctual/lights/0/range", "SCALAR", 1, light(LightProperty::Range)),
        (
            "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle",
            "SCALAR",
            1,
            light(LightProperty::OuterCone),
        ),
        (
            "/cameras/0/perspective/yfov",
            "SCALAR",
            1,
            AnimationTarget::Camera(CameraIndex(0), CameraProperty::FieldOfView),
        ),
    ] {
        let mut document = stage();
        moves(&mut document, pointer, "LINEAR", shape, &vec![0.5; 2 * width]);
        let scene = document.import().unwrap();
        assert!(scene.warnings.is_empty(), "{pointer}: {:?}", scene.warnings);
        let channel = &scene.animations[0].channels[0];
        assert_eq!((channel.target, channel.keyframes.width), (expected, width), "{pointer}");
    }
}

#[test]
fn unknown_pointers_are_named_and_the_rest_plays() {
    for pointer in [
        "/materials/1/emissiveFactor",
        "/materials/0/name",
        "/materials/0/normalTexture/scale",
        "/cameras/0/perspective/zfar",
        "/cameras/0/orthographic/xmag",
        "/nodes/0/children",
        "nonsense",
        "/nodes/+0/scale",
    ] {
        let mut document = stage();
        moves(&mut document, pointer, "LINEAR", "SCALAR", &[0.5; 2]);
        moves(&mut document, "/nodes/0/scale", "LINEAR", "VEC3", &[0.5; 6]);
        let scene = document.import().unwrap();
        assert!(scene.animations[0].channels.is_empty() && scene.animations[1].channels.len() == 1);
        assert_eq!(scene.warnings.len(), 1, "{pointer}");
        assert!(scene.warnings[0].message.contains(pointer), "{:?}", scene.warnings);
    }
}

#[test]
fn wrong_values_of_properties_are_errors() {
    let base_color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    let visible = "/nodes/0/extensions/KHR_node_visibility/visible";
    for (pointer, interpolation, shape, values, expected) in [
        (base_color, "LINEAR", "VEC3", &[0.5; 6][..], "VEC3 of floats"),
        (base_color, "LINEAR", "VEC4", &[0.5; 4], "has 4 numbers"),
        (base_color, "LINEAR", "VEC4", &[1.5; 8], "must lie between 0 and 1"),
        ("/cameras/0/perspective/yfov", "LINEAR", "SCALAR", &[4.0; 2], "/output"),
        (visible, "STEP", "SCALAR", &[0.0; 2], "SCALAR of floats"),
    ] {
        let mut document = stage();
        moves(&mut document, pointer, interpolation, shape, values);
        let text = document.error(65);
        assert!(text.contains(expected), "{text}");
    }
    let mut document = stage();
    let switch = document.accessor(5121, "SCALAR", 2, &[0, 1]);
    moves_by(&mut document, visible, "LINEAR", switch);
    assert!(document.error(65).contains("must be STEP"));
    // A node moved by a pointer and by its name is moved twice.
    let mut document = stage();
    moves(&mut document, "/nodes/0/scale", "LINEAR", "VEC3", &[0.5; 6]);
    let named = json!({"sampler": 0, "target": {"node": 0, "path": "scale"}});
    document.json["animations"][0]["channels"].as_array_mut().unwrap().push(named);
    assert!(document.error(65).contains("another channel"));
}

#[test]
fn frames_carry_moved_materials_lights_and_cameras() {
    let mut document = stage();
    let strength = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
    moves(&mut document, strength, "LINEAR", "SCALAR", &[0.0, 8.0]);
    moves(&mut document, "/materials/0/emissiveFactor", "LINEAR", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.5, 0.0]);
    moves(
        &mut document,
        "/extensions/KHR_lights_punctual/lights/0/intensity",
        "LINEAR",
        "SCALAR",
        &[2.0, 6.0],
    );
    moves(&mut document, "/cameras/0/perspective/yfov", "LINEAR", "SCALAR", &[0.5, 1.5]);
    // A spline that overshoots its keys of 1 stays in the range of colours.
    let base_color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    let (zero, one, steep) = ([0.0; 4], [1.0; 4], [9.0; 4]);
    moves(&mut document, base_color, "CUBICSPLINE", "VEC4", &[zero, one, steep, zero, one, zero].concat());
    let scene = document.import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let frame = frame(&scene, 0.5);
    // Half way: factor (1/2, 1/4, 0), strength 4, intensity 4, field 1.
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
fn hidden_nodes_hide_what_is_below_but_not_the_camera() {
    let mut document = stage();
    let switch = document.accessor(5121, "SCALAR", 2, &[1, 0]);
    moves_by(&mut document, "/nodes/0/extensions/KHR_node_visibility/visible", "STEP", switch);
    let scene = document.import().unwrap();
    let hidden = |time| frame(&scene, time).flags[0].has(crate::bvh::PrimitiveFlags::HIDDEN);
    assert!(!hidden(0.5) && hidden(1.0));
    assert_eq!((frame(&scene, 0.5).lights.len(), frame(&scene, 1.0).lights.len()), (1, 0));
    assert_eq!(frame(&scene, 0.5).camera, frame(&scene, 1.0).camera);
    // At rest, and wrong.
    let mut document = stage();
    document.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(false);
    assert!(frame(&document.import().unwrap(), 0.0).lights.is_empty());
    document.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(0);
    assert!(document.error(65).contains("/nodes/0/extensions/KHR_node_visibility/visible"));
}

/// The triangle three times: moved, turned and scaled.
fn instanced() -> Document {
    let mut document = Document::triangle();
    let translation = document.floats("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let half = (i16::MAX as f32 * std::f32::consts::FRAC_1_SQRT_2) as i16;
    let turns = [[0, 0, 0, i16::MAX], [0, 0, half, half], [0, 0, 0, i16::MAX]];
    let bytes: Vec<u8> = turns.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let rotation = document.accessor(5122, "VEC4", 3, &bytes);
    document.json["accessors"][rotation]["normalized"] = json!(true);
    let scale = document.floats("VEC3", &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -2.0, 1.0, 1.0]);
    let attributes = json!({"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale});
    document.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    document.json["nodes"][0]["translation"] = json!([0, 0, 7]);
    document
}

fn attributes(document: &mut Document) -> &mut Value {
    &mut document.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
}

#[test]
fn instances_take_the_place_of_the_mesh() {
    let scene = instanced().import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let frame = frame(&scene, 0.0);
    // The node lifts everything by 7 along z; (1, 0, 0) is the second corner.
    assert_eq!((frame.triangles.len(), frame.shapes.len()), (3, 3));
    assert_eq!(frame.triangles[0].vertices[1], Vec3::new(1.0, 0.0, 7.0));
    // Turned by 90° about z, then moved by 5 along x.
    assert!(frame.triangles[1].vertices[1].abs_diff_eq(Vec3::new(5.0, 1.0, 7.0), 1e-4));
    // Mirrored: the last two corners change places.
    assert_eq!(frame.triangles[2].vertices[2], Vec3::new(-2.0, 0.0, 7.0));
    assert!(frame.shapes[2].mirrored && !frame.shapes[1].mirrored);
    assert_eq!(frame.shapes.iter().map(|shape| shape.instance).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(frame.shapes[2].mesh, MeshIndex(0));
}

#[test]
fn wrong_instances_name_their_place() {
    let mut document = instanced();
    let two = document.floats("VEC3", &[0.0; 6]);
    attributes(&mut document)["SCALE"] = json!(two);
    assert!(document.error(65).contains("/attributes/SCALE"), "counts differ");
    let mut document = instanced();
    let zeros = document.floats("VEC4", &[0.0; 12]);
    attributes(&mut document)["ROTATION"] = json!(zeros);
    assert!(document.error(65).contains("length zero"));
    let mut document = instanced();
    *attributes(&mut document) = json!({});
    assert!(document.error(65).contains("must not be empty"));
    // Many instances of one triangle are more than memory holds.
    let mut document = Document::triangle();
    let many = json!({"componentType": 5126, "type": "VEC3", "count": 100_000_000});
    let many = document.push("accessors", many);
    document.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": many}}});
    assert!(document.error(77).contains("--max-memory"));
    // Each takes a place among the shapes besides its matrix and its triangle: 20 000 · (12 + 64 + 160 + 256) B.
    let mut document = Document::triangle();
    let often = document.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 20_000}));
    document.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": often}}});
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document.to_json().to_string()).unwrap();
    let within = |max_memory_bytes| import(&path, &ImportOptions { max_memory_bytes });
    assert!(within(12_000_000).is_ok());
    assert!(within(7_000_000).unwrap_err().to_string().contains("/scenes/0"));
}
