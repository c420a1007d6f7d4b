//! Import of image-based lights.

use base64::Engine;
use glam::Vec3;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};

use super::{Document, error_text, import_bytes};
use crate::gltf::{ImportOptions, import};

/// PNG with all texels equal, as a `data:` URI.
fn png_image(size: u32, texel: [u8; 4]) -> Value {
    let mut file = Vec::new();
    let texels = texel.repeat((size * size) as usize);
    let encoder = image::codecs::png::PngEncoder::new(&mut file);
    encoder.write_image(&texels, size, size, ExtendedColorType::Rgba8).unwrap();
    let text = base64::engine::general_purpose::STANDARD.encode(file);
    json!({"uri": format!("data:image/png;base64,{text}")})
}

/// Cube map with a level of 2x2 texels and one of 1x1. Face 0 is RGBD with a divisor of 51.
fn lit() -> Value {
    let mut document = Document::triangle();
    document.json["images"] = json!([
        png_image(2, [255, 255, 255, 51]),
        png_image(2, [0, 0, 0, 255]),
        png_image(1, [255, 0, 0, 255])
    ]);
    document.json["extensions"] = json!({"EXT_lights_image_based": {"lights": [{
        "intensity": 2,
        "rotation": [0, 2, 0, 0],
        "irradianceCoefficients": vec![[1, 2, 3]; 9],
        "specularImageSize": 2,
        "specularImages": [[0, 1, 1, 1, 1, 1], [2, 2, 2, 2, 2, 2]]
    }]}});
    document.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 0}});
    document.to_json()
}

#[test]
fn cube_maps_are_decoded_from_rgbd() {
    let scene = import_bytes("a.gltf", lit().to_string().as_bytes()).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.scenes[0].image_light.map(|light| light.0), Some(0));
    let light = &scene.image_lights[0];
    assert_eq!(
        (light.intensity, light.rotation.y, light.irradiance[8]),
        (2.0, 1.0, Vec3::new(1.0, 2.0, 3.0))
    );
    assert_eq!((light.levels[0].size, light.levels[1].size, light.levels.len()), (2, 1, 2));
    // White divided by 51/255 is 5.
    assert_eq!(light.levels[0].faces[0], vec![[5.0; 3]; 4]);
    assert_eq!(light.levels[1].faces[5], vec![[1.0, 0.0, 0.0]]);
}

#[test]
fn image_lights_keep_their_faces_and_reserve_one_image() {
    // Six faces of 2x2 texels and of one, of 12 bytes each. The triangle has three vertices of 64 bytes.
    let of_mesh = 3 * 64 + 12;
    let one = import_bytes("a.gltf", lit().to_string().as_bytes()).unwrap().memory;
    assert_eq!(one.kept_bytes, 30 * 12 + of_mesh);
    let mut document = lit();
    let lights = document["extensions"]["EXT_lights_image_based"]["lights"].as_array_mut().unwrap();
    lights.push(lights[0].clone());
    let text = document.to_string();
    let two = import_bytes("a.gltf", text.as_bytes()).unwrap().memory;
    assert_eq!(two.kept_bytes, 2 * 30 * 12 + of_mesh);
    // An image of 64x32 + 32x16 + … texels, a third more than the first, for the light that is chosen: it is the last of what the import
    // reserves. A further light takes less than an image.
    let image = 64 * 32 * 12 * 4 / 3;
    assert!(two.import_bytes - one.import_bytes < image, "{one:?} {two:?}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, text).unwrap();
    let options = ImportOptions { max_memory_bytes: two.import_bytes - 1, ..ImportOptions::default() };
    let error = error_text(import(&path, &options), 77);
    assert!(error.contains("/extensions/EXT_lights_image_based/lights:"), "{error}");
}

#[test]
fn invalid_image_lights_are_errors_with_a_pointer() {
    for (key, value, expected) in [
        ("irradianceCoefficients", json!([[1, 2, 3]]), "nine coefficients"),
        ("irradianceCoefficients", json!(vec![[1, 2]; 9]), "/irradianceCoefficients/0"),
        ("specularImageSize", json!(3), "power of two"),
        ("specularImages", json!([]), "at least one level"),
        ("specularImages", json!([[0, 1]]), "must list six images"),
        ("specularImages", json!([[0, 1, 1, 1, 1, 2]]), "1x1 texels, not 2x2"),
        ("specularImages", json!([[0, 1, 1, 1, 1, 9]]), "no image 9"),
        ("rotation", json!([0, 0, 0, 0]), "length zero"),
        ("intensity", json!(-1), "/intensity"),
    ] {
        let mut document = lit();
        document["extensions"]["EXT_lights_image_based"]["lights"][0][key] = value;
        let text = error_text(import_bytes("a.gltf", document.to_string().as_bytes()), 65);
        assert!(
            text.contains(expected) && text.contains("/extensions/EXT_lights_image_based/lights/0"),
            "{text}"
        );
    }
    let mut document = lit();
    document["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = json!(1);
    let text = error_text(import_bytes("a.gltf", document.to_string().as_bytes()), 65);
    assert!(text.contains("/scenes/0/extensions/EXT_lights_image_based/light"), "{text}");
}
