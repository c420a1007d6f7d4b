//! Summaries for pull requests, and annotations of build servers.

use rayframe::image_file::decode_png;
use serde_json::Value;

use super::{SUITE, Stage};

/// A suite with an identical image, a change within the limits, a difference, a missing and an orphaned reference.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn stage() -> Stage {
    let scenes = [
        ("a/point.gltf", "light/point.gltf"),
        ("a/spot.gltf", "light/spot.gltf"),
        ("sun.gltf", "light/directional.gltf"),
    ];
    let stage = Stage::accepted(SUITE, &scenes);
    stage.write("a/point.toml", "scene = 'point.gltf'\nlight_scale = 1.01\n");
    stage.write("a/spot.toml", "scene = 'spot.gltf'\nlight_scale = 3\n");
    stage.scene("new_one.gltf", "light/range.gltf", "", "");
    std::fs::copy(stage.path("references/sun.exr"), stage.path("references/old.exr")).unwrap();
    stage
}

#[test]
fn a_summary_lists_failures_and_changes_worst_first_with_thumbnails() {
    let stage = stage();
    stage.run(&["test", "--summary", "out/my summary.md"]).ends(1, &[]);
    let text = std::fs::read_to_string(stage.path("out/my summary.md")).unwrap();
    assert!(text.contains(": 3 failed, 1 changed within limits, 1 identical\n"), "{text}");
    let rows: Vec<&str> =
        text.lines().filter(|line| line.starts_with("| <code>") || line.starts_with('#')).collect();
    let begins = [
        "## ",
        "### Failed",
        "| <code>new&#95;one</code> | failed: missing | there is no reference ",
        "| <code>old</code> | failed: orphaned | no shot renders this reference |",
        "| <code>a/spot</code> | failed: different | mean FLIP: ",
        "### Changed within limits",
        "| <code>a/point</code> | changed within limits | difference of mean brightness: ",
    ];
    assert_eq!(rows.len(), begins.len(), "{text}");
    for (row, begin) in rows.iter().zip(begins) {
        assert!(row.starts_with(begin), "{row}\n{begin}");
    }
    assert!(rows[4].contains("| light: red times ") && rows[6].contains("| light: red times 1.010"));
    // Every cell has as many bars as the head, and every thumbnail exists.
    for row in text.lines().filter(|line| line.starts_with('|')) {
        assert_eq!(row.matches('|').count(), 8, "{row}");
    }
    let addresses: Vec<&str> =
        text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(a, _)| a).collect();
    assert_eq!(addresses.len(), 1 + 1 + 3 + 3, "{addresses:?}");
    for address in &addresses {
        let png = std::fs::read(stage.path("out").join(address.replace("%20", " "))).unwrap();
        assert_eq!(decode_png(std::path::Path::new(address), &png).unwrap().size, (48, 27));
    }
    // A later run leaves no old thumbnails.
    stage.run(&["test", "sun", "--summary", "out/my summary.md"]).ends(0, &[]);
    let text = std::fs::read_to_string(stage.path("out/my summary.md")).unwrap();
    assert!(
        text.ends_with(": 1 identical\n\n<!-- rayframe summary -->\n") && text.lines().count() == 3,
        "{text}"
    );
    assert_eq!(std::fs::read_dir(stage.path("out/my summary.md.files")).unwrap().count(), 0);
    stage.run(&["test", "--summary", "suite.toml/summary.md"]).ends(73, &["suite.toml"]);
}

#[test]
fn reports_show_passing_images_where_they_are_asked_for() {
    let stage = stage();
    let shots = |arguments: &[&str]| {
        stage.run(&[&["test", "-q", "--report"], arguments].concat());
        let text = std::fs::read_to_string(stage.path(arguments[0]).join("index.html")).unwrap();
        let json =
            text.split_once("<script type=\"application/json\"").and_then(|(_, rest)| rest.split_once('>'));
        let json = json.and_then(|(_, rest)| rest.split_once("</script>")).map(|(json, _)| json).unwrap();
        let page: Value = serde_json::from_str(json).unwrap();
        page["shots"].as_array().unwrap().clone()
    };
    let names = |shots: &[Value]| -> Vec<String> {
        shots.iter().map(|shot| shot["name"].as_str().unwrap_or_default().to_owned()).collect()
    };
    let failing = ["a/spot", "new_one", "old", "a/point"];
    assert_eq!(names(&shots(&["plain", "--no-cache"])), failing);
    // Whether the shot was rendered or its verdict kept.
    for arguments in [&["fresh", "--report-passing", "--no-cache"][..], &["kept", "--report-passing"]] {
        let shots = shots(arguments);
        assert_eq!(names(&shots), [&failing[..], &["sun"]].concat());
        let frame = &shots[4]["frames"][0];
        assert_eq!((&frame["verdict"], &frame["expected"]["width"]), (&"identical".into(), &48.into()));
    }
    // Merged reports, too.
    for (part, folder) in [("1/2", "r1"), ("2/2", "r2")] {
        stage.run(&["test", "-q", "--shard", part, "--report", folder]);
    }
    assert_eq!(
        names(&shots(&["merged", "--report-passing", "--merge", "r1", "r2"])).last(),
        Some(&"sun".into())
    );
    stage.run(&["test", "--list", "--report-passing"]).ends(2, &[]);
}

#[test]
fn annotations_name_files_of_the_repository() {
    let stage = stage();
    std::fs::create_dir(stage.path(".git")).unwrap();
    stage.run(&["test", "--init", "--github-annotations"]).ends(2, &[]);
    let ran = stage.run(&["test", "--github-annotations", "--code-quality", "quality.json", "-q"]);
    let expected = [
        "::error file=new_one.gltf,title=new_one failed%3A missing::there is no reference ",
        "::error file=references/old.exr,title=old failed%3A orphaned::no shot renders",
        "::error file=a/spot.toml,title=a/spot failed%3A different::mean FLIP: ",
        "::warning file=a/point.toml,title=a/point changed within limits::difference of mean brightness: ",
    ];
    let commands: Vec<&str> = ran.text.lines().filter(|line| line.starts_with("::")).collect();
    assert_eq!(commands.len(), expected.len(), "{}", ran.text);
    for (command, begin) in commands.iter().zip(expected) {
        assert!(command.starts_with(begin), "{command}");
    }
    assert!(commands[2].contains("%0Alikely light: "), "{}", commands[2]);
    assert!(!ran.stdout.contains("::error"), "{}", ran.stdout);

    let text = std::fs::read_to_string(stage.path("quality.json")).unwrap();
    let issues: Vec<Value> = serde_json::from_str(&text).unwrap();
    let told: Vec<_> = issues
        .iter()
        .map(|issue| (issue["check_name"].as_str().unwrap(), issue["severity"].as_str().unwrap()))
        .collect();
    let kinds = [("missing", "major"), ("orphaned", "major"), ("different", "major"), ("changed", "minor")];
    assert_eq!(
        told,
        kinds
            .map(|(kind, severity)| (["rayframe-", kind].concat(), severity))
            .each_ref()
            .map(|(a, b)| (a.as_str(), *b))
    );
    assert_eq!(issues[2]["location"], serde_json::json!({"path": "a/spot.toml", "lines": {"begin": 1}}));
    let prints: std::collections::BTreeSet<_> =
        issues.iter().map(|issue| issue["fingerprint"].as_str()).collect();
    assert_eq!(prints.len(), 4);
    stage.run(&["test", "sun", "--code-quality", "quality.json"]).ends(0, &[]);
    assert_eq!(std::fs::read_to_string(stage.path("quality.json")).unwrap(), "[]\n");
}
