use std::borrow::Cow;
use std::path::Path;

use serde_json::json;

use super::Document;
use crate::gltf::accessor::{Data, DecodedAccessors};
use crate::gltf::context::Context;
use crate::gltf::document;
use crate::scene::Primitive;

/// Six vertices with every kind of attribute. The primitives use all, the first three, and the last three in another order.
fn shared_list() -> Document {
    let mut document = Document::triangle();
    let numbers =
        |count: usize, first: f32| (0..count).map(|i| first + i as f32 / count as f32).collect::<Vec<f32>>();
    document.attribute("POSITION", "VEC3", &numbers(18, 0.0));
    document.attribute("NORMAL", "VEC3", &numbers(18, 0.5));
    document.attribute("WEIGHTS_0", "VEC4", &numbers(24, 0.5));
    let joints: Vec<u8> = (0..24).collect();
    let codes: Vec<u8> = (0..24).map(|code| 10 * code).collect();
    for (name, shape, bytes) in [("JOINTS_0", "VEC4", joints), ("COLOR_0", "VEC4", codes)] {
        let accessor = document.accessor(5121, shape, 6, &bytes);
        document.json["accessors"][accessor]["normalized"] = json!(name == "COLOR_0");
        document.set_attribute(name, accessor);
    }
    document.attribute("TEXCOORD_0", "VEC2", &numbers(12, 0.0));

    // A target that moves vertices 1 and 4
    let indices = document.view(&[1, 4]);
    let values: Vec<u8> = numbers(6, 1.0).iter().flat_map(|value| value.to_le_bytes()).collect();
    let values = document.view(&values);
    let sparse = json!({
        "count": 2,
        "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values}
    });
    let target = json!({"componentType": 5126, "type": "VEC3", "count": 6, "sparse": sparse});
    let target = document.push("accessors", target);

    let mut primitive = document.json["meshes"][0]["primitives"][0].clone();
    primitive["targets"] = json!([{"POSITION": target}]);
    let primitives = [&[0, 1, 2, 3, 4, 5][..], &[0, 1, 2], &[5, 3, 4]].map(|indices| {
        let accessor = document.accessor(5121, "SCALAR", indices.len(), indices);
        let mut primitive = primitive.clone();
        primitive["indices"] = json!(accessor);
        primitive
    });
    document.json["meshes"][0]["primitives"] = json!(primitives);
    document
}

/// Everything that a primitive stores of a vertex.
fn vertex(primitive: &Primitive, index: usize) -> String {
    let influences = primitive.influences.as_ref().unwrap();
    let four = 4 * index..4 * index + 4;
    format!(
        "{} {} {} {} {:?} {:?} {}",
        primitive.positions[index],
        primitive.normals.as_ref().unwrap()[index],
        primitive.colors.as_ref().unwrap()[index],
        primitive.uvs[0][index],
        &influences.joints[four.clone()],
        &influences.weights[four],
        primitive.targets[0].positions.as_ref().unwrap()[index],
    )
}

#[test]
fn primitives_read_the_vertices_that_they_use_of_a_shared_list() {
    let scene = shared_list().import().unwrap();
    let [all, first, last] = &scene.meshes[0].primitives[..] else { panic!() };
    assert_eq!((&first.triangles[..], &last.triangles[..]), (&[[0, 1, 2]][..], &[[2, 0, 1]][..]));
    for index in 0..3 {
        assert_eq!(vertex(first, index), vertex(all, index));
        assert_eq!(vertex(last, index), vertex(all, index + 3));
    }
    assert_ne!(vertex(last, 1), vertex(last, 2));
    for primitive in [first, last] {
        assert_eq!(primitive.positions.len(), 3);
        assert_eq!(primitive.targets[0].positions.as_ref().unwrap().len(), 3);
    }
}

#[test]
fn values_that_no_triangle_uses_are_checked_once() {
    let mut document = shared_list();
    // A list whose first vertex belongs to no triangle.
    let primitives = document.json["meshes"][0]["primitives"].as_array().unwrap();
    document.json["meshes"][0]["primitives"] = json!([primitives[2], primitives[2]]);
    let accessor = document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap();
    let start = document.json["bufferViews"][accessor as usize]["byteOffset"].as_u64().unwrap() as usize;
    document.bytes[start..start + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(document.error(65).contains("element 0 is infinite or not a number"));
}

/// The elements 1 and 40 of an accessor of three floats, zeros for wrong ones, read twice: each with the memory that the reading takes.
fn read_twice(document: &Document, accessor: usize) -> [(Vec<[f32; 3]>, u64); 2] {
    let mut context = Context::new(Path::new("a.gltf"), 1 << 20);
    let json = document.to_json().to_string();
    let parsed = document::Document::parse(&mut context, json.as_bytes()).unwrap();
    let (buffers, decoded) = ([Some(Cow::Borrowed(&document.bytes[..]))], DecodedAccessors::new());
    let data = Data { vertices: Some(&[1, 40]), ..Data::new(&parsed, &buffers, &[], &decoded) };
    [(); 2].map(|()| {
        let used_before = context.used_bytes();
        let elements = data.floats_or_zeros(&mut context, accessor, "").unwrap();
        (elements, context.used_bytes() - used_before)
    })
}

#[test]
fn lists_with_wrong_elements_are_read_as_a_whole_once() {
    let mut values: Vec<f32> = (0..300).map(|i| i as f32).collect();
    values[121] = f32::NAN;
    let mut document = Document::triangle();
    let accessor = document.floats("VEC3", &values);
    let expected = vec![[3.0, 4.0, 5.0], [0.0; 3]];
    // 100 elements of 12 bytes, then two.
    assert_eq!(read_twice(&document, accessor), [(expected.clone(), 1200), (expected, 24)]);
}

#[test]
fn sparse_lists_are_read_as_a_whole_once() {
    let mut document = Document::triangle();
    // 7, 8, 9 for the element 40 of a list of zeros.
    let indices = document.view(&[40]);
    let values = document.view(&[7.0_f32, 8.0, 9.0].map(f32::to_le_bytes).concat());
    let sparse = json!({
        "count": 1,
        "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values}
    });
    let list = json!({"componentType": 5126, "type": "VEC3", "count": 100, "sparse": sparse});
    let accessor = document.push("accessors", list);
    let expected = vec![[0.0; 3], [7.0, 8.0, 9.0]];
    assert_eq!(read_twice(&document, accessor), [(expected.clone(), 1200), (expected, 24)]);
}
