//! Files below the folder of references that are no references.

use rayframe::image::{ColorEncoding, Image};

use super::{SUITE, Stage};

const POINT: (&str, &str) = ("a/point.gltf", "light/point.gltf");

/// Writes an image as this program does.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
pub(super) fn write_image(stage: &Stage, name: &str, size: (u32, u32)) {
    let pixels = vec![[0.5, 0.6, 0.7, 1.0]; (size.0 * size.1) as usize];
    Image::from_rgba(size, ColorEncoding::Linear, &pixels).write(&stage.path(name)).unwrap();
}

#[test]
fn environments_and_plates_of_shots_are_no_references() {
    let stage = Stage::new(&format!("{SUITE}env = 'references/env/sky.exr'\n"));
    stage.scene(POINT.0, POINT.1, "", "");
    stage.scene("base.gltf", "light/spot.gltf", "", "");
    stage.write("s.toml", "scene = 'base.gltf'\nframes = 1\nbackground = 'references/plates/bg.####.exr'\n");
    write_image(&stage, "references/env/sky.exr", (8, 4));
    // Of the second plate no frame is rendered.
    for plate in ["references/plates/bg.0001.exr", "references/plates/bg.0002.exr"] {
        write_image(&stage, plate, (48, 27));
    }
    let ran = stage.run(&["test"]);
    ran.ends(1, &["FAIL a/point", "FAIL s"]);
    assert!(!ran.text.contains("no shot renders"), "{}", ran.text);
    stage.run(&["accept"]).ends(0, &["added references/s.exr"]);
    stage.run(&["test"]).ends(0, &["2 images identical, 0 changed within limits, 0 failed"]);
    // What an earlier run marked is discarded.
    stage.write("references/env/sky.exr.remove.new", "no shot\n\n");
    stage.run(&["accept"]).ends(0, &["no pending images"]);
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    let kept = ["a/point.exr", "env/sky.exr", "plates/bg.0001.exr", "plates/bg.0002.exr", "s.exr"];
    assert_eq!(stage.references(), kept);
}

#[test]
fn files_of_other_programs_are_kept() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    stage.write("references/photo.exr", "a photo");
    let kept = "kept references/photo.exr, which rayframe did not write";
    stage.run(&["test"]).ends(1, &["FAIL photo", "no shot renders this reference"]);
    stage.run(&["accept"]).ends(0, &[kept]);
    assert_eq!(stage.references(), ["a/point.exr", "photo.exr"]);
    stage.run(&["test"]).ends(1, &["FAIL photo"]);
    stage.run_with(&["review"], "a\n", None).ends(0, &["is no image of a shot", kept]);
    stage.run_with(&["test"], "", Some("true")).ends(1, &["FAIL photo"]);
    stage.run(&["accept", "--from", "report"]).ends(0, &[kept]);
    assert_eq!(stage.references(), ["a/point.exr", "photo.exr"]);
}

/// What Git LFS and git-annex leave in place of a file that they have not fetched, and the command that fetches it.
const POINTERS: [(&str, &str); 2] = [
    ("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", "git lfs pull"),
    ("/annex/objects/SHA256E-s12345--4d7a.exr\n", "git annex get"),
];

