//! The scenes in `scenes/` are what `examples/make_scenes` writes, byte for byte, and nothing else lies there.

#[path = "../examples/make_scenes/main.rs"]
mod make_scenes;

use std::path::Path;

#[test]
fn every_file_is_reproduced() {
    let scenes = make_scenes::all_scenes().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let lines = make_scenes::differences(&folder, &scenes).unwrap();
    assert!(lines.is_empty(), "{}\nrun `cargo run --release --example make_scenes`", lines.join("\n"));
}

#[test]
fn changed_missing_and_unknown_files_are_told() {
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
    // One-thing scenes stay readable in a review; the demo has dense spheres.
    for (path, content) in make_scenes::all_scenes().unwrap() {
        let limit = if path.starts_with("demo") { 1_500_000 } else { 60_000 };
        assert!(content.len() < limit, "{}: {} bytes", path.display(), content.len());
    }
}
