//! Reports of `rayframe diff`: JSON against its schema, and the HTML page.

use std::path::Path;

use serde_json::Value;

use super::{Stage, json, rayframe};
use crate::progress::schema::Schema;

#[test]
fn json_matches_its_schema() {
    let stage = Stage::new();
    let schema = Schema::read("diff");
    let a = stage.square("a.exr", (40, 24), 4);
    let b = stage.square("b.exr", (40, 24), 24);
    let wide = stage.square("wide.exr", (48, 24), 4);
    let broken = stage.at("broken.exr");
    // Files of rayframe are finite; those of other programs need not be.
    let pixel = |x: usize, _: usize| (0.2_f32, if x == 7 { f32::INFINITY } else { 0.2 }, f32::NAN, 1.0_f32);
    exr::prelude::write_rgba_file(&broken, 40, 24, pixel).unwrap();
    for frame in [1, 2, 3] {
        stage.square(&format!("new/a.{frame:04}.exr"), (40, 24), 4 * frame);
    }
    stage.square("old/a.0002.exr", (40, 24), 4);
    stage.square("old/a.0004.exr", (40, 24), 4);
    let (new, old) = (stage.at("new"), stage.at("old"));
    let lit = stage.rendered("lit.exr", "light/point.gltf", |_| {}, &[]);
    let brighter = stage.rendered("brighter.exr", "light/point.gltf", |_| {}, &["--light-scale", "1.3"]);
    let pairs = [
        [&a, &a],
        [&b, &a],
        [&wide, &a],
        [&broken, &a],
        [&a, &broken],
        [&new, &old],
        [&lit, &a],
        [&brighter, &lit],
    ];
    let is_faulty = |one: &String, other: &String| [&wide, &broken, &lit].contains(&one) || other == &broken;
    for [actual, reference] in pairs {
        for preset in ["exact", "strict", "visual", "noisy"] {
            let report = json(&rayframe(&["diff", actual, reference, "--preset", preset, "--json"]));
            schema.check(&report);
            assert_eq!(
                report["frames"][0]["faults"].as_array().unwrap().is_empty(),
                !is_faulty(actual, reference),
                "{actual}"
            );
            // The schema also rejects values.
            for (name, value) in [("schema", 2.into()), ("preset", "loose".into()), ("same", Value::Null)] {
                let mut wrong = report.clone();
                wrong[name] = value;
                assert!(!schema.accepts(&wrong), "{name}");
            }
        }
    }
}

#[test]
fn a_report_is_one_page_with_its_images() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (40, 24), 4);
    let b = stage.square("b.exr", (40, 24), 24);
    let folder = stage.at("deep/report");
    let output = rayframe(&["diff", &b, &a, "--report", &folder]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let page = report_page(&folder);
    let shot = &page["shots"][0];
    assert_eq!((&page["can_approve"], &page["folders"][0]["failed"]), (&false.into(), &1.into()));
    assert_eq!(shot["frames"][0]["actual"]["width"], 40);
    assert_eq!(shot["frames"][0]["status"], "different");
    let command = format!("rayframe diff {b} {a} --preset visual --json");
    assert!(shot["commands"].as_array().unwrap().iter().any(|named| named[1] == command.as_str()), "{shot}");
    // A second run writes the same bytes.
    let bytes = std::fs::read(format!("{folder}/index.html")).unwrap();
    rayframe(&["diff", &b, &a, "--report", &folder]);
    assert!(bytes == std::fs::read(format!("{folder}/index.html")).unwrap());
    assert_eq!(rayframe(&["diff", &a, &a, "--report", &folder]).status.code(), Some(0));
    let page = report_page(&folder);
    assert_eq!(
        (page["shots"].as_array().map(Vec::len), &page["folders"][0]["identical"]),
        (Some(0), &1.into())
    );
    // A page that cannot be written is refused before anything is compared.
    let output = rayframe(&["diff", &stage.at("gone.exr"), &a, "--report", &format!("{a}/report")]);
    assert_eq!(output.status.code(), Some(73), "{output:?}");
    assert_eq!(rayframe(&["diff", &a, &a, "--report", ""]).status.code(), Some(2));
}

