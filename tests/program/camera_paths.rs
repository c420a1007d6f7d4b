//! `--camera-path`.

use std::path::Path;
use std::process::{Command, Output};

use crate::{names, stderr};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/animation/hierarchy.gltf");

/// A second from the front to the side, and one more around the corner.
const WALK: &str = "
[[key]]
time = 0
position = [0, 1, 8]
look_at = [0, 0, 0]
fov = 40

[[key]]
time = 1
position = [4, 1, 4]
look_at = [1, 0, 0]
fov = 60
";

/// Runs `rayframe render` in `folder` with tiny images.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(folder: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(["render", SCENE, "-r", "32x18", "--samples", "1", "--exposure", "0", "--fps", "10"]);
    command.args(options).current_dir(folder).output().unwrap()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn pixels(folder: &Path, options: &[&str]) -> image::RgbaImage {
    let output = render(folder, &[options, &["-o", "one.png", "--overwrite"]].concat());
    assert!(output.status.success(), "{options:?}: {}", stderr(&output));
    image::open(folder.join("one.png")).unwrap().into_rgba8()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn folder_with(head: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("walk.toml"), format!("{head}{WALK}")).unwrap();
    folder
}

#[test]
fn a_linear_path_is_half_way_in_the_middle() {
    let folder = folder_with("interpolation = \"linear\"");
    let still = |given: &[&str]| pixels(folder.path(), &[&["--animation", "none"], given].concat());
    for (frame, options) in [
        ("0", ["--camera-position", "0,1,8", "--look-at", "0,0,0", "--fov", "40"]),
        ("5", ["--camera-position", "2,1,6", "--look-at", "0.5,0,0", "--fov", "50"]),
        ("10", ["--camera-position", "4,1,4", "--look-at", "1,0,0", "--fov", "60"]),
        // Ends are held.
        ("99", ["--camera-position", "4,1,4", "--look-at", "1,0,0", "--fov", "60"]),
    ] {
        let along = still(&["--camera-path", "walk.toml", "-f", frame]);
        assert!(along == still(&[&options[..], &["-f", frame]].concat()), "frame {frame}");
    }
    // Options change what the keys say.
    let changed = still(&["--camera-path", "walk.toml", "-f", "5", "--fov", "40", "--look-at", "0,0,0"]);
    let options = ["--camera-position", "2,1,6", "--look-at", "0,0,0", "--fov", "40", "-f", "5"];
    assert!(changed == still(&options));
}

#[test]
fn all_frames_are_those_of_the_path_and_a_loop_ends_before_it_repeats() {
    let open = folder_with("");
    let planned = |folder: &Path| {
        let output = render(folder, &["--animation", "none", "--camera-path", "walk.toml", "-n"]);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(stderr(&output).contains("camera path walk.toml"), "{}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(planned(open.path()).contains("frames = \"0-10\""), "{}", planned(open.path()));
    // Two keys a second apart: the way back takes another second.
    let closed = folder_with("loop = true");
    assert!(planned(closed.path()).contains("frames = \"0-19\""), "{}", planned(closed.path()));
    let at = |frame: &str| {
        pixels(closed.path(), &["--animation", "none", "--camera-path", "walk.toml", "-f", frame])
    };
    assert!(at("3") == at("23") && at("0") != at("10"));
}

#[test]
fn a_loop_lasts_one_period_wherever_its_first_key_is() {
    for (first, second) in [("2", "3"), ("-2", "-1")] {
        let folder = tempfile::tempdir().unwrap();
        let keys = WALK
            .replace("time = 1", &format!("time = {second}"))
            .replace("time = 0", &format!("time = {first}"));
        std::fs::write(folder.path().join("walk.toml"), format!("loop = true{keys}")).unwrap();
        let output = render(folder.path(), &["--animation", "none", "--camera-path", "walk.toml", "-n"]);
        let plan = String::from_utf8_lossy(&output.stdout);
        assert!(plan.contains("frames = \"0-19\""), "first key at {first}: {plan}");
    }
}

#[test]
fn a_path_begins_without_the_roll_of_a_later_key() {
    let folder = folder_with("interpolation = \"linear\"");
    let rolled = format!("interpolation = \"linear\"{WALK}roll = 30\n");
    std::fs::write(folder.path().join("rolled.toml"), rolled).unwrap();
    let along = |path: &str, frame: &str, more: &[&str]| {
        let options = [&["--animation", "none", "--camera-path", path, "-f", frame], more].concat();
        pixels(folder.path(), &options)
    };
    assert!(along("rolled.toml", "0", &[]) == along("walk.toml", "0", &[]));
    assert!(along("rolled.toml", "5", &[]) == along("walk.toml", "5", &["--roll", "15"]));
    assert!(along("rolled.toml", "10", &[]) == along("walk.toml", "10", &["--roll", "30"]));
}

