//! `accept`, `reject` and `review`: by name, by a file of approvals, interactively, and under CI.

use serde_json::json;

use super::{SUITE, Stage};

const SCENES: [(&str, &str); 3] = [
    ("point.gltf", "light/point.gltf"),
    ("point_far.gltf", "light/spot.gltf"),
    ("sun.gltf", "light/directional.gltf"),
];

/// A suite with three pending images.
fn pending() -> Stage {
    let stage = Stage::new(SUITE);
    for (name, scene) in SCENES {
        stage.scene(name, scene, "", "");
    }
    stage.run(&["test"]).ends(1, &["0 images identical, 0 changed within limits, 3 failed"]);
    stage
}

#[test]
fn an_exact_name_selects_its_shot_and_a_partial_name_all_that_contain_it() {
    let stage = pending();
    stage.run(&["accept", "point"]).ends(0, &["added references/point.exr"]);
    assert_eq!(stage.references(), ["point.exr", "point_far.exr.new", "sun.exr.new"]);
    stage.run(&["reject", "poi"]).ends(0, &["rejected point_far"]);
    assert_eq!(stage.references(), ["point.exr", "sun.exr.new"]);
}

#[test]
fn scenes_that_cannot_be_opened_do_not_keep_others_from_being_accepted() {
    let stage = pending();
    for name in ["point_far.gltf", "sun.gltf"] {
        stage.write(name, "{");
    }
    // Named ones are accepted all or none.
    stage.run(&["accept", "point"]).ends(0, &["added references/point.exr"]);
    stage.run(&["accept", "sun"]).ends(65, &["sun.gltf"]);
    stage.scene("point.gltf", "light/point.gltf", "", "");
    std::fs::remove_file(stage.path("references/point.exr")).unwrap();
    stage.run(&["test", "point"]).ends(1, &["no reference"]);
    let told =
        ["added references/point.exr", "not accepted: 1 pending image of point_far, which cannot be opened"];
    let ran = stage.run(&["accept"]);
    ran.ends(65, &told);
    ran.ends(65, &["not accepted: 1 pending image of sun", "error: point_far.gltf", "error: sun.gltf"]);
    assert_eq!(stage.references(), ["point.exr", "point_far.exr.new", "sun.exr.new"]);
    // Once they can be opened again, they are accepted.
    stage.scene("point_far.gltf", "light/spot.gltf", "", "");
    stage.run(&["accept"]).ends(65, &["added references/point_far.exr", "error: sun.gltf"]);
}

#[test]
fn images_that_cannot_be_decoded_do_not_keep_others_from_being_accepted() {
    let stage = pending();
    let image = std::fs::read(stage.path("references/point_far.exr.new")).unwrap();
    std::fs::write(stage.path("references/point_far.exr.new"), &image[..image.len() / 2]).unwrap();
    stage.write("references/sun.exr.new", "no image");
    let [far, sun] = ["references/point_far.exr.new: is damaged", "references/sun.exr.new: is neither"];
    // A name, or a part of one, is accepted all or none.
    stage.run(&["accept", "point"]).ends(0, &["added references/point.exr"]);
    stage.run(&["accept", "sun"]).ends(65, &[sun]);
    std::fs::remove_file(stage.path("references/point.exr")).unwrap();
    stage.run(&["test", "point"]).ends(1, &["no reference"]);
    stage.run(&["accept", "poi"]).ends(65, &[far]);
    assert_eq!(stage.references(), ["point.exr.new", "point_far.exr.new", "sun.exr.new"]);
    let ran = stage.run(&["accept"]);
    ran.ends(65, &["added references/point.exr", "not accepted: references/point_far.exr.new", far]);
    ran.ends(65, &["not accepted: references/sun.exr.new", sun]);
    assert_eq!(stage.references(), ["point.exr", "point_far.exr.new", "sun.exr.new"]);
    // The test renders them again.
    stage.run(&["test"]).ends(1, &["1 image identical"]);
    stage.run(&["accept"]).ends(0, &["added references/point_far.exr", "added references/sun.exr"]);
}

#[test]
fn images_whose_bytes_have_changed_are_not_accepted() {
    // The name of the software decodes as well with another letter.
    let stage = pending();
    let path = stage.path("references/sun.exr.new");
    let mut image = std::fs::read(&path).unwrap();
    let name = image.windows(8).position(|bytes| bytes == b"rayframe").unwrap();
    image[name] = b'R';
    std::fs::write(&path, &image).unwrap();
    stage.run(&["accept", "sun"]).ends(65, &["sun.exr.new: is damaged: its bytes do not match its checksum"]);
    assert_eq!(stage.references(), ["point.exr.new", "point_far.exr.new", "sun.exr.new"]);
}

