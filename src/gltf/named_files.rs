//! The files that a scene file names, found without an import.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::container;
use super::context::Context;
use super::options::ImportOptions;
use super::uri::{self, Uri};

/// Properties whose objects may have a `uri`.
const PROPERTIES: [&str; 2] = ["buffers", "images"];

/// The files of buffers and images that the scene at `path` names, whether they are there or not. Empty where the scene itself cannot be read.
///
/// Unlike an import, this needs none of the files to be whole: a program can watch them until a broken one is repaired.
pub fn named_files(path: &Path) -> Vec<PathBuf> {
    let mut context = Context::new(path, ImportOptions::default().max_memory_bytes);
    let Ok(file) = container::read(&mut context) else { return Vec::new() };
    let Ok(root) = serde_json::from_slice::<Value>(file.json()) else { return Vec::new() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let objects = PROPERTIES.iter().filter_map(|&property| root.get(property)?.as_array()).flatten();
    let uris = objects.filter_map(|object| object.get("uri")?.as_str()).filter(|uri| !uri::is_data(uri));
    uris.filter_map(|uri| match uri::parse(uri) {
        Ok(Uri::Relative(file)) => Some(folder.join(file)),
        _ => None,
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_once_the_scene_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("a.gltf");
        let text = r#"{"buffers": [{"uri": "a%20b.bin", "byteLength": 4}, {"byteLength": 1}, {"uri": 3}],
            "images": [{"uri": "data:image/png;base64,AAAA"}, {"uri": "maps/c.png"}, {"uri": "https://example.org/d.png"}]}"#;
        std::fs::write(&scene, text).unwrap();
        assert_eq!(named_files(&scene), ["a b.bin", "maps/c.png"].map(|name| folder.path().join(name)));
        std::fs::write(&scene, &text[..text.len() - 1]).unwrap();
        assert!(named_files(&scene).is_empty());
        assert!(named_files(&folder.path().join("b.gltf")).is_empty());
    }
}