#[test]
fn a_summary_of_a_comparison_is_that_of_a_suite() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (40, 24), 4);
    let b = stage.square("b.exr", (40, 24), 24);
    let file = stage.at("deep/summary.md");
    let summary = |actual: &str, reference: &str| {
        let code = rayframe(&["diff", actual, reference, "--summary", &file]).status.code();
        (code, std::fs::read_to_string(&file).unwrap_or_default())
    };
    let (code, text) = summary(&b, &a);
    assert_eq!(code, Some(1));
    assert!(text.starts_with("## ") && text.contains(": 1 failed\n"), "{text}");
    assert!(text.contains("| failed: different | mean FLIP: ") && text.contains("b.exr"), "{text}");
    let thumbnails = |text: &str| text.matches("](summary.md.files/").count();
    assert_eq!(thumbnails(&text), 3, "{text}");
    let (code, text) = summary(&a, &a);
    assert!(code == Some(0) && text.contains(": 1 identical\n") && thumbnails(&text) == 0, "{text}");
    // Sequences, with a frame that only one side has.
    for (folder, frames) in [("new", [1, 2]), ("old", [2, 3])] {
        for frame in frames {
            stage.square(&format!("{folder}/a.{frame:04}.exr"), (40, 24), 4);
        }
    }
    let (code, text) = summary(&stage.at("new"), &stage.at("old"));
    assert_eq!(code, Some(1));
    assert!(text.contains(": 2 failed, 1 identical\n") && text.contains("| failed: missing |"), "{text}");
    // With a page, both show the same images, and a place that cannot be written is found before anything is compared.
    let folder = stage.at("page");
    rayframe(&["diff", &b, &a, "--summary", &file, "--report", &folder]);
    assert!(std::fs::read_to_string(&file).is_ok_and(|text| thumbnails(&text) == 3));
    assert_eq!(report_page(&folder)["folders"][0]["failed"], 1);
    let output = rayframe(&["diff", &stage.at("gone.exr"), &a, "--summary", &format!("{a}/summary.md")]);
    assert_eq!(output.status.code(), Some(73), "{output:?}");
}

