//! Files that are too large. They are sparse, so that only their lengths are.

use std::fs::OpenOptions;

use super::stage::Stage;
use super::triangle::{INDICES, POSITIONS, buffer, document, glb};

/// Makes a file in `scene/` longer by a hole.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn lengthen(stage: &Stage, name: &str, bytes: u64) {
    let path = stage.folder.path().join("scene").join(name);
    OpenOptions::new().write(true).open(path).unwrap().set_len(bytes).unwrap();
}

#[test]
fn scene_files_beyond_32_bits_are_invalid() {
    // No memory limit lets a GLB have a longer length than it can state.
    for (name, content) in [("a.glb", glb(&document(None))), ("a.gltf", document(None).to_string().into())] {
        let stage = Stage::new(name, content);
        lengthen(&stage, name, 5_000_000_000);
        let words = ["a.gl", "5.0 GB", "at most 4.3 GB", ".bin"];
        stage.assert_fails(name, (65, &words));
        assert!(!stage.render(name, &["-o", "a.exr"]).stderr.contains("--max-memory"));
    }
}

#[test]
fn scene_files_beyond_the_memory_limit_are_refused_with_need_and_limit() {
    let stage = Stage::new("a.glb", glb(&document(None)));
    lengthen(&stage, "a.glb", 3_900_000_000);
    let words = ["a.glb: the file has 3.9 GB, more than the limit of 1.0 GB", "--max-memory"];
    stage.assert_fails_with("a.glb", &["-o", "a.exr", "--max-memory", "1G"], (77, &words));
}

#[test]
fn buffers_beyond_the_memory_limit_are_refused_with_need_and_limit() {
    let stage = Stage::new("bad.gltf", document(Some("a.bin")).to_string());
    std::fs::write(stage.folder.path().join("scene/a.bin"), buffer(&POSITIONS, &INDICES)).unwrap();
    lengthen(&stage, "a.bin", 5_000_000_000);
    let words =
        ["/buffers/0/uri: ", "a.bin", "need", "5.0 GB, more than the limit of 1.0 GB", "--max-memory"];
    stage.assert_fails_with("bad.gltf", &["-o", "a.exr", "--max-memory", "1G"], (77, &words));
}
