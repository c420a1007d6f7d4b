//! Frames and files that cannot be made, and those that may not be replaced.

use std::path::Path;

use super::stage::Stage;
use super::triangle::triangle;

#[test]
fn outputs_that_cannot_be_made_are_told_before_the_first_frame() {
    let stage = Stage::with(&triangle());
    std::fs::write(stage.folder.path().join("file"), "").unwrap();
    stage.assert_fails_with("bad.gltf", &["-o", "file/a.exr"], (73, &["file"]));
    std::fs::create_dir(stage.folder.path().join("a.exr")).unwrap();
    stage.assert_fails_with("bad.gltf", &["-o", "a.exr"], (73, &["a.exr"]));
    if cfg!(target_os = "linux") {
        // Not even the superuser can make a folder here.
        stage.assert_fails_with("bad.gltf", &["-o", "/proc/rayframe/a.exr"], (73, &["/proc/rayframe"]));
    }
}

#[cfg(unix)]
#[test]
fn a_folder_without_leave_to_write_is_told_before_the_first_frame() {
    use std::os::unix::fs::PermissionsExt as _;
    let stage = Stage::with(&triangle());
    let folder = stage.folder.path().join("locked");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser may write anyway; then there is nothing to see here.
    if std::fs::write(folder.join("probe"), "").is_err() {
        stage.assert_fails_with("bad.gltf", &["-o", "locked/a.exr"], (73, &["locked/a.exr"]));
    }
}

#[test]
fn frames_that_would_share_a_name_are_a_usage_error() {
    let stage = Stage::with(&triangle());
    let options = ["-o", "out/a.exr", "-f", "1-2"];
    stage.assert_fails_with("bad.gltf", &options, (2, &["out/a.exr", "####"]));
}

#[test]
fn pictures_that_do_not_fit_are_refused_before_anything_is_allocated() {
    let stage = Stage::with(&triangle());
    for size in ["65536x65536", "2147483647x2147483647"] {
        let options = ["-o", "out/a.exr", "--max-memory", "1G", "-r", size];
        stage.assert_fails_with("bad.gltf", &options, (77, &["bad.gltf: ", size, "--max-memory"]));
    }
}

#[test]
fn ranges_that_name_no_frames_are_usage_errors() {
    let stage = Stage::with(&triangle());
    for range in ["3-1", "1,x", "", "1-2-3", "1-10x0", "0-99999999999999999999"] {
        let options = ["-o", "out/a.####.exr", "-f", range];
        stage.assert_fails_with("bad.gltf", &options, (2, &["--frames"]));
    }
}

#[test]
fn a_foreign_frame_is_not_replaced_unasked() {
    let stage = Stage::with(&triangle());
    let path = stage.folder.path().join("out/a.0002.exr");
    std::fs::create_dir(stage.folder.path().join("out")).unwrap();
    std::fs::write(&path, "yesterday's picture").unwrap();
    let options = ["-o", "out/a.####.exr", "-f", "1-3"];
    stage.assert_fails_with("bad.gltf", &options, (73, &["out/a.0002.exr", "--resume", "--overwrite"]));
    assert_eq!(std::fs::read(&path).unwrap(), b"yesterday's picture");

    for flag in ["--resume", "--overwrite"] {
        std::fs::write(&path, "yesterday's picture").unwrap();
        let ending = stage.render("bad.gltf", &[&options[..], &[flag]].concat());
        assert_eq!(ending.code, Some(0), "{flag}: {}", ending.said);
        let warns =
            ending.said.contains("1 file made from something else will be replaced: \"out/a.0002.exr\"");
        assert_eq!(warns, flag == "--resume", "{}", ending.said);
        assert!(is_exr(&path) && is_exr(&path.with_file_name("a.0003.exr")), "{flag}");
    }
}

/// Whether the file begins as OpenEXR files do.
fn is_exr(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]))
}
