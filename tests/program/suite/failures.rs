//! Failures of `rayframe test` and their messages.

use super::{SUITE, Stage};

const POINT: (&str, &str) = ("light/point.gltf", "light/point.gltf");

#[test]
fn a_new_folder_becomes_a_suite_that_guards_a_scene() {
    let stage = Stage::new("");
    stage.run(&["test", "--init"]).ends(73, &["suite.toml", "is there already"]);
    std::fs::remove_file(stage.path("suite.toml")).unwrap();
    stage.run(&["test"]).ends(2, &["rayframe test --init makes one"]);
    stage.run(&["test", "--init"]).ends(0, &["suite.toml written"]);
    stage.run(&["test"]).ends(65, &["neither a shot file (.toml) nor a scene"]);
    stage.scene("point.gltf", POINT.1, "", "");
    stage.run(&["test"]).ends(1, &["there is no reference references/point@camera.exr", "report/index.html"]);
    stage.run(&["accept"]).ends(0, &["added references/point@camera.exr"]);
    stage.run(&["test"]).ends(0, &["1 image identical"]);
    assert!(std::fs::read_to_string(stage.path(".gitignore")).unwrap().contains("*.new"));
    // From a folder below as well.
    std::fs::create_dir(stage.path("below")).unwrap();
    let below = stage.path("below");
    let suite = ["test", "--suite", ".."];
    let output =
        std::process::Command::new(env!("CARGO_BIN_EXE_rayframe")).arg("test").current_dir(&below).output();
    assert!(output.unwrap().status.success());
    let output =
        std::process::Command::new(env!("CARGO_BIN_EXE_rayframe")).args(suite).current_dir(&below).output();
    assert!(output.unwrap().status.success());
}

#[test]
fn a_second_suite_of_a_folder_has_folders_of_its_own() {
    let stage = Stage::new("");
    std::fs::remove_file(stage.path("suite.toml")).unwrap();
    stage.scene("point.gltf", POINT.1, "", "");
    let nightly = ["--suite", "nightly.toml"];
    stage.run(&["test", "--init"]).ends(0, &[]);
    stage
        .run(&[&["test", "--init"], &nightly[..]].concat())
        .ends(0, &["nightly.toml written", "add to .gitignore: /nightly-report/ *.new"]);
    let text = std::fs::read_to_string(stage.path("nightly.toml")).unwrap();
    stage.write("nightly.toml", &text.replace("[320, 180]", "[48, 27]"));
    stage.run(&["test"]).ends(1, &["there is no reference references/"]);
    stage.run(&["accept"]).ends(0, &["added references/point@camera.exr"]);
    stage.run(&[&["test"], &nightly[..]].concat()).ends(1, &["there is no reference nightly-references/"]);
    stage.run(&[&["accept"], &nightly[..]].concat()).ends(0, &["added nightly-references/point@camera.exr"]);
    for suite in [&[][..], &nightly] {
        stage.run(&[&["test"], suite].concat()).ends(0, &["1 image identical"]);
    }
}

#[test]
fn commands_of_the_report_run_for_names_that_look_like_options() {
    let stage = Stage::new(SUITE);
    stage.scene("-x.gltf", POINT.1, "", "");
    stage.run(&["test", "--", "-x"]).ends(1, &["FAIL -x"]);
    let page = std::fs::read_to_string(stage.path("report/index.html")).unwrap();
    for command in ["rayframe test --suite suite.toml -- -x", "rayframe accept --suite suite.toml -- -x"] {
        assert!(page.contains(command), "{command}");
        let words: Vec<_> = command.split(' ').skip(1).collect();
        assert_ne!(stage.run(&words).code, Some(2), "{command}");
    }
    stage.run(&["test"]).ends(0, &["1 image identical"]);
}

