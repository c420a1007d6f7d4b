//! Exit codes and messages that need no scene, or none but an empty one.

use std::process::{Command, Output, Stdio};

use rayframe::bvh::SimdLevel;

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn rayframe(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rayframe")).args(arguments).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn both<'a>(first: &[&'a str], second: &[&'a str]) -> Vec<&'a str> {
    [first, second].concat()
}

/// One line of error, naming `word`, and this exit code.
fn assert_fails(arguments: &[&str], code: i32, word: &str) {
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
        (&["--integrator", "path"], "whitted"),
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
fn negative_frames_and_blenders_order_are_understood() {
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

#[cfg(target_os = "linux")]
#[test]
fn a_closed_standard_output_is_no_panic() {
    // Every write to /dev/full fails, as to a pipe that nobody reads any more.
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let status = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .arg("--help")
        .stdout(Stdio::from(full))
        .stderr(Stdio::null())
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(0));
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

/// Runs `arguments` on a terminal of this kind, through the `script` program; nothing where that is missing.
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
            return;
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
    assert_fails(&["render", &scene, "--env", "nowhere.hdr"], 66, "R,G,B, studio or none");
    assert_fails(&["render", &scene, "--env", &format!("{map}@abc")], 2, "number of degrees");
    assert_fails(&["render", &map], 65, "an environment goes after --env");
    assert_fails(&["render", &scene, "-s", "5"], 2, "last frame, 0");
}

#[test]
fn a_variant_changes_the_picture_and_unknown_ones_are_listed() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/material/variants.gltf");
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, options: &[&str]| {
        let path = folder.path().join(name);
        let output = path.to_str().unwrap();
        let arguments = [&["render", scene, "-r", "16x9", "--samples", "1", "-q", "-o", output], options];
        let done = rayframe(&arguments.concat());
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        rayframe::regression::Picture::read(&path).unwrap().pixels
    };
    let own = render("own.exr", &[]);
    let red = render("red.exr", &["--variant", "red"]);
    let gold = render("gold.exr", &["--variant", "#1"]);
    // The box, left of the middle: white, red, and white again, since "gold" is for the ball alone.
    let box_at = 4 * 16 + 5;
    let [own_box, red_box, gold_box] = [&own, &red, &gold].map(|pixels| pixels[box_at]);
    assert!(own_box[1] > 0.2 && red_box[1] < 0.2 * red_box[0], "{own_box:?} {red_box:?}");
    assert_eq!(own_box, gold_box);
    assert!(own != gold && red != gold);

    assert_fails(&["render", scene, "--variant", "blue"], 2, "there is no variant \"blue\"; ");
    assert_fails(&["render", scene, "--variant", "blue"], 2, "#0 \"red\", #1 \"gold\"");
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains("variants:\n  #0 \"red\"\n  #1 \"gold\"\n"), "{shown}");
    assert!(shown.contains("KHR_materials_variants: supported"), "{shown}");
}

#[test]
fn info_tells_of_everything_whether_it_is_supported() {
    let folder = tempfile::tempdir().unwrap();
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let text = std::fs::read_to_string(root.join("animation/pointer_light_camera.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    // One channel of the three names what is not there; a texture is not used; an extension is not known.
    document["animations"][0]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
        "/materials/9/alphaCutoff".into();
    document["textures"] = serde_json::json!([{}]);
    document["extensionsUsed"].as_array_mut().unwrap().push("ACME_glow".into());
    let scene = folder.path().join("a.gltf");
    std::fs::write(&scene, document.to_string()).unwrap();
    let scene = scene.to_str().unwrap();

    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    for line in [
        "1 s, 2 channels, 1 more left out, supported in part",
        "spot, supported",
        "perspective, supported",
        "1 more that no material uses",
        "KHR_animation_pointer: supported",
        "ACME_glow: not supported, left out",
        "/materials/9/alphaCutoff",
    ] {
        assert!(shown.contains(line), "{line} is not in\n{shown}");
    }
    let output = rayframe(&["info", "--json", scene]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["schema"], 2);
    assert_eq!(report["clips"][0]["ignored_channels"], 1);
    assert_eq!(report["clips"][0]["support"], "supported in part");
    assert_eq!(report["lights"][0]["support"], "supported");
    assert_eq!(report["cameras"][0]["support"], "supported");
    assert_eq!(report["unused_textures"], 1);

    let scene = root.join("light/image_based.gltf");
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene.to_str().unwrap()]).stdout).into_owned();
    assert!(shown.contains("cube of 16x16 texels, 3 levels, supported"), "{shown}");
}

