//! `rayframe diff`: images, sequences, AOVs, difference maps and exit codes.

mod assets;
mod report;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rayframe::image::PixelWindow;
use rayframe::regression::{Channel, ColorEncoding, Image, Samples};
use serde_json::Value;

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn rayframe(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rayframe")).args(arguments).output().unwrap()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A folder of images.
struct Stage(tempfile::TempDir);

impl Stage {
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    /// Writes a grey image with a brighter square at `column`.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn square(&self, name: &str, size: (u32, u32), column: u32) -> String {
        let pixel = |at: u32| {
            let (x, y) = (at % size.0, at / size.0);
            let value = if (column..column + 8).contains(&x) && (8..16).contains(&y) { 0.8 } else { 0.2 };
            [value, value, value, 1.0]
        };
        let pixels: Vec<_> = (0..size.0 * size.1).map(pixel).collect();
        let image = Image::from_rgba(size, ColorEncoding::Linear, &pixels);
        image.write(Path::new(&self.at(name))).unwrap();
        self.at(name)
    }

    /// Renders a changed scene with AOVs.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn rendered(&self, name: &str, scene: &str, change: impl Fn(&mut Value), options: &[&str]) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let mut text: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        change(&mut text);
        let scene: PathBuf = self.0.path().join("changed.gltf");
        std::fs::write(&scene, text.to_string()).unwrap();
        let (scene, file) = (scene.display().to_string(), self.at(name));
        let layers = "depth,normal,geometric_normal,albedo,node_id,material_id,object_id";
        let fixed = [
            "render",
            &scene,
            "-o",
            &file,
            "-r",
            "96x54",
            "-f",
            "0",
            "-q",
            "--overwrite",
            "--layers",
            layers,
        ];
        let output = rayframe(&[&fixed[..], options].concat());
        assert!(output.status.success(), "{output:?}");
        file
    }
}

#[test]
fn two_images_match_or_differ_with_value_and_limit() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (40, 24), 4);
    let b = stage.square("b.exr", (40, 24), 24);
    let output = rayframe(&["diff", &a, &a]);
    assert_eq!((output.status.code(), printed(&output).starts_with("identical: ")), (Some(0), true));
    let output = rayframe(&["diff", &b, &a]);
    let told = printed(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.starts_with("failed (preset visual): "), "{told}");
    assert!(
        told.contains("  FAIL FLIP of the worst tile: 0.") && told.contains(" > 0.1, worst at column "),
        "{told}"
    );
    assert!(told.contains("  ok   difference of mean brightness: 0 <= 0.03"), "{told}");
}

#[test]
fn images_beyond_the_memory_limit_are_refused() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (400, 240), 4);
    assert_eq!(rayframe(&["diff", &a, &a, "--max-memory", "100M"]).status.code(), Some(0));
    let output = rayframe(&["diff", &a, &a, "--max-memory", "1M"]);
    assert_eq!(output.status.code(), Some(77));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("more than the limit of 500.0 kB"), "{message}");
    // A page reads files without a counterpart, too.
    for folder in ["new", "old"] {
        std::fs::create_dir(stage.at(folder)).unwrap();
        stage.square(&format!("{folder}/a.0001.exr"), (8, 8), 4);
    }
    std::fs::rename(&a, stage.at("new/a.0002.exr")).unwrap();
    let report = ["--report", &stage.at("report"), "--max-memory", "1M"];
    let output = rayframe(&[&["diff", &stage.at("new"), &stage.at("old")], &report[..]].concat());
    assert_eq!(output.status.code(), Some(77), "{output:?}");
}

#[test]
fn json_and_maps_locate_differences() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (40, 24), 4);
    let b = stage.square("b.exr", (40, 24), 24);
    let (heat, flip) = (stage.at("heat.png"), stage.at("flip.exr"));
    let output =
        rayframe(&["diff", &b, &a, "--json", "--preset", "strict", "--heat-map", &heat, "--flip-map", &flip]);
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    assert_eq!(
        (&report["schema"], &report["same"], &report["preset"]),
        (&1.into(), &false.into(), &"strict".into())
    );
    let frame = &report["frames"][0];
    assert_ne!(frame["actual_hash"], frame["reference_hash"]);
    // Two squares of 64 pixels each.
    assert_eq!(frame["layers"][0]["different_pixels"], 128);
    assert!(frame["checks"].as_array().unwrap().iter().any(|check| check["passes"] == false));
    let map = Image::read(Path::new(&flip)).unwrap();
    let Samples::Float(errors) = &map.channels[0].samples else { panic!("no numbers") };
    let mean = errors.iter().map(|&error| f64::from(error)).sum::<f64>() / errors.len() as f64;
    assert_eq!(report["series"]["mean_flip"][0].as_f64(), Some(mean));
    let heat = Image::read(Path::new(&heat)).unwrap();
    let red = heat.colors().unwrap();
    assert!(red[12 * 40 + 8][0] > 0.4 && red[22 * 40 + 38][0] < 0.2, "{:?}", red[12 * 40 + 8]);
}