#[test]
fn commands_permit_the_folders_that_were_permitted() {
    let stage = Stage::new("");
    stage.write("suite/suite.toml", &format!("references = '../my refs'\n{SUITE}"));
    stage.scene("suite/point.gltf", POINT.1, "", "");
    let options = ["--suite", "suite", "--allow-dir", "my refs"];
    let ran = stage.run(&[&["test"], &options[..]].concat());
    let typed = "--suite suite --allow-dir 'my refs'";
    let next = format!("rayframe review {typed}, or rayframe accept|reject [NAME] {typed}");
    ran.ends(1, &["FAIL point", &next]);
    let page = std::fs::read_to_string(stage.path("suite/report/index.html")).unwrap();
    let page = page.replace("&#39;", "'");
    let of_suite = "--suite suite/suite.toml --allow-dir 'my refs'";
    for command in ["test", "test point", "accept point", "reject point"] {
        let command = format!("rayframe {command} {of_suite}");
        assert!(page.contains(&command), "{command}");
    }
    let folder = stage.0.path().canonicalize().unwrap();
    let [suite, references] = ["suite/suite.toml", "my refs"].map(|name| folder.join(name));
    let approvals = format!(
        "--approvals approvals.json --suite {} --allow-dir '{}'",
        suite.display(),
        references.display()
    );
    assert!(page.contains(&approvals), "{approvals}");
    let accepted = stage.run(&[&["accept", "point"], &options[..]].concat());
    accepted.ends(0, &["added my refs/point.exr"]);
    std::fs::remove_file(stage.path("my refs/point.exr")).unwrap();
    let in_ci = stage.run_with(&[&["test"], &options[..]].concat(), "", Some("true"));
    in_ci.ends(1, &["FAIL point", &format!("rayframe accept --from DIR {typed}")]);
    let accepted = stage.run(&[&["accept", "--from", "suite/report"], &options[..]].concat());
    accepted.ends(0, &["added my refs/point.exr"]);
}

#[test]
fn shots_that_make_several_sequences_name_the_list_that_tests_them() {
    let stage = Stage::new(SUITE);
    stage.scene("point.gltf", POINT.1, "", "");
    for (setting, list) in [("camera", "cameras"), ("animation", "clips"), ("variant", "variants")] {
        stage.write("all.toml", &format!("scene = 'point.gltf'\n{setting} = 'each'\n"));
        let why = format!("all.toml:2:1: {setting}: each makes several sequences");
        stage.run(&["test"]).ends(1, &[&why, &format!("or write {list} = \"each\" in the table [test]")]);
    }
}

#[test]
fn a_changed_scene_fails_with_value_limit_and_cause_until_it_is_accepted_or_rejected() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    stage.scene(POINT.0, POINT.1, "\"intensity\": ", "\"intensity\": 9");
    let ran = stage.run(&["test"]);
    ran.ends(
        1,
        &["FAIL light/point (preset visual)", "mean FLIP: 0.", " > 0.08", "likely light", "1 failed"],
    );
    assert_eq!(
        stage.references(),
        ["light/point.exr", "light/point.exr.compared.new", "light/point.exr.new"]
    );
    // `test` never applies a finding.
    stage.run(&["test"]).ends(1, &["FAIL light/point"]);
    stage.run(&["reject"]).ends(0, &["rejected light/point"]);
    assert_eq!(stage.references(), ["light/point.exr"]);
    stage.run(&["test"]).ends(1, &["FAIL light/point"]);
    stage.run(&["accept", "light/point"]).ends(0, &["replaced references/light/point.exr"]);
    stage.run(&["test"]).ends(0, &["1 image identical"]);
    assert_eq!(stage.references(), ["light/point.exr"]);
}

#[test]
fn an_image_that_passes_again_leaves_nothing_pending() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    stage.scene(POINT.0, POINT.1, "\"intensity\": ", "\"intensity\": 9");
    stage.run(&["test"]).ends(1, &[]);
    stage.scene(POINT.0, POINT.1, "", "");
    stage.run(&["test"]).ends(0, &[]);
    assert_eq!(stage.references(), ["light/point.exr"]);
    stage.run(&["accept"]).ends(0, &["no pending images"]);
    // A name of a shot is no error, and neither is a part of one.
    for name in ["light/point", "light/point.exr", "light"] {
        stage.run(&["accept", name]).ends(0, &["no pending images of light"]);
    }
    stage.run(&["accept", "lihgt"]).ends(2, &["no shot or image has the name \"lihgt\", or contains it"]);
}

