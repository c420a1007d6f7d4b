//! Images that changed within the limits: text, report formats, exit codes, and accepting them.

use serde_json::Value;

use super::{SUITE, Stage};
use crate::progress::schema::Schema;

const POINT: (&str, &str) = ("point.gltf", "light/point.gltf");
const SPOT: (&str, &str) = ("spot.gltf", "light/spot.gltf");
const CHANGED: &str = "point.exr.changed.new";
/// The SHA-256 of the reference with which the pending image was compared.
const COMPARED: &str = "point.exr.compared.new";

/// A suite with an identical image and one that is 1 % brighter than its reference, which the preset `visual` admits.
fn changed() -> Stage {
    let stage = Stage::accepted(SUITE, &[POINT, SPOT]);
    stage.write("point.toml", "scene = 'point.gltf'\nlight_scale = 1.01\n");
    stage
}

#[test]
fn a_change_within_the_limits_is_named_and_stored() {
    let stage = changed();
    let ran = stage.run(&["test"]);
    ran.ends(
        0,
        &[
            "changed point (preset visual): difference of mean brightness: 0.0",
            " <= 0.03\n",
            "1 image identical, 1 changed within limits, 0 failed, ",
            "report: report/index.html",
            "rayframe accept --changed",
        ],
    );
    assert_eq!(stage.references(), ["point.exr", CHANGED, COMPARED, "spot.exr"]);
    assert_eq!(stage.run(&["test", "-q"]).text, "");
    // A failure replaces the pending image, and an identical image removes it.
    stage.write("point.toml", "scene = 'point.gltf'\nlight_scale = 2\n");
    stage.run(&["test"]).ends(1, &["1 image identical, 0 changed within limits, 1 failed"]);
    assert_eq!(stage.references(), ["point.exr", COMPARED, "point.exr.new", "spot.exr"]);
    stage.write("point.toml", "scene = 'point.gltf'\nlight_scale = 1.01\n");
    stage.run(&["test"]).ends(0, &[]);
    assert_eq!(stage.references(), ["point.exr", CHANGED, COMPARED, "spot.exr"]);
    stage.write("point.toml", "scene = 'point.gltf'\n");
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    assert_eq!(stage.references(), ["point.exr", "spot.exr"]);
}

#[test]
fn changes_fail_on_request() {
    let stage = changed();
    let fail_on_changed = ["test", "--fail-on", "changed"];
    let ran = stage.run(&fail_on_changed);
    ran.ends(
        1,
        &["FAIL point (preset visual)", "likely light: red times 1.010", "1 changed within limits, 0 failed"],
    );
    stage.run(&["test", "--fail-on", "changed", "-q"]).ends(1, &["FAIL point (preset visual)"]);
    stage.run(&["test", "spot", "--fail-on", "changed"]).ends(0, &[]);
    stage
        .run(&["test", "--fail-on", "changed", "--junit", "junit.xml", "--json"])
        .ends(1, &["\"passes\": false"]);
    let xml = std::fs::read_to_string(stage.path("junit.xml")).unwrap();
    assert!(xml.contains("failures=\"1\"") && xml.contains("type=\"changed\""), "{xml}");
}

#[test]
fn only_an_option_an_exact_name_or_an_approval_accepts_a_change() {
    let stage = changed();
    stage.write("spot.toml", "scene = 'spot.gltf'\nlight_scale = 3\n");
    stage.run(&["test"]).ends(1, &["0 images identical, 1 changed within limits, 1 failed"]);
    stage.run(&["accept", "p"]).ends(
        0,
        &["replaced references/spot.exr", "1 change within the limits is still pending", "accept --changed"],
    );
    assert_eq!(stage.references(), ["point.exr", CHANGED, COMPARED, "spot.exr"]);
    stage.run(&["accept"]).ends(0, &["rayframe accept --changed accepts it"]);
    assert_eq!(stage.references(), ["point.exr", CHANGED, COMPARED, "spot.exr"]);
    stage.run(&["accept", "--changed"]).ends(0, &["replaced references/point.exr"]);
    stage.run(&["accept", "--changed"]).ends(0, &["no pending images that changed within the limits"]);
    stage.run(&["test"]).ends(0, &["2 images identical"]);

    // `--changed` leaves failures alone; an exact name takes either.
    stage.write("point.toml", "scene = 'point.gltf'\n");
    stage.write("spot.toml", "scene = 'spot.gltf'\n");
    stage.run(&["test"]).ends(1, &[]);
    stage.run(&["accept", "--changed", "spot"]).ends(0, &["no pending images that changed"]);
    stage.run(&["accept", "point"]).ends(0, &["replaced references/point.exr"]);
    assert_eq!(stage.references(), ["point.exr", "spot.exr", "spot.exr.compared.new", "spot.exr.new"]);
}

#[test]
fn review_and_approvals_take_changes() {
    let stage = changed();
    let report = report(&stage);
    let hash = &report["shots"][0]["pictures"][0]["hash"];
    let approvals = serde_json::json!({"schema": 1, "approved": [{"name": "point", "hash": hash}]});
    stage.write("approvals.json", &approvals.to_string());
    let words = ["1/1 point changed within the limits", "mean brightness: 0.0", "1 still pending"];
    stage.run_with(&["review"], "s\n", None).ends(0, &words);
    stage.run(&["accept", "--approvals", "approvals.json"]).ends(0, &["replaced references/point.exr"]);
    stage.run(&["test"]).ends(0, &["2 images identical"]);
}

#[test]
fn json_junit_and_page_state_the_verdict() {
    let stage = changed();
    let report = report(&stage);
    Schema::read("test").check(&report);
    let image = |shot: usize| &report["shots"][shot]["pictures"][0];
    assert_eq!((&image(0)["verdict"], &image(0)["status"]), (&"changed".into(), &"passed".into()));
    assert_eq!((&image(1)["verdict"], &image(1)["hash"]), (&"identical".into(), &Value::Null));
    assert_eq!(image(0)["cause"]["kind"], "light");
    assert_eq!([&report["identical"], &report["changed"], &report["failed"]], [1, 1, 0]);
    assert_eq!(report["passes"], true);

    stage.run(&["test", "--junit", "junit.xml"]).ends(0, &[]);
    let xml = std::fs::read_to_string(stage.path("junit.xml")).unwrap();
    for words in [
        "failures=\"0\"",
        "<property name=\"verdict\" value=\"changed\"/>",
        "<system-out>changed within limits\n",
    ] {
        assert!(xml.contains(words), "no {words} in {xml}");
    }

    let page = std::fs::read_to_string(stage.path("report/index.html")).unwrap();
    assert!(page.contains("<h2>Changed within limits</h2>") && page.contains("id=\"image-2\""));
    assert!(
        page.contains("rayframe accept point --suite")
            && page.contains("rayframe diff references/point.exr.changed.new")
    );
}

/// The JSON report of a test.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn report(stage: &Stage) -> Value {
    serde_json::from_str(&stage.run(&["test", "--json"]).stdout).unwrap()
}