#[test]
fn a_summary_of_two_assets_tells_lost_content_first() {
    let stage = Stage::new();
    let lose = |scene: &mut Value| {
        scene.as_object_mut().unwrap().remove("animations");
    };
    let scene = "animation/hierarchy.gltf";
    let (old, new) = (stage.version("old.gltf", scene, |_| {}), stage.version("new.gltf", scene, lose));
    let file = stage.at("summary.md");
    let output = rayframe(&["diff", &new, &old, "-r", "64x36", "--samples", "1", "--summary", &file]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let text = std::fs::read_to_string(&file).unwrap();
    let head = text.lines().next().unwrap_or_default();
    assert!(head.contains(": 1 lost, ") && text.contains("\n### Lost\n\n- lost: "), "{text}");
}

#[test]
fn a_report_of_a_sequence_has_all_frames_and_those_without_a_counterpart() {
    let stage = Stage::new();
    for (frame, column) in [(1, 4), (2, 24), (4, 4)] {
        stage.square(&format!("new/a.{frame:04}.exr"), (40, 24), column);
    }
    for frame in [1, 2, 3] {
        stage.square(&format!("old/a.{frame:04}.exr"), (40, 24), 4);
    }
    let folder = stage.at("report");
    let output = rayframe(&["diff", &stage.at("new/a.####.exr"), &stage.at("old"), "--report", &folder]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let page = report_page(&folder);
    let frames = page["shots"][0]["frames"].as_array().unwrap();
    let told: Vec<_> =
        frames.iter().map(|frame| (frame["frame"].as_i64(), frame["status"].as_str())).collect();
    let wanted = [(1, "passed"), (2, "different"), (3, "orphaned"), (4, "missing")];
    assert_eq!(told, wanted.map(|(frame, status)| (Some(frame), Some(status))));
    let has = |frame: usize, side: &str| !frames[frame][side].is_null();
    let has_images = [0, 1, 2, 3].map(|frame| (has(frame, "expected"), has(frame, "actual")));
    assert_eq!(has_images, [(false, false), (true, true), (true, false), (false, true)]);
    assert_eq!((has(0, "flip"), has(1, "errors"), has(3, "flip")), (true, true, false));
    assert!(page["shots"][0]["commands"][0][1].as_str().unwrap().contains("a.0002.exr"));
}

#[test]
fn frames_with_previews_of_their_names_are_told_apart() {
    let stage = Stage::new();
    // The worst frame is the EXR file of the first pair.
    for (name, column) in [("a.0001.exr", 24), ("a.0001.png", 4), ("a.0002.exr", 4)] {
        stage.square(&format!("new/{name}"), (40, 24), column);
        stage.square(&format!("old/{name}"), (40, 24), 4);
    }
    stage.square("new/a.0002.png", (40, 24), 5);
    stage.square("old/a.0002.png", (40, 24), 4);
    let [new, old, folder, summary] = ["new", "old", "report", "summary.md"].map(|name| stage.at(name));
    let options = ["--fail-on", "changed", "--report", &folder, "--summary", &summary];
    let output = rayframe(&[&["diff", &new, &old][..], &options].concat());
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let page = report_page(&folder);
    let names: Vec<_> =
        page["shots"][0]["frames"].as_array().unwrap().iter().map(|frame| &frame["name"]).collect();
    let name = |name: &str| format!("{new}/{name}");
    let wanted = ["a.0001.exr", "a.0001.png", "a.0002.exr", "a.0002.png"].map(name);
    assert_eq!(names, wanted.iter().collect::<Vec<_>>());
    let command = page["shots"][0]["commands"][0][1].as_str().unwrap();
    assert!(command.contains("new/a.0001.exr") && command.contains("old/a.0001.exr"), "{command}");
    let summary = std::fs::read_to_string(summary).unwrap();
    assert!(summary.contains("a.0001.exr") && summary.contains("a.0002.png"), "{summary}");
}

/// The data of a page.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn report_page(folder: &str) -> Value {
    let text = std::fs::read_to_string(format!("{folder}/index.html")).unwrap();
    let (_, rest) = text.split_once("id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn outputs_replace_no_input_and_not_each_other() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (40, 24), 4);
    let b = stage.square("b.exr", (40, 24), 24);
    let sky = stage.square("sky.exr", (8, 4), 4);
    std::fs::create_dir(stage.at("below")).unwrap();
    // Another name of the same file.
    let same = stage.at("below/../b.exr");
    let [s, t] = ["s.gltf", "t.gltf"].map(|name| {
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/light/point.gltf");
        std::fs::copy(scene, stage.at(name)).unwrap();
        stage.at(name)
    });
    let refused = |arguments: &[&str], file: &str, words: &str| {
        let before = std::fs::read(file).ok();
        let output = rayframe(&[&["diff", "--overwrite"], arguments].concat());
        let told = String::from_utf8_lossy(&output.stderr);
        let words = format!("\"{file}\" {words} and cannot be written to as well; choose another name");
        assert!(output.status.code() == Some(2) && told.contains(&words), "{arguments:?}: {told}");
        assert_eq!(std::fs::read(file).ok(), before);
    };
    for file in [&a, &b, &same] {
        refused(&[&a, &b, "--summary", file], file, "is an input");
        refused(&[&a, &b, "--flip-map", file], file, "is an input");
    }
    for file in [&s, &t] {
        refused(&[&s, &t, "--summary", file], file, "is an input");
    }
    refused(&[&s, &t, "--env", &sky, "--summary", &sky], &sky, "is an input");
    let (page, map) = (stage.at("report/index.html"), stage.at("map.exr"));
    let other = "will hold something else";
    refused(&[&a, &b, "--report", &stage.at("report"), "--summary", &page], &page, other);
    refused(&[&a, &b, "--flip-map", &map, "--summary", &map], &map, other);
    assert!(!Path::new(&page).exists() && !Path::new(&map).exists());
}
