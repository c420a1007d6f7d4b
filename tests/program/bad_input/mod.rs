//! Wrong input ends in one line that says where, with the exit code that says what kind, and leaves no file.

mod content;
mod outputs;
mod paths;
mod stage;
mod triangle;

use stage::Stage;
use triangle::{document, glb, triangle};

/// Without this the other tests could fail for a reason of their own.
#[test]
fn the_scene_that_is_spoiled_below_is_right() {
    let text = triangle();
    let binary = glb(&document(None));
    for (name, content) in [("a.gltf", text.to_string().into_bytes()), ("a.glb", binary)] {
        let stage = Stage::new(name, content);
        let ending = stage.render(name, &["-o", "out/a.exr", "--strict"]);
        assert_eq!((ending.code, ending.said.as_str()), (Some(0), ""), "{name}");
        assert!(stage.folder.path().join("out/a.exr").is_file());
    }
}