#[test]
fn many_large_textures_are_refused_by_their_total_and_shown_without_decoding_them() {
    let folder = tempfile::tempdir().unwrap();
    let first = folder.path().join("t0.png");
    image::GrayImage::new(4096, 4096).save(&first).unwrap();
    for index in 1..20 {
        std::fs::copy(&first, folder.path().join(format!("t{index}.png"))).unwrap();
    }
    let numbered = |value: &dyn Fn(usize) -> serde_json::Value| (0..20).map(value).collect::<Vec<_>>();
    let document = serde_json::json!({
        "asset": {"version": "2.0"},
        "images": numbered(&|index| serde_json::json!({"uri": format!("t{index}.png")})),
        "textures": numbered(&|index| serde_json::json!({"source": index})),
        "materials": numbered(&|index| serde_json::json!({"emissiveTexture": {"index": index}})),
    });
    let path = folder.path().join("walls.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    let scene = path.to_str().unwrap();
    let output = folder.path().join("a.exr");
    let output = output.to_str().unwrap();

    // 20 · 89 478 484 bytes, and 89 478 480 while the last mip maps are made.
    let render = ["render", scene, "-o", output, "--max-memory", "500M"];
    for word in
        ["20 images need 1.9 GB with mip maps", "/images/0 \"t0.png\" with 89.5 MB", "limit of 500.0 MB"]
    {
        assert_fails(&render, 77, word);
    }
    // The picture comes first, and the plan knows what texels would need; the list does not ask.
    assert_fails(&[&render[..], &["-r", "30000x30000"]].concat(), 77, "30000x30000 pixels need about");
    assert_fails(&[&render[..], &["--dry-run"]].concat(), 77, "20 images need 1.9 GB");
    let planned = rayframe(&["render", scene, "-o", output, "--max-memory", "2G", "--dry-run"]);
    assert_eq!(planned.status.code(), Some(0), "{}", stderr(&planned));
    let shown = rayframe(&["info", scene, "--max-memory", "100M"]);
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(
        text.contains("#19 4096x4096, 8 bits") || text.contains("\"t19.png\" 4096x4096, 8 bits"),
        "{text}"
    );
}

#[test]
fn what_nobody_would_want_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.exr");
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
    let said = |scene: &str, options: &[&str]| {
        let scene = format!("{root}{scene}");
        let arguments = ["render", &scene, "-o", output.to_str().unwrap(), "-r", "16x9", "--overwrite"];
        let done = rayframe(&[&arguments[..], &["--samples", "1", "-f", "0"], options].concat());
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        stderr(&done)
    };
    // A mirror in the middle of the picture and no way to go on from it.
    let cut = said("material/mirror.gltf", &["--depth", "0"]);
    assert!(cut.contains(" % of the light was cut off at depth 0: raise --depth"), "{cut}");
    assert!(!said("material/diffuse.gltf", &["--depth", "0"]).contains("cut off"));

    // The same camera behind everything.
    let text = std::fs::read_to_string(format!("{root}material/diffuse.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    for node in document["nodes"].as_array_mut().unwrap() {
        if node.get("camera").is_some() {
            *node = serde_json::json!({"name": "lost", "camera": 0, "translation": [0, 0, -1000]});
        }
    }
    let scene = folder.path().join("lost.gltf");
    std::fs::write(&scene, document.to_string()).unwrap();
    let arguments =
        ["render", scene.to_str().unwrap(), "-o", output.to_str().unwrap(), "-r", "16x9", "--overwrite"];
    let lost = stderr(&rayframe(&arguments));
    assert!(lost.contains("warning: camera \"") && lost.contains("sees nothing in frame 0"), "{lost}");
}

#[test]
fn names_of_nodes_are_listed_and_suggested() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/environment/shadow_catcher.gltf");
    let render = ["render", scene, "--dry-run", "-o", "unwritten.exr"];
    assert_fails(&both(&render, &["--shadow-catcher", "flor"]), 2, "did you mean \"floor\"?");
    assert_fails(&both(&render, &["--aperture", "0.1", "--focus", "flor"]), 2, "did you mean \"floor\"?");
    assert_fails(
        &both(&render, &["--aperture", "0.1", "--focus", "-1"]),
        2,
        "a distance lies above 0 metres",
    );
    assert_fails(&both(&render, &["--shadow-catcher", "#999"]), 2, "\"floor\"");

    let shown = rayframe(&["info", "--json", scene]);
    let report: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    let nodes = report["holding_nodes"].as_array().unwrap();
    let floor = nodes.iter().find(|node| node["name"] == "floor").unwrap();
    assert_eq!(floor["holds"], serde_json::json!(["mesh"]));
    let by_number = format!("#{}", floor["index"]);
    let done = rayframe(&both(&render, &["--shadow-catcher", &by_number, "--background", "none"]));
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    assert!(stderr(&done).contains("background none"), "{}", stderr(&done));
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains(&format!("  {by_number} \"floor\" mesh\n")), "{shown}");
}

