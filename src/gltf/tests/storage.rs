//! The same ring in every supported storage format: `scenes/storage`, written by the reference encoders of the formats.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{error_text, import_bytes};
use crate::gltf::{ImportOptions, import};
use crate::scene::{Primitive, Scene, Texels};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/storage/{name}.gltf"))
}

fn scene(name: &str) -> Scene {
    let scene = import(&path(name), &ImportOptions::default()).unwrap();
    assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
    scene
}

fn document(name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(path(name)).unwrap()).unwrap()
}

fn ring(scene: &Scene) -> &Primitive {
    let node = scene.nodes.iter().find(|node| node.name.as_deref() == Some("ring")).unwrap();
    &scene.meshes[node.mesh.unwrap().index()].primitives[0]
}

/// All triangles by the bits of their vertices, the smallest vertex first.
fn triangles(primitive: &Primitive) -> BTreeSet<[Vec<u32>; 3]> {
    let bits = |corner: u32| {
        let corner = corner as usize;
        let normal = primitive.normals.as_ref().unwrap()[corner].to_array();
        let position = primitive.positions[corner].to_array();
        let values = position.into_iter().chain(normal).chain(primitive.uvs[0][corner].to_array());
        values.map(f32::to_bits).collect::<Vec<u32>>()
    };
    let turned = |corners: &[u32; 3]| {
        let mut corners = corners.map(bits);
        let least = (0..3).min_by_key(|&i| corners[i].clone()).unwrap();
        corners.rotate_left(least);
        corners
    };
    primitive.triangles.iter().map(turned).collect()
}

#[test]
fn compressed_geometry_equals_uncompressed_geometry() {
    let plain = scene("plain");
    for name in ["meshopt_ext", "meshopt_khr"] {
        assert_eq!(ring(&scene(name)), ring(&plain), "{name}");
    }
    // Draco reorders vertices and triangles.
    let draco = scene("draco");
    assert_eq!(ring(&draco).triangles.len(), ring(&plain).triangles.len());
    assert!(triangles(ring(&draco)) == triangles(ring(&plain)));
}

#[test]
fn compressed_images_are_preferred_and_equal_to_plain_ones() {
    let chequer = |x: u32, y: u32| {
        if (x / 4 + y / 4).is_multiple_of(2) { [233, 200, 125, 255] } else { [59, 92, 142, 255] }
    };
    let expected: Vec<[u8; 4]> = (0..32 * 16).map(|i| chequer(i % 32, i / 32)).collect();
    for name in ["plain", "webp", "basis_uastc", "basis_etc1s"] {
        let scene = scene(name);
        assert_eq!((scene.images[0].width, scene.images[0].height, scene.images.len()), (32, 16, 1));
        assert!(scene.images[0].texels == Texels::Rgba8(expected.clone()), "{name}");
    }
}

fn draco_extension(document: &mut Value) -> &mut Value {
    let mesh = document["meshes"].as_array().unwrap().len() - 1;
    &mut document["meshes"][mesh]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
}

