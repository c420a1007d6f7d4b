//! Each material variant of a scene in one run.

use std::path::Path;

use serde_json::Value;

use super::{assert_code, rayframe, told_all};
use crate::progress::schema::Schema;
use crate::{both, names, rayframe as program};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/material/variants.gltf");
const EACH: [&str; 2] = ["--variant", "each"];

/// The scene with variants, without its camera.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn without_camera() -> Value {
    let mut scene: Value = serde_json::from_slice(&std::fs::read(SCENE).unwrap()).unwrap();
    scene.as_object_mut().unwrap().remove("cameras");
    scene["nodes"][0].as_object_mut().unwrap().remove("camera");
    scene
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn each_variant_is_a_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let told = assert_code(&rayframe(folder, &both(&[SCENE], &EACH)), 0);
    assert_eq!(names(folder), ["variants.gold.exr", "variants.red.exr"], "{told}");
    // Each is what it is alone.
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    for (name, alone) in [("gold", "#1"), ("red", "red")] {
        let output = format!("alone.{name}.exr");
        assert_code(&rayframe(folder, &[SCENE, "--variant", alone, "-o", &output]), 0);
        assert!(read(&output) == read(&format!("variants.{name}.exr")), "{name}");
    }
    assert_ne!(read("variants.gold.exr"), read("variants.red.exr"));
    assert_code(&rayframe(folder, &[SCENE, "--variant", "red", "-o", "{scene}-{variant}.png"]), 0);
    assert!(folder.join("variants-red.png").is_file());
    // A scene without variants has its own materials.
    super::write(folder, "s.gltf", &super::still());
    assert_code(&rayframe(folder, &both(&["s.gltf"], &EACH)), 0);
    assert!(folder.join("s.exr").is_file());
    assert_code(&rayframe(folder, &both(&["s.gltf", "-o", "s.{variant}.exr"], &EACH)), 0);
    assert!(folder.join("s.none.exr").is_file());
}

#[test]
fn variants_follow_clips_and_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut scene =
        serde_json::from_str::<Value>(&super::moving(&[("walk", 0.5)], 2).to_file_text()).unwrap();
    scene["extensions"]["KHR_materials_variants"] =
        serde_json::json!({"variants": [{"name": "a/b"}, {"name": "c"}, {"name": "C"}]});
    scene["extensionsUsed"].as_array_mut().unwrap().push("KHR_materials_variants".into());
    std::fs::write(folder.join("m.gltf"), scene.to_string()).unwrap();
    let each = both(&["m.gltf", "--animation", "each", "--camera", "each", "-f", "0"], &EACH);
    assert_code(&rayframe(folder, &each), 0);
    let variants = ["C (2)", "a_b", "c"];
    let of_camera = |camera: &str| variants.map(|variant| format!("m.walk.{camera}.{variant}.0000.exr"));
    let expected: Vec<_> = ["left", "right"].into_iter().flat_map(of_camera).collect();
    assert_eq!(names(folder)[1..], expected);
    // Their order.
    let plan =
        rayframe(folder, &both(&each, &["-n", "--progress", "json", "-o", "{clip}.{camera}.{variant}.exr"]));
    assert_code(&plan, 0);
    let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
    Schema::read("progress").check(&plan);
    assert_eq!(plan["settings"]["variant"], "each");
    let paths: Vec<_> =
        plan["frames"].as_array().unwrap().iter().map(|frame| frame["path"].as_str().unwrap()).collect();
    let expected = ["left.a_b", "left.c", "left.C (2)", "right.a_b", "right.c", "right.C (2)"];
    assert_eq!(paths, expected.map(|name| format!("walk.{name}.exr")));
    let keys = ["clip", "camera", "variant"].map(|key| plan["frames"][3][key].as_str().unwrap());
    assert_eq!(keys, ["walk", "right", "a/b"]);
    // A name that lacks the variant.
    let told = assert_code(&rayframe(folder, &both(&each, &["-o", "t/{clip}.{camera}.exr"])), 2);
    let expected = "m.gltf clip \"walk\", camera \"left\", variant \"a/b\" and \
                    m.gltf clip \"walk\", camera \"left\", variant \"c\" would both be written to";
    assert!(told.contains(expected), "{told}");
    assert!(told.contains("put {variant} in the name, such as t/{variant}.{clip}.{camera}.exr"), "{told}");
    assert!(!folder.join("t").exists());
}

#[test]
fn reports_name_the_variant() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let reports = ["--stats", "{variant}.stats.json", "--manifest", "{variant}.json"];
    let options =
        both(&reports, &["-o", "{variant}.png", "--contact-sheet", "all.png", "--progress", "json"]);
    let output = rayframe(folder, &both(&both(&[SCENE], &EACH), &options));
    assert_code(&output, 0);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let events: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let schema = Schema::read("progress");
    for event in &events {
        schema.check(event);
    }
    let of = |name: &str, key: &str| -> Vec<Value> {
        events.iter().filter(|event| event["event"] == name).map(|event| event[key].clone()).collect()
    };
    assert_eq!(of("frame_done", "variant"), ["red", "gold"]);
    assert_eq!(of("total", "variant"), [Value::Null]);
    // One exposure for both.
    let exposures = of("exposure", "ev");
    assert!(exposures.len() == 2 && exposures[0] == exposures[1], "{exposures:?}");
    let manifest = json(&folder.join("gold.json"));
    Schema::read("manifest").check(&manifest);
    assert_eq!((&manifest["variant"], &manifest["clip"]), (&"gold".into(), &Value::Null));
    // Its keys are in the order of the alphabet, in the text as well.
    let text = std::fs::read_to_string(folder.join("gold.json")).unwrap();
    let keys: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("  \"")?.split_once('"')).collect();
    assert!(keys.is_sorted_by_key(|(key, _)| *key), "{keys:?}");
    assert_eq!(json(&folder.join("red.stats.json"))["variant"], "red");
    // A frame of each on the sheet, with its name below.
    let sheet = image::open(folder.join("all.png")).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (4 + 2 * (64 + 4), 4 + (18 + 18 + 4)));
    // Tone-mapped files of a variant alone are others, because their exposure is.
    assert_code(&rayframe(folder, &[SCENE, "--variant", "red", "-o", "{variant}.png"]), 73);
}

