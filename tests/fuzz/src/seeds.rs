//! The inputs that a run starts from: scenes of the suite, and files that rayframe and its encoders write.

mod files;
mod texts;

use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::mutation::{SETTING_WORDS, WORDS, joined_scene};
use crate::targets::scene_files::SEPARATOR;
use crate::verdict::must;

pub(crate) use files::{archives, exrs, hdrs, image_pairs, jpegs, ktx2s, pngs, tiles, webps};
pub(crate) use texts::{
    approvals, camera_paths, definitions, manifests, patterns, rendered, shards, shots, suites,
};

/// Largest scene that is a seed, bytes: small inputs run fast.
const MAX_SCENE: usize = 24_000;
/// Random inputs of targets whose bytes are numbers.
const RANDOM_SEEDS: u64 = 24;

/// One input with its file name.
#[derive(Clone, Debug)]
pub struct Seed {
    /// Its file name.
    pub name: String,
    /// The input.
    pub bytes: Vec<u8>,
}

pub(crate) fn seed(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Seed {
    Seed { name: name.into(), bytes: bytes.into() }
}

/// Words of all formats, as a dictionary of libFuzzer.
pub fn dictionary() -> String {
    let settings = rayframe::settings::DEFINITIONS.iter().map(|definition| definition.name);
    let words = settings.chain(WORDS).chain(SETTING_WORDS);
    words.map(|word| ["\"", word, "\"\n"].concat()).collect()
}

/// The small scenes of the suite, by name.
fn scenes() -> Vec<(String, Vec<u8>)> {
    let mut scenes = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")];
    while let Some(folder) = folders.pop() {
        let mut paths: Vec<PathBuf> =
            must(std::fs::read_dir(&folder)).map(|entry| must(entry).path()).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "gltf") {
                let bytes = must(std::fs::read(&path));
                let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                if bytes.len() <= MAX_SCENE {
                    scenes.push((format!("{}_{}", stem(&folder), stem(&path)), bytes));
                }
            }
        }
    }
    scenes
}

/// Scenes as text, and some with their first buffer in a file.
pub(crate) fn scenes_with_resources() -> Vec<Seed> {
    let mut seeds = Vec::new();
    for (name, text) in scenes() {
        let (document, buffer) = without_buffer(&text, Some("a.bin"));
        seeds.push(seed(format!("{name}_file"), [document.as_slice(), SEPARATOR, &buffer].concat()));
        seeds.push(seed(name, text));
    }
    seeds
}

/// Scenes as binary files.
pub(crate) fn binary_scenes() -> Vec<Seed> {
    let binary = |(name, text): (String, Vec<u8>)| {
        let (document, buffer) = without_buffer(&text, None);
        seed(name, joined_scene(&document, &buffer))
    };
    scenes().into_iter().map(binary).collect()
}

/// Scenes behind options: none, each alone with some scene, and a few of any.
pub(crate) fn renders() -> Vec<Seed> {
    let mut seeds = Vec::new();
    for (index, (name, text)) in scenes().into_iter().enumerate() {
        for (kind, options) in
            [("plain", 0), ("path", 1), ("one", 1 << (index % 24)), ("few", 0x0010_4210 << (index % 5))]
        {
            let options: u32 = options;
            seeds.push(seed(format!("{name}_{kind}"), [&options.to_le_bytes(), text.as_slice()].concat()));
        }
    }
    seeds
}

/// The document with its first buffer in the file `uri` or in the binary chunk, and the bytes of the buffer.
fn without_buffer(text: &[u8], uri: Option<&str>) -> (Vec<u8>, Vec<u8>) {
    let mut document: Value = must(serde_json::from_slice(text));
    let buffer = &mut document["buffers"][0];
    let data = buffer["uri"].as_str().and_then(|uri| uri.split_once(";base64,"));
    let bytes = data.map(|(_, data)| must(STANDARD.decode(data))).unwrap_or_default();
    match (uri, buffer.as_object_mut()) {
        (Some(uri), _) => buffer["uri"] = uri.into(),
        (None, Some(buffer)) => drop(buffer.remove("uri")),
        (None, None) => {}
    }
    (must(serde_json::to_vec(&document)), bytes)
}

fn storage_scene(text: &str) -> (Value, Vec<u8>) {
    let (document, buffer) = without_buffer(text.as_bytes(), None);
    (must(serde_json::from_slice(&document)), buffer)
}

/// The bytes of an object with an offset and a length.
fn slice<'a>(object: &Value, buffer: &'a [u8]) -> &'a [u8] {
    let number = |key: &str| object[key].as_u64().unwrap_or_default() as usize;
    buffer.get(number("byteOffset")..).and_then(|rest| rest.get(..number("byteLength"))).unwrap_or_default()
}

/// The stream of the ring.
pub(crate) fn draco() -> Vec<Seed> {
    let (document, buffer) = storage_scene(include_str!("../../../scenes/storage/draco.gltf"));
    vec![seed("ring", slice(&document["bufferViews"][4], &buffer))]
}

/// The streams of the ring with each filter.
pub(crate) fn meshopt() -> Vec<Seed> {
    let texts = [
        ("khr", include_str!("../../../scenes/storage/meshopt_khr.gltf"), "KHR_meshopt_compression"),
        ("ext", include_str!("../../../scenes/storage/meshopt_ext.gltf"), "EXT_meshopt_compression"),
    ];
    let mut seeds = Vec::new();
    for (version, text, extension) in texts {
        let (document, buffer) = storage_scene(text);
        for view in 4..8 {
            let object = &document["bufferViews"][view]["extensions"][extension];
            let mode = u8::from(object["mode"] == "TRIANGLES");
            let number = |key: &str| object[key].as_u64().unwrap_or_default();
            for filter in 0..5 {
                let mut bytes = vec![mode, filter];
                bytes.extend((number("count") as u16).to_le_bytes());
                bytes.push(number("byteStride") as u8);
                bytes.extend(slice(object, &buffer));
                seeds.push(seed(format!("{version}_{view}_{filter}"), bytes));
            }
        }
    }
    seeds
}

/// Random numbers.
pub(crate) fn triangles() -> Vec<Seed> {
    let mut seeds = Vec::new();
    for number in 0..RANDOM_SEEDS {
        let mut random = crate::mutation::Random::new(number);
        let length = 64 << (number % 6);
        let bytes: Vec<u8> = (0..length).map(|_| random.bits() as u8).collect();
        seeds.push(seed(format!("random_{number}"), bytes));
    }
    seeds
}