#[test]
fn references_that_were_not_fetched_are_not_replaced() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    for (pointer, command) in POINTERS {
        stage.write("references/a/point.exr", pointer);
        for ci in [None, Some("true")] {
            stage.run_with(&["test"], "", ci).ends(1, &["FAIL a/point", command]);
            assert_eq!(stage.references(), ["a/point.exr"]);
        }
        stage.run(&["accept"]).ends(0, &["no pending images"]);
        stage.run(&["accept", "--from", "report"]).ends(0, &["the report has no such images"]);
        // An image that an earlier run stored.
        stage.write("references/a/point.exr.new", "an image");
        stage.run(&["accept"]).ends(65, &["references/a/point.exr: is a ", command]);
        assert_eq!(std::fs::read_to_string(stage.path("references/a/point.exr")).unwrap(), pointer);
        std::fs::remove_file(stage.path("references/a/point.exr.new")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn references_that_are_links_are_read_and_not_replaced() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    let (reference, stored) = (stage.path("references/a/point.exr"), stage.path("stored"));
    std::fs::rename(&reference, &stored).unwrap();
    std::os::unix::fs::symlink(&stored, &reference).unwrap();
    stage.run(&["test"]).ends(0, &["1 image identical"]);
    stage.scene(POINT.0, POINT.1, "\"intensity\": ", "\"intensity\": 9");
    stage.run(&["test"]).ends(1, &["FAIL a/point"]);
    let before = std::fs::read(&stored).unwrap();
    let refused = "references/a/point.exr: is a link, which no image replaces; make it a file";
    stage.run(&["accept"]).ends(73, &[refused, "not accepted: references/a/point.exr.new"]);
    stage.run_with(&["review"], "a\n", None).ends(73, &[refused]);
    stage.run_with(&["test"], "", Some("true")).ends(1, &["FAIL a/point"]);
    stage.run(&["accept", "--from", "report"]).ends(73, &[refused]);
    assert!(reference.is_symlink() && std::fs::read(&stored).unwrap() == before);

    // A link to nothing, as git-annex leaves it in place of a file that it has not fetched.
    std::fs::rename(&stored, stage.path("kept")).unwrap();
    let lost = "references/a/point.exr: is a link to nothing; fetch its file";
    stage.run(&["accept", "--from", "report"]).ends(65, &[lost]);
    stage.run(&["accept"]).ends(65, &[lost]);
    stage.run(&["test"]).ends(1, &["FAIL a/point", lost]);
    stage.run(&["accept"]).ends(0, &["no pending images"]);
    std::fs::rename(stage.path("kept"), &stored).unwrap();
    // Unlocked, it is a file of the same bytes.
    stage.run(&["test"]).ends(1, &["FAIL a/point"]);
    std::fs::rename(&stored, &reference).unwrap();
    stage.run(&["accept"]).ends(0, &["replaced references/a/point.exr"]);
    stage.run(&["test"]).ends(0, &["1 image identical"]);
}

#[cfg(unix)]
#[test]
fn links_to_nothing_that_no_shot_renders_are_removed() {
    let stage = Stage::accepted(SUITE, &[POINT]);
    let set_link = |target: &str| {
        std::os::unix::fs::symlink(target, stage.path("references/old.exr")).unwrap();
    };
    let (orphaned, removed) =
        (["FAIL old", "no shot renders this reference"], ["removed references/old.exr"]);
    // To nothing, and to itself.
    for target in ["nothing", "old.exr"] {
        set_link(target);
        stage.run(&["test"]).ends(1, &orphaned);
        stage.run(&["accept"]).ends(0, &removed);
        set_link(target);
        stage.run(&["test"]).ends(1, &orphaned);
        stage.run_with(&["review"], "a\n", None).ends(0, &removed);
        set_link(target);
        stage.run_with(&["test"], "", Some("true")).ends(1, &orphaned);
        stage.run(&["accept", "--from", "report"]).ends(0, &removed);
        assert_eq!(stage.references(), ["a/point.exr"]);
    }
    // It leads to a file since.
    set_link("nothing");
    stage.run(&["test"]).ends(1, &orphaned);
    std::fs::copy(stage.path("references/a/point.exr"), stage.path("references/nothing")).unwrap();
    stage.run(&["accept"]).ends(1, &["has changed since the change was found"]);
    assert!(stage.path("references/old.exr").exists());
}

#[test]
fn images_of_reports_are_no_references() {
    for (suite, arguments) in [
        (SUITE.to_owned(), &["test", "--report", "references/report"][..]),
        (format!("report = 'references/report'\n{SUITE}"), &["test"]),
    ] {
        let stage = Stage::new(&suite);
        stage.scene(POINT.0, POINT.1, "", "");
        let in_ci = stage.run_with(arguments, "", Some("true"));
        assert!(stage.path("references/report/images/a/point.exr").exists());
        for ran in [in_ci, stage.run(&["test"])] {
            ran.ends(1, &["FAIL a/point"]);
            assert!(!ran.text.contains("no shot renders"), "{}", ran.text);
        }
    }
}
