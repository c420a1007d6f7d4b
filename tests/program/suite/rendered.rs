//! `rayframe accept --from`: the images that a build server rendered become references without rendering again.

use std::path::Path;

use serde_json::{Value, json};

use super::{SUITE, Stage};

const POINT: (&str, &str) = ("a/point.gltf", "light/point.gltf");
const SPOT: (&str, &str) = ("spot.gltf", "light/spot.gltf");
const SUN: (&str, &str) = ("sun.gltf", "light/directional.gltf");
const FROM: [&str; 3] = ["accept", "--from", "artefact"];

/// A suite tested where `CI` is set, with its report moved to the folder `artefact`: a change within the limits, a difference, a missing
/// and an orphaned reference.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
pub(super) fn tested_in_ci() -> Stage {
    let stage = Stage::accepted(SUITE, &[POINT, SPOT, SUN]);
    stage.write("a/point.toml", "scene = 'point.gltf'\nlight_scale = 1.01\n");
    stage.write("spot.toml", "scene = 'spot.gltf'\nlight_scale = 3\n");
    stage.scene("new.gltf", "light/range.gltf", "", "");
    std::fs::remove_file(stage.path("sun.gltf")).unwrap();
    let words = ["0 images identical, 1 changed within limits, 3 failed", "accept --from DIR"];
    stage.run_with(&["test"], "", Some("true")).ends(1, &words);
    assert_eq!(stage.references(), ["a/point.exr", "spot.exr", "sun.exr"]);
    std::fs::rename(stage.path("report"), stage.path("artefact")).unwrap();
    stage
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn bytes(stage: &Stage, name: &str) -> Vec<u8> {
    std::fs::read(stage.path(name)).unwrap()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn list(stage: &Stage) -> Value {
    serde_json::from_slice(&bytes(stage, "artefact/images.json")).unwrap()
}

#[test]
fn images_of_a_build_server_become_references() {
    let stage = tested_in_ci();
    let listed: Vec<Value> =
        list(&stage)["images"].as_array().unwrap().iter().map(|image| image["name"].clone()).collect();
    assert_eq!(listed, ["a/point", "new", "spot", "sun"]);
    // An exact name selects one image, and plain `--from` leaves changes within the limits.
    stage.run(&[&FROM[..], &["spot"]].concat()).ends(0, &["replaced references/spot.exr"]);
    assert_eq!(bytes(&stage, "references/spot.exr"), bytes(&stage, "artefact/images/spot.exr"));
    let ran = stage.run(&FROM);
    ran.ends(0, &["added references/new.exr", "removed references/sun.exr"]);
    assert!(!ran.text.contains("point") && !ran.text.contains("spot"), "{}", ran.text);
    stage.run(&FROM).ends(0, &["all images are references already"]);
    // A shot without such an image in the report.
    stage.scene("identical.gltf", POINT.1, "", "");
    stage.run(&[&FROM[..], &["identical"]].concat()).ends(0, &["the report has no such images"]);
    std::fs::remove_file(stage.path("identical.gltf")).unwrap();
    stage.run(&[&FROM[..], &["--changed"]].concat()).ends(0, &["replaced references/a/point.exr"]);
    assert_eq!(stage.references(), ["a/point.exr", "new.exr", "spot.exr"]);
    stage.run(&["test"]).ends(0, &["3 images identical, 0 changed within limits, 0 failed"]);
    // Nothing is written where `CI` is set, and a suite that passes there leaves no images.
    stage.run_with(&FROM, "", Some("true")).ends(2, &["CI is set"]);
    stage.run_with(&["test"], "", Some("true")).ends(0, &[]);
    assert!(!stage.path("report/images.json").exists());
}

#[test]
fn approvals_select_images_of_a_build_server() {
    let stage = tested_in_ci();
    let images = list(&stage)["images"].clone();
    let approve = |approved: Value| {
        stage.write("approvals.json", &json!({"schema": 1, "approved": approved}).to_string());
        stage.run(&[&FROM[..], &["--approvals", "approvals.json"]].concat())
    };
    approve(json!([{"name": "spot", "hash": "00"}]))
        .ends(1, &["nothing was accepted: spot: the image that was approved is not in the report"]);
    approve(json!([{"name": "a/point", "hash": images[0]["hash"]}, {"name": "sun", "hash": null}]))
        .ends(0, &["replaced references/a/point.exr", "removed references/sun.exr"]);
    assert_eq!(stage.references(), ["a/point.exr", "spot.exr"]);
}

#[test]
fn images_that_fit_no_longer_are_refused_by_name_and_nothing_is_accepted() {
    let stage = tested_in_ci();
    let references = stage.references();
    let refused = |word: &str| stage.run(&FROM).ends(1, &["nothing was accepted: ", word]);
    // Another image in the place of one that was tested.
    let (spot, new) = (bytes(&stage, "artefact/images/spot.exr"), bytes(&stage, "artefact/images/new.exr"));
    std::fs::write(stage.path("artefact/images/spot.exr"), &new).unwrap();
    refused("spot: its file is not the image that was tested");
    std::fs::write(stage.path("artefact/images/spot.exr"), &spot).unwrap();
    // A file beyond the limit, which is not read to its end.
    std::fs::File::create(stage.path("artefact/images/spot.exr")).unwrap().set_len(64 << 30).unwrap();
    stage.run(&FROM).ends(77, &["images/spot.exr: the file has 1025 KiB and a reference at most 1024"]);
    std::fs::write(stage.path("artefact/images/spot.exr"), &spot).unwrap();
    // Another reference.
    let reference = bytes(&stage, "references/spot.exr");
    std::fs::copy(stage.path("references/sun.exr"), stage.path("references/spot.exr")).unwrap();
    refused("spot: its reference is not the one");
    std::fs::write(stage.path("references/spot.exr"), &reference).unwrap();
    // Another shot.
    stage.write("spot.toml", "scene = 'spot.gltf'\nlight_scale = 4\n");
    refused("spot: its shot, scene or version of rayframe is not the one");
    stage.write("spot.toml", "scene = 'spot.gltf'\nlight_scale = 3\n");
    // A shot of the orphaned reference is back.
    stage.scene("sun.gltf", SUN.1, "", "");
    refused("sun: a shot renders this reference now");
    assert_eq!(stage.references(), references);
    assert_eq!(bytes(&stage, "references/spot.exr"), reference);

    let from = |folder: &str| stage.run(&["accept", "--from", folder]);
    for gone in ["gone", "gone.zip"] {
        from(gone).ends(66, &[&format!("rayframe: error: {gone}: cannot be read: ")]);
    }
    from("suite.toml")
        .ends(65, &["suite.toml: is no whole zip archive; name one, or the folder that has images.json"]);
    stage.run(&[&FROM[..], &["moon"]].concat()).ends(2, &["no image of the report has the name \"moon\""]);
    let mut outside = list(&stage);
    outside["images"][0]["name"] = "../spot".into();
    stage.write("artefact/images.json", &outside.to_string());
    stage.run(&FROM).ends(65, &["the name \"../spot\" leaves the folder"]);
    assert!(Path::new(&stage.path("spot.gltf")).exists());
}

#[test]
fn a_shot_that_cannot_be_opened_keeps_only_its_own_references() {
    let stage = tested_in_ci();
    let sun = || stage.run(&[&FROM[..], &["sun"]].concat());
    // It may render the reference once it is whole.
    stage.write("sun.gltf", "{");
    sun().ends(1, &["nothing was accepted: sun: its shot cannot be opened", "sun.gltf"]);
    assert!(stage.path("references/sun.exr").exists());
    std::fs::remove_file(stage.path("sun.gltf")).unwrap();
    stage.write("new.gltf", "{");
    sun().ends(0, &["removed references/sun.exr"]);
    assert_eq!(stage.references(), ["a/point.exr", "spot.exr"]);
}

#[test]
fn files_of_others_in_the_folder_of_the_report_are_kept() {
    let stage = Stage::accepted(SUITE, &[POINT, SPOT]);
    let test = |options: &[&str]| {
        stage.run_with(&[&["test", "--report", "web"], options].concat(), "", Some("true"))
    };
    let keeps = |name: &str, content: &str| {
        stage.write(name, content);
        test(&[]).ends(73, &[&format!("{name}: is there already and is not a ")]);
        assert_eq!(bytes(&stage, name), content.as_bytes());
        assert!(!stage.path("web/index.html").exists());
        std::fs::remove_file(stage.path(name)).unwrap();
    };
    for foreign in [r#"{"mine": true}"#, r#"{"schema": 1, "images": ["a.png"]}"#, "[]"] {
        keeps("web/images.json", foreign);
    }
    keeps("web/images/a/point.exr", "precious");
    keeps("web/images/spot@front.0012.exr", "precious");
    // Those of no shot stay, and empty files may be replaced.
    stage.write("web/images/hero.exr", "precious");
    stage.write("web/images.json", "");
    test(&[]).ends(0, &["2 images identical"]);
    assert!(!stage.path("web/images.json").exists());
    // Where nothing is kept, nothing is checked.
    stage.write("web/images.json", "{}");
    stage.run(&["test", "--report", "web"]).ends(0, &[]);
    assert_eq!(bytes(&stage, "web/images.json"), b"{}");
    // Its own files are replaced, of a run that was killed as well.
    stage.write("spot.toml", "scene = 'spot.gltf'\nlight_scale = 3\n");
    stage.write("web/images/spot.exr", "precious");
    test(&[]).ends(73, &["web/images.json"]);
    test(&["--overwrite"]).ends(1, &["1 failed"]);
    test(&[]).ends(1, &["1 failed"]);
    std::fs::remove_file(stage.path("web/images.json")).unwrap();
    test(&[]).ends(1, &["1 failed"]);
    stage.run(&["accept", "--from", "web"]).ends(0, &["replaced references/spot.exr"]);
    test(&[]).ends(0, &["2 images identical"]);
    assert!(!stage.path("web/images.json").exists() && !stage.path("web/images/spot.exr").exists());
    assert_eq!(bytes(&stage, "web/images/hero.exr"), b"precious");
}
