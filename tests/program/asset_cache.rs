//! `--asset-cache`: frames are those without it, whatever the folder holds.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::{both, names, rayframe, stderr};

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A triangle with a texture of 512x256 texels, which this program renders.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn scene(folder: &Path) -> PathBuf {
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");
    let image = folder.join("image.png");
    let made =
        rayframe(&["render", demo, "-f", "0", "-r", "512x256", "--samples", "1", "-q", "-o", text(&image)]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    // Positions and texture coordinates of one triangle.
    let floats = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 3.0, 3.0, 3.0, 1.5, 0.0_f32];
    let bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    fs::write(folder.join("triangle.bin"), bytes).unwrap();
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "buffers": [{"uri": "triangle.bin", "byteLength": 60}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3, "min": [-1, -1, 0], "max": [1, 1, 0]},
                      {"bufferView": 1, "componentType": 5126, "type": "VEC2", "count": 3}],
        "images": [{"uri": "image.png"}], "textures": [{"source": 0}],
        "materials": [{"doubleSided": true, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 0}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}]}"#;
    let path = folder.join("scene.gltf");
    fs::write(&path, gltf).unwrap();
    path
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(scene: &Path, more: &[&str]) -> (Output, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let given = ["render", text(scene), "-r", "48x32", "--samples", "1", "-q", "-o", text(&path)];
    let output = rayframe(&both(&given, more));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    (output, fs::read(path).unwrap())
}

#[test]
fn frames_are_the_same_without_and_with_a_new_a_full_and_a_damaged_cache() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let cache = folder.path().join("new/cache");
    let with_cache = ["--asset-cache", text(&cache)];
    let (_, expected) = render(&scene, &[]);
    // A dry run and refused settings create nothing.
    let dry = rayframe(&both(&["render", text(&scene), "-n", "-q"], &with_cache));
    assert_eq!(dry.status.code(), Some(0), "{}", stderr(&dry));
    assert_eq!(names(&cache), [] as [&str; 0]);
    // Texels, colour levels and normal levels.
    for _ in 0..2 {
        let (output, bytes) = render(&scene, &with_cache);
        assert!(bytes == expected);
        assert_eq!(stderr(&output), "");
        assert_eq!(names(&cache).len(), 3);
    }
    // Of the last run: statistics and -v say what was found.
    let [stats, frame] = ["stats.json", "b.exr"].map(|name| folder.path().join(name));
    let args = ["render", text(&scene), "-r", "8x8", "-v", "-o", text(&frame), "--stats", text(&stats)];
    let output = rayframe(&both(&args, &with_cache));
    assert!(stderr(&output).contains("asset cache: 3 hits, 0 misses"), "{}", stderr(&output));
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(stats).unwrap()).unwrap();
    assert_eq!(stats["asset_cache"], serde_json::json!({"hits": 3, "misses": 0}));
    // An entry is read: with false texels and true checksums the image would differ, so each one is damaged in turn.
    for name in names(&cache) {
        let path = cache.join(&name);
        let whole = fs::read(&path).unwrap();
        let mut damaged = whole.clone();
        damaged[whole.len() / 2] ^= 0x40;
        for content in [&damaged[..], &whole[..whole.len() / 2], b"of somebody else"] {
            fs::write(&path, content).unwrap();
            assert!(render(&scene, &with_cache).1 == expected, "{name}");
            assert!(fs::read(&path).unwrap() == whole, "{name} is written anew");
        }
    }
}

#[test]
fn a_cache_that_cannot_be_written_is_one_warning() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let file = folder.path().join("file");
    fs::write(&file, "of somebody else").unwrap();
    let (_, expected) = render(&scene, &[]);
    let (output, bytes) = render(&scene, &["--asset-cache", text(&file), "--strict"]);
    assert!(bytes == expected);
    let told = stderr(&output);
    assert_eq!(told.matches("asset cache").count(), 1, "{told}");
    assert_eq!(fs::read(&file).unwrap(), b"of somebody else");
}

#[test]
fn shot_files_keep_a_cache_in_their_folder_unless_permitted() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let shots = folder.path().join("shots");
    fs::create_dir(&shots).unwrap();
    let shot = shots.join("a.toml");
    let settings =
        "scene = \"../scene.gltf\"\noutput = \"a.exr\"\nresolution = \"8x8\"\nasset_cache = \"../cache\"\n";
    fs::write(&shot, settings).unwrap();
    assert!(scene.is_file());
    let refused = rayframe(&["render", text(&shot), "-q"]);
    assert_eq!(refused.status.code(), Some(77), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("asset_cache"), "{}", stderr(&refused));
    let permitted = rayframe(&["render", text(&shot), "-q", "--allow-dir", text(folder.path())]);
    assert_eq!(permitted.status.code(), Some(0), "{}", stderr(&permitted));
    assert_eq!(names(&folder.path().join("cache")).len(), 3);
}