#[test]
fn differences_of_crops_are_told_and_mapped_in_the_whole_image() {
    let stage = Stage::new();
    let cropped = |name: &str, column: u32| {
        let path = stage.square(name, (40, 24), column);
        let mut image = Image::read(Path::new(&path)).unwrap();
        image.display_window = PixelWindow::full(200, 150);
        image.data_window = PixelWindow { x0: 100, y0: 50, x1: 140, y1: 74 };
        image.write(Path::new(&path)).unwrap();
        (path, image)
    };
    let ((a, reference), (b, _)) = (cropped("a.exr", 4), cropped("b.exr", 24));
    let flip = stage.at("flip.exr");
    let output = rayframe(&["diff", &b, &a, "--json", "--preset", "strict", "--flip-map", &flip]);
    let report = json(&output);
    let channels = report["frames"][0]["layers"][0]["channels"].as_array().unwrap();
    let differing = channels.iter().find(|channel| channel["largest"].as_f64() > Some(0.0)).unwrap();
    let at = &differing["largest_at"];
    assert_eq!((at[0].as_u64(), at[1].as_u64()), (Some(104), Some(58)));
    let map = Image::read(Path::new(&flip)).unwrap();
    assert_eq!([map.display_window, map.data_window], [reference.display_window, reference.data_window]);
}

#[test]
fn sequences_are_matched_by_frame_and_missing_frames_are_named() {
    let stage = Stage::new();
    for (frame, column) in [(1, 4), (2, 4), (3, 24)] {
        stage.square(&format!("new/a.{frame:04}.exr"), (40, 24), column);
    }
    for frame in [1, 2, 3, 4] {
        stage.square(&format!("old/b_{frame}.exr"), (40, 24), 4);
    }
    let (new, old) = (stage.at("new/a.####.exr"), stage.at("old/b_%d.exr"));
    let output = rayframe(&["diff", &new, &old]);
    let told = printed(&output);
    assert_eq!(output.status.code(), Some(1));
    assert!(told.contains("mean FLIP   ▁▁█"), "{told}");
    assert!(told.contains("missing in the first: the frame of ") && told.contains("b_4.exr"), "{told}");
    let counts = "failed (preset visual): 2 frames identical, 0 changed within limits, 1 failed, 1 missing";
    assert!(told.contains(counts), "{told}");
    let heat = stage.at("heat.####.png");
    let report =
        json(&rayframe(&["diff", &stage.at("new"), &stage.at("old"), "--json", "--heat-map", &heat]));
    assert_eq!(report["series"]["frame"], serde_json::json!([1, 2, 3]));
    assert!(Path::new(&stage.at("heat.0003.png")).exists());
    std::fs::remove_file(stage.at("old/b_4.exr")).unwrap();
    std::fs::remove_file(stage.at("old/b_3.exr")).unwrap();
    std::fs::remove_file(stage.at("new/a.0003.exr")).unwrap();
    assert_eq!(rayframe(&["diff", &new, &old, "--preset", "exact"]).status.code(), Some(0));
}

#[test]
fn missing_channels_are_told_once() {
    let stage = Stage::new();
    for (frame, names) in [(1, &["Z", "U", "V"][..]), (2, &["Z", "U", "V"]), (3, &["Z"])] {
        let name = format!("old/a.{frame}.exr");
        stage.square(&format!("new/a.{frame}.exr"), (40, 24), if frame == 3 { 24 } else { 4 });
        let mut image = Image::read(Path::new(&stage.square(&name, (40, 24), 4))).unwrap();
        for name in names {
            let channel = Channel { name: (*name).to_owned(), ..image.channels[0].clone() };
            image.channels.push(channel);
        }
        image.write(Path::new(&stage.at(&name))).unwrap();
    }
    let (new, old) = (stage.at("new"), stage.at("old"));
    let told = printed(&rayframe(&["diff", &new, &old]));
    for line in [
        "FAIL 2 frames: lacks the channels U, V of the reference",
        "FAIL 3 frames: lacks the channel Z of the reference",
    ] {
        assert_eq!(told.lines().filter(|told| *told == line).count(), 1, "{told}");
    }
    // The table and these lines are all about the frames without other failures.
    assert!(!told.contains(&stage.at("new/a.1.exr")) && told.contains(&stage.at("new/a.3.exr")), "{told}");
    assert_eq!(told.matches("channel").count(), 5, "{told}");
    let report = json(&rayframe(&["diff", &new, &old, "--json"]));
    assert_eq!(report["frames"][0]["failures"].as_array().unwrap().len(), 3);
    // One image.
    let told = printed(&rayframe(&["diff", &stage.at("old/a.1.exr"), &stage.at("new/a.1.exr")]));
    assert!(told.contains("  FAIL has the channels U, V, Z, which the reference lacks\n"), "{told}");
}