#[test]
fn invalid_draco_extensions_are_errors_with_a_pointer() {
    let spoiled = |spoil: &dyn Fn(&mut Value)| {
        let mut document = document("draco");
        spoil(&mut document);
        let text = error_text(import_bytes("a.gltf", document.to_string().as_bytes()), 65);
        assert!(text.contains("/extensions/KHR_draco_mesh_compression"), "{text}");
        text
    };
    assert!(spoiled(&|d| draco_extension(d)["attributes"]["NORMAL"] = json!(7)).contains("no attribute 7"));
    assert!(
        spoiled(&|d| draco_extension(d)["attributes"]["COLOR_0"] = json!(1)).contains("for these values")
    );
    assert!(spoiled(&|d| draco_extension(d)["attributes"]["TEXCOORD_0"] = json!(0)).contains("3 components"));
    assert!(spoiled(&|d| draco_extension(d)["bufferView"] = json!(99)).contains("no buffer view 99"));
    assert!(spoiled(&|d| draco_extension(d)["bufferView"] = json!(0)).contains("damaged"));
    let accessor = |d: &mut Value, name: &str| {
        let mesh = d["meshes"].as_array().unwrap().len() - 1;
        d["meshes"][mesh]["primitives"][0]["attributes"][name].as_u64().unwrap() as usize
    };
    let text = spoiled(&|d| {
        let index = accessor(d, "NORMAL");
        d["accessors"][index]["count"] = json!(324);
    });
    assert!(text.contains("325 vertices, but accessor"), "{text}");
    let text = spoiled(&|d| {
        let index = accessor(d, "NORMAL");
        d["accessors"][index]["componentType"] = json!(5120);
        d["accessors"][index]["normalized"] = json!(true);
    });
    assert!(text.contains("Float32"), "{text}");
}

#[test]
fn wrong_index_counts_of_exporters_are_warned_about() {
    let mut document = document("draco");
    let mesh = document["meshes"].as_array().unwrap().len() - 1;
    let indices = document["meshes"][mesh]["primitives"][0]["indices"].as_u64().unwrap() as usize;
    document["accessors"][indices]["count"] = json!(3);
    let scene = import_bytes("a.gltf", document.to_string().as_bytes()).unwrap();
    assert_eq!(ring(&scene).triangles.len(), 576);
    assert!(scene.warnings[0].message.contains("index counts"));
}

/// Corrupts the bytes of the last buffer view that `view` finds, and imports. The result must be a scene or a one-line error.
fn corrupt_and_import(name: &str, view: impl Fn(&Value) -> Value, rounds: u32) {
    use base64::Engine;
    let engine = base64::engine::general_purpose::STANDARD;
    let original = document(name);
    let span = view(&original);
    let start = span["byteOffset"].as_u64().unwrap() as usize;
    let length = span["byteLength"].as_u64().unwrap() as usize;
    let (head, body) = original["buffers"][0]["uri"].as_str().unwrap().split_once(',').unwrap();
    let bytes = engine.decode(body).unwrap();
    let started = Instant::now();
    let mut refused = 0_u32;
    let mut state = 7_u32;
    for round in 0..rounds {
        let mut bytes = bytes.clone();
        state = state.wrapping_mul(1664525).wrapping_add(1013904223);
        if round % 4 == 0 {
            // Truncated bytes read as zero.
            let cut = start + (state >> 8) as usize % length;
            bytes[cut..start + length].fill(0);
        } else {
            bytes[start + (state >> 8) as usize % length] ^= 1 << (state & 7);
        }
        let mut document = original.clone();
        document["buffers"][0]["uri"] = json!(format!("{head},{}", engine.encode(&bytes)));
        if let Err(error) = import_bytes("a.gltf", document.to_string().as_bytes()) {
            let text = error.to_string();
            assert!(matches!(error.exit_code(), 65 | 77) && !text.contains('\n'), "{text}");
            assert!(!text.contains("please report"), "{name} panicked: {text}");
            refused += 1;
        }
    }
    // Most bytes of a lossless stream are numbers, for which any value is valid.
    assert!(refused > rounds / 64, "{name}: {refused}");
    assert!(started.elapsed() < Duration::from_secs(60), "{name}: {:?}", started.elapsed());
}

#[test]
fn corrupted_files_give_a_scene_or_a_one_line_error() {
    let view_of =
        |document: &Value, index: &Value| document["bufferViews"][index.as_u64().unwrap() as usize].clone();
    corrupt_and_import("draco", |d| view_of(d, &draco_extension(&mut d.clone())["bufferView"]), 300);
    for name in ["webp", "basis_uastc", "basis_etc1s"] {
        corrupt_and_import(name, |d| view_of(d, &d["images"][1]["bufferView"]), 200);
    }
}
