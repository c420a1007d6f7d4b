//! The suite `scenes/` as code: text glTF scenes that show one thing each, shot files for those that need settings, and an
//! environment image.
//!
//! `cargo run -p make_scenes` writes the files; `cargo run -p make_scenes -- --check` only compares. Every run gives the same
//! bytes on every machine: all arithmetic is IEEE or `libm`.

#![expect(clippy::unnecessary_wraps, reason = "all scenes share one signature; those with images can fail")]

mod animation;
mod bvh;
mod camera;
pub mod color_chart;
pub mod color_difference;
mod demo;
mod demo_bodies;
mod environment;
mod geometry;
mod geometry_storage;
mod glass;
mod image_light;
mod light;
mod material;
mod material_extensions;
mod morph;
mod path;
mod properties;
mod scene;
mod showcase;
mod skin;
mod storage;
mod texture;
mod texture_detail;
mod texture_maps;

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

use scene_builder::document::Built;

/// The suite file: settings of all shots, and the folder of the references.
const SUITE: &str = r#"# The pictures of all scenes: `rayframe test --suite scenes --allow-dir .` renders them and compares.
scenes = "."
references = "../reference_images"
report = "../target/regression"
cache = "../target/regression-cache"
max_reference_kib = 256

[test]
preset = "exact"

[shot]
resolution = [160, 90]
samples = 4
frames = 0
aovs = ["object_id", "material_id"]   # few bytes that tell what moved from what is lit otherwise
strict = true
"#;

/// A scene: its path below `scenes/` without the extension, and the function that builds it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    path: &'static str,
    build: fn() -> Built,
}

pub(crate) const fn entry(path: &'static str, build: fn() -> Built) -> Entry {
    Entry { path, build }
}

/// All files of the suite: path below `scenes/` and content.
pub fn all_scenes() -> Result<BTreeMap<PathBuf, Vec<u8>>, Box<dyn Error>> {
    let areas: [&[Entry]; 22] = [
        &light::SCENES,
        &image_light::SCENES,
        &material::SCENES,
        &glass::SCENES,
        &material_extensions::SCENES,
        &texture::SCENES,
        &texture_maps::SCENES,
        &texture_detail::SCENES,
        &environment::SCENES,
        &animation::SCENES,
        &skin::SCENES,
        &morph::SCENES,
        &geometry::SCENES,
        &geometry_storage::SCENES,
        &camera::SCENES,
        &bvh::SCENES,
        &scene::SCENES,
        &properties::SCENES,
        &storage::SCENES,
        &path::SCENES,
        &demo::SCENES,
        &showcase::SCENES,
    ];
    let mut files = BTreeMap::new();
    for entry in areas.concat() {
        let gltf = (entry.build)().map_err(|error| format!("{}: {error}", entry.path))?;
        let scene = PathBuf::from(format!("{}.gltf", entry.path));
        let name = scene.file_name().unwrap_or_default().to_string_lossy();
        if let Some(shot) = gltf.to_shot_text(&name) {
            files.insert(scene.with_extension("toml"), shot.into_bytes());
        }
        files.insert(scene, gltf.to_file_text().into_bytes());
    }
    files.insert(PathBuf::from("suite.toml"), SUITE.into());
    files.insert(PathBuf::from(environment::IMAGE_PATH), environment::image());
    Ok(files)
}

/// Compares the files below `folder` with `scenes`: one line for each that is missing, different or unknown.
pub fn differences(
    folder: &Path,
    scenes: &BTreeMap<PathBuf, Vec<u8>>,
) -> Result<Vec<String>, Box<dyn Error>> {
    let mut lines = Vec::new();
    for (path, content) in scenes {
        match std::fs::read(folder.join(path)) {
            Ok(bytes) if bytes == *content => {}
            Ok(_) => lines.push(format!("{}: is not what make_scenes writes", path.display())),
            Err(error) => lines.push(format!("{}: {error}", path.display())),
        }
    }
    for path in files_below(folder)? {
        let known = path.strip_prefix(folder).is_ok_and(|path| scenes.contains_key(path));
        if !known {
            lines.push(format!("{}: make_scenes does not write this file", path.display()));
        }
    }
    Ok(lines)
}

fn files_below(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(files_below(&path)?);
        } else {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
