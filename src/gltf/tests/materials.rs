use base64::Engine;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};

use super::{error_text, import_bytes};
use crate::error::Result;
use crate::gltf::{ExtensionSupport, extension_support};
use crate::scene::{
    AlphaMode, Filter, Light, LightKind, Scene, Texels, TextureIndex, UvRotation, UvTransform, Volume,
    WrapMode,
};
use glam::{Vec2, Vec3};

/// PNG of one texel as a `data:` URI.
pub(super) fn png_uri(texel: [u8; 4]) -> String {
    let mut file = Vec::new();
    image::codecs::png::PngEncoder::new(&mut file)
        .write_image(&texel, 1, 1, ExtendedColorType::Rgba8)
        .unwrap();
    let base64 = base64::engine::general_purpose::STANDARD.encode(file);
    format!("data:image/jpeg;base64,{base64}")
}

/// Imports a file with `material` and two textures.
#[expect(clippy::needless_pass_by_value, reason = "callers build the value in place")]
pub(super) fn import_material(material: Value) -> Result<Scene> {
    let document = json!({
        "asset": {"version": "2.0"},
        "images": [{"uri": "missing.png"}, {"uri": png_uri([1, 2, 3, 4])}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9985}],
        "textures": [{"source": 0}, {"source": 1, "sampler": 0}],
        "materials": [material]
    });
    import_bytes("a.gltf", document.to_string().as_bytes())
}

#[test]
fn only_used_images_are_read() {
    let scene = import_material(json!({"normalTexture": {"index": 1}})).unwrap();
    assert_eq!(scene.images.len(), 1);
    // The contents determine the format. The media type wrongly says JPEG.
    assert_eq!(scene.images[0].texels, Texels::Rgba8(vec![[1, 2, 3, 4]]));
    let sampler = scene.textures[0].sampler;
    assert_eq!((sampler.wrap_u, sampler.wrap_v), (WrapMode::ClampToEdge, WrapMode::MirroredRepeat));
    assert_eq!((sampler.magnify, sampler.minify), (Filter::Nearest, Filter::Linear));
    error_text(import_material(json!({"normalTexture": {"index": 0}})), 66);
    error_text(import_material(json!({"normalTexture": {"index": 2}})), 65);
}

/// Materials in whose textures `texture` nothing looks up, and the number of the other textures that they have.
fn materials_without_lookups(texture: &Value) -> Vec<(Value, usize)> {
    let used = json!({"index": 1});
    let mut materials = vec![
        (json!({"emissiveTexture": texture}), 0),
        (
            json!({
                "pbrMetallicRoughness": {"baseColorTexture": texture, "metallicRoughnessTexture": texture},
                "extensions": {
                    "KHR_materials_pbrSpecularGlossiness": {"diffuseTexture": used},
                    "KHR_materials_specular": {"specularTexture": texture, "specularColorTexture": texture}
                }
            }),
            1,
        ),
        (
            // AOVs have the normals of unlit surfaces.
            json!({
                "pbrMetallicRoughness": {"baseColorTexture": used, "metallicRoughnessTexture": texture},
                "normalTexture": used, "occlusionTexture": texture,
                "emissiveFactor": [1, 1, 1], "emissiveTexture": texture,
                "extensions": {
                    "KHR_materials_unlit": {},
                    "KHR_materials_anisotropy": {"anisotropyStrength": 1, "anisotropyTexture": texture},
                    "KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": texture},
                    "KHR_materials_specular": {"specularTexture": texture}
                }
            }),
            2,
        ),
        (
            json!({"extensions": {
                "KHR_materials_unlit": {},
                "KHR_materials_pbrSpecularGlossiness":
                    {"diffuseTexture": used, "specularGlossinessTexture": texture}
            }}),
            1,
        ),
    ];
    for (extension, keys) in [
        (
            "KHR_materials_clearcoat",
            &["clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"][..],
        ),
        ("KHR_materials_sheen", &["sheenColorTexture", "sheenRoughnessTexture"]),
        ("KHR_materials_iridescence", &["iridescenceTexture", "iridescenceThicknessTexture"]),
        ("KHR_materials_anisotropy", &["anisotropyTexture"]),
        ("KHR_materials_transmission", &["transmissionTexture"]),
        (
            "KHR_materials_diffuse_transmission",
            &["diffuseTransmissionTexture", "diffuseTransmissionColorTexture"],
        ),
    ] {
        let members: Value = keys.iter().map(|&key| (key.to_owned(), texture.clone())).collect();
        materials.push((json!({"extensions": {extension: members}}), 0));
    }
    materials
}

