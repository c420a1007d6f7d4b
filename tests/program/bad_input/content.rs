//! Files with invalid content or unsupported required features.

use serde_json::{Value, json};

use super::stage::Stage;
use super::triangle::{BUFFER_BYTES, INDICES, POSITIONS, document, embedded, glb, triangle};

#[test]
fn a_truncated_glb_fails_at_any_length() {
    let whole = glb(&document(None));
    let bin_start = whole.len() - 8 - BUFFER_BYTES.next_multiple_of(4);
    for length in [0, 3, 4, 11, 12, 19, 20, 100, bin_start, bin_start + 4, bin_start + 20, whole.len() - 1] {
        Stage::new("cut.glb", &whole[..length]).assert_fails("cut.glb", (65, &["cut.glb: "]));
    }
}

#[test]
fn chunks_with_a_wrong_length_fail() {
    for length in [u32::MAX, u32::MAX - 3, 1 << 31] {
        let mut file = glb(&document(None));
        file[12..16].copy_from_slice(&length.to_le_bytes());
        Stage::new("lie.glb", &file).assert_fails("lie.glb", (65, &["lie.glb: ", "truncated or damaged"]));
    }
}

/// `output` is a setting, too, and the program shows settings as its options.
#[test]
fn fields_of_the_file_are_not_shown_as_options() {
    let mut document = triangle();
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
    document["animations"] = json!([{ "channels": [channel], "samplers": [{ "input": 0 }] }]);
    let expected = (65, ["/animations/0", "\"output\""].as_slice());
    Stage::with(&document).assert_fails("bad.gltf", expected);
}

#[test]
fn a_missing_buffer_is_named_with_its_json_pointer() {
    let stage = Stage::with(&document(Some("gone.bin")));
    stage.assert_fails("bad.gltf", (66, &["gone.bin", "bad.gltf", "/buffers/0/uri"]));
}

#[test]
fn a_buffer_that_is_too_short_fails() {
    let stage = Stage::with(&document(Some("short.bin")));
    std::fs::write(stage.folder.path().join("scene/short.bin"), [0; BUFFER_BYTES - 1]).unwrap();
    stage.assert_fails("bad.gltf", (65, &["bad.gltf: ", "/buffers/0"]));
}

#[test]
fn indices_past_the_end_fail_in_every_array() {
    let spoil = |pointer: &str, value: Value| {
        let mut spoiled = triangle();
        *spoiled.pointer_mut(pointer).unwrap() = value;
        Stage::with(&spoiled)
    };
    for (stage, at) in [
        (Stage::with(&embedded(&POSITIONS, &[0, 1, 3])), "/accessors/1: "),
        // The primitive restart value is not a valid index.
        (Stage::with(&embedded(&POSITIONS, &[0, 1, u16::MAX])), "/accessors/1: "),
        (spoil("/meshes/0/primitives/0/indices", json!(2)), "/meshes/0/primitives/0/indices: "),
        (
            spoil("/meshes/0/primitives/0/attributes/POSITION", json!(9)),
            "/meshes/0/primitives/0/attributes/POSITION: ",
        ),
        (spoil("/nodes/0/mesh", json!(1)), "/nodes/0/mesh: "),
        (spoil("/scenes/0/nodes/0", json!(1)), "/scenes/0/nodes"),
        (spoil("/scene", json!(1)), "/scene: "),
        (spoil("/bufferViews/1/buffer", json!(1)), "/bufferViews/1"),
        (spoil("/bufferViews/1/byteLength", json!(7)), "/bufferViews/1"),
        (spoil("/bufferViews/0/byteOffset", json!(u64::MAX)), "/bufferViews/0"),
        (spoil("/accessors/0/count", json!(4)), "/accessors/0"),
        (spoil("/accessors/0/count", json!(u64::MAX)), "/accessors/0"),
        (spoil("/accessors/0/bufferView", json!(2)), "/accessors/0"),
    ] {
        stage.assert_fails("bad.gltf", (65, &["bad.gltf: ", at]));
    }
}

#[test]
fn positions_that_are_not_finite_fail() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut positions = POSITIONS;
        positions[1][2] = value;
        let stage = Stage::with(&embedded(&positions, &INDICES));
        stage.assert_fails("bad.gltf", (65, &["bad.gltf: ", "/accessors/0: ", "element 1"]));
    }
}

#[test]
fn nodes_that_are_not_trees_fail() {
    for (nodes, at) in [
        (json!([{ "mesh": 0, "children": [0] }]), "/nodes/0"),
        (json!([{ "children": [1] }, { "mesh": 0, "children": [0] }]), "/nodes/0"),
        // A root above a cycle gives the first node of the cycle two parents.
        (json!([{ "children": [1] }, { "children": [2] }, { "mesh": 0, "children": [1] }]), "/nodes/"),
        (json!([{ "children": [1, 2] }, { "children": [2] }, { "mesh": 0 }]), "/nodes/"),
    ] {
        let mut cyclic = triangle();
        cyclic["nodes"] = nodes;
        Stage::with(&cyclic).assert_fails("bad.gltf", (65, &["bad.gltf: ", at]));
    }
}

#[test]
fn an_unknown_required_extension_is_named() {
    let mut document = triangle();
    document["extensionsUsed"] = json!(["ACME_hologram"]);
    document["extensionsRequired"] = json!(["ACME_hologram"]);
    let words = ["bad.gltf: ", "/extensionsRequired: ", "ACME_hologram"];
    Stage::with(&document).assert_fails("bad.gltf", (65, &words));
}

#[test]
fn an_unknown_optional_extension_is_one_warning_or_a_strict_error() {
    let mut document = triangle();
    document["extensionsUsed"] = json!(["ACME_hologram"]);
    document["nodes"][0]["extensions"] = json!({ "ACME_hologram": { "depth": 2 } });
    let stage = Stage::with(&document);
    let words =
        ["bad.gltf: ", "/nodes/0/extensions/ACME_hologram: ", "ACME_hologram is not supported", "--strict"];
    stage.assert_fails_with("bad.gltf", &["-o", "out/a.exr", "--strict"], (65, &words));

    let run = stage.render("bad.gltf", &["-o", "out/a.exr"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert!(run.stderr.starts_with("rayframe: warning: scene/bad.gltf: /nodes/0/"), "{}", run.stderr);
    assert!(stage.folder.path().join("out/a.exr").is_file());
}

#[test]
fn files_that_are_not_gltf_fail() {
    for content in ["", "{", "[]", "null", "PNG", "{}", r#"{"asset":{"version":"1.0"}}"#] {
        Stage::new("bad.gltf", content).assert_fails("bad.gltf", (65, &["bad.gltf: "]));
    }
    // Nested deeper than the stack of any parser.
    let deep = format!("{}{}", "[".repeat(200_000), "]".repeat(200_000));
    Stage::new("bad.gltf", deep).assert_fails("bad.gltf", (65, &["bad.gltf: "]));
}
