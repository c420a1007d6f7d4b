use serde_json::json;

use super::Document;
use crate::gltf::{ImportOptions, import};
use glam::{Vec2, Vec3, Vec4};

#[test]
fn interleaved_attributes_follow_their_stride() {
    let mut document = Document::triangle();
    // 12 bytes of position, 8 of texture coordinates, 4 of padding.
    let mut bytes = Vec::new();
    for vertex in 0..3_u16 {
        let v = f32::from(vertex);
        for value in [v, v * v, 0.0, v / 4.0, 0.5, f32::NAN] {
            bytes.extend(value.to_le_bytes());
        }
    }
    let view = document.view(&bytes);
    document.json["bufferViews"][view]["byteStride"] = json!(24);
    let accessor = |shape: &str, offset: usize| json!({"bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 3, "type": shape});
    let positions = document.push("accessors", accessor("VEC3", 0));
    let uvs = document.push("accessors", accessor("VEC2", 12));
    document.set_attribute("POSITION", positions);
    document.set_attribute("TEXCOORD_0", uvs);
    let scene = document.import().unwrap();
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(primitive.positions[2], Vec3::new(2.0, 4.0, 0.0));
    assert_eq!(primitive.uvs[0][2], Vec2::new(0.5, 0.5));
}

#[test]
fn sparse_values_replace_zeros_where_there_is_no_view() {
    let mut document = Document::triangle();
    let indices = document.view(&[1, 2]);
    let values: Vec<u8> =
        [4.0_f32, 5.0, 6.0, 7.0, 8.0, 9.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let values = document.view(&values);
    let sparse = json!({
        "count": 2,
        "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values}
    });
    let accessor = json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse});
    let accessor = document.push("accessors", accessor);
    document.set_attribute("POSITION", accessor);
    let scene = document.import().unwrap();
    let expected = [Vec3::ZERO, Vec3::new(4.0, 5.0, 6.0), Vec3::new(7.0, 8.0, 9.0)];
    assert_eq!(scene.meshes[0].primitives[0].positions, expected);

    // Out of range, unsorted, and more than the accessor has.
    document.json["accessors"][accessor]["count"] = json!(2);
    assert!(document.error(65).contains("sparse"));
    document.json["accessors"][accessor]["count"] = json!(3);
    let offset = document.json["bufferViews"][indices]["byteOffset"].as_u64().unwrap() as usize;
    document.bytes[offset..offset + 2].copy_from_slice(&[2, 1]);
    assert!(document.error(65).contains("strictly increasing"));
    document.json["accessors"][accessor]["sparse"]["count"] = json!(4);
    assert!(document.error(65).contains("/sparse/count"));
}

#[test]
fn quantized_attributes_need_their_extension() {
    let mut document = Document::triangle();
    let bytes = [0_u8, 0, 0, 0, 127, 0, 0, 0, 0, 0x81, 0, 0];
    let accessor = document.accessor(5120, "VEC3", 3, &bytes);
    let view = document.json["accessors"][accessor]["bufferView"].as_u64().unwrap();
    document.json["bufferViews"][view as usize]["byteStride"] = json!(4);
    document.json["accessors"][accessor]["normalized"] = json!(true);
    document.set_attribute("POSITION", accessor);
    assert!(document.error(65).contains("KHR_mesh_quantization"));
    document.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    document.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let scene = document.import().unwrap();
    let expected = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, -1.0, 0.0)];
    assert_eq!(scene.meshes[0].primitives[0].positions, expected);
    // Without normalization the values are the integers.
    document.json["accessors"][accessor]["normalized"] = json!(false);
    let scene = document.import().unwrap();
    assert_eq!(scene.meshes[0].primitives[0].positions[1], Vec3::X * 127.0);
}

#[test]
fn colors_of_any_format_are_floats_with_alpha() {
    for (component, shape, bytes) in [
        (5121, "VEC3", vec![255, 51, 0, 0, 0, 0, 0, 0, 0]),
        (5123, "VEC4", [0xff_u8, 0xff, 0x33, 0x33, 0, 0, 0xff, 0xff].repeat(3)),
    ] {
        let mut document = Document::triangle();
        let accessor = document.accessor(component, shape, 3, &bytes);
        document.json["accessors"][accessor]["normalized"] = json!(true);
        document.set_attribute("COLOR_0", accessor);
        let scene = document.import().unwrap();
        let colors = scene.meshes[0].primitives[0].colors.as_ref().unwrap();
        assert_eq!(colors[0], Vec4::new(1.0, 0.2, 0.0, 1.0));
        assert_eq!(colors.len(), 3);
    }
}

