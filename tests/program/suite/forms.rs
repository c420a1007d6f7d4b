//! Report formats: JSON against its schema, JUnit XML, and text.

use serde_json::Value;

use super::{SUITE, Stage};
use crate::progress::schema::Schema;

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn stage() -> Stage {
    let scenes = [("a/point.gltf", "light/point.gltf"), ("a/spot.gltf", "light/spot.gltf")];
    let stage = Stage::accepted(SUITE, &scenes);
    stage.scene("a/spot.gltf", "light/spot.gltf", "\"intensity\": ", "\"intensity\": 9");
    stage.scene("b/new.gltf", "light/range.gltf", "", "");
    stage.write("b/broken.glb", "glTF?");
    std::fs::copy(stage.path("references/a/point.exr"), stage.path("references/old.exr")).unwrap();
    stage
}

#[test]
fn json_matches_its_schema() {
    let ran = stage().run(&["test", "--json"]);
    assert_eq!(ran.code, Some(1));
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    Schema::read("test").check(&report);
    let statuses: Vec<_> = report["shots"]
        .as_array()
        .unwrap()
        .iter()
        .map(|shot| (shot["name"].as_str().unwrap(), shot["pictures"][0]["status"].as_str().unwrap()))
        .collect();
    let expected =
        [("a/point", "passed"), ("a/spot", "different"), ("b/broken", "broken"), ("b/new", "missing")];
    assert_eq!(statuses, expected);
    assert_eq!(report["dangling"], serde_json::json!(["old"]));
    assert_eq!((&report["passed"], &report["failed"]), (&1.into(), &4.into()));
    assert_eq!((&report["identical"], &report["changed"]), (&1.into(), &0.into()));
}

#[test]
fn junit_names_every_image() {
    let stage = stage();
    stage.run(&["test", "--junit", "out/junit.xml"]).ends(1, &[]);
    let xml = std::fs::read_to_string(stage.path("out/junit.xml")).unwrap();
    for words in [
        "<testsuites name=\"rayframe test\" tests=\"5\" skipped=\"0\" failures=\"3\" errors=\"1\"",
        "<testsuite name=\"a\" tests=\"2\" skipped=\"0\" errors=\"0\" failures=\"1\"",
        "<testcase name=\"a/point\" classname=\"a\"",
        "<testcase name=\"old\" classname=\"(root)\"",
        "type=\"different\"",
        "type=\"missing\"",
        "type=\"broken\"",
        "type=\"orphaned\"",
        "likely light",
    ] {
        assert!(xml.contains(words), "no {words} in {xml}");
    }
    stage.run(&["test", "--junit", "suite.toml/junit.xml"]).ends(73, &["suite.toml"]);
}

#[test]
fn text_has_a_line_for_each_folder_and_then_failures() {
    let stage = stage();
    let ran = stage.run(&["test"]);
    let lines: Vec<&str> = ran.stdout.lines().collect();
    assert!(lines[0].starts_with(".  ") && lines[0].ends_with("1 failed"), "{}", ran.stdout);
    assert!(lines[1].starts_with("a  ") && lines[2].starts_with("b  "), "{}", ran.stdout);
    assert_eq!(stage.run(&["test", "a/point", "-q"]).text, "");
    let passes = stage.run(&["test", "a/point"]);
    assert_eq!(passes.text.lines().count(), 2, "{}", passes.text);
    assert!(stage.run(&["test", "-q"]).stdout.starts_with("FAIL a/spot"));
}
