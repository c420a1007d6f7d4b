//! Names that the system refuses: found before any folder is made.

use super::{assert_code, moving, rayframe, write};
use crate::names;

#[test]
fn a_name_that_is_too_long_leaves_no_folder_of_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let long = "n".repeat(300);
    write(folder, "long.gltf", &moving(&[("walk", 0.5), (&long, 1.0)], 1));
    write(folder, "m.gltf", &moving(&[("walk", 0.5), ("run", 1.0)], 1));
    let barely = format!("{{clip}}/{}.exr", "n".repeat(245));
    let statistics = format!("x/{{clip}}-{long}.json");
    for arguments in [
        &["long.gltf", "-o", "{clip}/a.png"][..],
        // The name of the checkpoint is longer than that of the frame.
        &["m.gltf", "-o", &barely, "--integrator", "path", "--checkpoint"],
        &["m.gltf", "-o", "{clip}/a.png", "--stats", &statistics],
    ] {
        let each = crate::both(arguments, &["--animation", "each", "-f", "0"]);
        let told = assert_code(&rayframe(folder, &each), 73);
        assert!(told.contains("choose another name"), "{told}");
        assert_eq!(names(folder), ["long.gltf", "m.gltf"], "{told}");
    }
}
