//! Several scenes, clips, cameras and variants in one run: names of files, collisions, failures, one exposure, and contact sheets.

mod refused_names;
mod variants;

use std::path::Path;
use std::process::{Command, Output};

use glam::Vec3;
use scene_builder::document::Gltf;
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::cuboid;
use scene_builder::staging::{Track, clip, directional_light, flat3, perspective};
use serde_json::Value;

use crate::names;
use crate::progress::schema::Schema;

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn rayframe(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    let size = ["-r", "32x18", "--samples", "1", "--depth", "1"];
    command.arg("render").args(size).args(arguments).current_dir(folder).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
fn assert_code(output: &Output, code: i32) -> String {
    let told = told(output);
    assert_eq!(output.status.code(), Some(code), "{told}");
    told
}

/// A cube.
fn still() -> Gltf {
    let mut gltf = Gltf::new("a cube");
    let material = Material::matte("grey", [0.5; 3]).add_to(&mut gltf);
    let mesh = cuboid(1.0, 1.0, 1.0).add_to(&mut gltf, material);
    gltf.node(Node::mesh(mesh).named("cube"));
    gltf
}

/// A cube under a light with clips that move it to the right, up to a frame, and cameras in front of it.
fn moving(clips: &[(&str, f32)], cameras: usize) -> Gltf {
    let mut gltf = still();
    directional_light(&mut gltf, Vec3::new(0.0, 0.0, 1.0), 40.0);
    for name in ["left", "right"].into_iter().take(cameras) {
        let lens = perspective(&mut gltf, 40.0, None);
        gltf.node(Node { camera: Some(lens), ..Node::default() }.named(name).at(0.0, 0.0, 4.0));
    }
    for &(name, distance) in clips {
        let times = [0.0, 1.0 / 24.0];
        let values = flat3(&[Vec3::ZERO, Vec3::new(distance, 0.0, 0.0)]);
        let track = Track { node: 0, path: "translation", interpolation: "LINEAR", times: &times, values };
        clip(&mut gltf, name, &[track]);
    }
    gltf
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn write(folder: &Path, name: &str, gltf: &Gltf) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, gltf.to_file_text()).unwrap();
}

#[test]
fn scenes_are_rendered_one_after_another_under_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "b.c.gltf", &still());
    write(folder, ".hidden.gltf", &still());
    std::fs::write(folder.join("shot.toml"), "scene = 'b.c.gltf'\noutput = 'own.{scene}.{shot}.exr'")
        .unwrap();
    let output = rayframe(folder, &["b.c.gltf", ".hidden.gltf", "-o", "thumbs/{scene}.{clip}.{camera}.png"]);
    let told = assert_code(&output, 0);
    assert_eq!(names(&folder.join("thumbs")), ["_hidden.all.auto.png", "b.c.all.auto.png"]);
    let lines: Vec<_> = told.lines().collect();
    assert!(lines.last().unwrap().starts_with("2 scenes: 2 frames written in "), "{told}");
    assert!(told.contains("frame 0 (2/2) written thumbs/_hidden"), "{told}");
    // A shot file has an output of its own; other scenes the default.
    let told = assert_code(&rayframe(folder, &["shot.toml", ".hidden.gltf"]), 0);
    assert!(told.contains("\n2 scenes: 2 frames written"), "{told}");
    assert!(folder.join("own.b.c.shot.exr").is_file() && folder.join(".hidden.exr").is_file());
    // All of it is kept, and names are filled for a single scene as well.
    let told = assert_code(&rayframe(folder, &["shot.toml", ".hidden.gltf"]), 0);
    assert!(told.contains("\n2 scenes: 0 frames written, 2 kept in "), "{told}");
    assert_code(&rayframe(folder, &["b.c.gltf", "-o", "{scene}.{clip}.exr", "--animation", "none"]), 0);
    assert!(folder.join("b.c.none.exr").is_file());
}

