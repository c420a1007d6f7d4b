//! Scenes that are tested alone, with all memory and threads: two large ones are never held at a time.

use std::path::Path;

use crate::gltf::named_files;

/// Scenes of more bytes are large.
const LARGE_SCENE_BYTES: u64 = 64 << 20;

/// Whether the scene file alone is large. Reads nothing.
pub(super) fn is_large_file(scene: &Path) -> bool {
    length(scene) > LARGE_SCENE_BYTES
}

/// Whether the scene file is large with the buffers and images that it names.
pub(super) fn is_large(scene: &Path) -> bool {
    if is_large_file(scene) {
        return true;
    }
    let mut files = named_files(scene);
    files.sort();
    files.dedup();
    let bytes = files.iter().map(|file| length(file)).fold(length(scene), u64::saturating_add);
    bytes > LARGE_SCENE_BYTES
}

fn length(file: &Path) -> u64 {
    std::fs::metadata(file).map_or(0, |metadata| metadata.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_a_scene_names_count_once() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("a.gltf");
        let text = r#"{"buffers": [{"uri": "a.bin", "byteLength": 4}, {"uri": "a.bin", "byteLength": 8}],
            "images": [{"uri": "b.png"}]}"#;
        std::fs::write(&scene, text).unwrap();
        let resize = |name: &str, bytes: u64| {
            std::fs::File::create(folder.path().join(name)).unwrap().set_len(bytes).unwrap();
        };
        assert!(!is_large(&scene));
        resize("a.bin", LARGE_SCENE_BYTES / 2 + 1);
        assert!(!is_large(&scene));
        resize("b.png", LARGE_SCENE_BYTES / 2);
        assert!(is_large(&scene) && !is_large_file(&scene));
        resize("a.gltf", LARGE_SCENE_BYTES + 1);
        assert!(is_large_file(&scene));
    }
}
