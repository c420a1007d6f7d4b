//! Parts of a suite: shards whose reports are merged, and shots that changed since a revision.

use std::process::Command;

use serde_json::{Value, json};

use super::{Ran, SUITE, Stage};

/// Ten shots: changed within the limits, different, without a reference, broken, identical; and an orphaned reference.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn ten_shots() -> Stage {
    let stage = Stage::new(&format!("{SUITE}aovs = ['material_id']\n"));
    for number in 0..10 {
        stage.scene(&format!("folder/shot{number}.gltf"), "light/point.gltf", "", "");
    }
    stage.run(&["test", "-q"]).ends(1, &[]);
    stage.run(&["accept"]).ends(0, &[]);
    let scene = |number: u32| format!("scene = 'shot{number}.gltf'\n");
    stage.write("folder/shot1.toml", &format!("{}light_scale = 1.01\n", scene(1)));
    stage.write("folder/shot2.toml", &format!("{}light_scale = 3\n", scene(2)));
    stage.write("folder/shot3.toml", &format!("{}resolution = [32, 18]\n", scene(3)));
    stage.write("folder/shot4.gltf", "{");
    std::fs::remove_file(stage.path("references/folder/shot5.exr")).unwrap();
    std::fs::remove_file(stage.path("folder/shot6.gltf")).unwrap();
    stage.scene("folder/shot7.gltf", "light/point.gltf", "[0.6, 0.6, 0.6, 1]", "[0.3, 0.3, 0.3, 1]");
    stage
}

/// The JSON that `rayframe test` printed, without what differs between runs.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn comparable(ran: &Ran) -> Value {
    let mut json: Value = serde_json::from_str(&ran.stdout).unwrap();
    json["seconds"] = Value::Null;
    json["report"] = Value::Null;
    for shot in json["shots"].as_array_mut().unwrap() {
        shot["seconds"] = Value::Null;
    }
    json
}

#[test]
fn merged_shards_are_the_whole_result() {
    let stage = ten_shots();
    let whole = stage.run_with(&["test", "--json", "--no-cache", "--report", "whole"], "", Some("true"));
    let shard = |part: &str, folder: &str| {
        stage.run(&["test", "--json", "--no-cache", "--shard", part, "--report", folder])
    };
    let parts: Vec<Value> = [("1/3", "r1"), ("2/3", "r2"), ("3/3", "r3")]
        .map(|(part, folder)| comparable(&shard(part, folder)))
        .into();
    let names = |json: &Value| json["shots"].as_array().map_or(0, Vec::len);
    assert_eq!(parts.iter().map(names).sum::<usize>(), 9);
    assert!(parts.iter().all(|part| names(part) > 0), "{parts:?}");

    let merge =
        ["test", "--json", "--report", "merged", "--summary", "merged.md", "--merge", "r1", "r2", "r3"];
    let merged = stage.run(&merge);
    assert_eq!(merged.code, whole.code);
    assert!(merged.stdout.contains("materials or textures changed: \\\"floor\\\""), "{}", merged.stdout);
    assert_eq!(comparable(&merged), comparable(&whole));
    // Without the images of what changed nothing can be said.
    std::fs::rename(stage.path("r1/images"), stage.path("kept")).unwrap();
    let without = stage.run(&merge);
    assert_eq!(without.code, Some(66), "{}", without.text);
    std::fs::rename(stage.path("kept"), stage.path("r1/images")).unwrap();
    assert_eq!(comparable(&stage.run(&merge)), comparable(&whole));
    // The merged report has the images of all machines.
    let list = |folder: &str| std::fs::read_to_string(stage.path(folder).join("images.json")).unwrap();
    assert_eq!(list("merged"), list("whole"));
    assert!(std::fs::read_to_string(stage.path("merged.md")).unwrap().contains("folder/shot2"));
    std::fs::remove_file(stage.path("folder/shot4.gltf")).unwrap();
    std::fs::remove_file(stage.path("references/folder/shot4.exr")).unwrap();
    stage
        .run(&["accept", "--from", "merged", "folder/shot2"])
        .ends(0, &["replaced references/folder/shot2.exr"]);
}