#[test]
fn the_first_line_says_which_is_the_reference() {
    let stage = Stage::new();
    for (name, column) in [("old/a.1.exr", 4), ("new/a.1.exr", 24)] {
        stage.square(name, (40, 24), column);
    }
    let first = |new: &str, old: &str| {
        let told = printed(&rayframe(&["diff", new, old]));
        told.lines().next().unwrap_or_default().to_owned()
    };
    let (new, old) = (stage.at("new"), stage.at("old"));
    assert_eq!(first(&new, &old), format!("{new} against the reference {old}"));
    let (new, old) = (stage.at("new/a.1.exr"), stage.at("old/a.1.exr"));
    assert_eq!(first(&new, &old), format!("failed (preset visual): {new} against the reference {old}"));
    assert_eq!(first(&old, &old), format!("identical: {old} against the reference {old}"));
}

#[test]
fn folders_below_are_compared() {
    let stage = Stage::new();
    for (name, column) in [("new/a", 4), ("old/a", 4), ("new/sub/b", 4), ("old/sub/b", 24), ("old/sub/c", 4)]
    {
        stage.square(&format!("{name}.exr"), (40, 24), column);
    }
    let output = rayframe(&["diff", &stage.at("new"), &stage.at("old")]);
    let told = printed(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(
        told.contains(&format!("missing in the first: the frame of {}", stage.at("old/sub/c.exr"))),
        "{told}"
    );
    let failed =
        format!("{} against the reference {}:", stage.at("new/sub/b.exr"), stage.at("old/sub/b.exr"));
    assert!(told.contains(&failed), "{told}");
    assert!(told.contains("1 frame identical, 0 changed within limits, 1 failed, 1 missing"), "{told}");
}

#[test]
fn exit_codes_distinguish_usage_bad_files_and_missing_files() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (40, 24), 4);
    let wide = stage.square("wide.exr", (48, 24), 4);
    let text = stage.at("a.txt");
    std::fs::write(&text, "hello").unwrap();
    let code = |arguments: &[&str]| rayframe(&[&["diff"], arguments].concat()).status.code();
    let output = rayframe(&["diff", &a, &wide, "--heat-map", &stage.at("none.png")]);
    assert!(!Path::new(&stage.at("none.png")).exists());
    assert!(printed(&output).contains("the size is 40x24, the reference's 48x24"));
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(code(&[&a]), Some(2));
    assert_eq!(code(&[&a, &a, "--preset", "loose"]), Some(2));
    for (option, value, remedy) in [
        ("--mean-flip", "-1", "write a number from 0 to 1, or inf for no limit"),
        ("--tile-flip", "1.5", "write a number from 0 to 1, or inf for no limit"),
        ("--object-flip", "x", "write a number from 0 to 1, or inf for no limit"),
        ("--brightness", "-0.5", "write a number from 0, or inf for no limit"),
    ] {
        let output = rayframe(&["diff", &a, &a, option, value]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && message.contains(remedy), "{message}");
    }
    assert_eq!(code(&[&a, &a, "--mean-flip", "1", "--tile-flip", "inf", "--brightness", "3"]), Some(0));
    assert_eq!(code(&[&a, &a, "--layers", "depth"]), Some(2));
    assert_eq!(code(&[&a, &a, "--aovs", "depth"]), Some(2));
    for (option, name, ending) in [
        ("--heat-map", "heat.exr", ".png"),
        ("--heat-map", "heat.jpg", ".png"),
        ("--heat-map", "heat", ".png"),
        ("--flip-map", "map.png", ".exr"),
    ] {
        let output = rayframe(&["diff", &a, &a, option, name]);
        let told = String::from_utf8_lossy(&output.stderr);
        let expected = format!("{option} {name}: end it with {ending}\n");
        assert!(output.status.code() == Some(2) && told.ends_with(&expected), "{told}");
    }
    assert_eq!(code(&[&a, &stage.at("")]), Some(2));
    assert_eq!(code(&[&a, &text]), Some(65));
    assert_eq!(code(&[&a, &stage.at("gone.exr")]), Some(66));
    assert_eq!(code(&[&a, &a, "--heat-map", &stage.at("gone/../a.exr/heat.png")]), Some(73));
}