#[test]
fn declared_lengths_beyond_the_data_are_errors() {
    let edits: [(&str, serde_json::Value); 9] = [
        ("/accessors/0/count", json!(4)),
        ("/accessors/0/count", json!(0)),
        ("/accessors/0/count", json!(u64::MAX)),
        ("/accessors/0/byteOffset", json!(u64::MAX)),
        ("/accessors/0/bufferView", json!(7)),
        ("/bufferViews/0/byteLength", json!(37)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/0/byteStride", json!(8)),
        ("/bufferViews/0/buffer", json!(1)),
    ];
    for (pointer, value) in edits {
        let mut document = Document::triangle();
        let (owner, key) = pointer.rsplit_once('/').unwrap();
        document.json.pointer_mut(owner).unwrap()[key] = value.clone();
        document.error(65);
    }
    let mut json = Document::triangle().to_json();
    json["buffers"][0]["byteLength"] = json!(1_u64 << 40);
    let result = super::import_bytes("a.gltf", json.to_string().as_bytes());
    assert!(super::error_text(result, 65).contains("/buffers/0/byteLength"));
}

#[test]
fn accessors_over_the_memory_limit_are_refused_before_allocation() {
    let mut document = Document::triangle();
    document.json["accessors"][0] =
        json!({"componentType": 5126, "type": "VEC3", "count": 4_000_000_000_u64});
    assert!(document.error(77).contains("`max_memory`"));
    // A limit too small for the file itself.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, Document::triangle().to_json().to_string()).unwrap();
    let options = ImportOptions { max_memory_bytes: 6_000, ..ImportOptions::default() };
    assert_eq!(import(&path, &options).unwrap_err().exit_code(), 77);
}

#[test]
fn infinities_and_nans_are_errors() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut document = Document::triangle();
        document.attribute("POSITION", "VEC3", &[0.0, 0.0, 0.0, 0.0, value, 0.0, 0.0, 0.0, 0.0]);
        assert!(document.error(65).contains("/accessors/1: element 1"));
        let mut document = Document::triangle();
        let mut values = [0.5; 12];
        values[9] = value;
        document.attribute("COLOR_0", "VEC4", &values);
        assert!(document.error(65).contains("element 2"), "{value}");
    }
}

#[test]
fn normals_and_tangents_that_are_not_finite_are_computed() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for name in ["NORMAL", "TANGENT"] {
            let mut document = Document::triangle();
            let mut normals = [0.0, 0.6, 0.8].repeat(3);
            let mut tangents = [1.0, 0.0, 0.0, 1.0].repeat(3);
            if name == "NORMAL" {
                normals[6] = value;
            } else {
                tangents[11] = value;
            }
            document.attribute("NORMAL", "VEC3", &normals);
            document.attribute("TANGENT", "VEC4", &tangents);
            let scene = document.import().unwrap();
            let pointer = format!("/meshes/0/primitives/0/attributes/{name}");
            let message = "some elements are infinite or not a number; they are taken as zero";
            assert!(
                scene.warnings.iter().any(|w| w.pointer == pointer && w.message == message),
                "{:?}",
                scene.warnings
            );
            let primitive = &scene.meshes[0].primitives[0];
            let (normals, tangents) =
                (primitive.normals.as_ref().unwrap(), primitive.tangents.as_ref().unwrap());
            // The triangle lies in the xy plane.
            let replaced = if name == "NORMAL" { Vec3::Z } else { normals[1] };
            assert_eq!((normals[0], normals[2]), (normals[1], replaced), "{name} {value}");
            assert!(tangents.iter().all(|tangent| tangent.truncate().is_normalized()), "{tangents:?}");
            assert!(name == "NORMAL" || tangents[2].truncate().dot(normals[2]).abs() < 1e-6);
        }
    }
}