#[test]
fn images_that_nothing_looks_up_are_not_read() {
    // The image is missing, and the set of coordinates beyond the limit.
    for (material, used) in materials_without_lookups(&json!({"index": 0, "texCoord": 64})) {
        let scene = import_material(material.clone()).unwrap();
        assert_eq!(scene.textures.len(), used.min(1), "{material}");
        assert_eq!(scene.materials[0].texture_refs().count(), used, "{material}");
        assert_eq!(scene.unused_textures, 2 - used.min(1), "{material}");
    }
    // References are checked all the same.
    for wrong in [json!({"index": 2}), json!({}), json!({"index": 0, "texCoord": -1}), json!([])] {
        for (material, _) in materials_without_lookups(&wrong) {
            error_text(import_material(material), 65);
        }
    }
}

#[test]
fn images_that_animations_may_show_are_read() {
    let read = |material: Value| {
        let document = json!({
            "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_animation_pointer"],
            "images": [{"uri": png_uri([1, 2, 3, 4])}], "textures": [{"source": 0}], "materials": [material]
        });
        import_bytes("a.gltf", document.to_string().as_bytes()).unwrap().materials[0].texture_refs().count()
    };
    assert_eq!(read(json!({"emissiveTexture": {"index": 0}})), 1);
    let coat = json!({"clearcoatTexture": {"index": 0}, "clearcoatNormalTexture": {"index": 0}});
    assert_eq!(read(json!({"extensions": {"KHR_materials_clearcoat": coat}})), 2);
    // Nothing animates what an unlit material is, and what another model replaces.
    assert_eq!(read(json!({"emissiveTexture": {"index": 0}, "extensions": {"KHR_materials_unlit": {}}})), 0);
    assert_eq!(
        read(json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "extensions": {"KHR_materials_pbrSpecularGlossiness": {}}
        })),
        0
    );
}

#[test]
fn texture_transforms_of_every_slot_are_imported() {
    let info = json!({"index": 1, "texCoord": 3, "extensions": {"KHR_texture_transform":
        {"offset": [0.5, 0.25], "rotation": 1.5, "scale": [2, 3], "texCoord": 1}}});
    let scene = import_material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": info, "metallicRoughnessTexture": info},
        "normalTexture": info, "occlusionTexture": info, "emissiveFactor": [1, 1, 1], "emissiveTexture": info,
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": info}}
    }))
    .unwrap();
    let material = &scene.materials[0];
    let references = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture.map(|normal| normal.texture),
        material.occlusion_texture.map(|occlusion| occlusion.texture),
        material.emissive_texture,
        material.transmission.and_then(|transmission| transmission.texture),
    ];
    for reference in references {
        let reference = reference.unwrap();
        assert_eq!((reference.texture, reference.uv_set), (TextureIndex(0), 1));
        let expected = UvTransform {
            offset: Vec2::new(0.5, 0.25),
            rotation: UvRotation::from_radians(1.5),
            scale: Vec2::new(2.0, 3.0),
        };
        assert_eq!(reference.transform, expected);
    }
    assert_eq!(scene.textures.len(), 1);
}

#[test]
fn extension_values_are_imported() {
    let scene = import_material(json!({
        "alphaMode": "MASK", "alphaCutoff": 0.25, "emissiveFactor": [1, 0.5, 0],
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_ior": {"ior": 1.25},
            "KHR_materials_unlit": {},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [1, 0.5, 0.25]}
        }
    }))
    .unwrap();
    let material = &scene.materials[0];
    assert_eq!(material.emissive, Vec3::new(8.0, 4.0, 0.0));
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.25 });
    assert!(material.unlit && material.ior == 1.25);
    let volume = Volume {
        thickness: 1.0,
        attenuation_distance: f32::INFINITY,
        attenuation_color: Vec3::new(1.0, 0.5, 0.25),
    };
    assert_eq!(material.volume, Some(volume));
    assert!(scene.warnings.is_empty());
    // The default material is the last.
    assert_eq!(scene.materials.len(), 2);
    assert_eq!(scene.materials[1], crate::scene::Material::default());
}