#[test]
fn aovs_show_the_cause_of_a_change() {
    let stage = Stage::new();
    let kind = |actual: &str, reference: &str| {
        let report = json(&rayframe(&["diff", actual, reference, "--json", "--preset", "exact"]));
        report["frames"][0]["cause"]["kind"].as_str().unwrap_or_default().to_owned()
    };
    let squares = "texture/base_color_srgb.gltf";
    let intact = stage.rendered("intact.exr", squares, |_| {}, &[]);
    let swapped = |scene: &mut Value| {
        scene["textures"][0]["source"] = 1.into();
        scene["textures"][1]["source"] = 0.into();
    };
    assert_eq!(kind(&stage.rendered("swapped.exr", squares, swapped, &[]), &intact), "material");
    let balls = "material/metal_roughness_row.gltf";
    let intact = stage.rendered("balls.exr", balls, |_| {}, &[]);
    let moved = |scene: &mut Value| scene["nodes"][4]["translation"] = serde_json::json!([0.0, 1.5, 0.0]);
    assert_eq!(kind(&stage.rendered("moved.exr", balls, moved, &[]), &intact), "geometry");
    let lit = stage.rendered("lit.exr", "light/point.gltf", |_| {}, &[]);
    let brighter = stage.rendered("brighter.exr", "light/point.gltf", |_| {}, &["--light-scale", "1.3"]);
    assert_eq!(kind(&brighter, &lit), "light");
    // Depth has no map, which is told once, and not by --quiet where nothing fails.
    let told = |options: &[&str]| {
        let maps = ["--heat-map", &stage.at("none.png"), "--flip-map", &stage.at("none.exr")];
        let fixed = ["diff", &lit, &lit, "--aovs", "depth"];
        let output = rayframe(&[&fixed[..], &maps[..], options].concat());
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8_lossy(&output.stderr).matches("no map, because they have no colours").count()
    };
    assert_eq!((told(&[]), told(&["--quiet"])), (1, 0));
    // Only the selected AOVs count.
    let code = |aovs| rayframe(&["diff", &brighter, &lit, "--preset", "exact", "--aovs", aovs]).status.code();
    assert_eq!((code("data"), code("beauty"), code("depth,albedo")), (Some(0), Some(1), Some(0)));
}

#[test]
fn images_that_changed_within_limits_are_told_from_identical_ones() {
    let stage = Stage::new();
    let write = |name: &str, value: f32| {
        let image = Image::from_rgba((40, 24), ColorEncoding::Linear, &vec![[value, value, value, 1.0]; 960]);
        image.write(Path::new(&stage.at(name))).unwrap();
        stage.at(name)
    };
    let (old, new) = (write("old.exr", 0.5), write("new.exr", 0.501));
    let output = rayframe(&["diff", &new, &old]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(printed(&output).starts_with("changed within limits (preset visual): "), "{output:?}");
    let report = json(&rayframe(&["diff", &new, &old, "--json"]));
    assert_eq!((&report["same"], &report["verdict"]), (&true.into(), &"changed".into()));
    assert_eq!(
        (&report["frames"][0]["verdict"], &report["frames"][0]["cause"]["kind"]),
        (&"changed".into(), &"light".into())
    );
    // One word of the command line makes the change a failure.
    let code = |actual: &str| rayframe(&["diff", actual, &old, "--fail-on", "changed"]).status.code();
    assert_eq!((code(&new), code(&old)), (Some(1), Some(0)));
    assert_eq!(rayframe(&["diff", &new, &old, "--fail-on", "different"]).status.code(), Some(2));
    // Quiet where nothing fails.
    let quiet = |more: &[&str]| {
        let output = rayframe(&[&["diff", &new, &old, "-q"], more].concat());
        (output.status.code(), printed(&output).lines().next().unwrap_or_default().to_owned())
    };
    assert_eq!(quiet(&[]), (Some(0), String::new()));
    let (code, line) = quiet(&["--fail-on", "changed"]);
    assert!(code == Some(1) && line.starts_with("changed within limits"), "{line}");
    assert_eq!(quiet(&["--json"]), (Some(0), "{".to_owned()));
    // The page shows changed images.
    let folder = stage.at("report");
    rayframe(&["diff", &new, &old, "--report", &folder]);
    let page = std::fs::read_to_string(format!("{folder}/index.html")).unwrap();
    assert!(page.contains("<h2>Changed within limits</h2>") && page.contains("id=\"image-2\""));
    assert!(!page.contains("<h2>Failed</h2>"));
}