#[test]
fn files_of_one_name_are_refused_before_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["a.gltf", "x/a.gltf", "B.gltf", "x/b.gltf"] {
        write(folder, name, &still());
    }
    write(folder, "a.depth.gltf", &still());
    let before = names(folder);
    for (arguments, words) in [
        (&["a.gltf", "a.depth.gltf", "--aovs", "depth", "--split-aovs"][..], &["\"a.depth.exr\""][..]),
        (&["a.gltf", "B.gltf", "-o", "t.png"][..], &["a.gltf and B.gltf", "{scene}.t.png"][..]),
        (&["a.gltf", "B.gltf", "-o", "t/t.png"], &["such as t/{scene}.t.png"]),
        (&["a.gltf", "B.gltf", "--stats", "t/s.json"], &["such as t/{scene}.s.json"]),
        (&["a.gltf", "x/a.gltf"], &["a.gltf and x/a.gltf", "a.exr", "called \"a\"; rename one, or"]),
        (&["a.gltf", "x/a.gltf", "-o", "{scene}.png"], &["called \"a\"; rename one, or"]),
        (&["B.gltf", "x/b.gltf", "-o", "t.png"], &["called \"b\"; rename one, or"]),
        (&["a.gltf", "a.gltf"], &["it is named twice"]),
        (&["B.gltf", "x/b.gltf", "-o", "{scene}.png"], &["B.gltf and x/b.gltf", "case"]),
        (&["a.gltf", "B.gltf", "--stats", "s.json"], &["--stats", "{scene}.s.json"]),
        (&["a.gltf", "B.gltf", "--manifest", "s.json", "--keep-going"], &["--manifest", "{scene}.s.json"]),
        (&["a.gltf", "B.gltf", "-o", "{scene}.png", "--movie", "m.gif"], &["--movie", "{scene}.m.gif"]),
        (&["a.gltf", "B.gltf", "-o", "{scene}.png", "--stats", "a.png"], &["--stats"]),
        (&["a.gltf", "B.gltf", "-o", "{scene}.png", "--stats", "{scene}.gltf", "--overwrite"], &["input"]),
        (&["a.gltf", "B.gltf", "-o", "{scene}.png", "-f", "0-2"], &["a.gltf: ", "####", "--frames"]),
    ] {
        let told = assert_code(&rayframe(folder, arguments), 2);
        assert_eq!(told.lines().count(), 1, "{arguments:?}: {told}");
        for word in words {
            assert!(told.contains(word), "{arguments:?}: {told}");
        }
        assert_eq!(names(folder), before, "{arguments:?}");
    }
    // A movie shows all frames.
    write(folder, "m.gltf", &moving(&[("walk", 0.5)], 1));
    let movie = ["m.gltf", "-o", "{scene}.png", "--movie", "{scene}.gif"];
    let told = assert_code(&rayframe(folder, &movie), 2);
    assert!(told.contains("####") && !folder.join("m.gif").exists(), "{told}");
    assert_code(&rayframe(folder, &crate::both(&movie, &["-f", "1"])), 0);
    for name in ["m.gltf", "m.png", "m.gif"] {
        std::fs::remove_file(folder.join(name)).unwrap();
    }
    // Files of something else are found before the first frame, too.
    std::fs::write(folder.join("B.exr"), "something").unwrap();
    let is_found = |options: &[&str]| {
        let told = assert_code(&rayframe(folder, &[&["a.gltf", "B.gltf"], options].concat()), 73);
        assert!(told.contains("B.exr") && !folder.join("a.exr").exists(), "{options:?}: {told}");
    };
    is_found(&[]);
    is_found(&["--resume"]);
    std::fs::remove_file(folder.join("B.exr")).unwrap();
    std::fs::create_dir(folder.join("B.exr")).unwrap();
    is_found(&[]);
    is_found(&["--resume"]);
    std::fs::remove_dir(folder.join("B.exr")).unwrap();
    std::fs::write(folder.join("B.exr.checkpoint"), "something").unwrap();
    is_found(&["--integrator", "path", "--checkpoint"]);
}