#[test]
fn a_reference_without_a_shot_fails_and_its_removal_can_be_accepted() {
    let stage = Stage::accepted(SUITE, &[POINT, ("light/spot.gltf", "light/spot.gltf")]);
    std::fs::rename(stage.path("light/spot.gltf"), stage.path("light/lamp.gltf")).unwrap();
    // A filter does not report references of other shots.
    stage.run(&["test", "light/point"]).ends(0, &["1 image identical"]);
    stage
        .run(&["test", "light"])
        .ends(1, &["FAIL light/lamp", "FAIL light/spot", "no shot renders this reference"]);
    let renamed = [
        "equals the reference light/spot, which no shot renders: renamed?",
        "equals the image light/lamp, which has no reference: renamed?",
    ];
    stage.run(&["test", "light"]).ends(1, &renamed);
    // What files tell of their scenes does not count.
    stage.scene("light/lamp.gltf", "light/spot.gltf", "\"floor\"", "\"ground\"");
    stage.run(&["test", "light"]).ends(1, &renamed);
    stage.run(&["accept"]).ends(0, &["added references/light/lamp.exr", "removed references/light/spot.exr"]);
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    assert_eq!(stage.references(), ["light/lamp.exr", "light/point.exr"]);
}

#[test]
fn jobs_of_a_farm_are_no_shots() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    for folder in ["job", "."] {
        let job = ["farm", "slurm", POINT.0, "-o", "out/a.####.exr", "--out-dir", folder];
        stage.run(&job).ends(0, &["job files in"]);
        assert!(stage.path(folder).join("shot.toml").is_file());
    }
    stage.run(&["test"]).ends(0, &["1 image identical, 0 changed within limits, 0 failed"]);
    assert_eq!(stage.references(), ["light/point.exr"]);
    // What the list of a job does not name, and what a file of another program names.
    stage.write("job/own.toml", "scene = '../light/point.gltf'\n");
    stage.write("job.json", r#"{"job_files": {"shot.toml": []}}"#);
    assert_eq!(stage.run(&["test", "--list"]).stdout, "job/own\nshot\n");
}

#[test]
fn sizes_frames_and_broken_files_fail() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    stage.write("suite.toml", &SUITE.replace("48", "32"));
    stage.run(&["test"]).ends(1, &["the size is 32x27, the reference's 48x27"]);

    // With two frames the names of the references differ from those with one.
    stage.write("suite.toml", &SUITE.replace("frames = 0", "frames = [0, 12]"));
    let words = ["FAIL light/point.0000", "FAIL light/point.0012", "FAIL light/point\n", "no shot renders"];
    stage.run(&["test"]).ends(1, &words);

    stage.write("suite.toml", SUITE);
    stage.write("references/light/point.exr", "version https://git-lfs.github.com/spec/v1\noid sha256:12\n");
    stage.run(&["test"]).ends(1, &["FAIL light/point", "git lfs pull"]);
    stage.write(POINT.0, "{");
    stage.run(&["test"]).ends(1, &["FAIL light/point", "light/point.gltf: "]);
    // A shot that could not be opened still uses its reference.
    assert!(!stage.run(&["test"]).text.contains("no shot renders"));
}

#[test]
fn a_reference_that_cannot_be_read_is_the_failure_of_its_frame_alone() {
    let frames = SUITE.replace("frames = 0", "frames = [0, 12]");
    let stage = Stage::accepted(&frames, &[POINT]);
    let reference = stage.path("references/light/point.0012.exr");
    std::fs::remove_file(&reference).unwrap();
    std::fs::create_dir(&reference).unwrap();
    let told =
        ["FAIL light/point.0012\n     references/light/point.0012.exr: is a folder", "1 image identical"];
    stage.run(&["test"]).ends(1, &told);
    // No image replaces it.
    stage.run(&["accept"]).ends(0, &["no pending images"]);
}

