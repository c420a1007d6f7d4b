//! The suite in `scenes/` is what `make_scenes` writes, byte for byte, and holds no other file.

use std::path::Path;

use rayframe::regression::{Image, are_identical};

#[test]
fn every_file_is_reproduced() {
    let scenes = make_scenes::all_scenes().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let lines = make_scenes::differences(&folder, &scenes).unwrap();
    assert!(lines.is_empty(), "{}\nrun `cargo run -p make_scenes`", lines.join("\n"));
}

#[test]
fn changed_missing_and_unknown_files_are_listed() {
    let scenes = [("a.gltf", "{}\n"), ("b.gltf", "{}\n")];
    let scenes = scenes.map(|(path, text)| (path.into(), text.as_bytes().to_owned())).into();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.gltf"), "{ }\n").unwrap();
    std::fs::write(folder.path().join("c.gltf"), "{}\n").unwrap();
    let lines = make_scenes::differences(folder.path(), &scenes).unwrap();
    assert_eq!(lines.len(), 3, "{lines:?}");
    assert!(lines[0].starts_with("a.gltf: is not"), "{lines:?}");
    assert!(lines[1].starts_with("b.gltf: "), "{lines:?}");
    assert!(lines[2].contains("c.gltf: make_scenes does not write"), "{lines:?}");
}

#[test]
fn scenes_are_small() {
    // Small scenes are readable in a review. The demo has dense spheres, the showcase furniture.
    for (path, content) in make_scenes::all_scenes().unwrap() {
        let limit = match path.iter().next().and_then(|folder| folder.to_str()) {
            Some("demo") => 1_500_000,
            Some("showcase") => 450_000,
            _ => 60_000,
        };
        assert!(content.len() < limit, "{}: {} bytes", path.display(), content.len());
    }
}

/// Lossless packing of geometry and images gives the image of the plain file to the last bit.
#[test]
fn packed_scenes_match_the_plain_one() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference_images/storage");
    let image = |name: &str| Image::read(&folder.join(format!("{name}.exr"))).unwrap();
    let plain = image("plain");
    for name in ["meshopt_ext", "meshopt_khr", "draco", "webp", "basis_uastc", "basis_etc1s"] {
        assert!(are_identical(&image(name), &plain), "{name}");
    }
}