#[test]
fn the_camera_of_another_file_moves_as_it_does_there() {
    let folder = tempfile::tempdir().unwrap();
    let cameras =
        concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/animation/pointer_light_camera.gltf").to_owned();
    let own = |options: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .args(["render", &cameras, "-r", "32x18", "--samples", "1", "--exposure", "0", "-f", "20"])
            .args(["-o", "one.png", "--overwrite"])
            .args(options)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        image::open(folder.path().join("one.png")).unwrap().into_rgba8()
    };
    let first = format!("{cameras}#0");
    assert!(own(&[]) == own(&["--camera-path", &cameras]) && own(&[]) == own(&["--camera-path", &first]));
    let output = render(folder.path(), &["--camera-path", &format!("{cameras}#nobody"), "-n"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--camera-path: ") && stderr(&output).contains("nobody"));
}

#[test]
fn a_dry_run_and_a_shot_file_keep_the_path() {
    let folder = folder_with("");
    let shot = format!("scene = \"{SCENE}\"\ncamera_path = \"walk.toml\"\n");
    std::fs::write(folder.path().join("shot.toml"), shot).unwrap();
    let run = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_rayframe")).args(arguments).current_dir("/").output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        output
    };
    let path = |name: &str| folder.path().join(name).display().to_string();
    let common = ["-r", "16x9", "--samples", "1", "-f", "3"];
    let dry = run(&[&["render", &path("shot.toml"), "-o", &path("a.exr"), "-n"], &common[..]].concat());
    std::fs::write(folder.path().join("dry.toml"), dry.stdout).unwrap();
    run(&[&["render", &path("shot.toml"), "-o", &path("a.exr")], &common[..]].concat());
    run(&["render", &path("dry.toml"), "-o", &path("b.exr")]);
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(read("a.exr") == read("b.exr"));
    // Another path is another render.
    std::fs::write(folder.path().join("walk.toml"), WALK.replace("time = 1", "time = 2")).unwrap();
    let again = ["render", &path("shot.toml"), "-o", &path("a.exr")];
    let output = Command::new(env!("CARGO_BIN_EXE_rayframe")).args(again).args(common).output().unwrap();
    assert_eq!(output.status.code(), Some(73), "{}", stderr(&output));
}

#[test]
fn wrong_paths_are_refused_with_their_place() {
    let key = |time: &str, position: &str, rest: &str| {
        format!("[[key]]\ntime = {time}\nposition = {position}\nlook_at = [0, 0, 0]\n{rest}\n")
    };
    let first = key("0", "[0, 0, 1]", "");
    for (text, expected) in [
        (String::new(), "walk.toml:1:1: key: a path needs at least two keys, and the file has 0"),
        (first.clone(), "walk.toml:1:1: key: a path needs at least two keys, and the file has 1"),
        (format!("{first}{}", key("0", "[0, 0, 2]", "")), "walk.toml:6:1: key: time 0 is not after 0"),
        (format!("{first}{}", key("1", "[0, 0, 0]", "")), "walk.toml:6:1: key: look_at is the position"),
        (format!("{first}{}", key("1", "[0, 0]", "")), "walk.toml:8:1: position: write three numbers"),
        (format!("{first}{}", key("1", "[0, 0, 2]", "fov = 0")), "walk.toml:10:1: fov: write degrees"),
        (
            format!("{first}{}", key("1", "[0, 0, 2]", "lookat = 0")),
            "walk.toml:10:1: \"lookat\" is not part of a key; did you mean \"look_at\"?",
        ),
        (
            "interpolation = \"cubic\"\n".to_owned(),
            "walk.toml:1:1: interpolation: write \"smooth\" or \"linear\"",
        ),
        ("lop = true\n".to_owned(), "did you mean \"loop\"?"),
        ("[[key]]\ntime = 0\n".to_owned(), "walk.toml:1:1: key: names no position"),
        ("key = 3\n".to_owned(), "walk.toml:1:1: key: expected tables [[key]]"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("walk.toml"), &text).unwrap();
        let output = render(folder.path(), &["--camera-path", "walk.toml"]);
        assert!(stderr(&output).contains(expected), "{text}\n{}", stderr(&output));
        assert_eq!(output.status.code(), Some(65), "{}", stderr(&output));
        assert_eq!(names(folder.path()), ["walk.toml"]);
    }
    let folder = folder_with("");
    for other in
        ["--orbit=1,2", "--view=front", "--camera-position=1,2,3", "--turntable=4", "--frame-node=#0"]
    {
        let output = render(folder.path(), &["--camera-path", "walk.toml", other]);
        assert_eq!(output.status.code(), Some(2), "{other}: {}", stderr(&output));
    }
    assert_eq!(render(folder.path(), &["--camera-path", "missing.toml"]).status.code(), Some(66));
}

#[test]
fn motion_blur_follows_the_path() {
    let folder = folder_with("");
    let at = |options: &[&str]| {
        pixels(
            folder.path(),
            &[&["--animation", "none", "--camera-path", "walk.toml", "-f", "5"], options].concat(),
        )
    };
    assert!(at(&[]) != at(&["--shutter", "1", "--time-samples", "2"]));
}
