//! What common exporters write against the specification, though its meaning is clear: rendered, with a warning.

use serde_json::{Value, json};

use super::materials::import_material;
use super::{Document, error_text, import_bytes};
use crate::gltf::ExtensionSupport::Ignored;
use crate::gltf::extension_support;
use crate::scene::{LocalTransform, Projection, Scene};
use glam::{Quat, Vec2, Vec3, Vec4};

/// The pointer of the only warning, and whether its message has `text`.
fn only_warning<'a>(scene: &'a Scene, text: &str) -> (&'a str, bool) {
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    (warning.pointer.as_str(), warning.message.contains(text))
}

#[test]
fn null_counts_as_absent() {
    // JavaScript writes infinite numbers as null: three.js distances of volumes and far planes.
    let volume = json!({"thicknessFactor": 0.5, "attenuationDistance": null});
    let material = json!({
        "doubleSided": null, "normalTexture": null, "extensions": {"KHR_materials_volume": volume}
    });
    let scene = import_material(material).unwrap();
    assert_eq!(scene.materials[0].volume.unwrap().attenuation_distance, f32::INFINITY);
    assert!(!scene.materials[0].double_sided);
    assert_eq!(only_warning(&scene, "is null"), ("/materials/0/doubleSided", true));
    // Elements of lists have no default.
    let sheen = json!({"extensions": {"KHR_materials_sheen": {"sheenColorFactor": [null, 0, 0]}}});
    assert!(error_text(import_material(sheen), 65).contains("/sheenColorFactor"));
}

#[test]
fn an_attenuation_distance_of_0_is_infinite() {
    let volume = json!({"thicknessFactor": 0.5, "attenuationDistance": 0, "attenuationColor": [0.5, 1, 1]});
    let scene = import_material(json!({"extensions": {"KHR_materials_volume": volume}})).unwrap();
    assert_eq!(scene.materials[0].volume.unwrap().attenuation_distance, f32::INFINITY);
    let pointer = "/materials/0/extensions/KHR_materials_volume/attenuationDistance";
    assert_eq!(only_warning(&scene, "taken for infinite"), (pointer, true));
}

#[test]
fn distances_beyond_32_bit_floats_are_infinite() {
    // Babylon.js writes the largest 64-bit float.
    let largest = json!(f64::MAX);
    let volume =
        json!({"thicknessFactor": 0.5, "attenuationDistance": largest, "attenuationColor": [0.5, 1, 1]});
    let scene = import_material(json!({"extensions": {"KHR_materials_volume": volume}})).unwrap();
    assert_eq!(scene.materials[0].volume.unwrap().attenuation_distance, f32::INFINITY);
    assert!(scene.warnings.is_empty());

    let mut document = Document::triangle();
    document.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    document.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "range": largest}]}});
    document.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1, "zfar": largest}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": largest}},
    ]);
    let scene = document.import().unwrap();
    assert_eq!(scene.lights[0].range, None);
    let far = |camera: usize| match scene.cameras[camera].projection {
        Projection::Perspective { z_far, .. } => z_far,
        Projection::Orthographic { z_far, .. } => Some(z_far),
    };
    assert_eq!([far(0), far(1)], [None, Some(f32::MAX)]);
    // Other numbers have no such meaning.
    let bright = json!({"emissiveFactor": [1e300, 0, 0]});
    let error = error_text(import_material(bright), 65);
    assert!(error.contains("/emissiveFactor: must be a number that 32-bit floats can hold"), "{error}");
}

#[test]
fn long_quaternions_are_rotations() {
    let mut document = Document::triangle();
    document.json["nodes"][0]["rotation"] = json!([0, 3e30, 0, 4e30]);
    let scene = document.import().unwrap();
    let LocalTransform::Trs { rotation, .. } = scene.nodes[0].local else { panic!() };
    assert!(rotation.abs_diff_eq(Quat::from_xyzw(0.0, 0.6, 0.0, 0.8), 1e-6), "{rotation}");
}

