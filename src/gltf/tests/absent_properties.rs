//! Animation pointers to properties of objects that the file leaves out, because all have their default values.

use glam::Vec4;
use serde_json::json;

use super::pointers::{animatable, animate, animate_with};
use super::properties::frame;
use crate::scene::{AnimationTarget, MaterialIndex, MaterialProperty, NodeIndex, TextureSlot};

#[test]
fn extensions_with_default_values_may_be_absent() {
    let mut document = animatable();
    let plain = document.push("materials", json!({"emissiveFactor": [1, 1, 1]}));
    let extensions = format!("/materials/{plain}/extensions");
    animate(&mut document, &format!("{extensions}/KHR_materials_ior/ior"), "LINEAR", "SCALAR", &[1.2, 1.9]);
    let strength = format!("{extensions}/KHR_materials_emissive_strength/emissiveStrength");
    animate(&mut document, &strength, "LINEAR", "SCALAR", &[1.0, 7.0]);
    // Without a coat there is nothing to animate.
    let coat = format!("{extensions}/KHR_materials_clearcoat/clearcoatFactor");
    animate(&mut document, &coat, "LINEAR", "SCALAR", &[0.0, 1.0]);
    let scene = document.import().unwrap();
    let targets = scene.animations.iter().map(|clip| clip.channels.first().map(|channel| channel.target));
    let material = |property| Some(AnimationTarget::Material(MaterialIndex(plain as u32), property));
    let expected = [material(MaterialProperty::Ior), material(MaterialProperty::EmissiveStrength), None];
    assert_eq!(targets.collect::<Vec<_>>(), expected);
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].message.contains("clearcoatFactor"));

    // Those of other objects
    let mut document = animatable();
    let dispersion = format!("{extensions}/KHR_materials_dispersion/dispersion");
    let plain = document.push("materials", json!({"emissiveTexture": {"index": 0}}));
    animate(&mut document, &dispersion, "LINEAR", "SCALAR", &[0.0, 0.5]);
    let shift = format!("/materials/{plain}/emissiveTexture/extensions/KHR_texture_transform/offset");
    animate(&mut document, &shift, "LINEAR", "VEC2", &[0.0, 0.0, 0.5, 1.0]);
    let switch = document.accessor(5121, "SCALAR", 2, &[1, 0]);
    animate_with(&mut document, "/nodes/1/extensions/KHR_node_visibility/visible", "STEP", switch);
    let scene = document.import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let targets = scene.animations.iter().map(|clip| clip.channels.first().map(|channel| channel.target));
    let expected = [
        material(MaterialProperty::Dispersion),
        material(MaterialProperty::TextureOffset(TextureSlot::Emissive)),
        Some(AnimationTarget::Visibility(NodeIndex(1))),
    ];
    assert_eq!(targets.collect::<Vec<_>>(), expected);
}

#[test]
fn factors_may_be_animated_where_all_are_absent() {
    let mut document = animatable();
    let plain = document.push("materials", json!({}));
    let factors = format!("/materials/{plain}/pbrMetallicRoughness");
    animate(
        &mut document,
        &format!("{factors}/baseColorFactor"),
        "LINEAR",
        "VEC4",
        &[0.0, 0.5, 0.0, 1.0].repeat(2),
    );
    animate(&mut document, &format!("{factors}/metallicFactor"), "LINEAR", "SCALAR", &[0.25; 2]);
    let scene = document.import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let posed = [0, 1].map(|clip| scene.animations[clip].channels[0].target);
    let material = |property| AnimationTarget::Material(MaterialIndex(plain as u32), property);
    assert_eq!(posed, [material(MaterialProperty::BaseColor), material(MaterialProperty::Metallic)]);
    let green = frame(&scene, 0.5).materials[plain].base_color;
    assert_eq!(green, Vec4::new(0.0, 0.5, 0.0, 1.0));

    // A texture that is absent, and a list of materials that is too short, have no defaults.
    for pointer in [
        &format!("{factors}/baseColorTexture/extensions/KHR_texture_transform/offset"),
        "/materials/9/pbrMetallicRoughness/metallicFactor",
        "/nodes/9/extensions/KHR_node_visibility/visible",
    ] {
        let mut document = animatable();
        document.push("materials", json!({}));
        animate(&mut document, pointer, "LINEAR", "SCALAR", &[0.5; 2]);
        let scene = document.import().unwrap();
        assert!(scene.animations[0].channels.is_empty() && scene.warnings.len() == 1, "{pointer}");
    }
}