#[test]
fn an_image_too_large_for_a_reference_fails_and_is_not_kept() {
    let stage = Stage::new(&format!("max_reference_kib = 1\n{SUITE}"));
    stage.scene(POINT.0, POINT.1, "", "");
    stage.run(&["test"]).ends(1, &["KiB and a reference at most 1", "raise max_reference_kib"]);
    assert_eq!(stage.references(), [] as [&str; 0]);
    stage.write("suite.toml", SUITE);
    stage.run(&["test"]).ends(1, &["no reference"]);
    stage.write("suite.toml", &format!("max_reference_kib = 1\n{SUITE}"));
    stage.run(&["accept"]).ends(77, &["a reference at most 1"]);
}

#[test]
fn the_image_of_an_older_scene_is_not_accepted_after_a_broken_one() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    stage.scene(POINT.0, POINT.1, "\"intensity\": ", "\"intensity\": 1");
    stage.run(&["test"]).ends(1, &["FAIL light/point"]);
    assert!(stage.references().contains(&"light/point.exr.new".to_owned()));
    stage.write("suite.toml", &format!("max_reference_kib = 1\n{SUITE}"));
    stage.scene(POINT.0, POINT.1, "\"intensity\": ", "\"intensity\": 2");
    stage.run(&["test"]).ends(1, &["a reference at most 1"]);
    assert_eq!(stage.references(), ["light/point.exr"]);
    stage.write("suite.toml", SUITE);
    stage.run(&["accept"]).ends(0, &["no pending images"]);
}

#[test]
fn a_broken_image_of_an_opened_shot_hides_no_orphaned_references() {
    let stage = Stage::accepted(&SUITE.replace("frames = 0", "frames = [0, 12]"), &[POINT]);
    let words = ["FAIL light/point.0000", "FAIL light/point.0012", "no shot renders this reference"];
    let limited = format!("max_reference_kib = 1\n{SUITE}");
    for suite in [SUITE, &limited] {
        stage.write("suite.toml", suite);
        stage.run(&["test"]).ends(1, &words);
        let references = stage.references();
        for frame in ["0000", "0012"] {
            assert!(references.contains(&format!("light/point.{frame}.exr.remove.new")), "{references:?}");
        }
    }
    stage.run(&["test"]).ends(1, &["raise max_reference_kib"]);
}

#[test]
fn shot_files_have_settings_and_limits_of_their_own() {
    let stage = Stage::new(SUITE);
    stage.scene("point.gltf", POINT.1, "", "");
    stage.write("dim.toml", "scene = 'point.gltf'\nlight_scale = 0.5\n[test]\npreset = 'exact'\n");
    stage.write(
        "bright.toml",
        "scene = 'point.gltf'\nlight_scale = 2\n[test]\nmean_flip = 1\ntile_flip = 1\nobject_flip = 1\nbrightness = 1\n",
    );
    let list = stage.run(&["test", "--list"]);
    assert_eq!(list.stdout, "bright\ndim\n");
    stage.run(&["test"]).ends(1, &[]);
    stage.run(&["accept"]).ends(0, &[]);
    for (shot, from) in [("dim", "0.5"), ("bright", "2")] {
        let text = std::fs::read_to_string(stage.path(&format!("{shot}.toml"))).unwrap();
        stage.write(&format!("{shot}.toml"), &text.replace(&format!("= {from}\n"), "= 0.55\n"));
    }
    let ran = stage.run(&["test"]);
    ran.ends(1, &["FAIL dim (preset exact)", "values whose bits differ"]);
    assert!(!ran.text.contains("FAIL bright"), "{}", ran.text);
    stage.write("dim.toml", "scene = 'point.gltf'\n[test]\npresets = 'exact'\n");
    stage
        .run(&["test", "dim"])
        .ends(1, &["FAIL dim", "dim.toml:3:1: \"presets\" is not a key of [test]; did you mean \"preset\"?"]);
    stage.write("dim.toml", "scene = 'point.gltf'\nsampels = 4\n");
    stage.run(&["test", "dim"]).ends(1, &["FAIL dim", "dim.toml:2:1: \"sampels\"", "samples"]);
    stage.run(&["test", "dusk"]).ends(2, &["no shot's name contains \"dusk\""]);
}

