use glam::{Mat4, Quat, Vec3};
use serde_json::json;

use super::Document;
use super::pointers::animate;
use crate::frame::Frame;
use crate::scene::{
    AnimationTarget, Interpolation, LocalTransform, NodeIndex, Scene, Selection, SelectionRequest,
};

/// Document with an animation of node 0 along `path` with the given keyframes.
fn clip(path: &str, interpolation: &str, times: &[f32], shape: &str, values: &[f32]) -> Document {
    let mut document = Document::triangle();
    let input = document.floats("SCALAR", times);
    let output = document.floats(shape, values);
    document.json["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
    }]);
    document
}

#[test]
fn keyframes_of_each_interpolation_are_read() {
    let scene = clip("scale", "STEP", &[0.0, 1.0], "VEC3", &[1.0; 6]).import().unwrap();
    let channel = &scene.animations[0].channels[0];
    assert_eq!(channel.target, AnimationTarget::Scale(NodeIndex(0)));
    assert_eq!(channel.keyframes.interpolation, Interpolation::Step);
    assert_eq!((channel.keyframes.width, channel.keyframes.values.len()), (3, 6));
    let scene = clip("translation", "CUBICSPLINE", &[0.5], "VEC3", &[1.0; 9]).import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.values.len(), 9);
    assert_eq!(scene.animations[0].duration_seconds(), 0.5);
}

#[test]
fn wrong_keys_are_errors() {
    for (document, expected) in [
        (clip("scale", "LINEAR", &[1.0, 0.5], "VEC3", &[1.0; 6]), "must increase"),
        (clip("scale", "LINEAR", &[0.0, f32::NAN], "VEC3", &[1.0; 6]), "not a number"),
        (clip("scale", "LINEAR", &[0.0, 1.0], "VEC3", &[1.0; 3]), "/output: has 3 numbers"),
        (clip("scale", "CUBICSPLINE", &[0.0], "VEC3", &[1.0; 3]), "/output"),
        (clip("scale", "LINEAR", &[0.0], "VEC4", &[1.0; 4]), "VEC4"),
        (clip("scale", "BEZIER", &[0.0], "VEC3", &[1.0; 3]), "/interpolation"),
        (clip("rotation", "LINEAR", &[0.0], "VEC4", &[0.0; 4]), "length zero"),
    ] {
        let text = document.error(65);
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn normalized_rotations_are_converted() {
    let mut document = clip("rotation", "LINEAR", &[0.0], "VEC4", &[1.0; 4]);
    let bytes: Vec<u8> = [0_i16, -32767, 0, 0].iter().flat_map(|c| c.to_le_bytes()).collect();
    let output = document.accessor(5122, "VEC4", 1, &bytes);
    document.json["accessors"][output]["normalized"] = json!(true);
    document.json["animations"][0]["samplers"][0]["output"] = json!(output);
    let scene = document.import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.values, [0.0, -1.0, 0.0, 0.0]);
}

#[test]
fn weights_have_one_component_per_target() {
    let mut document = clip("weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0, 1.0, 0.0]);
    document.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}, {"POSITION": 0}]);
    let scene = document.import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.width, 2);
}

#[test]
fn weights_without_morph_targets_are_ignored_with_a_warning() {
    let pointer = |pointer: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
    let mut document = clip("weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0]);
    document.json["nodes"] = json!([{"mesh": 0, "children": [1]}, {}]);
    for target in [
        json!({"node": 0, "path": "weights"}),
        json!({"node": 1, "path": "weights"}),
        pointer("/nodes/0/weights"),
        pointer("/meshes/0/weights/0"),
    ] {
        document.json["animations"][0]["channels"][0]["target"] = target;
        let scene = document.import().unwrap();
        assert!(scene.animations[0].channels.is_empty());
        let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
        assert_eq!(warning.pointer, "/animations/0/channels/0/target");
        assert!(warning.message.contains("without morph targets"), "{warning}");
    }
}

#[test]
fn weights_of_meshes_without_triangles_are_ignored() {
    let mut document = clip("weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0, 1.0, 0.0]);
    let primitive = &mut document.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{"POSITION": 0}, {"POSITION": 0}]);
    primitive["mode"] = json!(0);
    let pointer = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/meshes/0/weights/1"}}});
    for target in [json!({"node": 0, "path": "weights"}), pointer] {
        document.json["animations"][0]["channels"][0]["target"] = target;
        let scene = document.import().unwrap();
        assert!(scene.animations[0].channels.is_empty());
        assert!(scene.warnings.iter().any(|warning| warning.pointer.starts_with("/meshes/0/primitives/0")));
    }
}

#[test]
fn first_keys_before_time_0_by_a_rounding_error_are_at_time_0() {
    let scene = clip("scale", "LINEAR", &[-1e-8, 0.5], "VEC3", &[1.0; 6]).import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.times_seconds, [0.0, 0.5]);
}

#[test]
fn keys_before_time_0_are_kept_with_a_warning() {
    for (times, duration) in [([-1.0, 0.5], 0.5), ([-2.0, -1.0], 0.0)] {
        let scene = clip("scale", "LINEAR", &times, "VEC3", &[1.0; 6]).import().unwrap();
        assert_eq!(scene.animations[0].channels[0].keyframes.times_seconds, times);
        assert_eq!(scene.animations[0].duration_seconds(), duration);
        let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
        assert_eq!(warning.pointer, "/animations/0/samplers/0/input");
        assert!(warning.message.contains("before time 0"), "{warning}");
    }
    assert!(clip("scale", "LINEAR", &[-1.0, -2.0], "VEC3", &[1.0; 6]).error(65).contains("must increase"));
}

