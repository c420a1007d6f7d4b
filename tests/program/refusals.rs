//! Everything that can be known to fail fails before the first frame, with its own exit code: the table of the README.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::names;

/// A triangle with everything that a file may hold apart.
const TRIANGLE: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "URI"}]EXTENSIONS}"#;
/// Its corners: (0, 0, 0), (1, 0, 0), (0, 1, 0).
const CORNERS: &str = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";

/// What is typed behind `rayframe render`, the exit code, and a word of the message.
const REFUSALS: [(&[&str], i32, &str); 44] = [
    // Usage: what makes no sense by itself.
    (&["good.gltf", "--no-such-option"], 2, "--no-such-option"),
    (&["good.gltf", "-o", "new/a.jpg"], 2, "\".jpg\" cannot be written"),
    (&["good.gltf", "-o", "new/a"], 2, "no extension"),
    (&["good.gltf", "-o", "new/"], 2, "folder"),
    (&["good.gltf", "-o", "new/a.%s.exr"], 2, "%04d"),
    (&["good.gltf", "-f", "5-1"], 2, "backwards"),
    (&["good.gltf", "-f", "1-9x0"], 2, "step"),
    (&["good.gltf", "-f", "first"], 2, "1-10x2"),
    (&["good.gltf", "-f", ""], 2, "--frames"),
    (&["good.gltf", "-s", "9", "-e", "1"], 2, "--start"),
    (&["good.gltf", "-r", "0x9"], 2, "pixel"),
    (&["good.gltf", "-H", "0"], 2, "--height"),
    (&["good.gltf", "--scale", "0%"], 2, "scale"),
    (&["good.gltf", "--crop", "9,9,9,9"], 2, "crop"),
    (&["good.gltf", "-r", "8x6", "--crop", "4,4,9,6"], 2, "--crop"),
    (&["good.gltf", "--samples", "0"], 2, "--samples"),
    (&["good.gltf", "--layers", "depht"], 2, "depth"),
    (&["good.gltf", "--layers", "depth", "--exr", "dwaa"], 2, "precision"),
    // Usage: what makes no sense for this scene.
    (&["good.gltf", "--camera", "left"], 2, "left"),
    (&["good.gltf", "--animation", "walk"], 2, "walk"),
    (&["good.gltf", "--scene", "#7"], 2, "#7"),
    // Usage: two files of one name.
    (&["good.gltf", "-f", "1-2", "-o", "new/a.exr"], 2, "####"),
    (&["good.gltf", "-o", "new/a.exr", "--stats", "new/a.exr"], 2, "--stats"),
    (&["good.gltf", "-o", "new/a.exr", "--manifest", "new/../new/a.exr"], 2, "--manifest"),
    (&["good.gltf", "--manifest", "good.gltf"], 2, "--manifest"),
    (&["good.gltf", "--preview", "png", "--stats", "good.png"], 2, "--stats"),
    (
        &["good.gltf", "-o", "new/X.png", "--contact-sheet", "new/x.png"],
        2,
        "\"new/x.png\" differs in case only from \"new/X.png\"",
    ),
    (
        &["good.gltf", "--stats", "new/b.json", "--manifest", "New/B.json"],
        2,
        "which will hold something else",
    ),
    (&["good.gltf", "--preview", "png", "--contact-sheet", "Good.png"], 2, "which will hold a frame"),
    // Wrong input, and what is not supported.
    (&["broken.gltf"], 65, "broken.gltf: "),
    (&["required.gltf"], 65, "ACME_glow"),
    (&["used.gltf", "--strict"], 65, "ACME_glow"),
    (&["short.gltf"], 65, "/buffers/0"),
    (&["empty.glb"], 65, "empty.glb: "),
    // Missing input.
    (&["none.gltf"], 66, "none.gltf: "),
    (&["missing.gltf"], 66, "none.bin"),
    (&["good.gltf", "--env", "none.hdr"], 66, "none.hdr"),
    // Output that cannot be created.
    (&["good.gltf", "-o", "good.gltf/a.exr"], 73, "good.gltf"),
    (&["good.gltf", "-o", "taken.exr"], 73, "taken.exr"),
    (&["good.gltf", "-o", "foreign.exr"], 73, "--overwrite"),
    (&["good.gltf", "-o", "/proc/rayframe/a.exr"], 73, "/proc/rayframe"),
    (&["good.gltf", "--manifest", "taken.exr"], 73, "taken.exr"),
    // Limits.
    (&["good.gltf", "-r", "65536x65536", "--max-memory", "1G", "--preview", "png"], 77, "--max-memory"),
    (&["outside.gltf"], 77, "outside.gltf: "),
];

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn set_up(folder: &Path) {
    let scene = |name: &str, uri: &str, extensions: &str| {
        let text = TRIANGLE.replace("URI", uri).replace("EXTENSIONS", extensions);
        std::fs::write(folder.join(name), text).unwrap();
    };
    scene("good.gltf", CORNERS, "");
    scene("used.gltf", CORNERS, r#", "extensionsUsed": ["ACME_glow"]"#);
    let required = r#", "extensionsUsed": ["ACME_glow"], "extensionsRequired": ["ACME_glow"]"#;
    scene("required.gltf", CORNERS, required);
    scene("short.gltf", "data:application/octet-stream;base64,AAAA", "");
    scene("missing.gltf", "none.bin", "");
    scene("outside.gltf", "../none.bin", "");
    std::fs::write(folder.join("broken.gltf"), "{").unwrap();
    std::fs::write(folder.join("empty.glb"), "").unwrap();
    std::fs::write(folder.join("foreign.exr"), "another program's image").unwrap();
    std::fs::create_dir(folder.join("taken.exr")).unwrap();
}

#[test]
fn what_can_be_known_to_fail_fails_before_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("stage");
    std::fs::create_dir(&folder).unwrap();
    set_up(&folder);
    let before = names(&folder);
    for (arguments, code, word) in REFUSALS {
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .current_dir(&folder)
            .args(["render", "--progress", "json"])
            .args(arguments)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        let errors: Vec<_> = said.lines().filter(|line| line.starts_with("rayframe: error: ")).collect();
        assert_eq!(errors.len(), 1, "{arguments:?}: {said}");
        assert!(errors[0].contains(word), "{arguments:?}: \"{word}\" is not in: {said}");
        // The failure is the only event, so no frame was begun; and nothing was left.
        let told = String::from_utf8_lossy(&output.stdout);
        let events: Vec<Value> = told.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let is_failure = |event: &Value| event["event"] == "scene_failed" && event["code"] == code;
        assert!(events.len() <= 1 && events.iter().all(is_failure), "{arguments:?}: {told}");
        // Options that no scene could have are told before any scene.
        let may_be_of_options = code == 2 && !["left", "walk", "#7"].contains(&word);
        assert!(!events.is_empty() || may_be_of_options, "{arguments:?}");
        assert_eq!(names(&folder), before, "{arguments:?}");
    }
}