#[test]
fn review_asks_about_each_image() {
    let stage = pending();
    let ran = stage.run_with(&["review"], "a\nwhat\nr\n", None);
    ran.ends(
        0,
        &[
            "1/3 point has no reference yet",
            "added references/point.exr",
            "rejected point_far",
            "1 still pending",
        ],
    );
    assert_eq!(stage.references(), ["point.exr", "sun.exr.new"]);
    stage.run_with(&["review"], "s\n", None).ends(0, &["1 still pending"]);
    stage.scene("point.gltf", "light/point.gltf", "\"intensity\": ", "\"intensity\": 9");
    stage.run(&["test", "point"]).ends(1, &[]);
    let ran = stage.run_with(&["review", "point"], "y\n", None);
    ran.ends(
        0,
        &["differs from its reference", "mean FLIP", "likely light", "replaced references/point.exr"],
    );
}

#[test]
fn nothing_becomes_a_reference_where_ci_is_set() {
    let stage = Stage::new(SUITE);
    stage.scene("point.gltf", "light/point.gltf", "", "");
    stage.run_with(&["test"], "", Some("true")).ends(1, &["no reference", "CI is set"]);
    assert_eq!(stage.references(), [] as [&str; 0]);
    stage.run(&["test"]).ends(1, &[]);
    for command in ["accept", "review"] {
        stage.run_with(&[command], "a\n", Some("1")).ends(2, &["CI is set"]);
    }
    assert_eq!(stage.references(), ["point.exr.new"]);
    // CI=false does not count as CI.
    stage.run_with(&["accept"], "", Some("false")).ends(0, &["added"]);
}

