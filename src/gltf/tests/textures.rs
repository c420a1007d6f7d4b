//! Samplers, mip maps of each encoding, and their memory.

use base64::Engine;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};

use super::{error_text, import_bytes};
use crate::asset_cache::{AssetCache, ImageShape};
use crate::error::Result;
use crate::gltf::{ImageLoading, ImportOptions, import, import_with_cache};
use crate::scene::{Encoding, Filter, Image, MipFilter, Scene, Texels, mip_levels};

/// PNG of noise with constant alpha.
fn png(side: u32, alpha: u8, seed: u32) -> String {
    let noise = |index: u32| (index ^ seed).wrapping_mul(2_654_435_761).to_le_bytes();
    let texels: Vec<u8> = (0..side * side)
        .flat_map(|index| [noise(index)[1], noise(index)[2], noise(index)[3], alpha])
        .collect();
    let mut file = Vec::new();
    image::codecs::png::PngEncoder::new(&mut file)
        .write_image(&texels, side, side, ExtendedColorType::Rgba8)
        .unwrap();
    format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(&file))
}

fn import_json(document: &Value) -> Result<Scene> {
    import_bytes("a.gltf", document.to_string().as_bytes())
}

#[test]
fn sampler_filters_are_imported() {
    for (minify, expected) in [
        (None, (Filter::Linear, MipFilter::Linear)),
        (Some(9728), (Filter::Nearest, MipFilter::None)),
        (Some(9729), (Filter::Linear, MipFilter::None)),
        (Some(9984), (Filter::Nearest, MipFilter::Nearest)),
        (Some(9985), (Filter::Linear, MipFilter::Nearest)),
        (Some(9986), (Filter::Nearest, MipFilter::Linear)),
        (Some(9987), (Filter::Linear, MipFilter::Linear)),
    ] {
        let sampler = minify.map_or(json!({}), |minify| json!({"minFilter": minify}));
        let mut document = json!({
            "asset": {"version": "2.0"},
            "images": [{"uri": png(4, 255, 0)}],
            "samplers": [sampler],
            "textures": [{"source": 0, "sampler": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        });
        let scene = import_json(&document).unwrap();
        let sampler = scene.textures[0].sampler;
        assert_eq!((sampler.minify, sampler.mip), expected, "{minify:?}");
        // Only filters that use mip maps cause them to be computed.
        let levels = scene.mips[0].levels(Encoding::Srgb).len();
        assert_eq!(levels, if sampler.mip == MipFilter::None { 0 } else { 2 });
        if minify.is_none() {
            document["textures"][0].as_object_mut().unwrap().remove("sampler");
            assert_eq!(import_json(&document).unwrap().textures[0].sampler, sampler);
        }
        // Emitters are measured in them, too.
        document["materials"] = json!([{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}]);
        assert_eq!(import_json(&document).unwrap().mips[0].levels(Encoding::Srgb).len(), 2);
    }
}

#[test]
fn images_have_mip_maps_for_each_encoding() {
    let document = json!({
        "asset": {"version": "2.0"},
        "images": [{"uri": png(8, 255, 0)}, {"uri": png(8, 99, 0)}],
        "textures": [{"source": 0}, {"source": 1}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1}},
            {"occlusionTexture": {"index": 0}},
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}, "alphaMode": "BLEND"}
        ]
    });
    let scene = import_json(&document).unwrap();
    // Images are in the order in which materials refer to them.
    let opaque = scene
        .images
        .iter()
        .position(|image| matches!(&image.texels, Texels::Rgba8(texels) if texels[0][3] == 255));
    let order = if opaque == Some(0) { [0, 1] } else { [1, 0] };
    let levels = |image: usize, encoding| scene.mips[order[image]].levels(encoding);
    let has = |image, encoding| !levels(image, encoding).is_empty();
    assert!(has(0, Encoding::Srgb) && has(0, Encoding::Linear) && !has(0, Encoding::Normal));
    assert!(has(1, Encoding::Srgb) && has(1, Encoding::Normal) && !has(1, Encoding::Linear));
    // An opaque image needs no separate mip maps for coverage.
    assert!(std::ptr::eq(levels(0, Encoding::Srgb), levels(0, Encoding::CoveredSrgb)));
    assert!(!std::ptr::eq(levels(1, Encoding::Srgb), levels(1, Encoding::CoveredSrgb)));
}