#[test]
fn incomplete_and_outdated_reports_are_not_merged() {
    let stage = ten_shots();
    for (part, folder) in [("1/2", "r1"), ("2/2", "r2"), ("1/3", "r3")] {
        stage.run(&["test", "-q", "--shard", part, "--report", folder]);
    }
    stage.run(&["test", "-q", "--report", "whole"]).ends(1, &[]);
    let merge = |folders: &[&str]| stage.run(&[&["test", "--report", "merged", "--merge"], folders].concat());
    merge(&["r1"]).ends(2, &["the report of shard 2/2 is missing"]);
    merge(&["r1", "r1"]).ends(2, &["r1: the report of shard 1/2 is given twice"]);
    merge(&["r2", "r3"]).ends(2, &["r3: the report is that of shard 1/3, and others are of 2 shards"]);
    merge(&["r2", "whole"]).ends(2, &["whole: the report is not that of a shard"]);
    merge(&["r1", "gone"]).ends(66, &["gone/result.json: cannot be read"]);
    stage
        .run(&["test", "--report", "r1", "--merge", "r1", "r2"])
        .ends(2, &["name another folder with --report"]);
    merge(&["r1", "r2"]).ends(1, &["FAIL folder/shot2"]);
    // Reports come from other machines: a name may not lead out of the folder.
    let report = std::fs::read_to_string(stage.path("r1/result.json")).unwrap();
    let hostile = report.replace("\"folder/shot", "\"../../shot");
    assert_ne!(hostile, report);
    stage.write("r1/result.json", &hostile);
    merge(&["r1", "r2"]).ends(65, &["the name \"../../shot", "leaves the folder"]);
    stage.write("other/result.json", "[1]");
    stage
        .run(&["test", "--report", "other"])
        .ends(73, &["other/result.json: is there already and is not the result"]);
    stage.write("r1/result.json", "{");
    merge(&["r1", "r2"]).ends(65, &["r1/result.json: no report of this version"]);
    std::fs::remove_file(stage.path("r1/result.json")).unwrap();
    stage.run(&["test", "-q", "--shard", "1/2", "--report", "r1"]);
    // Reports of filtered runs, of other shots, and of other references of identical images.
    stage.run(&["test", "-q", "shot7", "--shard", "1/2", "--report", "f1"]);
    stage.run(&["test", "-q", "shot7", "--shard", "2/2", "--report", "f2"]);
    merge(&["f1", "f2"]).ends(2, &["no report has the shot folder/"]);
    stage.scene("folder/new.gltf", "light/point.gltf", "", "");
    merge(&["r1", "r2"]).ends(2, &["no report has the shot folder/new"]);
    std::fs::remove_file(stage.path("folder/new.gltf")).unwrap();
    std::fs::rename(stage.path("references/folder/shot9.exr"), stage.path("shot9.exr")).unwrap();
    merge(&["r1", "r2"]).ends(1, &["references/folder/shot9.exr: changed since"]);
    std::fs::rename(stage.path("shot9.exr"), stage.path("references/folder/shot9.exr")).unwrap();
    stage.run(&["accept", "folder/shot2"]).ends(0, &["replaced"]);
    merge(&["r1", "r2"]).ends(1, &["references/folder/shot2.exr: changed since", "was tested; test again"]);
    let seconds = std::fs::read_to_string(stage.path("r1/result.json")).unwrap();
    let (before, after) = seconds.split_once("\"seconds\": ").unwrap();
    stage.write("r1/result.json", &format!("{before}\"seconds\": -{after}"));
    merge(&["r1", "r2"]).ends(65, &["a time is no number of seconds"]);
    stage.run(&["test", "--shard", "4/3"]).ends(2, &["there is no part 4 of 3; parts are 1 to 3"]);
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn git(stage: &Stage, arguments: &[&str]) {
    let identity = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"];
    let output =
        Command::new("git").arg("-C").arg(stage.path("")).args(identity).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn shards_of_what_changed_are_merged() {
    let scenes = ["a.gltf", "b.gltf", "c.gltf", "d.gltf"].map(|name| (name, "light/point.gltf"));
    let stage = Stage::accepted(SUITE, &scenes);
    stage.write(".gitignore", "/report/\n/.rayframe-cache/\n*.new\n/r1/\n/r2/\n/merged/\n");
    git(&stage, &["init", "-q", "-b", "main"]);
    git(&stage, &["add", "-A"]);
    git(&stage, &["commit", "-q", "-m", "a"]);
    stage.write("a.gltf", &(std::fs::read_to_string(stage.path("a.gltf")).unwrap() + " "));
    for (part, folder) in [("1/2", "r1"), ("2/2", "r2")] {
        let ran = stage.run(&[
            "test",
            "--changed-since",
            "HEAD",
            "--shard",
            part,
            "--report",
            folder,
            "--no-cache",
        ]);
        ran.ends(0, &["not tested, as none of their files changed"]);
    }
    let merge = ["test", "--report", "merged", "--merge", "r1", "r2"];
    stage.run(&merge).ends(0, &["1 image identical", "; 3 shots not tested, as none of their files changed"]);
    let json: Value =
        serde_json::from_str(&std::fs::read_to_string(stage.path("merged/result.json")).unwrap()).unwrap();
    assert_eq!((&json["not_tested"], &json["shots"][0]["name"]), (&json!(["b", "c", "d"]), &json!("a")));
    // A shot that no shard saw is still missing.
    stage.scene("e.gltf", "light/point.gltf", "", "");
    stage.run(&merge).ends(2, &["no report has the shot e"]);
}

#[test]
fn shots_that_changed_since_a_revision_are_selected() {
    let stage = Stage::new(SUITE);
    for name in ["a", "b", "d"] {
        stage.scene(&format!("{name}.gltf"), "light/point.gltf", "", "");
    }
    stage.write("c.toml", "scene = 'a.gltf'\n");
    stage.write("with_light.toml", "scene = 'b.gltf'\nenv = 'light.hdr'\n");
    let light = |value| image::Rgb32FImage::from_pixel(8, 4, image::Rgb([value; 3]));
    light(0.5).save(stage.path("light.hdr")).unwrap();
    let listed = |revision: &str| {
        let ran = stage.run(&["test", "--list", "--changed-since", revision]);
        (ran.code, ran.stdout.lines().map(str::to_owned).collect::<Vec<_>>())
    };
    let ran = stage.run(&["test", "--changed-since", "HEAD"]);
    ran.ends(2, &["--changed-since: "]);
    git(&stage, &["init", "-q", "-b", "main"]);
    stage.run(&["test", "-q"]).ends(1, &[]);
    stage.run(&["accept"]).ends(0, &[]);
    stage.write(".gitignore", "/report/\n*.new\n");
    git(&stage, &["add", "-A"]);
    git(&stage, &["commit", "-q", "-m", "a"]);
    assert_eq!(listed("HEAD"), (Some(0), vec![]));
    stage.run(&["test", "--changed-since", "HEAD"]).ends(0, &["0 images identical"]);
    stage.run(&["test", "--changed-since", "gone"]).ends(2, &["\"gone\" is no commit of the repository"]);
    stage.run(&["test", "--changed-since", "--output=x"]).ends(2, &[]);
    // A scene, a file that a shot names, a reference, and a new shot.
    stage.write("a.gltf", &(std::fs::read_to_string(stage.path("a.gltf")).unwrap() + " "));
    assert_eq!(listed("HEAD").1, ["c"]);
    git(&stage, &["checkout", "-q", "a.gltf"]);
    light(0.6).save(stage.path("light.hdr")).unwrap();
    assert_eq!(listed("HEAD").1, ["with_light"]);
    git(&stage, &["checkout", "-q", "."]);
    std::fs::remove_file(stage.path("references/d.exr")).unwrap();
    stage.scene("new.gltf", "light/point.gltf", "", "");
    assert_eq!(listed("HEAD").1, ["d", "new"]);
    git(&stage, &["add", "-A"]);
    stage.run(&["test", "-q"]).ends(1, &[]);
    stage.run(&["accept"]).ends(0, &[]);
    git(&stage, &["add", "-A"]);
    git(&stage, &["commit", "-q", "-m", "b"]);
    assert_eq!(listed("HEAD").1, [""; 0]);
    assert_eq!(listed("HEAD~1").1, ["new"]);
    // What git does not track may differ; links count as well as what they point to.
    stage.write(".gitignore", "/report/\n*.new\nignored.gltf\n");
    stage.scene("ignored.gltf", "light/point.gltf", "", "");
    stage.run(&["test", "ignored"]).ends(1, &[]);
    stage.run(&["accept", "ignored"]).ends(0, &[]);
    git(&stage, &["add", "-A"]);
    git(&stage, &["commit", "-q", "-m", "c"]);
    assert_eq!(listed("HEAD").1, ["ignored"]);
    std::fs::remove_file(stage.path("ignored.gltf")).unwrap();
    std::fs::remove_file(stage.path("references/ignored.exr")).unwrap();
    git(&stage, &["commit", "-q", "-a", "-m", "d"]);
    // A scene becomes a shot when its shot file goes.
    std::fs::remove_file(stage.path("c.toml")).unwrap();
    std::fs::remove_file(stage.path("references/c.exr")).unwrap();
    assert_eq!(listed("HEAD").1, ["a"]);
    let ran = stage.run(&["test", "--changed-since", "HEAD"]);
    ran.ends(1, &["FAIL a", "3 shots not tested, as none of their files changed"]);
    git(&stage, &["checkout", "-q", "."]);
    stage.write("suite.toml", &format!("{SUITE}# comment\n"));
    assert_eq!(listed("HEAD").1, ["c", "d", "new", "with_light"]);
}

/// What `git diff` does not name: references that are missing in both, ignored, behind links, and in a repository of their own.
#[cfg(unix)]
#[test]
fn references_that_no_difference_names_select_their_shots() {
    let stage = Stage::new(SUITE);
    for name in ["a", "b", "d"] {
        stage.scene(&format!("{name}.gltf"), "light/point.gltf", "", "");
    }
    stage.scene("base.gltf", "light/spot.gltf", "", "");
    stage.write("c.toml", "scene = 'base.gltf'\n[test]\nviews = ['front', 'back']\n");
    stage.write(".gitignore", "/report/\n*.new\n");
    stage.run(&["test", "-q"]).ends(1, &[]);
    stage.run(&["accept"]).ends(0, &[]);
    git(&stage, &["init", "-q", "-b", "main"]);
    let commit = || {
        git(&stage, &["add", "-A"]);
        git(&stage, &["commit", "-q", "-m", "a"]);
    };
    let listed = || {
        let ran = stage.run(&["test", "--list", "--changed-since", "HEAD"]);
        ran.stdout.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    commit();
    assert_eq!(listed(), [""; 0]);
    // One of two references.
    std::fs::remove_file(stage.path("references/c@back.exr")).unwrap();
    commit();
    assert_eq!(listed(), ["c"]);
    git(&stage, &["checkout", "-q", "HEAD~1", "--", "references/c@back.exr"]);
    commit();
    assert_eq!(listed(), [""; 0]);
    // A reference that is ignored, and one that is a link to a file elsewhere.
    stage.write(".gitignore", "/report/\n*.new\n/references/b.exr\n");
    git(&stage, &["rm", "-q", "--cached", "references/b.exr"]);
    std::fs::create_dir(stage.path("store")).unwrap();
    std::fs::rename(stage.path("references/d.exr"), stage.path("store/d.exr")).unwrap();
    std::os::unix::fs::symlink("../store/d.exr", stage.path("references/d.exr")).unwrap();
    commit();
    assert_eq!(listed(), ["b"]);
    stage.write("store/d.exr", "another file");
    assert_eq!(listed(), ["b", "d"]);
    // References in a repository of their own are not tracked by that of the suite.
    git(&stage, &["rm", "-r", "-q", "--cached", "references"]);
    for command in [&["init", "-q", "-b", "main"][..], &["add", "-A"], &["commit", "-q", "-m", "a"]] {
        git(&stage, &[&["-C", "references"], command].concat());
    }
    commit();
    assert_eq!(listed(), ["a", "b", "c", "d"]);
}