#[test]
fn a_broken_scene_stops_all_or_only_itself() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "a.gltf", &still());
    write(folder, "c.gltf", &still());
    std::fs::write(folder.join("b.gltf"), "{").unwrap();
    let scenes =
        ["a.gltf", "b.gltf", "gone.glb", "c.gltf", "-o", "{scene}.png", "--contact-sheet", "all.png"];
    let told = assert_code(&rayframe(folder, &scenes), 65);
    assert!(told.contains("b.gltf: ") && told.lines().count() == 1, "{told}");
    assert_eq!(names(folder), ["a.gltf", "b.gltf", "c.gltf"]);
    let stopped = rayframe(folder, &crate::both(&scenes, &["--progress", "json"]));
    let told = String::from_utf8_lossy(&stopped.stdout).into_owned();
    let events: Vec<Value> = told.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(events.iter().map(|event| &event["event"]).collect::<Vec<_>>(), ["scene_failed", "total"]);
    assert_eq!(events[0]["scene"], events[1]["failed_scenes"][0]["scene"]);
    let schema = Schema::read("progress");
    let output = rayframe(folder, &crate::both(&scenes, &["--keep-going", "--progress", "json"]));
    let told = assert_code(&output, 65);
    assert_eq!(told.lines().filter(|line| line.contains("error: ")).count(), 2, "{told}");
    assert_eq!(names(folder), ["a.gltf", "a.png", "all.png", "b.gltf", "c.gltf", "c.png"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let events: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for event in &events {
        schema.check(event);
    }
    let total = events.last().unwrap();
    assert_eq!(
        (&total["event"], &total["scenes"], &total["written"]),
        (&"total".into(), &4.into(), &2.into())
    );
    assert_eq!(total["failed_scenes"][1]["scene"], "gone.glb");
    let done: Vec<_> = events.iter().filter(|event| event["event"] == "frame_done").collect();
    assert_eq!(done.iter().map(|event| &event["scene"]).collect::<Vec<_>>(), ["a.gltf", "c.gltf"]);
    // The exit code does not depend on the order.
    for scenes in [["b.gltf", "gone.glb"], ["gone.glb", "b.gltf"]] {
        assert_code(&rayframe(folder, &crate::both(&scenes, &["-o", "{scene}.png", "--keep-going"])), 65);
    }
    std::fs::create_dir(folder.join("models")).unwrap();
    let told = assert_code(&rayframe(folder, &["models"]), 65);
    assert!(told.contains("models: is a folder; name a file, such as models/*.glb"), "{told}");
    // A setting that one scene has no meaning for names the scene.
    let told = assert_code(&rayframe(folder, &["a.gltf", "c.gltf", "--camera", "cam"]), 2);
    assert!(told.contains("error: a.gltf: --camera: "), "{told}");
}

#[test]
fn each_clip_and_each_camera_is_a_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "m.gltf", &moving(&[("walk", 0.5), ("a/b|c", 1.0)], 2));
    write(folder, "s.gltf", &still());
    assert_code(&rayframe(folder, &["m.gltf", "--animation", "each"]), 0);
    let clips = ["m.a_b_c.0000.exr", "m.a_b_c.0001.exr", "m.walk.0000.exr", "m.walk.0001.exr"];
    let images: Vec<_> = names(folder).into_iter().filter(|name| !name.ends_with("gltf")).collect();
    assert_eq!(images, clips);
    // Each clip is what it is alone where the file has a camera.
    assert_code(&rayframe(folder, &["m.gltf", "--animation", "walk", "-o", "w/a.#.exr"]), 0);
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert!(read("w/a.1.exr") == read("m.walk.0001.exr"));
    // Products; a scene without clips and cameras is one sequence.
    let each = ["--animation", "each", "--camera", "each", "-f", "0"];
    let told = assert_code(
        &rayframe(folder, &crate::both(&["m.gltf", "s.gltf", "-o", "p/{scene}.{clip}.{camera}.png"], &each)),
        0,
    );
    assert_eq!(
        names(&folder.join("p")),
        ["m.a_b_c.left.png", "m.a_b_c.right.png", "m.walk.left.png", "m.walk.right.png", "s.none.auto.png"]
    );
    assert!(told.contains("2 scenes: 5 frames written in "), "{told}");
    assert_code(&rayframe(folder, &crate::both(&["s.gltf"], &each)), 0);
    assert!(folder.join("s.exr").is_file());
    // One exposure for all clips and cameras, and a frame of its own for each on the sheet.
    let told = assert_code(
        &rayframe(
            folder,
            &crate::both(&["m.gltf", "-o", "q/{clip}.{camera}.png", "--contact-sheet", "q.png"], &each),
        ),
        0,
    );
    let exposures: std::collections::BTreeSet<_> =
        told.lines().filter(|line| line.starts_with("exposure ")).collect();
    assert_eq!(exposures.len(), 1, "{told}");
    let sheet = image::open(folder.join("q.png")).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (4 + 2 * (64 + 4), 4 + 2 * (18 + 18 + 4)));
    // Names that a pattern needs.
    for (arguments, word) in [
        (&["m.gltf", "--animation", "each", "-o", "a.####.exr"][..], "{clip}.a.####.exr"),
        (&["m.gltf", "--camera", "each", "-o", "a.####.exr"], "{camera}.a.####.exr"),
        (&["m.gltf", "--animation", "each", "--movie", "m.gif"], "{clip}.m.gif"),
    ] {
        let told = assert_code(&rayframe(folder, arguments), 2);
        assert!(told.contains(word) && told.lines().count() == 1, "{told}");
    }
    let each = ["m.gltf", "--animation", "each", "--camera", "each", "-o", "t/{clip}.####.exr"];
    let told = assert_code(&rayframe(folder, &each), 2);
    assert!(told.contains("such as t/{camera}.{clip}.####.exr"), "{told}");
    // Clips and cameras tell no scenes apart.
    write(folder, "x/m.gltf", &moving(&[("run", 0.5)], 0));
    let told =
        assert_code(&rayframe(folder, &["m.gltf", "x/m.gltf", "--animation", "each", "-o", "a.####.png"]), 2);
    assert!(told.contains("{clip}.a.####.png"), "{told}");
    let told = assert_code(&rayframe(folder, &["m.gltf", "x/m.gltf", "-f", "0", "-o", "a.png"]), 2);
    assert!(told.contains("called \"m\"; rename one, or render them to different folders"), "{told}");
}

