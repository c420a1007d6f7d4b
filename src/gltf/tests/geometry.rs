use serde_json::{Value, json};

use super::Document;
use crate::scene::MorphTarget;
use glam::{Mat3, Vec2, Vec3, Vec4};

fn primitive_of(document: &mut Document) -> &mut Value {
    &mut document.json["meshes"][0]["primitives"][0]
}

fn index_accessor(document: &mut Document, indices: &[u8]) {
    let accessor = document.accessor(5121, "SCALAR", indices.len(), indices);
    primitive_of(document)["indices"] = json!(accessor);
}

#[test]
fn indices_must_refer_to_vertices() {
    for (indices, expected) in [([0, 1, 3], "index 2 is vertex 3"), ([0, 255, 1], "restart")] {
        let mut document = Document::triangle();
        index_accessor(&mut document, &indices);
        assert!(document.error(65).contains(expected));
    }
    let mut document = Document::triangle();
    primitive_of(&mut document)["indices"] = json!(0);
    assert!(document.error(65).contains("indices cannot be VEC3 of floats"));
}

#[test]
fn points_and_lines_are_warned_about_once_each() {
    let mut document = Document::triangle();
    let primitive = primitive_of(&mut document).clone();
    let modes = [0, 1, 2, 3, 4].map(|mode| {
        let mut primitive = primitive.clone();
        primitive["mode"] = json!(mode);
        primitive
    });
    document.json["meshes"][0]["primitives"] = json!(modes);
    let scene = document.import().unwrap();
    assert_eq!(scene.meshes[0].primitives.len(), 1);
    let pointers: Vec<&str> = scene.warnings.iter().map(|w| w.pointer.as_str()).collect();
    assert_eq!(pointers, ["/meshes/0/primitives/0/mode", "/meshes/0/primitives/1/mode"]);
}

#[test]
fn meshes_without_primitives_are_warned_about_once() {
    let mut document = Document::triangle();
    document.json["nodes"] = json!([{"mesh": 0}, {"mesh": 1, "weights": [0.5]}]);
    document.push("meshes", json!({"primitives": [], "weights": [1.0]}));
    document.push("meshes", json!({"primitives": []}));
    let scene = document.import().unwrap();
    let counts: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.primitives.len()).collect();
    assert_eq!(counts, [1, 0, 0]);
    let pointers: Vec<&str> = scene.warnings.iter().map(|w| w.pointer.as_str()).collect();
    assert_eq!(pointers, ["/meshes/1/primitives"]);
}

#[test]
fn weights_of_a_node_without_mesh_are_warned_about() {
    let mut document = Document::triangle();
    document.json["nodes"] = json!([{"weights": [0.5, 1.0], "children": [1]}, {"mesh": 0}]);
    document.json["scenes"] = json!([{"nodes": [0]}]);
    let scene = document.import().unwrap();
    assert_eq!(scene.nodes[0].weights, None);
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert_eq!(warning.pointer, "/nodes/0/weights");
    assert!(warning.message.contains("without mesh"), "{warning}");
}

#[test]
fn only_used_vertices_are_kept() {
    let mut document = Document::triangle();
    let positions: Vec<f32> = (0..15).map(|i| i as f32).collect();
    document.attribute("POSITION", "VEC3", &positions);
    index_accessor(&mut document, &[4, 1, 2]);
    let scene = document.import().unwrap();
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(primitive.triangles, [[2, 0, 1]]);
    assert_eq!(primitive.positions[2], Vec3::new(12.0, 13.0, 14.0));
    assert_eq!(primitive.positions.len(), 3);
}

#[test]
fn attributes_have_equal_counts_and_no_gaps_in_their_numbers() {
    let mut document = Document::triangle();
    document.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0]);
    assert!(document.error(65).contains("/NORMAL: has 1 elements"));
    let mut document = Document::triangle();
    document.attribute("WEIGHTS_1", "VEC4", &[0.25; 12]);
    assert!(document.error(65).contains("WEIGHTS_0 is missing"));
}

#[test]
fn texture_coordinates_that_no_texture_uses_may_be_wrong() {
    let mut document = Document::triangle();
    document.attribute("TEXCOORD_1", "VEC2", &[0.5; 6]);
    let scene = document.import().unwrap();
    assert!(scene.meshes[0].primitives[0].uvs.is_empty());
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert_eq!(warning.pointer, "/meshes/0/primitives/0/attributes/TEXCOORD_1");
    assert!(warning.message.ends_with("TEXCOORD_1 is ignored"), "{warning}");

    let values = [0.5, 0.5, f32::NAN, 0.5, 0.5, 0.5];
    let mut document = Document::triangle();
    document.attribute("TEXCOORD_0", "VEC2", &values);
    let scene = document.import().unwrap();
    let half = Vec2::splat(0.5);
    assert_eq!(scene.meshes[0].primitives[0].uvs, [[half, Vec2::ZERO, half]]);
    assert!(scene.warnings[0].message.contains("not a number"), "{:?}", scene.warnings);
    // A texture uses them.
    let mut document = with_normal_map(Document::triangle());
    document.attribute("TEXCOORD_0", "VEC2", &values);
    assert!(document.error(65).contains("element 1"));
}

