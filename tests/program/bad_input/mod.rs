//! Bad input: one line with the location, the exit code of its kind, and no files.

mod content;
mod large_files;
mod outputs;
mod paths;
mod pipes;
mod stage;
mod triangle;

use stage::Stage;
use triangle::{document, glb, triangle};

/// The base of the other tests renders, so that their failures come from what they change.
#[test]
fn the_unchanged_scene_renders() {
    let text = triangle();
    let binary = glb(&document(None));
    for (name, content) in [("a.gltf", text.to_string().into_bytes()), ("a.glb", binary)] {
        let stage = Stage::new(name, content);
        let run = stage.render(name, &["-o", "out/a.exr", "--strict"]);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{name}");
        assert!(stage.folder.path().join("out/a.exr").is_file());
    }
}