#[test]
fn clips_and_cameras_of_one_name_are_numbered() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "two.gltf", &moving(&[("walk", 0.5), ("walk", 1.0), ("run", 1.0)], 1));
    let each = ["two.gltf", "--animation", "each", "-f", "0"];
    let told = assert_code(&rayframe(folder, &crate::both(&each, &["-o", "t/{clip}.png"])), 0);
    assert_eq!(names(&folder.join("t")), ["run.png", "walk (2).png", "walk.png"], "{told}");
    for name in ["walk", "walk (2)", "run"] {
        assert!(told.contains(&format!("two.gltf: clip \"{name}\" ")), "{told}");
    }
    // Clips of equal names tell that the name of a file lacks them, too.
    let told = assert_code(&rayframe(folder, &crate::both(&each, &["-o", "a.png"])), 2);
    assert!(told.contains("clip \"walk (2)\" would both") && told.contains("{clip}.a.png"), "{told}");
    // Some file systems do not tell their case apart.
    write(folder, "case.gltf", &moving(&[("walk", 0.5), ("Walk", 1.0)], 1));
    let each = ["case.gltf", "--animation", "each", "-f", "0", "-o", "case/{clip}.png"];
    let told = assert_code(&rayframe(folder, &each), 0);
    assert_eq!(names(&folder.join("case")), ["Walk (2).png", "walk.png"], "{told}");
    // Names that differ only in what names of files cannot have.
    write(folder, "slash.gltf", &moving(&[("a/b", 0.5), ("a:b", 1.0)], 1));
    let told = assert_code(&rayframe(folder, &["slash.gltf", "--animation", "each"]), 2);
    assert!(told.contains("names are equal in names of files") && told.contains("'#1'"), "{told}");
}

/// Without a camera in the file, all clips are framed alike: so that the longest way stays in the image.
#[test]
fn clips_share_the_automatic_camera() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "m.gltf", &moving(&[("near", 0.1), ("far", 30.0)], 0));
    let rules = |arguments: &[&str]| {
        let told = assert_code(&rayframe(folder, &crate::both(&["m.gltf", "-n"], arguments)), 0);
        let rule = |line: &str| line.split_once("camera auto").map(|(_, rule)| rule.to_owned());
        told.lines().filter_map(rule).collect::<Vec<_>>()
    };
    let each = rules(&["--animation", "each"]);
    assert!(each.len() == 2 && each[0] == each[1], "{each:?}");
    assert_ne!(rules(&["--animation", "near"]), each[..1]);
    // Tone-mapped files of a clip alone are others, because their exposure is.
    let png = ["-o", "{clip}.####.png"];
    assert_code(&rayframe(folder, &crate::both(&["m.gltf", "--animation", "each"], &png)), 0);
    let told = assert_code(&rayframe(folder, &crate::both(&["m.gltf", "--animation", "far"], &png)), 73);
    assert!(told.contains("far.0000.png"), "{told}");
}

