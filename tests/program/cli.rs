//! Exit codes and messages that need no scene, or none but an empty one.

use std::process::Command;
#[cfg(target_os = "linux")]
use std::{path::Path, process::Stdio};

use rayframe::bvh::SimdLevel;

use crate::{rayframe, stderr};

/// One line of error, naming `word`, and this exit code.
pub(crate) fn assert_fails(arguments: &[&str], code: i32, word: &str) {
    let output = rayframe(arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(message.contains(word), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty());
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    assert!(message.starts_with("rayframe: error: "), "{arguments:?}: {message}");
}

#[test]
fn help_and_version_go_to_the_standard_output() {
    for arguments in [&["--help"][..], &["render", "--help"], &["info", "-h"], &["--version"]] {
        let output = rayframe(arguments);
        assert_eq!(output.status.code(), Some(0));
        assert!(!output.stdout.is_empty() && output.stderr.is_empty());
    }
}

#[test]
fn what_makes_no_sense_is_a_usage_error_before_the_scene_is_opened() {
    let nothing = rayframe(&[]);
    assert_eq!(nothing.status.code(), Some(2));
    assert!(stderr(&nothing).contains("Usage"));
    assert_fails(&["robot.glb"], 2, "rayframe render robot.glb");
    assert_fails(&["rendr"], 2, "'render'");
    assert_fails(&["render"], 2, "SCENE");
    for (options, word) in [
        (&["-f", "10-1"][..], "backwards"),
        (&["-f", "1-3", "-s", "1"], "--start"),
        (&["-a", "-f", "1"], "--frames"),
        (&["-j", "0"], "--step"),
        (&["--fps", "0"], "--fps"),
        (&["-o", "a.jpg"], "\".jpg\" cannot be written"),
        (&["-o", ""], "empty"),
        (&["-o", "out/"], "folder"),
        (&["-r", "0x10"], "pixel"),
        (&["-r", "8x8", "-W", "8"], "--width"),
        (&["-W", "0"], "--width"),
        (&["--scale", "0%"], "scale"),
        (&["--scale", "50"], "rite 50% or 0.5"),
        (&["--scale", "-1"], "50%"),
        (&["--crop", "5,5,5,9"], "crop"),
        (&["--samples", "0"], "write a whole number from 1 to 65536"),
        (&["--samplse", "1"], "'--samples'"),
        (&["--exposure", "bright"], "stops"),
        (&["--background", "1,2"], "--background"),
        (&["--env-intensity", "-1"], "--env-intensity"),
        (&["--env", "1,2"], "R,G,B"),
        (&["--env", "-1,0,0"], "not negative"),
        (&["--env", "Studio"], "did you mean studio?"),
        (&["--env", "outdoors"], "did you mean outdoor?"),
        (&["--background", "soft-box"], "did you mean softbox?"),
        (&["--env", "#ff8800"], "did you mean 1,0.246,0 (linear light)?"),
        (&["--background", "-1,0,0"], "not negative"),
        (&["--glossy", "-1"], "write a whole number from 0 to 4096"),
        (&["--shutter", "-1"], "180deg"),
        (&["--shutter", "360"], "did you mean 360deg?"),
        (&["--max-samples", "9", "--aa-threshold", "-1"], "write a number from 0 to 1"),
        (&["--max-samples", "9", "--aa-threshold", "2"], "write a number from 0 to 1"),
        (&["--light-radius", "-1"], "not negative"),
        (&["--aperture", "-1"], "f/2.8"),
        (&["-f", "5-"], "-s 5 renders from there"),
        (&["-r", "huge"], "1080p"),
        (&["--split", "0"], "area"),
        (&["--refit", "0.5"], "a factor of at least 1"),
        (&["--simd", "avx"], "--simd"),
        (&["--max-memory", "much"], "8GiB"),
        (&["--light-scale", "-1"], "light-scale"),
        (&["--resume", "--overwrite"], "--overwrite"),
        (&["-q", "-v"], "--verbose"),
        (&["--integrator", "bidirectional"], "whitted"),
        (&["-t", "many"], "write a whole number from 1 to 65535"),
        (&["-s", "x"], "--start"),
        (&["--layers", "depht"], "did you mean \"depth\"? There are beauty, depth,"),
        (&["--exr", "half,float"], "one type"),
        (&["--exr", "pxr24"], "half, float, none, rle, zips, zip, piz, dwaa, dwab"),
    ] {
        let arguments = [&["render", "no-such-file.glb"], options].concat();
        assert_fails(&arguments, 2, word);
    }
}

/// No machine has the instructions of both x86-64 and 64-bit ARM, so that some level is refused everywhere.
#[test]
fn instructions_that_the_machine_lacks_are_refused() {
    for (name, level) in [
        ("scalar", SimdLevel::Scalar),
        ("sse4.2", SimdLevel::Sse42),
        ("avx2", SimdLevel::Avx2),
        ("avx512", SimdLevel::Avx512),
        ("neon", SimdLevel::Neon),
    ] {
        let (code, word) = if level.is_supported() { (66, "no-such-file.glb") } else { (2, "--simd") };
        assert_fails(&["render", "no-such-file.glb", "--simd", name], code, word);
    }
    assert_fails(&["render", "no-such-file.glb", "--simd", "best"], 66, "no-such-file.glb");
}

#[test]
fn a_missing_scene_has_its_own_exit_code() {
    assert_fails(&["render", "no-such-file.glb"], 66, "no-such-file.glb");
    assert_fails(&["info", "no-such-file.glb"], 66, "no-such-file.glb");
    let output = rayframe(&["render", "no-such-file.glb"]);
    assert_eq!(stderr(&output).lines().count(), 1);
    assert!(stderr(&output).starts_with("rayframe: error: "));
}

#[test]
fn negative_frames_and_the_argument_order_of_blender_are_accepted() {
    // All of these get as far as the missing file.
    for options in [
        &["-f", "-3--2"][..],
        &["-s", "-5", "-e", "10", "-a"],
        &["-f", "1..10x2", "--spp", "1", "--outfile", "a.%04d.exr"],
        &["--exposure", "-1.5", "--fps", "24000/1001", "--scale", "50%"],
    ] {
        let arguments = [&["render", "no-such-file.glb"], options].concat();
        assert_fails(&arguments, 66, "no-such-file.glb");
    }
}

#[test]
fn names_cannot_fake_lines() {
    let output = rayframe(&["render", "a\nrayframe: error: b.glb"]);
    assert_eq!(stderr(&output).lines().count(), 1);
}

#[cfg(unix)]
#[test]
fn arguments_need_not_be_unicode() {
    use std::os::unix::ffi::OsStrExt as _;
    let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .arg("render")
        .arg(std::ffi::OsStr::from_bytes(b"\xff.glb"))
        .args(["-o", "a.exr"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(66));
}

/// Every command that prints data, with a full device and with a pipe that nobody reads as its standard output.
#[cfg(target_os = "linux")]
#[test]
fn data_that_cannot_be_printed_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/light/point.gltf");
    std::fs::copy(scene, folder.path().join("a.gltf")).unwrap();
    std::fs::write(folder.path().join("suite.toml"), "[shot]\nresolution = [8, 8]\nsamples = 1\n").unwrap();
    let run = |arguments: &[&str], stdout: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        command
            .current_dir(folder.path())
            .args(arguments)
            .stdout(stdout)
            .stderr(Stdio::piped())
            .output()
            .unwrap()
    };
    let size = ["render", "a.gltf", "-r", "8x8", "--samples", "1", "-q", "-o"];
    assert_eq!(run(&[&size[..], &["a.exr"]].concat(), Stdio::piped()).status.code(), Some(0));
    for arguments in [
        &["info", "a.gltf", "--json"][..],
        &["diff", "a.exr", "a.exr", "--json"],
        &["check", "a.exr", "--json"],
        &["test", "--list"],
        &["--help"],
        &["--version"],
        &["render", "--help"],
        &["help", "render"],
        &[&size[..], &["b.exr", "--dry-run"]].concat(),
        &[&size[..], &["c.exr", "--progress", "json"]].concat(),
        &[&size[..], &["d.exr", "--progress", "openjd"]].concat(),
    ] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = run(arguments, full.into());
        assert_eq!(output.status.code(), Some(74), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("standard output: "), "{}", stderr(&output));
        assert_eq!(stderr(&output).lines().count(), 1, "{}", stderr(&output));
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = run(arguments, writer.into());
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        assert_eq!(stderr(&output), "", "{arguments:?}");
    }
    // The frames are whole.
    assert!(["c.exr", "d.exr"].iter().all(|name| folder.path().join(name).is_file()));
}