#[test]
fn duplicate_targets_are_errors_and_missing_nodes_are_ignored() {
    let mut document = clip("scale", "LINEAR", &[0.0], "VEC3", &[1.0; 3]);
    let channel = document.json["animations"][0]["channels"][0].clone();
    document.json["animations"][0]["channels"] = json!([channel, channel]);
    assert!(document.error(65).contains("another channel"));

    let mut document = clip("scale", "LINEAR", &[0.0], "VEC3", &[1.0; 3]);
    document.json["animations"][0]["channels"] = json!([
        {"sampler": 0, "target": {"path": "scale"}},
        {"sampler": 0, "target": {"node": 0, "path": "color"}},
        {"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/x"}}}}
    ]);
    let scene = document.import().unwrap();
    assert!(scene.animations[0].channels.is_empty());
    let messages: Vec<&str> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(messages.len(), 2);
    assert!(messages[0].contains("\"color\"") && messages[1].contains("property /x"));
}

/// Asserts that node 0 has one pose with the matrix and with the same translation, rotation and scale. Node 0 is animated.
#[track_caller]
fn assert_matrix_is_decomposed(mut document: Document) {
    let rotation = Quat::from_xyzw(0.5, -0.1, 0.7, 0.5).normalize();
    let (scale, translation) = (Vec3::new(-2.0, 0.5, 3.0), Vec3::new(1.0, -2.0, 3.0));
    let matrix = Mat4::from_scale_rotation_translation(scale, rotation, translation);
    document.json["nodes"][0]["matrix"] = json!(matrix.to_cols_array());
    let of_matrix = document.import().unwrap();
    let node = &mut document.json["nodes"][0];
    node.as_object_mut().unwrap().remove("matrix");
    node["translation"] = json!(translation.to_array());
    node["rotation"] = json!(rotation.to_array());
    node["scale"] = json!(scale.to_array());
    let of_parts = document.import().unwrap();
    let pose = |scene: &Scene| {
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), scene).unwrap();
        Frame::at(scene, &selection, 0.25).triangles[0].vertices
    };
    let [first, second] = [&of_matrix, &of_parts].map(pose);
    for (first, second) in first.into_iter().zip(second) {
        assert!(first.abs_diff_eq(second, 1e-5), "{first} {second}");
    }
    let [warning] = &of_matrix.warnings[..] else { panic!("{:?}", of_matrix.warnings) };
    assert_eq!(warning.pointer, "/nodes/0/matrix");
    assert!(warning.message.contains("animated nodes have a matrix"), "{warning}");
    assert_eq!(of_parts.warnings, []);
}

#[test]
fn matrices_of_animated_nodes_are_decomposed() {
    let keys = [0.5, 0.5, 0.5, 0.5, 1.0, 0.0, 0.0, 0.0];
    for (path, shape, values) in
        [("translation", "VEC3", &keys[..6]), ("rotation", "VEC4", &keys), ("scale", "VEC3", &keys[..6])]
    {
        assert_matrix_is_decomposed(clip(path, "LINEAR", &[0.0, 1.0], shape, values));
        let mut document = Document::triangle();
        document.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
        animate(&mut document, &format!("/nodes/0/{path}"), "LINEAR", shape, values);
        assert_matrix_is_decomposed(document);
    }
}

#[test]
fn shear_of_animated_nodes_is_left_out_with_a_warning() {
    let mut document = clip("translation", "LINEAR", &[0.0], "VEC3", &[1.0; 3]);
    document.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    let scene = document.import().unwrap();
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert_eq!(warning.pointer, "/nodes/0/matrix");
    assert!(warning.message.contains("the shear is left out"), "{warning}");
    // Other channels leave the matrix as it is.
    document.json["animations"] = json!([]);
    let scene = document.import().unwrap();
    assert!(matches!(scene.nodes[0].local, LocalTransform::Matrix(_)) && scene.warnings.is_empty());
}

#[test]
fn keys_of_one_time_are_a_sudden_change_and_a_warning() {
    let scene = clip("scale", "LINEAR", &[0.0, 1.0, 1.0, 2.0], "VEC3", &[1.0; 12]).import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.times_seconds, [0.0, 1.0, 1.0, 2.0]);
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert!(warning.message.starts_with("keyframe 1 has the time of the next"), "{warning}");
    let backwards = clip("scale", "LINEAR", &[0.0, 1.0, 1.0, 0.5], "VEC3", &[1.0; 12]);
    assert!(backwards.error(65).contains("keyframe 2 is after the next"));
}

#[test]
fn keys_without_stored_data_share_time_zero() {
    let mut document = clip("scale", "LINEAR", &[0.0, 1.0], "VEC3", &[1.0; 6]);
    let input = &mut document.json["accessors"][1];
    input.as_object_mut().unwrap().remove("bufferView");
    (input["min"], input["max"]) = (json!([0]), json!([1]));
    let scene = document.import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.times_seconds, [0.0, 0.0]);
    assert_eq!(scene.warnings, []);
}