#[test]
fn factors_beyond_0_to_1_are_clamped_and_emission_is_used_as_it_is() {
    let bright = json!({"baseColorFactor": [1.4, 1, -0.5, 1], "roughnessFactor": 1.5});
    let scene = import_material(json!({"pbrMetallicRoughness": bright})).unwrap();
    let material = &scene.materials[0];
    assert_eq!((material.base_color, material.roughness), (Vec4::new(1.0, 1.0, 0.0, 1.0), 1.0));
    let pointers: Vec<&str> = scene.warnings.iter().map(|warning| warning.pointer.as_str()).collect();
    let color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    assert_eq!(pointers, [color, color, "/materials/0/pbrMetallicRoughness/roughnessFactor"]);

    for (name, value, factor) in [
        ("KHR_materials_specular", json!({"specularFactor": 2}), "specularFactor"),
        ("KHR_materials_clearcoat", json!({"clearcoatRoughnessFactor": -0.5}), "clearcoatRoughnessFactor"),
        ("KHR_materials_sheen", json!({"sheenColorFactor": [1, 1.2, 1]}), "sheenColorFactor"),
        ("KHR_materials_anisotropy", json!({"anisotropyStrength": 1.5}), "anisotropyStrength"),
        ("KHR_materials_pbrSpecularGlossiness", json!({"glossinessFactor": 50}), "glossinessFactor"),
    ] {
        let scene = import_material(json!({"extensions": {name: value}})).unwrap();
        let pointer = format!("/materials/0/extensions/{name}/{factor}");
        assert_eq!(only_warning(&scene, "must lie between 0 and 1"), (pointer.as_str(), true));
    }

    let scene = import_material(json!({"emissiveFactor": [3, 0.5, 0]})).unwrap();
    assert_eq!(scene.materials[0].emissive, Vec3::new(3.0, 0.5, 0.0));
    assert_eq!(only_warning(&scene, "used as it is"), ("/materials/0/emissiveFactor", true));
    error_text(import_material(json!({"emissiveFactor": [-1, 0, 0]})), 65);
}

/// A triangle with the attributes `TEXCOORD_0` and so on of `sets`, whose emissive texture has the coordinates `used`.
fn textured(sets: &[usize], used: usize) -> Document {
    let mut document = Document::triangle();
    document.json["images"] = json!([{"uri": super::materials::png_uri([1, 2, 3, 4])}]);
    document.json["textures"] = json!([{"source": 0}]);
    document.json["materials"] =
        json!([{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0, "texCoord": used}}]);
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    for set in sets {
        document.attribute(&format!("TEXCOORD_{set}"), "VEC2", &[*set as f32; 6]);
    }
    document
}

#[test]
fn texture_coordinates_after_a_gap_are_those_of_their_number() {
    let scene = textured(&[1], 1).import().unwrap();
    let uvs = &scene.meshes[0].primitives[0].uvs;
    assert_eq!((uvs[0][2], uvs[1][2], uvs.len()), (Vec2::ZERO, Vec2::ONE, 2));
    let pointer = "/meshes/0/primitives/0/attributes/TEXCOORD_1";
    assert_eq!(only_warning(&scene, "TEXCOORD_0 is missing"), (pointer, true));
    // Two gaps, and a set of any number that nothing uses
    let scene = textured(&[0, 3, 4_000_000_000], 3).import().unwrap();
    let uvs = &scene.meshes[0].primitives[0].uvs;
    assert_eq!((uvs[3][0], uvs.len()), (Vec2::splat(3.0), 4));
    assert!(scene.warnings.iter().any(|warning| warning.message.contains("TEXCOORD_4000000000 is ignored")));
}

#[test]
fn targets_displace_no_normals_that_the_primitive_lacks() {
    let mut document = Document::triangle();
    document.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0, "NORMAL": 0}]);
    let scene = document.import().unwrap();
    let target = &scene.meshes[0].primitives[0].targets[0];
    assert!(target.positions.is_some() && target.normals.is_none());
    let pointer = "/meshes/0/primitives/0/targets/0/NORMAL";
    assert_eq!(only_warning(&scene, "no NORMAL"), (pointer, true));
}

/// Imports an otherwise empty file that has `extensions`, of which it requires `required`.
fn with_extensions(extensions: &Value, required: &[&str]) -> Scene {
    let used: Vec<&String> = extensions.as_object().unwrap().keys().collect();
    let file = json!({
        "asset": {"version": "2.0"}, "extensions": extensions, "extensionsUsed": used, "extensionsRequired": required
    });
    import_bytes("a.gltf", file.to_string().as_bytes()).unwrap()
}

#[test]
fn extensions_that_no_image_shows_are_no_warnings() {
    // assimp and CAD converters write them.
    let names = [
        "FB_ngon_encoding",
        "EXT_structural_metadata",
        "EXT_mesh_features",
        "KHR_xmp_json_ld",
        "KHR_interactivity",
        "KHR_physics_rigid_bodies",
    ];
    assert!(names.iter().all(|name| extension_support(name, true) == Ignored));
    let extensions = json!({"FB_ngon_encoding": {}, "EXT_structural_metadata": {"schema": {}}});
    assert_eq!(with_extensions(&extensions, &["FB_ngon_encoding"]).warnings, []);
}

#[test]
fn extensions_that_are_not_supported_may_hold_anything() {
    let metadata = json!({"schema": {"properties": {"extensions": {"type": "STRING", "default": null}}}});
    assert_eq!(with_extensions(&json!({"EXT_structural_metadata": metadata}), &[]).warnings, []);
    let scene = with_extensions(&json!({"ACME_names": {"extensions": "glb"}}), &[]);
    assert_eq!(only_warning(&scene, "ACME_names is not supported"), ("/extensions/ACME_names", true));
}
