//! The warning about coordinates that 32-bit floats round visibly.

use serde_json::json;

use super::Document;

/// Triangle whose edges at the right angle have this length, at a distance along x.
fn triangle(distance: f32, edge: f32) -> Document {
    let mut document = Document::triangle();
    let positions = [distance, 0.0, 0.0, distance + edge, 0.0, 0.0, distance, edge, 0.0];
    document.attribute("POSITION", "VEC3", &positions);
    document
}

#[track_caller]
fn assert_warns(document: &Document, pointer: &str, message: &str) {
    let scene = document.import().unwrap();
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert_eq!((warning.pointer.as_str(), warning.message.as_str()), (pointer, message));
}

#[track_caller]
fn assert_silent(document: &Document) {
    assert_eq!(document.import().unwrap().warnings, []);
}

const FAR: &str =
    "world coordinates near 5000000 have steps of 0.5, and the mesh is 1 wide; move it near the origin";

#[test]
fn meshes_that_are_rounded_are_named() {
    assert_warns(&triangle(5e6, 1.0), "/meshes/0", FAR);
    // Steps of 1/256 on 2 m are visible, and on 8 m are not.
    let visible =
        "world coordinates near 50000 have steps of 0.0039, and the mesh is 2 wide; move it near the origin";
    assert_warns(&triangle(5e4, 2.0), "/meshes/0", visible);
    assert_silent(&triangle(5e4, 8.0));
    // A point has no shape.
    assert_silent(&triangle(5e6, 0.0));
}

#[test]
fn small_parts_of_large_scenes_are_not_named() {
    // A screw of 5 cm at the edge of a plant of 1200 m
    let mut document = triangle(0.0, 1.0);
    document.json["nodes"] = json!([
        {"mesh": 0, "translation": [600, 0, 0], "scale": [0.05, 0.05, 0.05]},
        {"mesh": 0, "translation": [-600, 0, 0], "scale": [100, 100, 100]}
    ]);
    document.json["scenes"][0]["nodes"] = json!([0, 1]);
    assert_silent(&document);
}

#[test]
fn nodes_that_move_a_mesh_far_away_are_named() {
    let mut document = triangle(0.0, 1.0);
    document.json["nodes"] = json!([
        {"mesh": 0, "translation": [0, 1e6, 0]},
        {"children": [2], "translation": [0, 0, -5e6]},
        {"mesh": 0}
    ]);
    document.json["scenes"][0]["nodes"] = json!([1]);
    assert_warns(&document, "/nodes/2", FAR);
    // Nodes that scale the mesh, that come back, and that no scene has.
    document.json["nodes"][2]["scale"] = json!([1e4, 1e4, 1e4]);
    document.json["nodes"][0]["translation"] = json!([0, 1, 0]);
    assert_silent(&document);
    document.json["nodes"][2] = json!({"mesh": 0, "translation": [0, 0, 5e6]});
    assert_silent(&document);
    document.json["nodes"][2] = json!({"mesh": 0});
    document.json["scenes"][0]["nodes"] = json!([0]);
    assert_silent(&document);
}

#[test]
fn joints_and_instances_move_meshes() {
    let mut document = triangle(0.0, 1.0);
    let joints = document.accessor(5121, "VEC4", 3, &[0; 12]);
    document.set_attribute("JOINTS_0", joints);
    document.attribute("WEIGHTS_0", "VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
    document.json["skins"] = json!([{"joints": [1]}]);
    document.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {"translation": [5e6, 0, 0]}]);
    document.json["scenes"][0]["nodes"] = json!([0, 1]);
    assert_warns(&document, "/nodes/0", FAR);
    // A skin leaves out the transform of its own node.
    document.json["nodes"] = json!([{"mesh": 0, "skin": 0, "translation": [5e6, 0, 0]}, {}]);
    assert_silent(&document);

    let mut document = triangle(0.0, 1.0);
    let translation = document.floats("VEC3", &[4_999_990.0, 0.0, 0.0, 5e6, 0.0, 0.0]);
    let attributes = json!({"TRANSLATION": translation});
    document.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    assert_warns(&document, "/nodes/0", FAR);
}