#[test]
fn tangents_without_normals_are_ignored_and_unknown_attributes_warned_about() {
    let mut document = Document::triangle();
    document.attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(3));
    document.attribute("COLOR_0", "VEC4", &[2.0; 12]);
    document.attribute("COLOR_1", "VEC4", &[1.0; 12]);
    document.attribute("_HEAT", "SCALAR", &[1.0; 3]);
    let scene = document.import().unwrap();
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!((&primitive.normals, &primitive.tangents), (&None, &None));
    assert_eq!(primitive.colors, Some(vec![Vec4::ONE; 3]));
    // The values of COLOR_0 beyond 1 are named, and COLOR_1 is not: glTF gives it no meaning, and Blender writes what a material does not use.
    let messages: Vec<_> = scene.warnings.iter().map(|warning| &warning.message).collect();
    assert!(matches!(messages[..], [message] if message.contains("COLOR_0")), "{messages:?}");
    let mut document = Document::triangle();
    document.attribute("COLOR_1", "VEC4", &[1.0; 12]);
    let warnings = document.import().unwrap().warnings;
    assert!(matches!(&warnings[..], [gap] if gap.message.contains("COLOR_0 is missing")), "{warnings:?}");
}

/// Adds a normal map on `TEXCOORD_0`.
fn with_normal_map(mut document: Document) -> Document {
    let image = super::materials::png_uri([128, 128, 255, 255]);
    document.json["images"] = json!([{"uri": image}]);
    document.json["textures"] = json!([{"source": 0}]);
    document.json["materials"] = json!([{"normalTexture": {"index": 0}}]);
    primitive_of(&mut document)["material"] = json!(0);
    document
}

