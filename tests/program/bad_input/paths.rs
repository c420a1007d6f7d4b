//! Scenes that refer to files outside their folder. The files exist and are valid, so only the check can refuse them.

use crate::rayframe;

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

#[test]
fn allow_dir_permits_files_of_scenes_to_every_command() {
    let stage = Stage::with(&document(Some("../shared/data.bin")));
    let at = |name: &str| stage.folder.path().join(name).display().to_string();
    std::fs::create_dir(at("shared")).unwrap();
    std::fs::write(at("shared/data.bin"), buffer(&POSITIONS, &INDICES)).unwrap();
    let (scene, shared) = (at("scene/bad.gltf"), at("shared"));
    let shot = at("scene/shot.toml");
    std::fs::write(
        &shot,
        "scene = 'bad.gltf'\nallow_dir = '../shared'\noutput = 'b.exr'\nresolution = [4, 4]\nenv = 'studio'\n",
    )
    .unwrap();
    let code = |arguments: &[&str]| rayframe(arguments).status.code();

    let render = ["render", &scene, "-q", "-r", "4x4", "-o", &at("a.exr")];
    assert_eq!(code(&[&render[..], &["--allow-dir", &shared]].concat()), Some(0));
    assert_eq!(code(&["render", &shot, "-q"]), Some(0));
    assert_eq!(code(&["info", &scene]), Some(77));
    assert_eq!(code(&["info", &scene, "--allow-dir", &shared]), Some(0));
    assert_eq!(code(&["diff", &scene, &scene]), Some(77));
    assert_eq!(code(&["diff", &scene, &scene, "--allow-dir", &shared]), Some(0));
    std::fs::remove_file(&shot).unwrap();
    let suite = at("scene/suite.toml");
    for (permission, expected) in [("", Some(77)), ("allow_dir = '../shared'\n", Some(0))] {
        std::fs::write(&suite, format!("[shot]\n{permission}")).unwrap();
        assert_eq!(code(&["test", "--suite", &suite, "--list-images"]), expected);
    }
    // A shot file gives nobody permission to write.
    std::fs::write(&shot, "scene = 'bad.gltf'\nallow_dir = '../shared'\noutput = '../shared/a.exr'\n")
        .unwrap();
    assert_eq!(code(&["render", &shot, "-q"]), Some(77));
    // Permission to write takes none to read.
    std::fs::create_dir(at("out")).unwrap();
    let elsewhere =
        "scene = 'bad.gltf'\nallow_dir = '../shared'\noutput = '../out/a.exr'\nresolution = [4, 4]\n";
    std::fs::write(&shot, elsewhere).unwrap();
    assert_eq!(code(&["render", &shot, "-q", "--allow-dir", &at("out")]), Some(0));
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
