//! Decoders of compressed geometry and of textures, inside a scene that refers to the input.
//!
//! The scenes are those of `scenes/storage`, whose stream or image is replaced.

use std::path::Path;
use std::sync::OnceLock;

use rayframe::gltf::import;
use rayframe::image_file::{decode_png_values, read_plate};
use serde_json::{Value, json};

use super::scene_files::OPTIONS;
use crate::input::Input;
use crate::scratch;
use crate::verdict::{LIBRARY_LIMIT, accepted, must};

/// Name of the file that holds the input.
const DATA: &str = "data.bin";

/// A scene of the suite, parsed once.
macro_rules! scene {
    ($name:literal) => {{
        static SCENE: OnceLock<Value> = OnceLock::new();
        SCENE.get_or_init(|| {
            must(serde_json::from_str(include_str!(concat!("../../../../scenes/storage/", $name, ".gltf"))))
        })
    }};
}

/// Adds the input as a buffer; returns its index.
fn add_buffer(scene: &mut Value, bytes: &[u8]) -> usize {
    scratch::file(DATA, bytes);
    let buffers = scene["buffers"].as_array_mut();
    buffers.map_or(0, |buffers| {
        buffers.push(json!({ "byteLength": bytes.len(), "uri": DATA }));
        buffers.len() - 1
    })
}

fn import_scene(scene: &Value) {
    accepted(import(&scratch::file("scene.gltf", scene.to_string().as_bytes()), &OPTIONS));
}

/// A Draco stream, as the geometry of the ring.
pub(crate) fn draco(input: &[u8]) {
    let mut scene = scene!("draco").clone();
    let buffer = add_buffer(&mut scene, input);
    scene["bufferViews"][4] = json!({ "buffer": buffer, "byteLength": input.len() });
    import_scene(&scene);
}

/// A meshopt stream with its codec, filter, count and stride.
pub(crate) fn meshopt(input: &[u8]) {
    let mut input = Input::new(input);
    let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(input.u8() % 3)];
    let filter = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"][usize::from(input.u8() % 5)];
    let (count, stride) = (input.u16(), input.u8());
    let stream = input.rest();
    let mut scene = scene!("meshopt_khr").clone();
    let buffer = add_buffer(&mut scene, stream);
    scene["bufferViews"][4] = json!({
        "buffer": 1,
        "byteLength": u32::from(count) * u32::from(stride),
        "extensions": { "KHR_meshopt_compression": {
            "buffer": buffer, "byteLength": stream.len(), "byteStride": stride, "count": count, "mode": mode, "filter": filter,
        } },
    });
    // The fallback may have any length.
    scene["buffers"][1]["byteLength"] = json!(1 << 24);
    import_scene(&scene);
}

fn texture(scene: &Value, image: usize, input: &[u8]) {
    let mut scene = scene.clone();
    let buffer = add_buffer(&mut scene, input);
    let view = scene["bufferViews"].as_array_mut().map_or(0, |views| {
        views.push(json!({ "buffer": buffer, "byteLength": input.len() }));
        views.len() - 1
    });
    scene["images"][image]["bufferView"] = json!(view);
    // Geometry takes longer than a small image. Materials and their textures are imported without it.
    if let Some(members) = scene.as_object_mut() {
        members.retain(|name, _| !["scene", "scenes", "nodes", "meshes", "cameras"].contains(&name.as_str()));
    }
    import_scene(&scene);
}

/// A PNG as a texture, as an image to compare, and as a plate.
pub(crate) fn png(input: &[u8]) {
    texture(scene!("plain"), 0, input);
    accepted(decode_png_values(Path::new("a.png"), input, LIBRARY_LIMIT));
    plate(input);
}

/// A JPEG as a texture and as a plate.
pub(crate) fn jpeg(input: &[u8]) {
    texture(scene!("plain"), 0, input);
    plate(input);
}

/// A WebP as a texture and as a plate.
pub(crate) fn webp(input: &[u8]) {
    texture(scene!("webp"), 1, input);
    plate(input);
}

/// A KTX2 file with Basis Universal data as a texture.
pub(crate) fn ktx2(input: &[u8]) {
    texture(scene!("basis_uastc"), 1, input);
}

fn plate(input: &[u8]) {
    accepted(read_plate(Path::new("plate"), input, LIBRARY_LIMIT));
}