#[test]
fn invalid_values_are_errors_with_a_pointer() {
    for (material, pointer) in [
        (json!({"alphaMode": "GLOW"}), "/materials/0/alphaMode"),
        (json!({"pbrMetallicRoughness": {"metallicFactor": "2"}}), "/materials/0"),
        (json!({"emissiveTexture": {}}), "/materials/0"),
        (json!({"extensions": {"KHR_materials_ior": {"ior": "abc"}}}), "/KHR_materials_ior/ior"),
        (json!({"extensions": {"KHR_materials_ior": {"ior": -0.5}}}), "/KHR_materials_ior/ior"),
        (json!({"extensions": {"KHR_materials_unlit": true}}), "/KHR_materials_unlit"),
        (
            json!({"extensions": {"KHR_materials_volume": {"attenuationDistance": -1}}}),
            "/attenuationDistance",
        ),
    ] {
        let text = error_text(import_material(material), 65);
        assert!(text.contains(pointer), "{text}");
    }
}

#[test]
fn indices_of_refraction_below_one_are_taken_for_one() {
    let scene = import_material(json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}})).unwrap();
    assert_eq!(scene.materials[0].ior, 1.0);
    assert_eq!(scene.warnings[0].pointer, "/materials/0/extensions/KHR_materials_ior/ior");
}

#[test]
fn unsupported_extensions_are_refused_or_warned_about() {
    let required = json!({"asset": {"version": "2.0"}, "extensionsUsed": ["ACME_glow"], "extensionsRequired": ["ACME_glow"]});
    let text = error_text(import_bytes("a.gltf", required.to_string().as_bytes()), 65);
    assert!(text.contains("ACME_glow"), "{text}");

    let optional = json!({
        "asset": {"version": "2.0"}, "extensionsUsed": ["ACME_glow", "ACME_matt_finish", "KHR_lights_punctual"],
        "materials": [{}, {"extensions": {"ACME_matt_finish": {}}}, {"extensions": {"ACME_matt_finish": {}}}],
        "nodes": [{"extensions": {"KHR_materials_ior": {}}}]
    });
    let scene = import_bytes("a.gltf", optional.to_string().as_bytes()).unwrap();
    let pointers: Vec<&str> = scene.warnings.iter().map(|warning| warning.pointer.as_str()).collect();
    let expected = [
        "/nodes/0/extensions/KHR_materials_ior",
        "/extensionsUsed/0",
        "/materials/1/extensions/ACME_matt_finish",
    ];
    assert_eq!(pointers, expected);
    assert_eq!(extension_support("KHR_materials_ior", true), ExtensionSupport::Supported);
    assert_eq!(extension_support("ACME_glow", false), ExtensionSupport::Ignored);
    assert_eq!(extension_support("ACME_glow", true), ExtensionSupport::Refused);
}

#[test]
fn required_extensions_without_effect_are_ignored() {
    assert_eq!(extension_support("CESIUM_RTC", true), ExtensionSupport::Ignored);
    let moved = json!({
        "asset": {"version": "2.0"}, "extensionsUsed": ["CESIUM_RTC"], "extensionsRequired": ["CESIUM_RTC"],
        "extensions": {"CESIUM_RTC": {"center": [6_378_137.0, 0.0, 0.0]}}
    });
    let scene = import_bytes("a.gltf", moved.to_string().as_bytes()).unwrap();
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert_eq!(warning.pointer, "/extensions/CESIUM_RTC");
    assert!(warning.message.ends_with("it is ignored"), "{warning}");
}