#[test]
fn options_that_do_nothing_say_so() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
    let said = |scene: &str, options: &[&str]| {
        let scene = format!("{root}{scene}");
        let arguments = ["render", &scene, "--dry-run", "--strict", "-o", "unwritten.####.exr"];
        let done = rayframe(&[&arguments[..], options].concat());
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        stderr(&done)
    };
    let unlit = "light/environment_only.gltf";
    for (scene, options, idle) in [
        (unlit, &["--env", "none", "--env-intensity", "2"][..], "--env-intensity"),
        (unlit, &["--light-scale", "2"], "--light-scale"),
        (unlit, &["--light-radius", "2"], "--light-radius"),
        (unlit, &["--env", "none", "--sun-angle", "2"], "--sun-angle"),
        (unlit, &["--shutter", "0.5"], "--shutter"),
        (unlit, &["--exposure", "1"], "--exposure"),
        (unlit, &["--tone", "standard"], "--tone"),
    ] {
        let said = said(scene, options);
        assert_eq!(said.matches("does nothing").count(), 1, "{said}");
        assert!(said.contains(&format!("{idle} does nothing: ")), "{said}");
    }
    for (scene, options) in [
        (unlit, &["--env", "studio", "--env-intensity", "2", "--sun-angle", "1"][..]),
        ("light/point.gltf", &["--light-scale", "2", "--light-radius", "0.1"]),
        ("light/directional.gltf", &["--sun-angle", "1"]),
        ("morph/weights.gltf", &["--shutter", "0.5", "--exposure", "1", "--preview", "png"]),
    ] {
        let said = said(scene, options);
        assert!(!said.contains("does nothing"), "{said}");
    }
}

#[test]
fn strict_says_each_thing_once_and_positions_may_be_plain() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.gltf");
    std::fs::write(&scene, r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["ACME_glow"]}"#).unwrap();
    let scene = scene.to_str().unwrap();
    assert_fails(&["render", scene, "--strict"], 65, "ACME_glow");
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains("lit by the studio"), "{shown}");
    let morph = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/morph/weights.gltf");
    let done =
        rayframe(&["render", morph, "--animation", "0", "--dry-run", "-f", "0", "-o", "unwritten.exr"]);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
}