#[test]
fn displacements_of_normals_that_are_not_finite_are_zero() {
    let mut document = Document::triangle();
    document.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let deltas = document.floats("VEC3", &[1.0, 0.0, 0.0, f32::NAN, 1.0, 1.0, 1.0, 0.0, 0.0]);
    document.json["meshes"][0]["primitives"][0]["targets"] = json!([{"NORMAL": deltas}]);
    let scene = document.import().unwrap();
    let target = &scene.meshes[0].primitives[0].targets[0];
    assert_eq!(target.normals, Some(vec![Vec3::X, Vec3::ZERO, Vec3::X]));
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    document.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": deltas}]);
    assert!(document.error(65).contains("element 1"));
}

#[test]
fn invalid_formats_are_errors() {
    for (name, component, shape) in [
        ("POSITION", 5126, "VEC2"),
        ("NORMAL", 5126, "VEC4"),
        ("COLOR_0", 5126, "SCALAR"),
        ("TEXCOORD_0", 5125, "VEC2"),
        ("POSITION", 9999, "VEC3"),
        ("POSITION", 5126, "VEC5"),
    ] {
        let mut document = Document::triangle();
        let accessor = document.accessor(component, shape, 3, &[0; 48]);
        document.set_attribute(name, accessor);
        assert!(document.error(65).contains(name));
    }
}

#[test]
fn many_primitives_over_one_accessor_are_refused_at_once() {
    // 5000 primitives of a million vertices each: 4 bytes per index are 20 GB, more than the limit of 4 GiB.
    let mut document = Document::triangle();
    document.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": 1_000_000});
    let primitive = document.json["meshes"][0]["primitives"][0].clone();
    document.json["meshes"][0]["primitives"] = json!(vec![primitive; 5000]);
    assert!(document.error(77).contains("/meshes/0/primitives/"));
}

#[test]
fn refused_triangles_are_told_with_what_is_read_before_them() {
    // 600 kB of text three times as a file, a value and a typed name, and 75 000 indices of 4 bytes, over a limit of 2 MB.
    let mut document = Document::triangle();
    document.json["nodes"][0]["name"] = json!("a".repeat(600_000));
    document.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": 75_000});
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document.to_json().to_string()).unwrap();
    let options = ImportOptions { max_memory_bytes: 2_000_000, ..ImportOptions::default() };
    let text = super::error_text(import(&path, &options), 77);
    let expected = "/meshes/0/primitives/0: the import needs about 2.1 MB, more than the limit of 2.0 MB";
    assert!(text.contains(expected), "{text}");
}

#[test]
fn lists_of_triangles_take_the_memory_of_their_indices_twice() {
    // 300 000 indices of 4 bytes as they are read and as 100 000 triangles; the file takes a few kilobytes.
    let mut document = Document::triangle();
    let indices = json!({"componentType": 5125, "type": "SCALAR", "count": 300_000});
    let indices = document.push("accessors", indices);
    document.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let memory = document.import().unwrap().memory;
    assert!((2_400_000..2_450_000).contains(&memory.import_bytes), "{memory:?}");
}

#[test]
fn missing_data_is_an_error_that_names_the_extension() {
    let mut json = Document::triangle().to_json();
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    let text = super::error_text(super::import_bytes("a.gltf", json.to_string().as_bytes()), 65);
    assert!(text.contains("needs buffer 0, which has no data"), "{text}");
    json["bufferViews"][0]["extensions"] = json!({"ACME_packing": {"buffer": 1}});
    let text = super::error_text(super::import_bytes("a.gltf", json.to_string().as_bytes()), 65);
    assert!(text.contains("unsupported extension ACME_packing"), "{text}");
}

#[test]
fn stated_extremes_are_compared_with_the_elements() {
    let mut document = Document::triangle();
    (document.json["accessors"][0]["min"], document.json["accessors"][0]["max"]) =
        (json!([0, 0, 0]), json!([1.0, 1.000_01, 0]));
    assert_eq!(document.import().unwrap().warnings, []);
    document.json["accessors"][0]["max"] = json!([1, 2, 0]);
    let warnings = document.import().unwrap().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let text = warnings[0].to_string();
    assert!(text.contains("/accessors/0/max") && text.contains("is 2") && text.contains("have 1"), "{text}");
}