#[test]
fn an_empty_scene_is_rendered_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("empty.gltf");
    std::fs::write(&scene, r#"{"asset": {"version": "2.0"}}"#).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .current_dir(folder.path())
        .args(["render", "empty.gltf", "-r", "4x4", "--quiet"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(stderr(&output).contains("empty.gltf: the scene draws no triangles"), "{}", stderr(&output));
    assert!(folder.path().join("empty.exr").is_file());
}

#[test]
fn no_file_is_written_over_another_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let scene = br#"{"asset": {"version": "2.0"}}"#;
    for name in ["a.gltf", "b.exr"] {
        std::fs::write(folder.path().join(name), scene).unwrap();
    }
    for (options, word) in [
        (&["a.gltf", "-o", "x.exr", "--stats", "./x.exr"][..], "--stats"),
        (&["a.gltf", "-o", "x.exr", "--preview", "png", "--stats", "x.png"], "--stats"),
        (&["a.gltf", "-o", "x.exr", "--stats", "a.gltf"], "--stats"),
        (&["b.exr", "-o", "./b.exr", "--overwrite"], "-o"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .current_dir(folder.path())
            .args([&["render", "-r", "4x4"], options].concat())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{options:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(word), "{options:?}: {}", stderr(&output));
    }
    assert!(std::fs::read(folder.path().join("a.gltf")).unwrap() == scene);
    assert!(std::fs::read(folder.path().join("b.exr")).unwrap() == scene);
}

/// Runs `arguments` on a terminal of this kind through the program `script`; `None` where that is missing.
#[cfg(target_os = "linux")]
fn on_a_terminal(terminal: &str, folder: &std::path::Path, arguments: &str) -> Option<String> {
    let command = format!("{} {arguments}", env!("CARGO_BIN_EXE_rayframe"));
    let output = Command::new("script")
        .args(["-qec", &command, "/dev/null"])
        .current_dir(folder)
        .env("TERM", terminal)
        .stdin(Stdio::null())
        .output()
        .ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(target_os = "linux")]
#[test]
fn terminals_that_cannot_show_bars_get_lines() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.gltf"), r#"{"asset": {"version": "2.0"}}"#).unwrap();
    for (terminal, has_bars) in [("dumb", false), ("xterm", true)] {
        let arguments = "render a.gltf -r 4x4 --overwrite";
        let Some(shown) = on_a_terminal(terminal, folder.path(), arguments) else {
            return crate::skipped("the program script is missing");
        };
        assert_eq!(shown.contains('\u{1b}'), has_bars, "{shown:?}");
        assert!(shown.ends_with("s\r\n") && shown.contains("1 frame written to a.exr in "), "{shown:?}");
    }
}

#[test]
fn a_clip_that_is_left_out_is_a_choice_and_nothing_to_be_strict_about() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/morph/weights.gltf");
    let mut document: serde_json::Value = serde_json::from_slice(&std::fs::read(scene).unwrap()).unwrap();
    // The same clip again moves what the first one moves.
    let clip = document["animations"][0].clone();
    document["animations"].as_array_mut().unwrap().push(clip);
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("twice.gltf");
    std::fs::write(&scene, document.to_string()).unwrap();
    let scene = scene.to_str().unwrap();

    let output = rayframe(&["render", scene, "-f", "30", "--strict", "--dry-run"]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("rayframe: warning: ") && said.contains("is left out"), "{said}");
    // Frame 30 is behind the last of 24.
    assert!(said.contains("frame 30 lies after the animation's end (24) and shows its last pose"), "{said}");

    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains("left out:\n  /animations/1: ") && !shown.contains("not supported:"), "{shown}");
}