#[test]
fn unsupported_images_are_errors_only_if_used() {
    let avif = json!({
        "asset": {"version": "2.0"}, "extensionsUsed": ["EXT_texture_avif"],
        "images": [{"uri": "a.avif"}],
        "textures": [{"extensions": {"EXT_texture_avif": {"source": 0}}}],
        "materials": [{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}]
    });
    let text = error_text(import_bytes("a.gltf", avif.to_string().as_bytes()), 65);
    assert!(text.contains("EXT_texture_avif"), "{text}");
    let mut unused = avif.clone();
    unused["materials"] = json!([{}]);
    assert_eq!(import_bytes("a.gltf", unused.to_string().as_bytes()).unwrap().warnings.len(), 1);
    let mut broken = avif;
    broken["textures"] = json!([{"source": 0}]);
    broken["images"] = json!([{"name": "bark", "uri": "data:image/png;base64,iVBORw0KGgo="}]);
    let text = error_text(import_bytes("a.gltf", broken.to_string().as_bytes()), 65);
    assert!(text.contains("/images/0: the image \"bark\""), "{text}");
}

#[test]
fn lights_are_checked() {
    let light = |light: Value| {
        let document = json!({
            "asset": {"version": "2.0"},
            "extensions": {"KHR_lights_punctual": {"lights": [light]}},
            "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}]
        });
        import_bytes("a.gltf", document.to_string().as_bytes())
    };
    let scene = light(json!({"type": "spot", "spot": {}, "range": 4, "intensity": 3})).unwrap();
    assert_eq!((scene.lights[0].range, scene.lights[0].intensity), (Some(4.0), 3.0));
    assert!(matches!(scene.lights[0].kind, LightKind::Spot { inner_cone_radians: 0.0, .. }));
    assert!(scene.nodes[0].light.is_some());
    for (hard, inner) in [([1.0, 1.0], 1.0), ([1.5, 1.0], 1.5), ([0.5, 1.0], 0.5)] {
        let cone = json!({"innerConeAngle": hard[0], "outerConeAngle": hard[1]});
        let scene = light(json!({"type": "spot", "spot": cone})).unwrap();
        let kind = LightKind::Spot { inner_cone_radians: inner, outer_cone_radians: 1.0 };
        assert_eq!((scene.lights[0].kind, scene.warnings.len()), (kind, usize::from(hard[0] > 1.0)));
    }
    let scene = light(json!({"type": "point", "color": [4, 1, 0], "intensity": 3})).unwrap();
    assert_eq!((scene.lights[0].color, scene.lights[0].intensity), (Vec3::new(4.0, 1.0, 0.0), 3.0));
    assert_eq!(scene.warnings[0].pointer, "/extensions/KHR_lights_punctual/lights/0/color");
    let scene = light(json!({"type": "point", "intensity": -1})).unwrap();
    assert_eq!((scene.lights[0].intensity, scene.warnings.len()), (0.0, 1));
    let scene = light(json!({"type": "point", "color": [1.00001, 1, -1e-9], "intensity": -1e-9})).unwrap();
    let Light { color, intensity, .. } = scene.lights[0];
    assert_eq!((color, intensity, scene.warnings.len()), (Vec3::new(1.0, 1.0, 0.0), 0.0, 0));
    for bad in [
        json!({"type": "spot"}),
        json!({"type": "spot", "spot": {"outerConeAngle": 2}}),
        json!({"type": "point", "range": 0}),
        json!({"type": "point", "color": [1, -1, 0]}),
        json!({"type": "area"}),
        json!({}),
    ] {
        error_text(light(bad), 65);
    }
}

#[test]
fn errors_of_types_name_the_member() {
    let error = |document: serde_json::Value| {
        error_text(import_bytes("a.gltf", document.to_string().as_bytes()).map(|_| Scene::default()), 65)
    };
    let material =
        |values| json!({"asset": {"version": "2.0"}, "materials": [{}, {"pbrMetallicRoughness": values}]});
    for (values, pointer) in [
        (json!({"baseColorFactor": [1, 1, 1]}), "/materials/1/pbrMetallicRoughness/baseColorFactor"),
        (json!({"roughnessFactor": "half"}), "/materials/1/pbrMetallicRoughness/roughnessFactor"),
        (
            json!({"baseColorTexture": {"index": -1}}),
            "/materials/1/pbrMetallicRoughness/baseColorTexture/index",
        ),
    ] {
        let error = error(material(values));
        assert!(error.contains(&format!(": {pointer}: ")), "{error}");
    }
    let node = json!({"asset": {"version": "2.0"}, "nodes": [{"children": [0, "one"]}]});
    assert!(error(node).contains(": /nodes/0/children/1: "));
}