/// The hash of an image in the JSON report.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn hash(stage: &Stage, name: &str) -> String {
    let ran = stage.run(&["test", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let shots = report["shots"].as_array().unwrap().iter();
    let mut images = shots.flat_map(|shot| shot["pictures"].as_array().unwrap());
    let image = images.find(|image| image["name"] == name).unwrap();
    image["hash"].as_str().unwrap().to_owned()
}

#[test]
fn approvals_are_accepted_where_they_match_the_pending_images() {
    let stage = pending();
    let approvals = |approved: serde_json::Value| {
        stage.write("approvals.json", &json!({"schema": 1, "approved": approved}).to_string());
    };
    let accept = ["accept", "--approvals", "approvals.json"];
    approvals(json!([{"name": "sun", "hash": hash(&stage, "sun")}, {"name": "point", "hash": "0000"}]));
    // One that does not match refuses all.
    stage.run(&accept).ends(1, &["nothing was accepted: point: ", "is not the one that was approved"]);
    approvals(json!([{"name": "gone", "hash": "0000"}]));
    stage.run(&accept).ends(1, &["gone: no pending image has this name"]);
    approvals(json!([{"name": "sun", "hash": null}]));
    stage.run(&accept).ends(1, &["its removal was approved, but an image is pending"]);
    approvals(json!([{"name": "sun", "hash": hash(&stage, "sun")}]));
    stage.run(&accept).ends(0, &["added references/sun.exr"]);
    assert_eq!(stage.references(), ["point.exr.new", "point_far.exr.new", "sun.exr"]);
    // A second time changes nothing and succeeds.
    stage.run(&accept).ends(0, &["all approved changes are applied already"]);

    std::fs::remove_file(stage.path("sun.gltf")).unwrap();
    stage.run(&["test"]).ends(1, &["no shot renders"]);
    approvals(json!([{"name": "sun", "hash": null}]));
    stage.run(&accept).ends(0, &["removed references/sun.exr"]);

    for (text, words) in
        [("{", "is not an approvals file"), ("{\"schema\": 2, \"approved\": []}", "has schema 2")]
    {
        stage.write("approvals.json", text);
        stage.run(&accept).ends(65, &[words]);
    }
    stage.run(&["accept", "--approvals", "gone.json"]).ends(66, &["gone.json"]);
}

#[test]
fn an_exact_name_always_wins_over_a_partial_match() {
    let stage = pending();
    stage.run(&["accept", "point"]).ends(0, &["added references/point.exr"]);
    // A second time, the exact name does not fall back to a partial match.
    for command in ["accept", "reject", "review"] {
        stage.run(&[command, "point"]).ends(0, &["no pending images of point"]);
        stage.run(&[command, "moon"]).ends(2, &["no shot or image has the name \"moon\", or contains it"]);
    }
    assert_eq!(stage.references(), ["point.exr", "point_far.exr.new", "sun.exr.new"]);
    stage.run(&["accept", "sun.exr"]).ends(0, &["added references/sun.exr"]);
    stage.run(&["test", "point.gltf"]).ends(0, &["1 image identical"]);
    assert_eq!(stage.run(&["test", "--list", "point"]).stdout, "point\n");
    stage.run(&["test", "--list", "moon"]).ends(2, &["no shot's name contains \"moon\""]);
}

#[test]
fn stale_findings_are_not_applied() {
    let stage = pending();
    stage.run(&["accept"]).ends(0, &[]);
    // A removal whose shot is back.
    let (scene, away) = (stage.path("sun.gltf"), stage.path("sun.away"));
    std::fs::rename(&scene, &away).unwrap();
    stage.run(&["test"]).ends(1, &["no shot renders this reference"]);
    std::fs::rename(&away, &scene).unwrap();
    stage
        .run(&["accept"])
        .ends(1, &["references/sun.exr.remove.new: the shots", "have changed since the change was found"]);
    stage.run(&["test", "point"]).ends(0, &[]);
    stage.run(&["accept"]).ends(0, &["no pending images"]);
    // An image whose reference has changed since, to one of an older time.
    stage.scene("point.gltf", "light/point.gltf", "\"intensity\": ", "\"intensity\": 9");
    stage.run(&["test"]).ends(1, &[]);
    let reference = stage.path("references/point.exr");
    let bytes = std::fs::read(&reference).unwrap();
    std::fs::write(&reference, "other").unwrap();
    let old = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(60);
    std::fs::File::options().append(true).open(&reference).unwrap().set_modified(old).unwrap();
    let changed = "the reference has changed since the change was found";
    stage.run(&["accept"]).ends(1, &["point.exr.new: ", changed]);
    std::fs::remove_file(&reference).unwrap();
    stage.run(&["accept"]).ends(1, &["point.exr.new: ", changed]);
    // One that has the same bytes, whatever its time, is the same.
    std::fs::write(&reference, bytes).unwrap();
    stage.run(&["accept"]).ends(0, &["replaced references/point.exr"]);
    // An image whose reference appeared since, and one whose shot is gone.
    stage.scene("moon.gltf", "light/point.gltf", "", "");
    stage.run(&["test", "moon"]).ends(1, &["no reference"]);
    std::fs::copy(&reference, stage.path("references/moon.exr")).unwrap();
    stage
        .run(&["accept", "moon"])
        .ends(1, &["moon.exr.new: the reference or the version of rayframe has changed"]);
    std::fs::remove_file(stage.path("references/moon.exr")).unwrap();
    std::fs::remove_file(stage.path("moon.gltf")).unwrap();
    stage
        .run(&["accept", "moon"])
        .ends(1, &["moon.exr.new: the shots of its name have changed since the change was found"]);
    assert!(!stage.path("references/moon.exr").exists());
}

/// A shot of two frames that brightened since its images were accepted.
fn brighter_frames() -> (Stage, String) {
    let frames = SUITE.replace("frames = 0", "frames = [0, 12]");
    let stage = Stage::accepted(&frames, &[("point.gltf", "light/point.gltf")]);
    stage.scene("point.gltf", "light/point.gltf", "\"intensity\": ", "\"intensity\": 9");
    stage.run(&["test"]).ends(1, &["FAIL point.0000", "FAIL point.0012"]);
    (stage, frames)
}

#[test]
fn images_that_their_shot_no_longer_renders_are_not_accepted() {
    let (stage, frames) = brighter_frames();
    let references = stage.references();
    stage.write("suite.toml", &SUITE.replace("frames = 0", "frames = [0, 1]"));
    let why = "point.0012.exr.new: the shot point does not render it any more";
    stage.run(&["accept", "point"]).ends(1, &[why, "rayframe reject point.0012.exr discards it"]);
    stage.run_with(&["review", "point.0012"], "a\n", None).ends(1, &[why]);
    assert_eq!(stage.references(), references);
    let told = ["replaced references/point.0000.exr", "not accepted: references/point.0012.exr.new", why];
    stage.run(&["accept"]).ends(1, &told);
    stage.run(&["reject", "point.0012.exr"]).ends(0, &["rejected point.0012"]);
    stage.run(&["accept"]).ends(0, &["no pending images"]);
    // A removal of a frame that the shot renders again.
    stage.run(&["test"]).ends(1, &["FAIL point.0012", "no shot renders this reference"]);
    stage.write("suite.toml", &frames);
    stage.run(&["accept", "point.0012"]).ends(1, &["the shots of its name have changed since"]);
    // A view that left the list of the shot.
    let of_views = |views: &str| SUITE.replace("[test]", &format!("[test]\nviews = {views}"));
    stage.write("suite.toml", &of_views("['front', 'left']"));
    stage.run(&["test"]).ends(1, &["FAIL point@left"]);
    stage.write("suite.toml", &of_views("['front']"));
    let why =
        "point@left.exr.new: the shot point does not render it any more; rayframe reject point@left.exr";
    stage.run(&["accept", "point@left"]).ends(1, &[why]);
    stage.run(&["accept", "point@front"]).ends(0, &["added references/point@front.exr"]);
}

#[test]
fn hashes_of_images_that_somebody_deleted_are_removed() {
    for command in ["test", "accept"] {
        let (stage, _) = brighter_frames();
        std::fs::remove_file(stage.path("references/point.0012.exr.new")).unwrap();
        stage.write("suite.toml", SUITE);
        let stray = "point.0012.exr.compared.new".to_owned();
        stage.run(&[command, "sun"]).ends(2, &[]);
        assert!(stage.references().contains(&stray));
        stage.run(&[command, "point"]);
        assert!(!stage.references().contains(&stray), "{:?}", stage.references());
    }
}

#[test]
fn a_failed_test_keeps_pending_images() {
    let stage = pending();
    let references = stage.references();
    stage.write("point.gltf", "{");
    stage.run(&["test"]).ends(1, &["FAIL point\n"]);
    assert_eq!(stage.references(), references);
    stage.write("suite.toml", &SUITE.replace("samples", "sampels"));
    stage.run(&["test"]).ends(65, &["suite.toml:5:1: \"sampels\"", "samples"]);
    assert_eq!(stage.references(), references);
    stage.write("suite.toml", &format!("{SUITE}threads = 2\n"));
    stage.run(&["test"]).ends(65, &["suite.toml:7:1: ", "threads", "has no effect"]);
}

#[test]
fn review_continues_after_a_damaged_reference() {
    let stage = pending();
    stage.run(&["accept"]).ends(0, &[]);
    stage.write("references/point.exr", "damaged");
    stage.run(&["test"]).ends(1, &["is neither an OpenEXR"]);
    stage.run_with(&["review"], "r\n", None).ends(0, &["is neither an OpenEXR", "rejected point"]);
}

#[test]
fn paths_of_files_select_what_their_names_do() {
    let stage = Stage::accepted(
        &format!("scenes = 'sub'\nreferences = 'refs'\n{SUITE}"),
        &[("sub/chars/Fox.gltf", "light/point.gltf"), ("sub/walk.gltf", "light/spot.gltf")],
    );
    for path in ["sub/walk.gltf", "./sub/walk.gltf", "refs/walk.exr", "walk.gltf", "walk.exr"] {
        stage.run(&["test", path]).ends(0, &["1 image identical"]);
        assert_eq!(stage.run(&["test", path, "--list"]).stdout, "walk\n", "{path}");
    }
    stage.scene("sub/walk.gltf", "light/spot.gltf", "\"intensity\": ", "\"intensity\": 9");
    stage.run(&["test"]).ends(1, &["FAIL walk"]);
    stage.run(&["accept", "refs/chars/Fox.exr"]).ends(0, &["no pending images of refs/chars/Fox.exr"]);
    stage.run(&["reject", "refs/walk.exr.new"]).ends(0, &["rejected walk"]);
    stage.run(&["test", "refs/run.exr"]).ends(2, &["no shot's name contains \"refs/run.exr\""]);
    let below = |path: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rayframe"));
        let output = command.args(["test", path, "--list"]).current_dir(stage.path("sub/chars")).output();
        String::from_utf8(output.unwrap().stdout).unwrap()
    };
    for path in ["Fox.gltf", "../chars/Fox.gltf", "../../refs/chars/Fox.exr"] {
        assert_eq!(below(path), "chars/Fox\n", "{path}");
    }
    // The name of another shot wins over a path.
    stage.scene("sub/Fox.gltf", "light/spot.gltf", "", "");
    assert_eq!(below("Fox.gltf"), "Fox\n");
}
