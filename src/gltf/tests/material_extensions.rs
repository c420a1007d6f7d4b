//! Material extensions and variants: valid values, invalid values, and combinations.

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

use super::materials::import_material;
use super::{error_text, import_bytes};
use crate::scene::{
    Anisotropy, ClearCoat, DiffuseTransmission, Glossiness, Iridescence, Material, MaterialIndex, Sheen,
    Specular, TextureIndex, TextureRef, UvTransform, VariantIndex,
};

/// Reference to the only texture that has an image, with coordinate set `uv_set`.
fn texture(uv_set: u32) -> TextureRef {
    TextureRef { texture: TextureIndex(0), uv_set, transform: UvTransform::default() }
}

fn info(uv_set: u32) -> Value {
    json!({"index": 1, "texCoord": uv_set})
}

#[expect(clippy::needless_pass_by_value, reason = "callers build the value in place")]
fn with_extension(name: &str, value: Value) -> Material {
    let scene = import_material(json!({"extensions": {name: value}})).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene.materials[0].clone()
}

#[test]
fn specular_values_and_textures_are_imported() {
    let material = with_extension(
        "KHR_materials_specular",
        json!({"specularFactor": 0.25, "specularTexture": info(1),
            "specularColorFactor": [2, 0.5, 0], "specularColorTexture": info(2)}),
    );
    let specular = Specular {
        factor: 0.25,
        texture: Some(texture(1)),
        color: Vec3::new(2.0, 0.5, 0.0),
        color_texture: Some(texture(2)),
    };
    assert_eq!(material, Material { specular: Some(specular), ..Material::default() });
}

#[test]
fn clear_coat_is_imported() {
    let material = with_extension(
        "KHR_materials_clearcoat",
        json!({"clearcoatFactor": 0.5, "clearcoatTexture": info(1), "clearcoatRoughnessFactor": 0.25,
            "clearcoatRoughnessTexture": info(2),
            "clearcoatNormalTexture": {"index": 1, "texCoord": 3, "scale": 0.75}}),
    );
    let normal_texture = crate::scene::NormalTexture { texture: texture(3), scale: 0.75 };
    let coat = ClearCoat {
        factor: 0.5,
        texture: Some(texture(1)),
        roughness: 0.25,
        roughness_texture: Some(texture(2)),
        normal_texture: Some(normal_texture),
    };
    assert_eq!(material, Material { clear_coat: Some(coat), ..Material::default() });
    assert_eq!(material.tangent_uv_set(), Some(3));
}

#[test]
fn sheen_is_imported() {
    let material = with_extension(
        "KHR_materials_sheen",
        json!({"sheenColorFactor": [0.5, 0.25, 1], "sheenColorTexture": info(1),
            "sheenRoughnessFactor": 0.75, "sheenRoughnessTexture": info(2)}),
    );
    let sheen = Sheen {
        color: Vec3::new(0.5, 0.25, 1.0),
        color_texture: Some(texture(1)),
        roughness: 0.75,
        roughness_texture: Some(texture(2)),
    };
    assert_eq!(material, Material { sheen: Some(sheen), ..Material::default() });
}

#[test]
fn iridescence_is_imported() {
    let material = with_extension(
        "KHR_materials_iridescence",
        json!({"iridescenceFactor": 0.5, "iridescenceTexture": info(1), "iridescenceIor": 1.75,
            "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 800,
            "iridescenceThicknessTexture": info(2)}),
    );
    let film = Iridescence {
        factor: 0.5,
        texture: Some(texture(1)),
        ior: 1.75,
        thickness_minimum_nm: 200.0,
        thickness_maximum_nm: 800.0,
        thickness_texture: Some(texture(2)),
    };
    assert_eq!(material, Material { iridescence: Some(film), ..Material::default() });
}

#[test]
fn anisotropy_is_imported() {
    let material = with_extension(
        "KHR_materials_anisotropy",
        json!({"anisotropyStrength": 0.5, "anisotropyRotation": -1.5, "anisotropyTexture": info(2)}),
    );
    let anisotropy = Anisotropy { strength: 0.5, rotation_radians: -1.5, texture: Some(texture(2)) };
    assert_eq!(material, Material { anisotropy: Some(anisotropy), ..Material::default() });
    assert_eq!(material.tangent_uv_set(), Some(2));
}

#[test]
fn diffuse_transmission_and_dispersion_are_imported() {
    let material = with_extension(
        "KHR_materials_diffuse_transmission",
        json!({"diffuseTransmissionFactor": 0.5, "diffuseTransmissionTexture": info(1),
            "diffuseTransmissionColorFactor": [1, 0.5, 0.25], "diffuseTransmissionColorTexture": info(2)}),
    );
    let layer = DiffuseTransmission {
        factor: 0.5,
        texture: Some(texture(1)),
        color: Vec3::new(1.0, 0.5, 0.25),
        color_texture: Some(texture(2)),
    };
    assert_eq!(material, Material { diffuse_transmission: Some(layer), ..Material::default() });

    let material = with_extension("KHR_materials_dispersion", json!({"dispersion": 0.36}));
    assert_eq!(material, Material { dispersion: 0.36, ..Material::default() });
}