#[test]
fn tangents_follow_u_and_bitangents_point_up_the_image() {
    // u grows along x. glTF's v points down the image, so with v decreasing along y the image is upright: bitangent
    // +y = cross(n, t) · w with n = z, t = x needs w = +1. With v increasing along y the image is upside down.
    for (v_at_top, sign) in [(0.0, 1.0), (2.0, -1.0)] {
        let mut document = Document::triangle();
        document.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(3));
        document.attribute("TEXCOORD_0", "VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, v_at_top]);
        let scene = with_normal_map(document).import().unwrap();
        let primitive = &scene.meshes[0].primitives[0];
        assert_eq!(primitive.tangents, Some(vec![Vec4::new(1.0, 0.0, 0.0, sign); 3]));
        assert_eq!(primitive.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn vertices_are_split_at_mirrored_texture_coordinates() {
    // Two triangles share the edge 0-1. The u axis of the second is reversed.
    let mut document = Document::triangle();
    document.attribute("POSITION", "VEC3", &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0]);
    document.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    document.attribute("TEXCOORD_0", "VEC2", &[0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    let joints = document.accessor(5121, "VEC4", 4, &[0; 16]);
    document.set_attribute("JOINTS_0", joints);
    document.attribute("WEIGHTS_0", "VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(4));
    index_accessor(&mut document, &[0, 2, 1, 0, 1, 3]);
    let mut document = with_normal_map(document);
    let deltas = document.floats("VEC3", &[9.0, 0.0, 0.0, 8.0, 0.0, 0.0, 7.0, 0.0, 0.0, 6.0, 0.0, 0.0]);
    primitive_of(&mut document)["targets"] = json!([{"POSITION": deltas}]);
    let scene = document.import().unwrap();
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(primitive.positions.len(), 6);
    let tangents = primitive.tangents.as_ref().unwrap();
    for (triangle, sign) in primitive.triangles.iter().zip([1.0, -1.0]) {
        for &vertex in triangle {
            assert_eq!(tangents[vertex as usize], Vec4::new(sign, 0.0, 0.0, sign));
        }
    }
    // The other attributes are split as well. The delta identifies the old vertex.
    let deltas = primitive.targets[0].positions.as_ref().unwrap();
    let old = [Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::NEG_X];
    for (position, delta) in primitive.positions.iter().zip(deltas) {
        assert_eq!(*position, old[9 - delta.x as usize]);
    }
    assert_eq!(primitive.influences.as_ref().unwrap().weights.len(), 24);
}

#[test]
fn generated_tangents_tell_their_coordinates_and_stored_ones_hold_for_all() {
    let mut document = Document::triangle();
    document.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(3));
    for name in ["TEXCOORD_0", "TEXCOORD_1"] {
        document.attribute(name, "VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    }
    let mut document = with_normal_map(document);
    document.json["materials"][0]["normalTexture"]["texCoord"] = json!(1);
    let set = |document: &Document| document.import().unwrap().meshes[0].primitives[0].tangent_uv_set;
    assert_eq!(set(&document), Some(1));
    document.attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(3));
    assert_eq!(set(&document), None);
}

#[test]
fn anisotropy_without_a_direction_is_told() {
    let mut document = Document::triangle();
    let extensions = json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}});
    document.push("materials", json!({"extensions": extensions}));
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let told: Vec<_> = document.import().unwrap().warnings.iter().map(ToString::to_string).collect();
    assert!(told.len() == 1 && told[0].contains("anisotropy has no direction without"), "{told:?}");
    let uvs = document.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    document.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    assert!(document.import().unwrap().warnings.is_empty());
}

#[test]
fn primitives_without_normals_get_tangents() {
    let mut document = Document::triangle();
    document.attribute("TEXCOORD_0", "VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    let scene = with_normal_map(document).import().unwrap();
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(primitive.normals, None);
    assert_eq!(primitive.tangents, Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3]));
}

#[test]
fn generated_tangents_follow_morphs() {
    // A skewed quad with skewed coordinates, and a target that turns and stretches it.
    let base = [[0.0, 0.0, 0.0], [2.0, 0.3, 0.0], [2.2, 1.5, 0.0], [0.1, 1.2, 0.0]].map(Vec3::from_array);
    let morph = Mat3::from_rotation_z(1.2) * Mat3::from_diagonal(Vec3::new(1.5, 0.8, 1.0));
    let turned = base.map(|position| morph * position);
    let tangents_of = |positions: [Vec3; 4], target: Option<[Vec3; 4]>| {
        let flat = |points: [Vec3; 4]| points.iter().flat_map(Vec3::to_array).collect::<Vec<f32>>();
        let mut document = Document::triangle();
        document.attribute("POSITION", "VEC3", &flat(positions));
        document.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
        // Linear in the positions, so that both triangles have one u axis.
        let uvs: Vec<f32> = base.iter().flat_map(|point| [0.4 * point.x - 0.7 * point.y, -point.y]).collect();
        document.attribute("TEXCOORD_0", "VEC2", &uvs);
        index_accessor(&mut document, &[0, 1, 2, 0, 2, 3]);
        let mut document = with_normal_map(document);
        if let Some(deltas) = target {
            let deltas = document.floats("VEC3", &flat(deltas));
            primitive_of(&mut document)["targets"] = json!([{"POSITION": deltas}]);
        }
        let primitive = document.import().unwrap().meshes[0].primitives[0].clone();
        let deltas = primitive.targets.first().and_then(|target| target.tangents.clone());
        let deltas = deltas.unwrap_or_else(|| vec![Vec3::ZERO; primitive.positions.len()]);
        let tangents = primitive.tangents.unwrap().into_iter().zip(deltas);
        tangents.map(|(tangent, delta)| (tangent.truncate() + delta).normalize()).collect::<Vec<_>>()
    };
    let deltas = [0, 1, 2, 3].map(|corner| turned[corner] - base[corner]);
    let (morphed, expected) = (tangents_of(base, Some(deltas)), tangents_of(turned, None));
    assert_eq!(morphed.len(), 4);
    for (morphed, expected) in morphed.iter().zip(&expected) {
        assert!((*morphed - *expected).length() < 1e-5, "{morphed} {expected}");
    }
    assert!((expected[0] - tangents_of(base, None)[0]).length() > 0.5);
}

#[test]
fn a_collapsed_triangle_that_a_morph_opens_does_not_turn_its_neighbours() {
    // The top edge of a quad, 2-3, is collapsed but for 1e-4, and the target opens it along z.
    let mut document = Document::triangle();
    document.attribute("POSITION", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1e-4, 1.0, 0.0]);
    document.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    document.attribute("TEXCOORD_0", "VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    index_accessor(&mut document, &[0, 1, 2, 1, 3, 2]);
    let mut document = with_normal_map(document);
    let deltas = document.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    primitive_of(&mut document)["targets"] = json!([{"POSITION": deltas}]);
    let primitive = document.import().unwrap().meshes[0].primitives[0].clone();
    let tangents = primitive.targets[0].tangents.as_ref().unwrap();
    for vertex in primitive.triangles[0] {
        assert!(tangents[vertex as usize].length() < 1.01, "{tangents:?}");
    }
}

#[test]
fn missing_coordinates_are_zero_with_a_warning() {
    let scene = with_normal_map(Document::triangle()).import().unwrap();
    assert_eq!(scene.meshes[0].primitives[0].uvs.len(), 1);
    assert!(scene.warnings[0].message.contains("TEXCOORD_0 is missing"));
}

#[test]
fn degenerate_surfaces_get_finite_tangents() {
    let mut document = Document::triangle();
    document.attribute("POSITION", "VEC3", &[1.0; 9]);
    document.attribute("NORMAL", "VEC3", &[0.0; 9]);
    document.attribute("TEXCOORD_0", "VEC2", &[0.5; 6]);
    let scene = with_normal_map(document).import().unwrap();
    let primitive = &scene.meshes[0].primitives[0];
    let tangents = primitive.tangents.as_ref().unwrap();
    assert!(tangents.iter().all(|tangent| tangent.is_finite() && tangent.truncate().is_normalized()));
    let normals = primitive.normals.as_ref().unwrap();
    assert!(normals.iter().all(|normal| normal.is_normalized()));
}

#[test]
fn morph_targets_need_a_base_and_equal_numbers() {
    let mut document = Document::triangle();
    primitive_of(&mut document)["targets"] = json!([{"POSITION": 0}, {}]);
    let scene = document.import().unwrap();
    assert_eq!(scene.meshes[0].weights, [0.0, 0.0]);
    assert_eq!(scene.meshes[0].primitives[0].targets[1], MorphTarget::default());
    document.json["meshes"][0]["weights"] = json!([1.0]);
    assert!(document.error(65).contains("/meshes/0/weights"));
    document.json["meshes"][0]["weights"] = json!([1, 0.5]);
    assert_eq!(document.import().unwrap().meshes[0].weights, [1.0, 0.5]);
    primitive_of(&mut document)["targets"] = json!([{"COLOR_0": 0}]);
    assert!(document.error(65).contains("no COLOR_0"));
}

#[test]
fn influences_of_all_sets_are_interleaved() {
    let mut document = Document::triangle();
    for (set, first) in [(0, 1), (1, 5)] {
        let joints: Vec<u8> = [first, first + 1, first + 2, first + 3].repeat(3);
        let accessor = document.accessor(5121, "VEC4", 3, &joints);
        document.set_attribute(&format!("JOINTS_{set}"), accessor);
        document.attribute(&format!("WEIGHTS_{set}"), "VEC4", &[0.25; 12]);
    }
    document.json["skins"] = json!([{"joints": (0..9).collect::<Vec<i32>>()}]);
    document.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {}, {}, {}, {}, {}, {}, {}, {}]);
    let scene = document.import().unwrap();
    let influences = scene.meshes[0].primitives[0].influences.as_ref().unwrap();
    assert_eq!(influences.per_vertex, 8);
    assert_eq!(influences.joints[8..16], [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(influences.weights, [0.125; 24]);
    // One joint fewer than used.
    document.json["skins"] = json!([{"joints": (0..8).collect::<Vec<i32>>()}]);
    assert!(document.error(65).contains("joint 8"));
}

#[test]
fn colors_out_of_range_are_named() {
    let mut document = Document::triangle();
    document.attribute("COLOR_0", "VEC3", &[0.0, 1.5, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let warnings = document.import().unwrap().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let text = warnings[0].to_string();
    assert!(text.contains("COLOR_0") && text.contains("outside 0 to 1"), "{text}");
}

#[test]
fn bytes_that_are_not_normalized_are_told_what_they_lack() {
    let mut document = Document::triangle();
    let colors = document.accessor(5121, "VEC4", 3, &[255; 12]);
    document.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    let error = document.error(65);
    assert!(
        error.contains("COLOR cannot be VEC4 of unsigned bytes unless its accessor is \"normalized\""),
        "{error}"
    );
    document.json["accessors"][colors]["normalized"] = json!(true);
    assert!(document.import().is_ok());
}

#[test]
fn flat_meshes_of_absorbing_volumes_are_told() {
    let with_volume = |volume: serde_json::Value| {
        let mut document = Document::triangle();
        let extensions =
            json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume});
        document.push("materials", json!({"extensions": extensions}));
        document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let scene = document.import().unwrap();
        scene.warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let tint = |thickness: f32| json!({"thicknessFactor": thickness, "attenuationDistance": 1, "attenuationColor": [0.9, 1, 1]});
    let told = with_volume(tint(0.01));
    assert!(told.len() == 1 && told[0].contains("/meshes/0: is flat and encloses no volume"), "{told:?}");
    // A thin wall, and a volume that absorbs nothing
    assert!(with_volume(tint(0.0)).is_empty() && with_volume(json!({"thicknessFactor": 0.01})).is_empty());
}
