//! Output files that cannot be created or may not be replaced.

use std::path::Path;

use crate::cli::assert_fails;

use super::stage::Stage;
use super::triangle::triangle;

#[test]
fn outputs_that_cannot_be_created_fail_before_the_first_frame() {
    let stage = Stage::with(&triangle());
    std::fs::write(stage.folder.path().join("file"), "").unwrap();
    stage.assert_fails_with("bad.gltf", &["-o", "file/a.exr"], (73, &["file"]));
    std::fs::create_dir(stage.folder.path().join("a.exr")).unwrap();
    stage.assert_fails_with("bad.gltf", &["-o", "a.exr"], (73, &["a.exr"]));
    if cfg!(target_os = "linux") {
        // Not even root can create a folder here.
        stage.assert_fails_with("bad.gltf", &["-o", "/proc/rayframe/a.exr"], (73, &["/proc/rayframe"]));
    }
}

#[test]
fn a_home_folder_that_no_shell_expanded_is_refused() {
    let stage = Stage::with(&triangle());
    for option in ["--output=~/a.exr", "--manifest=~/a.json", "--env=~/a.hdr", "--background=~/a.png"] {
        stage.assert_fails_with("bad.gltf", &[option], (2, &["~/a", "./~/a"]));
    }
    let shot = stage.folder.path().join("scene/shot.toml");
    for command in [["man", "--folder=~/a"], ["test", "--report=~/a"], ["info", "~/a"]] {
        assert_fails(&command, 2, "no shell has expanded ~");
    }
    std::fs::write(&shot, "scene = \"bad.gltf\"\noutput = \"~/a.exr\"\n").unwrap();
    stage.assert_fails_with("shot.toml", &[], (65, &["shot.toml:2:", "./~/a.exr"]));
    let run = stage.render("bad.gltf", &["-o", "./~/a.exr"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(stage.folder.path().join("~/a.exr").is_file());
}

#[test]
fn cameras_without_direction_are_refused() {
    let stage = Stage::with(&triangle());
    let same = ["--camera-position", "1,2,3", "--look-at", "1,2,3"];
    stage.assert_fails_with("bad.gltf", &same, (2, &["--look-at", "move one of the two"]));
    stage.assert_fails_with("bad.gltf", &["--up", "0,0,0"], (2, &["--up", "no direction"]));
}

#[test]
fn a_clamp_of_all_light_is_refused() {
    let stage = Stage::with(&triangle());
    let options = ["--integrator", "path", "--clamp-indirect", "0"];
    stage.assert_fails_with("bad.gltf", &options, (2, &["--clamp-indirect", "leave it out"]));
}

#[cfg(unix)]
#[test]
fn a_folder_without_write_permission_fails_before_the_first_frame() {
    use std::os::unix::fs::PermissionsExt as _;
    let stage = Stage::with(&triangle());
    let folder = stage.folder.path().join("locked");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(folder.join("probe"), "").is_ok() {
        return crate::skipped("root may write to any folder");
    }
    stage.assert_fails_with("bad.gltf", &["-o", "locked/a.exr"], (73, &["locked/a.exr"]));
}

#[test]
fn frames_that_would_share_a_name_are_a_usage_error() {
    let stage = Stage::with(&triangle());
    let options = ["-o", "out/a.exr", "-f", "1-2"];
    stage.assert_fails_with("bad.gltf", &options, (2, &["out/a.exr", "####"]));
}

#[test]
fn images_beyond_the_memory_limit_are_refused_before_allocation() {
    let stage = Stage::with(&triangle());
    // PNG files are made of whole images, and of the larger one even a band of rows is too large.
    for size in ["65536x65536", "2147483647x2147483647"] {
        let options = ["-o", "out/a.png", "--max-memory", "1G", "-r", size];
        stage.assert_fails_with("bad.gltf", &options, (77, &["bad.gltf: ", size, "--max-memory"]));
    }
    let options = ["-o", "out/a.exr", "--max-memory", "1G", "-r", "2147483647x2147483647"];
    stage.assert_fails_with("bad.gltf", &options, (77, &["bad.gltf: ", "--max-memory"]));
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
fn a_frame_of_another_program_is_not_replaced_without_overwrite() {
    let stage = Stage::with(&triangle());
    let path = stage.folder.path().join("out/a.0002.exr");
    std::fs::create_dir(stage.folder.path().join("out")).unwrap();
    std::fs::write(&path, "another program's image").unwrap();
    let options = ["-o", "out/a.####.exr", "-f", "1-3"];
    for more in [&[][..], &["--resume"]] {
        let options = [&options[..], more].concat();
        stage.assert_fails_with("bad.gltf", &options, (73, &["out/a.0002.exr", "only --overwrite"]));
        assert_eq!(std::fs::read(&path).unwrap(), b"another program's image");
        assert!(!path.with_file_name("a.0001.exr").exists());
    }
    let run = stage.render("bad.gltf", &[&options[..], &["--overwrite"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(is_exr(&path) && is_exr(&path.with_file_name("a.0003.exr")));
}

#[test]
fn resuming_replaces_damaged_frames_and_no_links() {
    let stage = Stage::with(&triangle());
    let path = stage.folder.path().join("out/a.0002.exr");
    let options = ["-o", "out/a.####.exr", "-f", "1-3"];
    let resume = [&options[..], &["--resume"]].concat();
    assert_eq!(stage.render("bad.gltf", &options).code, Some(0));
    let whole = std::fs::read(&path).unwrap();
    for damaged in [&whole[..whole.len() / 2], &[0; 500]] {
        std::fs::write(&path, damaged).unwrap();
        stage.assert_fails_with("bad.gltf", &options, (73, &["out/a.0002.exr", "--resume", "--overwrite"]));
        let run = stage.render("bad.gltf", &resume);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let warning = "1 file made from something else will be replaced: \"out/a.0002.exr\"";
        assert!(run.stderr.contains(warning), "{}", run.stderr);
        assert!(std::fs::read(&path).unwrap() == whole);
    }
    #[cfg(unix)]
    for target in ["gone.exr", "damaged.exr"] {
        std::fs::remove_file(&path).unwrap();
        std::fs::write(path.with_file_name("damaged.exr"), &whole[..whole.len() / 2]).unwrap();
        std::os::unix::fs::symlink(target, &path).unwrap();
        stage.assert_fails_with(
            "bad.gltf",
            &resume,
            (73, &["out/a.0002.exr", "a link to", "only --overwrite"]),
        );
        assert!(path.is_symlink());
    }
}

/// Whether the file starts with the magic number of OpenEXR.
fn is_exr(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]))
}