#[test]
fn extensions_without_values_have_no_effect() {
    for name in [
        "KHR_materials_clearcoat",
        "KHR_materials_sheen",
        "KHR_materials_iridescence",
        "KHR_materials_anisotropy",
        "KHR_materials_dispersion",
        "KHR_materials_diffuse_transmission",
    ] {
        assert_eq!(with_extension(name, json!({})), Material::default(), "{name}");
    }
    // The Fresnel curve of high indices depends on whether a material has it.
    let neutral = Specular { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: None };
    let material = with_extension("KHR_materials_specular", json!({}));
    assert_eq!(material, Material { specular: Some(neutral), ..Material::default() });
    // Defaults of iridescence: index of refraction 1.3, thickness 100 to 400 nm.
    let film = with_extension("KHR_materials_iridescence", json!({"iridescenceFactor": 1})).iridescence;
    let film = film.unwrap();
    assert_eq!((film.ior, film.thickness_minimum_nm, film.thickness_maximum_nm), (1.3, 100.0, 400.0));
}

#[test]
fn specular_glossiness_becomes_a_material_with_ior_zero() {
    let scene = import_material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicRoughnessTexture": info(3)},
        "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.5, 0.25, 0.75, 0.5], "diffuseTexture": info(1),
            "specularFactor": [0.25, 0.5, 1], "glossinessFactor": 0.75, "specularGlossinessTexture": info(2)}}
    }))
    .unwrap();
    let specular = Specular {
        factor: 1.0,
        texture: None,
        color: Vec3::new(0.25, 0.5, 1.0),
        color_texture: Some(texture(2)),
    };
    let expected = Material {
        base_color: Vec4::new(0.5, 0.25, 0.75, 0.5),
        base_color_texture: Some(texture(1)),
        metallic: 0.0,
        roughness: 0.25,
        ior: 0.0,
        specular: Some(specular),
        glossiness: Some(Glossiness { factor: 0.75, texture: Some(texture(2)) }),
        ..Material::default()
    };
    assert_eq!(scene.materials[0], expected);

    // Extensions that must not be combined with it are warned about.
    let both = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {},
        "KHR_materials_ior": {"ior": 2}, "KHR_materials_specular": {"specularFactor": 0.5}}});
    let scene = import_material(both).unwrap();
    let pointers: Vec<&str> = scene.warnings.iter().map(|warning| warning.pointer.as_str()).collect();
    assert_eq!(
        pointers,
        ["/materials/0/extensions/KHR_materials_ior", "/materials/0/extensions/KHR_materials_specular"]
    );
    let defaults = Specular { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: None };
    assert_eq!((scene.materials[0].ior, scene.materials[0].specular), (0.0, Some(defaults)));
    assert_eq!(scene.materials[0].base_color, Vec4::ONE);
}

#[test]
fn invalid_extension_values_are_errors_with_a_pointer() {
    for (name, value, pointer) in [
        ("KHR_materials_specular", json!({"specularFactor": "2"}), "/specularFactor"),
        ("KHR_materials_specular", json!({"specularColorFactor": [-1, 0, 0]}), "/specularColorFactor"),
        ("KHR_materials_specular", json!({"specularTexture": {"index": 9}}), "/specularTexture/index"),
        ("KHR_materials_clearcoat", json!({"clearcoatFactor": "1"}), "/clearcoatFactor"),
        ("KHR_materials_clearcoat", json!([]), "/KHR_materials_clearcoat"),
        ("KHR_materials_sheen", json!({"sheenColorFactor": [1, 1]}), "/sheenColorFactor"),
        ("KHR_materials_sheen", json!({"sheenColorTexture": {}}), "/sheenColorTexture/index"),
        ("KHR_materials_iridescence", json!({"iridescenceIor": 0.5}), "/iridescenceIor"),
        (
            "KHR_materials_iridescence",
            json!({"iridescenceThicknessMaximum": -1}),
            "/iridescenceThicknessMaximum",
        ),
        ("KHR_materials_dispersion", json!({"dispersion": -1}), "/dispersion"),
        (
            "KHR_materials_diffuse_transmission",
            json!({"diffuseTransmissionColorFactor": [1, 2]}),
            "/diffuseTransmissionColorFactor",
        ),
        ("KHR_materials_pbrSpecularGlossiness", json!({"glossinessFactor": [1]}), "/glossinessFactor"),
    ] {
        let text = error_text(import_material(json!({"extensions": {name: value}})), 65);
        assert!(text.contains(pointer) && text.contains("/materials/0/extensions"), "{text}");
    }
}

#[test]
fn texture_transforms_of_extensions_are_imported() {
    let turned =
        json!({"index": 1, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "texCoord": 1}}});
    let material = with_extension(
        "KHR_materials_sheen",
        json!({"sheenColorFactor": [1, 1, 1], "sheenRoughnessTexture": turned}),
    );
    let reference = material.sheen.unwrap().roughness_texture.unwrap();
    assert_eq!((reference.uv_set, reference.transform.offset), (1, Vec2::new(0.5, 0.0)));
}