#[test]
fn warnings_are_reported_and_fail_with_strict() {
    let stage = Stage::new(SUITE);
    stage.scene("a.gltf", POINT.1, "extensionsUsed\": [", "extensionsUsed\": [\"ACME_glow\", ");
    stage.run(&["test"]).ends(1, &["warning: a: ", "ACME_glow"]);
    stage.run(&["accept"]).ends(0, &[]);
    stage.run(&["test"]).ends(0, &["ACME_glow"]);
    stage.write("suite.toml", &format!("{SUITE}strict = true\n"));
    stage.run(&["test"]).ends(1, &["FAIL a", "ACME_glow"]);
}

#[test]
fn an_error_in_a_shot_file_is_the_failure_of_that_shot() {
    let stage = Stage::accepted(SUITE, &[("point.gltf", POINT.1), ("spot.gltf", "light/spot.gltf")]);
    stage.write("point.toml", "scene = 'point.gltf\n");
    stage.run(&["test"]).ends(1, &["FAIL point\n", "point.toml:1:", "1 failed, "]);
    // Its scene is not a shot of its own meanwhile, and a suite file is never a shot.
    stage.write("point.toml", "scene = 'point.gltf'");
    stage.write("fast.toml", "[shot]\nsamples = 1");
    assert_eq!(stage.run(&["test", "--list"]).stdout, "point\nspot\n");
    // A shot file with a table of suites, or with a missing scene, is still a shot.
    stage.write("point.toml", "scene = 'pint.gltf'");
    stage.write("spot.toml", "scene = 'spot.gltf'\n[shot]\nsamples = 2");
    let words = ["FAIL point\n", "pint.gltf", "FAIL spot\n", "spot.toml:2:2: ", "2 failed, "];
    stage.run(&["test"]).ends(1, &words);
    stage.run(&["test", "--list", "--suite", "fast.toml"]).ends(0, &["point\nspot\n"]);
}

#[test]
fn reports_go_to_the_given_folder_and_replace_nothing_else() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    for _ in 0..2 {
        stage.run(&["test", "--report", "pages"]).ends(0, &[]);
    }
    assert!(stage.path("pages/index.html").exists());
    stage.write("site/index.html", "<html>mine</html>");
    stage
        .run(&["test", "--report", "site"])
        .ends(73, &["site/index.html: is there already and is not a report"]);
    stage.run(&["test", "--report", "."]).ends(0, &["1 image identical"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_test_with_a_message() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::{Command, Stdio};
    let stage =
        Stage::new(&SUITE.replace("[48, 27]", "[1920, 1080]").replace("samples = 1", "samples = 256"));
    stage.scene(POINT.0, POINT.1, "", "");
    let mut child = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .arg("test")
        .current_dir(stage.path(""))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Waits until the handler is installed. SigCgt is the bit mask of caught signals, with signal 1 first.
    let catches = || {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        u64::from_str_radix(caught.trim(), 16).unwrap() & (1 << 1) != 0
    };
    while !catches() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let ended = child.wait().unwrap();
    assert_eq!(ended.signal(), Some(2));
    let told = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    assert!(told.contains("stopped after 0 shots; no report was written"), "{told}");
    assert_eq!(stage.references(), [] as [&str; 0]);
}

#[test]
fn a_partial_name_selects_the_shots_of_matching_images() {
    let stage = Stage::accepted(
        &SUITE.replace("frames = 0", "frames = [0, 12]"),
        &[("walk.gltf", "animation/hierarchy.gltf")],
    );
    for word in ["12", "walk.00", "."] {
        stage.run(&["test", word]).ends(0, &["2 images identical"]);
    }
    stage.run(&["test", "7"]).ends(2, &["no shot's name contains"]);
}