/// All variants are framed as the scene is without one, although a variant may hide from framing what another shows.
#[test]
fn variants_share_the_automatic_camera_and_the_ground() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("v.gltf"), without_camera().to_string()).unwrap();
    let catcher = ["v.gltf", "--shadow-catcher", "red"];
    let rules = |arguments: &[&str]| {
        let told = assert_code(&rayframe(folder, &both(&both(&catcher, &["-n"]), arguments)), 0);
        let rule = |line: &str| {
            let (_, rule) = line.split_once("camera auto")?;
            Some(rule.split_once(')')?.0.to_owned())
        };
        told.lines().filter_map(rule).collect::<Vec<_>>()
    };
    let (each, own) = (rules(&EACH), rules(&[]));
    let told = assert_code(&rayframe(folder, &both(&both(&catcher, &["-n"]), &EACH)), 0);
    assert!(told.contains(", variant \"red\", ") && told.contains(", variant \"gold\", "), "{told}");
    assert_eq!(each, [own.concat(), own.concat()]);
    assert_ne!(rules(&["--variant", "red"]), own);
    // Where materials do not matter, each is what it is alone, automatic camera and ground included.
    let ground = ["v.gltf", "--ground", "-o", "{variant}.exr"];
    assert_code(&rayframe(folder, &both(&ground, &EACH)), 0);
    let alone = ["v.gltf", "--ground", "-o", "alone.exr", "--variant", "gold"];
    assert_code(&rayframe(folder, &alone), 0);
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert!(read("alone.exr") == read("gold.exr"));
}

#[test]
fn one_variant_is_needed_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let out = folder.join("a.exr").display().to_string();
    let job = folder.join("job").display().to_string();
    for arguments in [
        both(&["watch", SCENE], &EACH),
        both(&["farm", "slurm", SCENE, "-o", &out, "--out-dir", &job], &EACH),
    ] {
        let told = assert_code(&program(&arguments), 2);
        assert!(
            told.contains("--variant: each makes several sequences, which only rayframe render takes"),
            "{told}"
        );
        assert!(told.contains("name one variant"), "{told}");
    }
    std::fs::create_dir(folder.join("suite")).unwrap();
    std::fs::write(folder.join("suite/suite.toml"), "").unwrap();
    std::fs::write(folder.join("suite/a.toml"), format!("scene = '{SCENE}'\nvariant = 'each'")).unwrap();
    let suite = folder.join("suite").display().to_string();
    let output = program(&["test", "--suite", &suite]);
    let told = told_all(&output);
    assert!(
        output.status.code() != Some(0) && told.contains("variant: each makes several sequences"),
        "{told}"
    );
}

/// A frame with its own materials is kept by what renders the same, and no other.
#[test]
fn none_cancels_the_variant_of_a_shot_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let own = ["-o", "own.exr"];
    assert_code(&rayframe(folder, &both(&[SCENE], &own)), 0);
    std::fs::write(folder.join("red.toml"), format!("scene = '{SCENE}'\nvariant = 'red'\n")).unwrap();
    let shot = both(&["red.toml"], &own);
    assert_code(&rayframe(folder, &shot), 73);
    for none in [["--variant", "none"], ["-D", "variant=none"]] {
        assert_code(&rayframe(folder, &both(&shot, &none)), 0);
    }
    assert_code(&rayframe(folder, &[SCENE, "--variant", "none", "-o", "{variant}.exr"]), 0);
    assert!(folder.join("none.exr").is_file());
    // The shot that a dry run prints renders the same.
    let dry_run = rayframe(folder, &both(&shot, &["--variant", "none", "-n"]));
    assert_code(&dry_run, 0);
    let printed = String::from_utf8_lossy(&dry_run.stdout);
    assert!(printed.contains("\nvariant = \"none\"\n"), "{printed}");
    std::fs::write(folder.join("printed.toml"), &*printed).unwrap();
    assert_code(&rayframe(folder, &["printed.toml"]), 0);
    assert_eq!(names(folder), ["none.exr", "own.exr", "printed.toml", "red.toml"]);
}

/// A catcher that no rendered variant has does nothing, which is told. One that any of them has is in use.
#[test]
fn catchers_of_other_variants_are_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let catcher = [SCENE, "--shadow-catcher", "gold", "-n"];
    let told =
        |variant: &str| assert_code(&rayframe(folder.path(), &both(&catcher, &["--variant", variant])), 0);
    let warning = "--shadow-catcher \"gold\" does nothing: nothing that is rendered has that name or index";
    assert_eq!(told("red").matches(warning).count(), 1);
    for variant in ["gold", "each"] {
        let told = told(variant);
        assert!(!told.contains("does nothing"), "{told}");
    }
}