#[test]
fn a_wrong_environment_names_its_option() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let scene = path("a.gltf", br#"{"asset": {"version": "2.0"}}"#);
    let map = path("sky.hdr", b"\xff\xfe");
    assert_fails(&["render", &scene, "--env", "white"], 2, "did you mean 1,1,1?");
    assert_fails(
        &["render", &scene, "--env", "nowhere.hdr"],
        66,
        "R,G,B, studio, softbox, outdoor, dark or none",
    );
    assert_fails(&["render", &scene, "--env", &format!("{map}@abc")], 2, "number of degrees");
    assert_fails(&["render", &map], 65, "environment with --env");
    assert_fails(&["render", &scene, "-s", "5"], 2, "last frame, 0");
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_be_started_are_worth_a_retry() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/light/point.gltf");
    std::fs::copy(scene, folder.path().join("a.gltf")).unwrap();
    std::fs::write(folder.path().join("suite.toml"), "[shot]\nresolution = [8, 8]\n").unwrap();
    for arguments in [
        &["render", "missing.glb", "--threads", "2"][..],
        &["render", "a.gltf"],
        &["test"],
        &["test", "--threads", "1"],
        &["check", "a.gltf"],
        &["diff", "a.exr", "b.exr"],
        &["merge", "a.exr", "-o", "c.exr"],
    ] {
        // Not even the stack of one thread fits into the address space, so that none fails after its start.
        let output = Command::new("sh")
            .env("RUST_MIN_STACK", "4000000000")
            .args(["-c", "ulimit -v 2000000; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_rayframe")])
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(75), "{arguments:?}: {message}");
        assert!(message.contains("threads cannot be started") && !message.contains("internal"), "{message}");
    }
}