#[test]
fn twenty_images_stay_within_the_memory_limit_or_are_refused_by_name() {
    // 4096 texels per side, scaled down by 64 in both directions.
    let images: Vec<Value> =
        (0..20).map(|index| json!({"name": format!("wall {index}"), "uri": png(64, 255, index)})).collect();
    let textures: Vec<Value> = (0..20).map(|source| json!({"source": source})).collect();
    let materials: Vec<Value> = (0..20)
        .map(|index| json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": index}}))
        .collect();
    let document = json!({
        "asset": {"version": "2.0"}, "images": images, "textures": textures, "materials": materials
    });
    let text = document.to_string();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walls.gltf");
    std::fs::write(&path, &text).unwrap();
    // Each thread decodes an image beside the others.
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let with_limit = |max_memory_bytes| {
        let options = ImportOptions { max_memory_bytes, ..ImportOptions::default() };
        one_thread.install(|| import(&path, &options))
    };

    // Lower bound: the file as text, as JSON and as encoded images, all texels, and a third more for mip maps.
    let texels = 20 * 64 * 64 * 4_u64;
    let (mut refused, mut enough) = (texels, 1 << 30);
    while enough - refused > 1 {
        let middle = u64::midpoint(refused, enough);
        if with_limit(middle).is_ok() { enough = middle } else { refused = middle }
    }
    let least = texels * 4 / 3 + text.len() as u64;
    assert!((least..least * 4).contains(&enough), "{enough} for {least}");
    // 64² · 4 bytes and 1365 texels of mip maps each, and temporarily four floats per texel of one image.
    let total = "20 images need 458.7 kB with mip maps";
    let largest = "the largest is /images/0 \"wall 0\" with 21.8 kB (64x64 texels)";
    for limit in [enough - 1, enough - texels / 2] {
        let told = error_text(with_limit(limit), 77);
        for word in [total, largest, "more than the limit of", "raise `max_memory`"] {
            assert!(told.contains(word), "{told}");
        }
    }
    // Headers only: nothing is counted.
    let headers = import(
        &path,
        &ImportOptions {
            max_memory_bytes: enough - texels,
            images: ImageLoading::Headers,
            ..ImportOptions::default()
        },
    )
    .unwrap();
    assert_eq!((headers.images.len(), headers.images[7].width), (20, 64));
    assert_eq!(headers.content_hash, with_limit(enough).unwrap().content_hash);
}

#[test]
fn images_of_more_texels_along_a_side_than_the_limit_are_refused() {
    let texels = vec![255; 70_000];
    for (width, height) in [(70_000, 1), (1, 70_000)] {
        let mut file = Vec::new();
        image::codecs::png::PngEncoder::new(&mut file)
            .write_image(&texels, width, height, ExtendedColorType::L8)
            .unwrap();
        let uri =
            format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(&file));
        let document = json!({
            "asset": {"version": "2.0"},
            "images": [{"uri": uri, "name": "strip"}], "textures": [{"source": 0}],
            "materials": [{"normalTexture": {"index": 0}}]
        });
        let told = error_text(import_json(&document), 77);
        let size = format!(
            "/images/0: the image \"strip\" has {width}x{height} texels, more than the limit of 65536"
        );
        assert!(told.contains(&size), "{told}");
    }
}

#[test]
fn images_and_mip_levels_of_the_cache_are_not_decoded() {
    // False texels and levels with true checksums under the true keys.
    let folder = tempfile::tempdir().unwrap();
    let png = png(256, 255, 1);
    let document = json!({
        "asset": {"version": "2.0"},
        "images": [{"uri": png.clone()}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    });
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    let encoded = png.trim_start_matches("data:image/png;base64,");
    let encoded = base64::engine::general_purpose::STANDARD.decode(encoded).unwrap();

    let cache = AssetCache::open(&folder.path().join("cache"), 1 << 30);
    let shape = ImageShape { width: 256, height: 256, is_deep: false };
    let key = shape.key_of(&encoded).unwrap();
    let mut image =
        Image { name: None, width: 256, height: 256, texels: Texels::Rgba8(vec![[7; 4]; 1 << 16]) };
    cache.store_texels(key, shape, &image.texels);
    let texels = image.texels.clone();
    image.texels = Texels::Rgba8(vec![[90; 4]; 1 << 16]);
    let levels = mip_levels(&image, Encoding::Srgb);
    cache.store_mip_levels(key, shape, (Encoding::Srgb, &levels));

    let scene = import_with_cache(&path, &ImportOptions::default(), Some(&cache)).unwrap();
    assert_eq!(scene.images[0].texels, texels);
    assert_eq!(scene.mips[0].levels(Encoding::Srgb), levels);
    let decoded = import(&path, &ImportOptions::default()).unwrap();
    assert!(decoded.images[0].texels != texels && decoded.mips[0].levels(Encoding::Srgb) != levels);
}
