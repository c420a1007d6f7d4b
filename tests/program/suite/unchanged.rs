//! Shots that were identical and have not changed since are not rendered again.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;

use super::{SUITE, Stage};

const POINT: (&str, &str) = ("a/point.gltf", "light/point.gltf");
const SPOT: (&str, &str) = ("spot.gltf", "light/spot.gltf");

/// Names of the shots that the last run did not render.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn cached(stage: &Stage) -> Vec<String> {
    let text = std::fs::read(stage.path("report/result.json")).unwrap();
    let result: Value = serde_json::from_slice(&text).unwrap();
    let shots = result["shots"].as_array().unwrap().iter().filter(|shot| shot["cached"] == true);
    shots.map(|shot| shot["name"].as_str().unwrap().to_owned()).collect()
}

/// What changes, how, and the shots of which nothing does.
type Change<'a> = (&'a str, &'a dyn Fn(), &'a [&'a str]);

/// Waits until files that are written get a later time than the last run began.
fn wait_a_tick() {
    std::thread::sleep(std::time::Duration::from_millis(20));
}

#[test]
fn verdicts_hold_until_an_input_changes() {
    let stage = Stage::accepted(SUITE, &[POINT, SPOT]);
    let buffer = with_buffer_file(&stage, "spare.gltf", "light/range.gltf");
    stage.write("close.toml", "scene = 'spare.gltf'\nenv = 'light.hdr'\n");
    let light = image::Rgb32FImage::from_pixel(8, 4, image::Rgb([0.9, 0.8, 0.7]));
    light.save(stage.path("light.hdr")).unwrap();
    stage.run(&["test"]).ends(1, &["no reference"]);
    stage.run(&["accept"]).ends(0, &["added"]);
    wait_a_tick();
    stage.run(&["test"]).ends(0, &["3 images identical"]);
    let all = ["a/point", "close", "spot"];
    let ran = stage.run(&["test"]);
    ran.ends(0, &["3 images identical, 0 changed within limits, 0 failed", "3 shots not rendered"]);
    assert_eq!(cached(&stage), all);
    stage.run(&["test", "--no-cache"]).ends(0, &["3 images identical"]);
    assert_eq!(cached(&stage), [""; 0]);

    // Each change is one that leaves the images as they are, so that only the inputs tell.
    let changes: [Change<'_>; 6] = [
        ("a buffer of a scene", &|| append(&stage, &buffer, "x"), &["a/point", "spot"]),
        ("a scene", &|| append(&stage, "a/point.gltf", " "), &["close", "spot"]),
        ("a scene of a shot file", &|| append(&stage, "spare.gltf", " "), &["a/point", "spot"]),
        ("a shot file", &|| append(&stage, "close.toml", "# comment\n"), &["a/point", "spot"]),
        ("a reference", &|| append(&stage, "references/spot.exr", "x"), &["a/point", "close"]),
        ("the suite", &|| append(&stage, "suite.toml", "# comment\n"), &[]),
    ];
    for (what, change, kept) in changes {
        stage.run(&["test"]).ends(0, &["3 images identical"]);
        wait_a_tick();
        change();
        wait_a_tick();
        stage.run(&["test"]).ends(0, &["3 images identical"]);
        assert_eq!(cached(&stage), kept, "after a change of {what}");
        assert_eq!(stage.run(&["test"]).code, Some(0));
        assert_eq!(cached(&stage), all, "after a change of {what}, again");
    }
    // Another file of an environment is told, whatever its pixels.
    append(&stage, "light.hdr", "x");
    wait_a_tick();
    stage.run(&["test"]).ends(0, &["changed close", "lights or the environment changed"]);
    assert_eq!(cached(&stage), ["a/point", "spot"]);
}

/// Suites of one folder share scenes, references and the folder of verdicts.
#[test]
fn a_verdict_holds_for_its_suite_file_alone() {
    let stage = Stage::accepted(SUITE, &[SPOT]);
    wait_a_tick();
    stage.run(&["test"]).ends(0, &["1 image identical"]);
    stage.run(&["test"]).ends(0, &["1 shot not rendered"]);
    stage.write("large.toml", &SUITE.replace("[48, 27]", "[96, 54]"));
    stage.run(&["test", "--suite", "large.toml"]).ends(1, &["FAIL spot"]);
    assert_eq!(cached(&stage), [""; 0]);
    // Another preset alone.
    stage.write("exact.toml", &SUITE.replace("visual", "exact"));
    wait_a_tick();
    stage.run(&["test", "--suite", "exact.toml"]).ends(0, &["1 image identical"]);
    assert_eq!(cached(&stage), [""; 0]);
    // The verdict of each stays, and is not that of the other where its file is copied.
    for suite in ["suite.toml", "exact.toml"] {
        stage.run(&["test", "--suite", suite]).ends(0, &["1 shot not rendered"]);
    }
    let of_suite = |suite: &str| stage.path(&format!(".rayframe-cache/{suite}/spot.json"));
    std::fs::copy(of_suite("suite.toml"), of_suite("exact.toml")).unwrap();
    stage.run(&["test", "--suite", "exact.toml"]).ends(0, &["1 image identical"]);
    assert_eq!(cached(&stage), [""; 0]);
}

/// The verdict of the same bytes says nothing about a file that a scene may not name.
#[cfg(unix)]
#[test]
fn a_link_that_leads_out_of_the_suite_is_followed_again() {
    let stage = Stage::accepted(SUITE, &[SPOT]);
    let buffer = stage.path(&with_buffer_file(&stage, "spare.gltf", "light/range.gltf"));
    stage.run(&["test"]).ends(1, &["no reference"]);
    stage.run(&["accept"]).ends(0, &["added"]);
    wait_a_tick();
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    stage.run(&["test"]).ends(0, &["2 shots not rendered"]);
    let outside = tempfile::tempdir().unwrap();
    let target = outside.path().join("spare.bin");
    std::fs::copy(&buffer, &target).unwrap();
    std::fs::remove_file(&buffer).unwrap();
    std::os::unix::fs::symlink(&target, &buffer).unwrap();
    stage.run(&["test"]).ends(1, &["FAIL spare", "1 image identical"]);
    assert_eq!(cached(&stage), ["spot"]);
}

/// Writes a scene of the repository whose first buffer is a file, and returns the name of that file.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn with_buffer_file(stage: &Stage, name: &str, scene: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    let mut document: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let uri = document["buffers"][0]["uri"].as_str().unwrap();
    let bytes = BASE64_STANDARD.decode(uri.split_once("base64,").unwrap().1).unwrap();
    let buffer = format!("{name}.bin");
    std::fs::write(stage.path(&buffer), bytes).unwrap();
    document["buffers"][0]["uri"] = Value::from(buffer.clone());
    stage.write(name, &document.to_string());
    buffer
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn append(stage: &Stage, name: &str, text: &str) {
    let path = stage.path(name);
    let mut bytes = std::fs::read(&path).unwrap();
    bytes.extend(text.as_bytes());
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn changed_and_failed_shots_are_rendered_again() {
    let stage = Stage::accepted(SUITE, &[POINT, SPOT]);
    wait_a_tick();
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    stage.write("spot.toml", "scene = 'spot.gltf'\nlight_scale = 3\n");
    for _ in 0..2 {
        stage.run(&["test"]).ends(1, &["1 image identical", "FAIL spot"]);
        assert_eq!(cached(&stage), ["a/point"]);
    }
    // The verdict of before the change does not come back.
    assert!(!stage.path(".rayframe-cache/suite.toml/spot.json").exists());
    // A pending image of a shot that is identical again is discarded without rendering, too.
    std::fs::remove_file(stage.path("spot.toml")).unwrap();
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    std::fs::write(stage.path("references/spot.exr.new"), "x").unwrap();
    stage.run(&["test"]).ends(0, &["2 shots not rendered"]);
    assert_eq!(stage.references(), ["a/point.exr", "spot.exr"]);
    // Files that are damaged, or of another program, tell nothing.
    let file = stage.path(".rayframe-cache/suite.toml/spot.json");
    let text = std::fs::read_to_string(&file).unwrap();
    let program = text.split("\"program\":\"").nth(1).unwrap();
    for damaged in [text[..text.len() / 2].to_owned(), text.replace(&program[..64], &"0".repeat(64))] {
        std::fs::write(&file, damaged).unwrap();
        stage.run(&["test"]).ends(0, &["2 images identical"]);
        assert_eq!(cached(&stage), ["a/point"]);
    }
    // The folder may be deleted, and is not seen by git.
    assert_eq!(std::fs::read_to_string(stage.path(".rayframe-cache/.gitignore")).unwrap(), "*\n");
    std::fs::remove_dir_all(stage.path(".rayframe-cache")).unwrap();
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    assert_eq!(cached(&stage), [""; 0]);
    // A folder that cannot be written to, or that has other files, is a warning.
    for (cache, why) in [
        ("a/point.gltf/x", ""),
        (".", "holds other files than verdicts"),
        ("references", "holds other files"),
    ] {
        stage.write("suite.toml", &format!("cache = '{cache}'\n{SUITE}"));
        stage
            .run(&["test"])
            .ends(0, &["2 images identical", "verdicts cannot be kept for the next run", why]);
        assert!(!stage.path(".gitignore").exists() && !stage.path("references/.gitignore").exists());
    }
}

#[test]
fn slow_shots_are_listed() {
    let stage = Stage::accepted(SUITE, &[POINT, SPOT]);
    stage.write("spot.toml", "scene = 'spot.gltf'\nresolution = [1280, 720]\n");
    stage.run(&["test", "--slowest", "x"]).ends(2, &["write a whole number from 0 to"]);
    let ran = stage.run(&["test", "--slowest", "1"]);
    ran.ends(1, &[" s  spot\n"]);
    assert!(!ran.text.contains(" s  a/point\n"), "{}", ran.text);
}

#[test]
fn files_of_other_programs_are_skipped_and_named() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    stage.write("Cargo.toml", "[package]\nname = 'a'\n");
    stage.write("path.toml", "[[key]]\ntime = 0\n");
    let ran = stage.run(&["test"]);
    ran.ends(0, &["1 image identical", "Cargo.toml: is skipped, as no key in it is a setting of a shot"]);
    assert!(!ran.text.contains("path.toml"), "{}", ran.text);
    // What may be a shot with an error is tested.
    stage.write("near.toml", "scene = 'a/point.gltf'\nsample = 3\n");
    stage.run(&["test"]).ends(1, &["FAIL near", "\"sample\" is no setting"]);
    stage.write("suite.toml", &format!("exclude = ['Cargo.toml', 'near.toml']\n{SUITE}"));
    let ran = stage.run(&["test"]);
    assert!(ran.code == Some(0) && !ran.text.contains("Cargo.toml"), "{}", ran.text);
    stage.write("suite.toml", &format!("scenes = 'a'\nexclude = ['a/point.gltf', 'gone']\n{SUITE}"));
    let ran = stage.run(&["test", "--list"]);
    ran.ends(
        0,
        &["suite.toml: exclude: there is no gone, neither in the suite's folder nor in that of its scenes"],
    );
    assert!(ran.stdout.trim().is_empty(), "{}", ran.stdout);
}

#[test]
fn references_are_replaced_by_accept_alone() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    for option in ["--update", "--update-snapshots", "--bless"] {
        stage.run(&["test", option]).ends(2, &["never replaces references", "rayframe accept"]);
    }
}

#[test]
fn shots_that_need_more_than_their_share_of_the_memory_are_tested_alone() {
    // Each image needs about 26 MB, more than a half and less than all of the limit.
    let suite = "[shot]\nresolution = [640, 360]\nsamples = 1\nframes = 0\nmax_memory = '40M'\n";
    let stage = Stage::accepted(suite, &[POINT, SPOT]);
    stage.run(&["test", "--no-cache", "-t", "2"]).ends(0, &["2 images identical"]);
    stage.write("suite.toml", &suite.replace("40M", "20M"));
    stage.run(&["test", "-t", "2"]).ends(1, &["2 failed", "need about", "more than the limit of 20.0 MB"]);
}