#[test]
fn diffuse_transmission_lets_light_into_volumes() {
    for (factor, thickness, is_volume) in [(0.5, 1.0, true), (0.0, 1.0, false), (0.5, 0.0, false)] {
        let scene = import_material(json!({"extensions": {
            "KHR_materials_volume": {"thicknessFactor": thickness},
            "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": factor}}}))
        .unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let material = &scene.materials[0];
        assert_eq!((material.is_volume(), material.transmits()), (is_volume, false), "{factor} {thickness}");
        let unlit = crate::scene::Material { unlit: true, ..material.clone() };
        assert!(!unlit.is_volume());
    }
}

/// Imports a white triangle with the variant mappings `mappings`.
#[expect(clippy::needless_pass_by_value, reason = "callers build the value in place")]
fn with_mappings(mappings: Value) -> crate::error::Result<crate::scene::Scene> {
    let positions: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let base64 = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, positions);
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": {"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}},
        "buffers": [{"byteLength": 36, "uri": format!("data:application/octet-stream;base64,{base64}")}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}],
        "materials": [{}, {}, {}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0,
            "extensions": {"KHR_materials_variants": {"mappings": mappings}}}]}]
    });
    import_bytes("a.gltf", document.to_string().as_bytes())
}

#[test]
fn variants_replace_materials() {
    let scene = with_mappings(json!([{"material": 2, "variants": [1]}])).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let names: Vec<&str> = scene.variants.iter().map(|variant| variant.name.as_str()).collect();
    assert_eq!(names, ["day", "night"]);
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(primitive.material_in(None), MaterialIndex(0));
    assert_eq!(primitive.material_in(Some(VariantIndex(0))), MaterialIndex(0));
    assert_eq!(primitive.material_in(Some(VariantIndex(1))), MaterialIndex(2));
}

#[test]
fn warnings_about_materials_are_those_of_their_variants() {
    let [day, night] = [0, 1].map(|index| Some(VariantIndex(index)));
    let anisotropy = json!({"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}}});
    let import = |material: usize, mappings: &[Value]| {
        let mut document = super::Document::triangle();
        document.json["extensions"] =
            json!({"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}});
        document.json["materials"] = json!([{}, anisotropy]);
        let primitive = document.json["meshes"][0]["primitives"][0].clone();
        let with_mappings = |mapping: &Value| {
            let mut primitive = primitive.clone();
            primitive["material"] = json!(material);
            primitive["extensions"] = json!({"KHR_materials_variants": {"mappings": [mapping]}});
            primitive
        };
        document.json["meshes"][0]["primitives"] = mappings.iter().map(with_mappings).collect();
        document.import().unwrap()
    };
    let counts = |scene: &crate::scene::Scene| {
        let counts = [vec![None], vec![day], vec![night], vec![None, day, night]];
        counts.map(|variants| scene.warnings_of(&variants).len())
    };
    let replacing = |material: usize, variant: usize| json!({"material": material, "variants": [variant]});
    let scene = import(0, &[replacing(1, 1)]);
    assert_eq!(scene.warnings.len(), 1);
    assert_eq!(counts(&scene), [0, 0, 1, 1]);
    assert_eq!(counts(&import(1, &[replacing(0, 1)])), [1, 1, 0, 1]);
    // Several primitives tell it once, each with its own place.
    let scene = import(0, &[replacing(1, 1), replacing(1, 0), replacing(1, 1)]);
    assert_eq!(scene.warnings.len(), 1);
    assert_eq!(counts(&scene), [0, 1, 1, 1]);
    assert_eq!(scene.warnings_of(&[day])[0].pointer, "/meshes/0/primitives/1/attributes");
}

#[test]
fn invalid_variants_are_errors_with_a_pointer() {
    for (mappings, pointer) in [
        (json!([{"material": 3, "variants": [1]}]), "/mappings/0/material"),
        (json!([{"variants": [1]}]), "/mappings/0/material"),
        (json!([{"material": 1}]), "/mappings/0/variants"),
        (json!([{"material": 1, "variants": [2]}]), "/mappings/0/variants/0"),
        (
            json!([{"material": 1, "variants": [0]}, {"material": 2, "variants": [1, 0]}]),
            "/mappings/1/variants/1",
        ),
        (json!({}), "/mappings"),
    ] {
        let text = error_text(with_mappings(mappings), 65);
        assert!(text.contains(pointer), "{text}");
    }
    for root in [json!({}), json!({"variants": [{}]}), json!({"variants": [{"name": 1}]})] {
        let document = json!({"asset": {"version": "2.0"}, "extensions": {"KHR_materials_variants": root}});
        let text = error_text(import_bytes("a.gltf", document.to_string().as_bytes()), 65);
        assert!(text.contains("/extensions/KHR_materials_variants/variants"), "{text}");
    }
}