#[test]
fn a_dry_run_prints_every_scene() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "m.gltf", &moving(&[("walk", 0.5), ("run", 1.0)], 1));
    write(folder, "s.gltf", &still());
    let each = ["m.gltf", "s.gltf", "--animation", "each", "-n"];
    let output = rayframe(folder, &crate::both(&each, &["--progress", "json"]));
    assert_code(&output, 0);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let plans: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(plans.len(), 2);
    assert_eq!((&plans[0]["scene"], &plans[0]["settings"]["animation"]), (&"m.gltf".into(), &"each".into()));
    assert_eq!(plans[0]["frames"].as_array().unwrap().len(), 4);
    assert_eq!((&plans[0]["frames"][3]["clip"], &plans[0]["frames"][3]["frame"]), (&"run".into(), &1.into()));
    assert_eq!(names(folder), ["m.gltf", "s.gltf"]);
    // The text of one scene makes the same files.
    let output = rayframe(folder, &["m.gltf", "--animation", "each", "-n"]);
    std::fs::write(folder.join("printed.toml"), &output.stdout).unwrap();
    assert_code(&rayframe(folder, &["printed.toml"]), 0);
    let output = rayframe(folder, &["m.gltf", "--animation", "each", "-n"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(text.matches(" s keep ").count(), 4, "{text}");
    // A dry run of several is one text a scene.
    let text = String::from_utf8_lossy(&rayframe(folder, &each).stdout).into_owned();
    assert_eq!(text.matches("\nscene = ").count(), 2, "{text}");
}

#[test]
fn reports_have_a_file_each_and_name_the_clip() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "m.gltf", &moving(&[("walk", 0.5), ("run", 1.0)], 1));
    let options =
        ["--stats", "{clip}.stats.json", "--manifest", "{scene}.{clip}.json", "--movie", "{clip}.gif"];
    let told = assert_code(&rayframe(folder, &crate::both(&["m.gltf", "--animation", "each"], &options)), 0);
    for name in ["walk.stats.json", "run.stats.json", "m.walk.json", "m.run.json", "walk.gif", "run.gif"] {
        assert!(folder.join(name).is_file(), "{name}: {told}");
    }
    let manifest: Value = serde_json::from_slice(&std::fs::read(folder.join("m.run.json")).unwrap()).unwrap();
    Schema::read("manifest").check(&manifest);
    assert_eq!(manifest["clip"], "run");
}

#[test]
fn one_sequence_is_needed_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "m.gltf", &moving(&[("walk", 0.5), ("run", 1.0)], 1));
    let watch = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        command.arg("watch").args(arguments).current_dir(folder).output().unwrap()
    };
    let told = assert_code(&watch(&["m.gltf", "--animation", "each"]), 2);
    assert!(told.contains("--animation: each makes several sequences"), "{told}");
    assert_eq!(watch(&["m.gltf", "m.gltf"]).status.code(), Some(2));
    std::fs::create_dir(folder.join("suite")).unwrap();
    std::fs::write(folder.join("suite/suite.toml"), "").unwrap();
    std::fs::write(folder.join("suite/a.toml"), "scene = '../m.gltf'\ncamera = 'each'").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    let output = command.args(["test", "--suite", "suite"]).current_dir(folder).output().unwrap();
    let both = format!("{}{}", told_all(&output), told);
    assert!(
        output.status.code() != Some(0) && both.contains("camera: each makes several sequences"),
        "{both}"
    );
}

fn told_all(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), told(output))
}

#[cfg(unix)]
#[test]
fn scene_names_need_not_be_unicode() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = tempfile::tempdir().unwrap();
    let name = std::ffi::OsStr::from_bytes(b"\xff:a.gltf");
    std::fs::write(folder.path().join(name), still().to_file_text()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    let output = command
        .args(["render", "-r", "16x9", "--samples", "1", "-o", "{scene}.exr"])
        .arg(name)
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_code(&output, 0);
    let expected = std::ffi::OsStr::from_bytes(b"\xff_a.exr");
    assert!(folder.path().join(expected).is_file());
}
