//! Animation pointers: resolution to properties, unknown pointers and invalid keyframe values.

use serde_json::json;

use super::Document;
use crate::scene::{
    AnimationTarget, CameraIndex, CameraProperty, ImageLightIndex, ImageLightProperty, LightIndex,
    LightProperty, MaterialIndex, MaterialProperty, NodeIndex, TextureSlot,
};

/// Triangle document with every property that the pointer tests animate.
pub(super) fn animatable() -> Document {
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
    let light = json!({"irradianceCoefficients": vec![[1, 1, 1]; 9], "specularImageSize": 1, "specularImages": [[0, 0, 0, 0, 0, 0]]});
    document.json["extensions"]["EXT_lights_image_based"] = json!({"lights": [light]});
    document.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 0}});
    document.push(
        "materials",
        json!({"extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {},
            "KHR_materials_pbrSpecularGlossiness": {"specularGlossinessTexture": transform}
        }}),
    );
    document.json["nodes"] = json!([
        {"mesh": 0, "children": [1], "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]);
    document.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    document
}

/// Adds an animation of `pointer` from time 0 to 1.
pub(super) fn animate(
    document: &mut Document,
    pointer: &str,
    interpolation: &str,
    shape: &str,
    values: &[f32],
) {
    let output = document.floats(shape, values);
    animate_with(document, pointer, interpolation, output);
}

pub(super) fn animate_with(document: &mut Document, pointer: &str, interpolation: &str, output: usize) {
    let input = document.floats("SCALAR", &[0.0, 1.0]);
    let clip = json!({
        "channels": [{"sampler": 0, "target": {
            "path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}
        }}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
    });
    document.push("animations", clip);
}

/// Checks that `pointer` resolves to `expected` and that its keyframes have the components of the accessor type `shape`.
fn assert_resolves(pointer: &str, shape: &str, expected: AnimationTarget) {
    let components = match shape {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        _ => 4,
    };
    let mut document = animatable();
    animate(&mut document, pointer, "LINEAR", shape, &vec![0.5; 2 * components]);
    let scene = document.import().unwrap();
    assert!(scene.warnings.is_empty(), "{pointer}: {:?}", scene.warnings);
    let channel = &scene.animations[0].channels[0];
    assert_eq!((channel.target, channel.keyframes.width), (expected, components), "{pointer}");
}

#[test]
fn extensions_of_undeclared_animations_are_kept() {
    for declared in [true, false] {
        let mut document = animatable();
        if !declared {
            document.json["extensionsUsed"] = json!([]);
        }
        let coat = json!({"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0}}});
        let material = document.push("materials", coat);
        let pointer = format!("/materials/{material}/extensions/KHR_materials_clearcoat/clearcoatFactor");
        animate(&mut document, &pointer, "LINEAR", "SCALAR", &[0.0, 1.0]);
        assert!(document.import().unwrap().materials[material].clear_coat.is_some(), "{declared}");
    }
}

#[test]
fn pointers_resolve_to_nodes_and_cameras() {
    assert_resolves("/nodes/0/translation", "VEC3", AnimationTarget::Translation(NodeIndex(0)));
    assert_resolves("/nodes/1/rotation", "VEC4", AnimationTarget::Rotation(NodeIndex(1)));
    let field_of_view = AnimationTarget::Camera(CameraIndex(0), CameraProperty::FieldOfView);
    assert_resolves("/cameras/0/perspective/yfov", "SCALAR", field_of_view);
}

#[test]
fn pointers_resolve_to_materials() {
    let slot = TextureSlot::BaseColor;
    for (path, shape, property) in [
        ("pbrMetallicRoughness/baseColorFactor", "VEC4", MaterialProperty::BaseColor),
        ("pbrMetallicRoughness/roughnessFactor", "SCALAR", MaterialProperty::Roughness),
        ("emissiveFactor", "VEC3", MaterialProperty::EmissiveFactor),
        (
            "extensions/KHR_materials_emissive_strength/emissiveStrength",
            "SCALAR",
            MaterialProperty::EmissiveStrength,
        ),
        (
            "pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset",
            "VEC2",
            MaterialProperty::TextureOffset(slot),
        ),
        (
            "pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/rotation",
            "SCALAR",
            MaterialProperty::TextureRotation(slot),
        ),
    ] {
        let expected = AnimationTarget::Material(MaterialIndex(0), property);
        assert_resolves(&format!("/materials/0/{path}"), shape, expected);
    }
}

#[test]
fn pointers_resolve_to_material_extensions() {
    let material = |property| AnimationTarget::Material(MaterialIndex(1), property);
    let extensions = "/materials/1/extensions";
    assert_resolves(
        &format!("{extensions}/KHR_materials_volume/thicknessFactor"),
        "SCALAR",
        material(MaterialProperty::Thickness),
    );
    let texture = "KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture";
    assert_resolves(
        &format!("{extensions}/{texture}/extensions/KHR_texture_transform/scale"),
        "VEC2",
        material(MaterialProperty::TextureScale(TextureSlot::SpecularGlossiness)),
    );
}

#[test]
fn transforms_of_thickness_textures_are_accepted_as_the_textures_are() {
    let mut document = animatable();
    let texture = json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}});
    document.json["materials"][1]["extensions"]["KHR_materials_volume"] =
        json!({"thicknessFactor": 1, "thicknessTexture": texture});
    let plain = document.import().unwrap();
    assert!(plain.warnings.is_empty(), "{:?}", plain.warnings);
    let transform =
        "/materials/1/extensions/KHR_materials_volume/thicknessTexture/extensions/KHR_texture_transform";
    let slot = TextureSlot::Thickness;
    let expected = [
        ("offset", "VEC2", MaterialProperty::TextureOffset(slot)),
        ("scale", "VEC2", MaterialProperty::TextureScale(slot)),
        ("rotation", "SCALAR", MaterialProperty::TextureRotation(slot)),
    ];
    for (key, shape, _) in expected {
        let count = if shape == "VEC2" { 4 } else { 2 };
        animate(&mut document, &format!("{transform}/{key}"), "LINEAR", shape, &[0.5; 4][..count]);
    }
    let scene = document.import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    for (clip, (key, _, property)) in scene.animations.iter().zip(expected) {
        let target = AnimationTarget::Material(MaterialIndex(1), property);
        assert_eq!(clip.channels.first().map(|channel| channel.target), Some(target), "{key}");
    }
    // Rays measure the thickness themselves, so that neither the texture nor its transform has an effect.
    let posed = super::properties::frame(&scene, 0.5).materials;
    assert_eq!(posed, super::properties::frame(&plain, 0.5).materials);
}

#[test]
fn pointers_resolve_to_lights() {
    for (path, shape, property) in [
        ("color", "VEC3", LightProperty::Color),
        ("range", "SCALAR", LightProperty::Range),
        ("spot/outerConeAngle", "SCALAR", LightProperty::OuterCone),
    ] {
        let expected = AnimationTarget::Light(LightIndex(0), property);
        assert_resolves(&format!("/extensions/KHR_lights_punctual/lights/0/{path}"), shape, expected);
    }
    for (path, shape, property) in [
        ("intensity", "SCALAR", ImageLightProperty::Intensity),
        ("rotation", "VEC4", ImageLightProperty::Rotation),
    ] {
        let expected = AnimationTarget::ImageLight(ImageLightIndex(0), property);
        assert_resolves(&format!("/extensions/EXT_lights_image_based/lights/0/{path}"), shape, expected);
    }
}

#[test]
fn pointers_that_blender_misspells_resolve() {
    let inner_cone = AnimationTarget::Light(LightIndex(0), LightProperty::InnerCone);
    assert_resolves("/extensions/KHR_lights_punctual/lights/0/spot.innerConeAngle", "SCALAR", inner_cone);
    let thickness = AnimationTarget::Material(MaterialIndex(1), MaterialProperty::Thickness);
    assert_resolves("/materials/1/extensions/KHR_materials_volume/thicknessFactor ", "SCALAR", thickness);
}

#[test]
fn unknown_pointers_are_warned_about_and_other_channels_imported() {
    for pointer in [
        "/materials/2/emissiveFactor",
        "/materials/0/name",
        "/nodes/9/weights/0",
        "/nodes/0/weights/+0",
        "/cameras/0/weights/0",
        "/materials/0/normalTexture/scale",
        "/cameras/0/perspective/zfar",
        "/cameras/0/orthographic/xmag",
        "/nodes/0/children",
        "nonsense",
        "/nodes/+0/scale",
    ] {
        let mut document = animatable();
        animate(&mut document, pointer, "LINEAR", "SCALAR", &[0.5; 2]);
        animate(&mut document, "/nodes/0/scale", "LINEAR", "VEC3", &[0.5; 6]);
        let scene = document.import().unwrap();
        assert!(scene.animations[0].channels.is_empty() && scene.animations[1].channels.len() == 1);
        assert_eq!(scene.warnings.len(), 1, "{pointer}");
        assert!(scene.warnings[0].message.contains(pointer), "{:?}", scene.warnings);
    }
}

#[test]
fn lamps_may_be_animated_as_files_have_them() {
    let mut document = animatable();
    let light = "/extensions/KHR_lights_punctual/lights/0";
    animate(&mut document, &format!("{light}/color"), "LINEAR", "VEC3", &[4.0, 1.0, 0.0, 4.0, 1.0, 0.0]);
    animate(&mut document, &format!("{light}/intensity"), "LINEAR", "SCALAR", &[-1.0, 2.0]);
    assert_eq!(document.import().unwrap().animations.len(), 2);
    animate(&mut document, &format!("{light}/color"), "LINEAR", "VEC3", &[-1.0; 6]);
    assert!(document.error(65).contains("must"));
}

const VISIBLE: &str = "/nodes/0/extensions/KHR_node_visibility/visible";

#[test]
fn keys_of_another_format_leave_out_their_channel_alone() {
    let emission = "/materials/0/emissiveFactor";
    for (pointer, interpolation, shape, values, expected) in [
        (emission, "LINEAR", "SCALAR", &[0.5; 2][..], "keys of three numbers cannot be SCALAR of floats"),
        ("/nodes/0/scale", "LINEAR", "VEC4", &[0.5; 8], "keys of three numbers cannot be VEC4 of floats"),
        (VISIBLE, "STEP", "SCALAR", &[0.0; 2], "keys of a boolean cannot be SCALAR of floats"),
    ] {
        let mut document = animatable();
        animate(&mut document, pointer, interpolation, shape, values);
        // A second channel animates the property.
        animate(&mut document, emission, "LINEAR", "VEC3", &[0.5; 6]);
        let mut second = document.json["animations"][1].take();
        let samplers = [document.json["animations"][0]["samplers"][0].take(), second["samplers"][0].take()];
        second["channels"][0]["sampler"] = json!(1);
        let channels = [document.json["animations"][0]["channels"][0].take(), second["channels"][0].take()];
        document.json["animations"] = json!([{"channels": channels, "samplers": samplers}]);
        let scene = document.import().unwrap();
        let [channel] = &scene.animations[0].channels[..] else { panic!("{:?}", scene.animations) };
        let target = AnimationTarget::Material(MaterialIndex(0), MaterialProperty::EmissiveFactor);
        assert_eq!(channel.target, target, "{pointer}");
        let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
        assert_eq!(warning.pointer, "/animations/0/samplers/0/output");
        assert_eq!(warning.message, format!("{expected}; the property is not animated"));
    }
}

#[test]
fn keys_of_colors_may_have_alpha() {
    for pointer in ["/materials/0/emissiveFactor", "/extensions/KHR_lights_punctual/lights/0/color"] {
        let mut document = animatable();
        let values = [0.1, 0.2, 0.3, 9.0, 0.4, 0.5, 0.6, 9.0];
        animate(&mut document, pointer, "LINEAR", "VEC4", &values);
        let scene = document.import().unwrap();
        let keyframes = &scene.animations[0].channels[0].keyframes;
        assert_eq!(keyframes.width, 3);
        assert_eq!(keyframes.values, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], "{pointer}");
        let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
        assert_eq!(warning.pointer, "/animations/0/samplers/0/output");
        assert!(warning.message.contains("alpha, which is ignored"), "{warning}");
    }
}

#[test]
fn invalid_keyframes_of_properties_are_errors() {
    let base_color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    for (pointer, interpolation, shape, values, expected) in [
        (base_color, "LINEAR", "VEC4", &[0.5; 4][..], "has 4 numbers"),
        ("/cameras/0/perspective/yfov", "LINEAR", "SCALAR", &[4.0; 2], "/output"),
    ] {
        let mut document = animatable();
        animate(&mut document, pointer, interpolation, shape, values);
        let text = document.error(65);
        assert!(text.contains(expected), "{text}");
    }
    let mut document = animatable();
    animate(&mut document, base_color, "LINEAR", "VEC4", &[0.5, 1.5, 0.5, 0.5, 0.5, -1.0, 0.5, 0.5]);
    let scene = document.import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.values, [0.5, 1.0, 0.5, 0.5, 0.5, 0.0, 0.5, 0.5]);
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert!(warning.message.contains("such as -1; they are clamped"), "{warning}");
    // Tangents of cubic splines stay.
    let mut document = animatable();
    let metallic = "/materials/0/pbrMetallicRoughness/metallicFactor";
    animate(&mut document, metallic, "CUBICSPLINE", "SCALAR", &[0.0, 0.5, 3.0, -3.0, 1.5, 0.0]);
    let scene = document.import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.values, [0.0, 0.5, 3.0, -3.0, 1.0, 0.0]);
    let mut document = animatable();
    animate(&mut document, "/materials/0/emissiveFactor", "LINEAR", "VEC3", &[3.0; 6]);
    let scene = document.import().unwrap();
    assert_eq!(scene.animations[0].channels[0].keyframes.values, [3.0; 6]);
    assert!(scene.warnings[0].message.contains("used as they are"), "{:?}", scene.warnings);
    let mut document = animatable();
    let switch = document.accessor(5121, "SCALAR", 2, &[0, 1]);
    animate_with(&mut document, VISIBLE, "LINEAR", switch);
    assert!(document.error(65).contains("must be STEP"));
    // The same node is animated by a pointer and by a node path.
    let mut document = animatable();
    animate(&mut document, "/nodes/0/scale", "LINEAR", "VEC3", &[0.5; 6]);
    let named = json!({"sampler": 0, "target": {"node": 0, "path": "scale"}});
    document.json["animations"][0]["channels"].as_array_mut().unwrap().push(named);
    assert!(document.error(65).contains("another channel"));
}

#[test]
fn values_that_must_be_positive_are_told_as_such() {
    for (pointer, expected) in [
        ("/extensions/KHR_lights_punctual/lights/0/range", "is -1, but must be a finite number above 0"),
        ("/cameras/0/perspective/yfov", "is -1, but must lie above 0 and be at most 3.1412"),
        ("/cameras/0/perspective/znear", "is -1, but must be a finite number above 0"),
    ] {
        for value in [-1.0_f32, 0.0] {
            let mut document = animatable();
            animate(&mut document, pointer, "LINEAR", "SCALAR", &[0.05, value]);
            let expected = expected.replace("-1", &value.to_string());
            let error = document.error(65);
            assert!(error.contains(&expected), "{error}");
        }
    }
}
