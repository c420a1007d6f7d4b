//! Mesh instancing (`EXT_mesh_gpu_instancing`).

use glam::{Vec3, Vec4};
use serde_json::{Value, json};

use super::properties::frame;
use super::{Document, ImportOptions, error_text, import};
use crate::scene::{MeshIndex, Scene};

/// Triangle with three instances: translated, rotated and scaled.
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
fn instances_replace_the_mesh() {
    let scene = instanced().import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let frame = frame(&scene, 0.0);
    // The node translates by 7 along z. (1, 0, 0) is the second vertex.
    assert_eq!((frame.triangles.len(), frame.instances.len()), (3, 3));
    assert_eq!(frame.triangles[0].vertices[1], Vec3::new(1.0, 0.0, 7.0));
    // Rotated by 90° about z, then translated by 5 along x.
    assert!(frame.triangles[1].vertices[1].abs_diff_eq(Vec3::new(5.0, 1.0, 7.0), 1e-4));
    // Mirrored: the last two vertices are swapped.
    assert_eq!(frame.triangles[2].vertices[2], Vec3::new(-2.0, 0.0, 7.0));
    assert!(frame.instances[2].mirrored && !frame.instances[1].mirrored);
    assert_eq!(frame.instances.iter().map(|instance| instance.node_instance).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(frame.instances[2].mesh, MeshIndex(0));
}

#[test]
fn colors_of_instances_multiply_those_of_vertices() {
    let mut document = instanced();
    let colors = document.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.5]);
    attributes(&mut document)["_COLOR_0"] = json!(colors);
    attributes(&mut document)["_ID"] = json!(colors);
    let [red, green, blue] =
        [Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.5, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0)];
    let scene = document.import().unwrap();
    let told: Vec<_> = scene.warnings.iter().map(ToString::to_string).collect();
    assert!(told.len() == 1 && told[0].contains("_COLOR_0 has values outside 0 to 1"), "{told:?}");
    let of_instances = |scene: &Scene| {
        let instances = frame(scene, 0.0).instances;
        instances.iter().map(|instance| instance.colors(scene, [0, 1, 2])).collect::<Vec<_>>()
    };
    assert_eq!(of_instances(&scene), [red, green, blue].map(|color| Some([color; 3])));
    // Vertices with an alpha
    let rgba = [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 0.25, 0.0, 0.0, 0.0, 1.0];
    let of_vertices = document.floats("VEC4", &rgba);
    document.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(of_vertices);
    let scene = document.import().unwrap();
    let half = Vec4::new(0.5, 0.0, 0.0, 0.25);
    assert_eq!(of_instances(&scene)[0], Some([red, half, Vec4::W]));
}

#[test]
fn custom_values_called_as_colors_are_no_error() {
    let mut document = instanced();
    let scalars = document.floats("SCALAR", &[1.0, 2.0, 3.0]);
    attributes(&mut document)["_COLOR_0"] = json!(scalars);
    let scene = document.import().unwrap();
    let told: Vec<_> = scene.warnings.iter().map(ToString::to_string).collect();
    assert!(told.len() == 1 && told[0].contains("the instances have no colours"), "{told:?}");
    assert!(scene.nodes[0].instance_colors.is_empty() && scene.nodes[0].instances.is_some());
}

#[test]
fn invalid_instances_are_errors_with_a_pointer() {
    let mut document = instanced();
    let two = document.floats("VEC3", &[0.0; 6]);
    attributes(&mut document)["SCALE"] = json!(two);
    assert!(document.error(65).contains("/attributes/SCALE"), "counts differ");
    let mut document = instanced();
    let zeros = document.floats("VEC4", &[0.0; 12]);
    attributes(&mut document)["ROTATION"] = json!(zeros);
    assert!(document.error(65).contains("length zero"));
    // Long ones are rotations, as those of nodes are.
    let mut document = instanced();
    let long = document.floats("VEC4", &[0.0, 0.0, 1e25, 1e25].repeat(3));
    attributes(&mut document)["ROTATION"] = json!(long);
    let long = document.import().unwrap().nodes[0].instances.clone().unwrap();
    assert!(long[1].x_axis.truncate().abs_diff_eq(Vec3::Y, 1e-6), "{}", long[1]);
    let mut document = instanced();
    *attributes(&mut document) = json!({});
    assert!(document.error(65).contains("must not be empty"));
}

/// A triangle with 20 000 instances in the origin.
fn instanced_often() -> Document {
    let mut document = Document::triangle();
    let often = document.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 20_000}));
    document.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": often}}});
    document
}

#[test]
fn each_instance_takes_memory_of_its_own() {
    let document = instanced_often();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document.to_json().to_string()).unwrap();
    let within =
        |max_memory_bytes| import(&path, &ImportOptions { max_memory_bytes, ..ImportOptions::default() });
    // Besides its matrix and triangle: 20 000 · (64 + 160 + 256) B. Of the import the matrices stay, not the translations, with a triangle of
    // three vertices.
    assert_eq!(within(12_000_000).unwrap().memory.kept_bytes, 20_000 * 64 + 3 * 64 + 12);
    let error = error_text(within(7_000_000), 77);
    assert!(error.contains("/scenes/0") && error.contains("`max_memory`"), "{error}");
}

#[test]
fn instances_need_memory_beside_keyframes() {
    // 9.6 MB of instances, and 300 000 keyframes of 4 + 12 bytes.
    let mut document = instanced_often();
    let [input, output] = ["SCALAR", "VEC3"].map(|shape| {
        document.push("accessors", json!({"componentType": 5126, "type": shape, "count": 300_000}))
    });
    document.json["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": input, "output": output}]
    }]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document.to_json().to_string()).unwrap();
    let within =
        |max_memory_bytes| import(&path, &ImportOptions { max_memory_bytes, ..ImportOptions::default() });
    assert!(within(16_000_000).is_ok());
    let error = error_text(within(12_000_000), 77);
    assert!(error.contains("/scenes/0") && error.contains("14.4 MB"), "{error}");
}
