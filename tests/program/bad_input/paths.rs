//! Scenes that refer to files outside their folder. The files exist and are valid, so only the check can refuse them.

use super::stage::Stage;
use super::triangle::{INDICES, POSITIONS, buffer, document};

#[test]
fn paths_out_of_the_scenes_folder_are_refused() {
    let secret = |stage: &Stage| {
        let path = stage.folder.path().join("secret.bin");
        std::fs::write(&path, buffer(&POSITIONS, &INDICES)).unwrap();
        path
    };
    for uri in
        ["../secret.bin", "sub/../../secret.bin", "%2e%2e/secret.bin", "..%2Fsecret.bin", "..\\secret.bin"]
    {
        let stage = Stage::with(&document(Some(uri)));
        secret(&stage);
        stage.assert_fails("bad.gltf", (77, &["bad.gltf: ", "/buffers/0/uri: "]));
    }
    for scheme in ["", "file://"] {
        let stage = Stage::new("bad.gltf", "");
        let uri = format!("{scheme}{}", secret(&stage).display());
        let scene = stage.folder.path().join("scene/bad.gltf");
        std::fs::write(scene, document(Some(&uri)).to_string()).unwrap();
        stage.assert_fails("bad.gltf", (77, &["bad.gltf: ", "/buffers/0/uri: "]));
    }
}

#[cfg(unix)]
#[test]
fn symbolic_links_out_of_the_scenes_folder_are_refused() {
    let stage = Stage::with(&document(Some("link.bin")));
    let secret = stage.folder.path().join("secret.bin");
    std::fs::write(&secret, buffer(&POSITIONS, &INDICES)).unwrap();
    std::os::unix::fs::symlink(&secret, stage.folder.path().join("scene/link.bin")).unwrap();
    stage.assert_fails("bad.gltf", (77, &["bad.gltf: ", "/buffers/0/uri: "]));
}
