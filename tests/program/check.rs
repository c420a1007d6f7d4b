//! `rayframe check`, and `--resume` with damaged files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::progress::schema::Schema;

/// A folder with rendered frames, three unless others are asked for, and their manifest.
struct Stage {
    folder: tempfile::TempDir,
    frames: &'static str,
}

const RENDER: [&str; 13] = [
    "-o",
    "out/a.####.exr",
    "-r",
    "24x16",
    "--samples",
    "1",
    "--manifest",
    "out/manifest.json",
    "-q",
    "--aovs",
    "depth",
    "--preview",
    "png",
];

impl Stage {
    fn new() -> Self {
        Self::of_frames("1-3")
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn of_frames(frames: &'static str) -> Self {
        let stage = Self { folder: tempfile::tempdir().unwrap(), frames };
        let output = stage.render(&[]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        stage
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        command.current_dir(self.folder.path()).args(arguments).output().unwrap()
    }

    fn render(&self, options: &[&str]) -> Output {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/skin/two_bone_strip.gltf");
        let scene = scene.display().to_string();
        self.run(&[&["render", &scene, "-f", self.frames], &RENDER[..], options].concat())
    }

    /// Exit code and lines of a check.
    fn check(&self, arguments: &[&str]) -> (Option<i32>, Vec<String>) {
        let output = self.run(&[&["check"], arguments].concat());
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        (output.status.code(), text.lines().map(str::to_owned).collect())
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.run(&[&["check", "--json"], arguments].concat());
        let report = serde_json::from_slice(&output.stdout).unwrap();
        Schema::read("check").check(&report);
        report
    }
}

#[test]
fn sixty_of_sixty_changed_bits_are_found_and_rendered_again() {
    let stage = Stage::of_frames("1-60");
    let names: Vec<String> = (1..=60).map(|frame| format!("out/a.{frame:04}.exr")).collect();
    let whole: Vec<Vec<u8>> = names.iter().map(|name| stage.bytes(name)).collect();
    // One bit of each frame, so that all parts of a file have their turn, and all bits of a byte.
    for (number, (name, whole)) in names.iter().zip(&whole).enumerate() {
        let mut changed = whole.clone();
        let at = whole.len() * (2 * number + 1) / 120;
        changed[at] ^= 1 << (number % 8);
        stage.write(name, &changed);
    }
    let (code, lines) = stage.check(&["-q", "out/a.####.exr"]);
    assert_eq!((code, lines.len()), (Some(1), 60), "{lines:?}");
    for (name, line) in names.iter().zip(&lines) {
        assert!(line.starts_with(&format!("FAIL {name}: ")), "{name}: {line}");
    }
    let resumed = stage.render(&["--resume"]);
    assert_eq!(resumed.status.code(), Some(0), "{resumed:?}");
    for (name, whole) in names.iter().zip(&whole) {
        assert!(stage.bytes(name) == *whole, "{name}");
    }
}

#[test]
fn movies_and_contact_sheets_are_in_the_manifest() {
    let stage = Stage::new();
    let more = ["--overwrite", "--contact-sheet", "out/all.png", "--movie", "out/all.gif"];
    assert_eq!(stage.render(&more).status.code(), Some(0));
    let manifest: Value = serde_json::from_slice(&stage.bytes("out/manifest.json")).unwrap();
    Schema::read("manifest").check(&manifest);
    let check = ["out", "--manifest", "out/manifest.json"];
    assert_eq!(stage.check(&check), (Some(0), vec!["8 whole files".to_owned()]));
    let mut sheet = stage.bytes("out/all.png");
    let middle = sheet.len() / 2;
    sheet[middle] ^= 1;
    stage.write("out/all.png", &sheet);
    let (code, lines) = stage.check(&check);
    assert_eq!((code, lines.len()), (Some(1), 2), "{lines:?}");
    assert!(lines[0].starts_with("FAIL out/all.png: is damaged"), "{lines:?}");
    std::fs::remove_file(stage.path("out/all.gif")).unwrap();
    let report = stage.json(&check);
    let missing: Vec<_> =
        report["files"].as_array().unwrap().iter().filter(|file| file["status"] == "missing").collect();
    assert!(missing.len() == 1 && missing[0]["frame"].is_null(), "{missing:?}");
}

#[test]
fn files_of_the_manifest_outside_of_the_named_folder_are_checked_where_they_are() {
    let stage = Stage::new();
    let more = ["--overwrite", "--contact-sheet", "sheet.png", "--movie", "all.gif"];
    assert_eq!(stage.render(&more).status.code(), Some(0));
    let whole = (Some(0), vec!["8 whole files".to_owned()]);
    for named in ["out", "./out", "out/a.####.exr"] {
        assert_eq!(stage.check(&[named, "--manifest", "out/manifest.json"]), whole, "{named}");
    }
    let movie = stage.bytes("all.gif");
    stage.write("all.gif", &movie[..movie.len() / 2]);
    let (code, lines) = stage.check(&["out", "--manifest", "out/manifest.json"]);
    assert!(code == Some(1) && lines[0] == "FAIL all.gif: its bytes do not match the manifest", "{lines:?}");
    stage.write("all.gif", &movie);
    // A copy is checked by its own files: those that the run wrote do not stand in for them.
    std::fs::create_dir(stage.path("copy")).unwrap();
    for name in ["a.0001.exr", "a.0002.exr", "manifest.json"] {
        stage.write(&format!("copy/{name}"), &stage.bytes(&format!("out/{name}")));
    }
    let (code, lines) = stage.check(&["copy", "--manifest", "copy/manifest.json"]);
    assert_eq!(code, Some(1), "{lines:?}");
    for name in ["out/a.0003.exr", "all.gif"] {
        let line = format!("FAIL {name}: is in the manifest and not among the named files");
        assert!(lines.contains(&line), "{lines:?}");
    }
    std::fs::remove_file(stage.path("all.gif")).unwrap();
    let (code, lines) = stage.check(&["out", "--manifest", "out/manifest.json"]);
    assert_eq!((code, &*lines[0]), (Some(1), "FAIL all.gif: is in the manifest and not there"));
}

#[test]
fn frames_that_another_program_has_saved_are_neither_damaged_nor_replaced() {
    let stage = Stage::of_frames("1");
    let mut saved = stage.bytes("out/a.0001.exr");
    let own = b"software\0string\0";
    let at = saved.windows(own.len()).position(|part| part == own).unwrap() + own.len() + 4;
    saved[at..at + 8].copy_from_slice(b"OpenImag");
    stage.write("out/a.0001.exr", &saved);
    let report = stage.json(&["out/a.0001.exr"]);
    assert_eq!(report["files"][0]["status"], "unknown", "{report}");
    let message = report["files"][0]["message"].as_str().unwrap();
    assert!(message.contains("OpenImag") && message.contains("has saved it since"), "{message}");
    let resumed = stage.render(&["--resume"]);
    assert_eq!(resumed.status.code(), Some(73), "{resumed:?}");
    assert!(stage.bytes("out/a.0001.exr") == saved);
    // With the manifest.
    let status = |stage: &Stage| {
        let report = stage.json(&["out", "--manifest", "out/manifest.json"]);
        let files = report["files"].as_array().unwrap().iter();
        let file = files.clone().find(|file| file["path"].as_str().unwrap().ends_with("a.0001.exr")).unwrap();
        (file["status"].as_str().unwrap().to_owned(), file["message"].as_str().unwrap().to_owned())
    };
    let (unknown, message) = status(&stage);
    assert_eq!(unknown, "unknown");
    let told = "its bytes do not match the manifest: OpenImag";
    assert!(message.starts_with(told) && message.ends_with(" has saved it since"), "{message}");
    // A file of this program with a changed bit is damaged.
    let middle = saved.len() / 2;
    saved[middle] ^= 1;
    saved[at..at + 8].copy_from_slice(b"rayframe");
    stage.write("out/a.0001.exr", &saved);
    assert_eq!(status(&stage).0, "damaged");
}

#[test]
fn animated_pngs_are_checked_whatever_their_ending() {
    let stage = Stage::of_frames("1-2");
    assert_eq!(stage.render(&["--overwrite", "--movie", "out/m.apng"]).status.code(), Some(0));
    assert_eq!(stage.check(&["out/m.apng"]), (Some(0), vec!["1 whole file".to_owned()]));
    let mut bytes = stage.bytes("out/m.apng");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    stage.write("out/m.apng", &bytes);
    assert_eq!(stage.check(&["out/m.apng"]).0, Some(1));
    // It is no image of which the first frame alone would be compared.
    assert_eq!(stage.run(&["diff", "out/m.apng", "out/m.apng"]).status.code(), Some(65));
}

#[test]
fn a_delivery_is_compared_with_its_manifest() {
    let stage = Stage::new();
    let manifest = ["--manifest", "out/manifest.json"];
    let all = [
        "out/a.0001.exr",
        "out/a.0001.png",
        "out/a.0002.exr",
        "out/a.0002.png",
        "out/a.0003.exr",
        "out/a.0003.png",
    ];
    let good = (Some(0), vec!["6 whole files".to_owned()]);
    assert_eq!(stage.check(&manifest), good);
    assert_eq!(stage.check(&[&all[..], &manifest].concat()), good);
    assert_eq!(stage.check(&["out"]), good);
    assert_eq!(stage.check(&["out", "-q"]), (Some(0), vec![]));

    // A delivery that was moved.
    let delivery = stage.path("delivery");
    std::fs::rename(stage.path("out"), &delivery).unwrap();
    let moved = ["--manifest", "delivery/manifest.json"];
    assert_eq!(stage.check(&moved), good);
    assert_eq!(stage.check(&[&["delivery"][..], &moved].concat()), good);

    // A delivery that is not there is not looked for elsewhere.
    let (code, lines) = stage.check(&[&["gone/a.####.exr"][..], &moved].concat());
    assert_eq!(
        (code, lines.last().map(String::as_str)),
        (Some(1), Some("0 whole files, 7 failed")),
        "{lines:?}"
    );

    // Damaged, missing, other and additional files.
    let mut damaged = stage.bytes("delivery/a.0001.exr");
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    stage.write("delivery/a.0001.exr", &damaged);
    std::fs::remove_file(stage.path("delivery/a.0002.exr")).unwrap();
    std::fs::copy(stage.path("delivery/a.0002.png"), stage.path("delivery/a.0003.png")).unwrap();
    std::fs::copy(stage.path("delivery/a.0003.exr"), stage.path("delivery/a.0004.exr")).unwrap();
    let report = stage.json(&["delivery", moved[0], moved[1]]);
    let failed: Vec<(&str, Option<i64>, &str)> = report["files"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|file| file["status"] != "whole")
        .map(|file| {
            let text = |key: &str| file[key].as_str().unwrap_or_default();
            (text("path"), file["frame"].as_i64(), text("status"))
        })
        .collect();
    let expected = [
        ("delivery/a.0001.exr", Some(1), "damaged"),
        ("out/a.0002.exr", Some(2), "missing"),
        ("delivery/a.0003.png", Some(3), "different"),
        ("delivery/a.0004.exr", None, "unlisted"),
    ];
    assert_eq!(failed, expected);
    assert_eq!((&report["whole"], &report["failed"]), (&3.into(), &4.into()));
    // Frames that were not rendered have no files.
    let text = String::from_utf8(stage.bytes("delivery/manifest.json")).unwrap();
    let mut json: Value = serde_json::from_str(&text).unwrap();
    json["frames"][2]["files"] = serde_json::json!([]);
    json["frames"][2]["status"] = "not_rendered".into();
    stage.write("delivery/manifest.json", json.to_string().as_bytes());
    let (code, lines) = stage.check(&["-q", moved[0], moved[1]]);
    assert_eq!((code, &*lines[0]), (Some(1), "FAIL frame 3: has no files: not rendered"));
}

#[test]
fn deliveries_with_folders_are_compared_with_their_manifest() {
    let stage = Stage { folder: tempfile::tempdir().unwrap(), frames: "0-1" };
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/skin/two_bone_strip.gltf");
    let outputs = ["-o", "k/{layer}/a.####.exr", "--manifest", "k/m.json", "--stats", "k/s.json"];
    let small =
        ["-r", "24x16", "--samples", "1", "-q", "-f", stage.frames, "--split-aovs", "--aovs", "depth"];
    let rendered = stage.run(&[&["render", &scene.display().to_string()][..], &outputs, &small].concat());
    assert_eq!(rendered.status.code(), Some(0), "{rendered:?}");
    let good = (Some(0), vec!["4 whole files".to_owned()]);
    assert_eq!(stage.check(&["k", "--manifest", "k/m.json"]), good);
    assert_eq!(stage.check(&["k/depth", "./k/beauty/", "--manifest", "k/m.json"]), good);

    // It was moved into another folder, where a hidden file is.
    std::fs::create_dir(stage.path("d")).unwrap();
    std::fs::rename(stage.path("k"), stage.path("d/v2")).unwrap();
    stage.write("d/v2/depth/.a.0001.exr.tmp", b"");
    let manifest = ["--manifest", "d/v2/m.json"];
    assert_eq!(stage.check(&[&["d"][..], &manifest].concat()), good);
    assert_eq!(stage.check(&[&["d/v2"][..], &manifest].concat()), good);

    // Windows adds files, and links lead to files that are there already.
    stage.write("d/v2/thumbs.db", b"");
    #[cfg(unix)]
    std::os::unix::fs::symlink("v2", stage.path("d/latest")).unwrap();
    assert_eq!(stage.check(&[&["d", "d/v2/depth"][..], &manifest].concat()), good);
    #[cfg(unix)]
    std::fs::remove_file(stage.path("d/latest")).unwrap();

    // Whatever else is there, at any depth.
    std::fs::create_dir(stage.path("d/v2/old")).unwrap();
    std::fs::copy(stage.path("d/v2/depth/a.0000.exr"), stage.path("d/v2/old/a.0000.exr")).unwrap();
    for name in ["beauty/notes.txt", "depth/all.mp4", "one.json"] {
        stage.write(&format!("d/v2/{name}"), b"");
    }
    let strays: Vec<_> = ["beauty/notes.txt", "depth/all.mp4", "old/a.0000.exr", "one.json"]
        .map(|name| format!("FAIL d/v2/{name}: is not in the manifest"))
        .into();
    assert_eq!(stage.check(&[&["d/v2", "-q"][..], &manifest].concat()), (Some(1), strays.clone()));

    // A file of the same name in another folder is not the one that is missing.
    std::fs::remove_file(stage.path("d/v2/beauty/a.0000.exr")).unwrap();
    let missing = vec!["FAIL k/beauty/a.0000.exr: is in the manifest and not there".to_owned()];
    let (code, lines) = stage.check(&[&["d/v2", "-q"][..], &manifest].concat());
    assert_eq!((code, lines), (Some(1), [missing, strays].concat()));
}

#[test]
fn folders_are_checked_at_any_depth_without_a_manifest() {
    let stage = Stage::of_frames("1-2");
    std::fs::create_dir_all(stage.path("out/b/c")).unwrap();
    for (name, new) in [("out/a.0001.exr", "out/b/c/a.0001.exr"), ("out/a.0002.exr", "out/b/a.0002.exr")] {
        std::fs::rename(stage.path(name), stage.path(new)).unwrap();
    }
    assert_eq!(stage.check(&["out"]), (Some(0), vec!["4 whole files".to_owned()]));
    let bytes = stage.bytes("out/b/c/a.0001.exr");
    stage.write("out/b/c/a.0001.exr", &bytes[..bytes.len() / 2]);
    let (code, lines) = stage.check(&["out"]);
    assert!(code == Some(1) && lines[0].starts_with("FAIL out/b/c/a.0001.exr: "), "{lines:?}");
    assert_eq!(lines[1..], ["3 whole files, 1 failed"]);
}

#[test]
fn files_without_a_checksum_are_not_taken_for_whole() {
    let stage = Stage::new();
    let foreign = stage.path("foreign.exr");
    exr::prelude::write_rgba_file(&foreign, 4, 4, |_, _| (0.5_f32, 0.5_f32, 0.5_f32, 1.0_f32)).unwrap();
    stage.write("notes.txt", b"notes");
    std::fs::create_dir(stage.path("e")).unwrap();
    let (code, lines) = stage.check(&["foreign.exr", "notes.txt", "gone.exr", "e", "out", "gone/a.####.exr"]);
    assert_eq!((code, lines.len()), (Some(1), 6), "{lines:?}");
    for part in [
        "FAIL foreign.exr: has no checksum",
        "FAIL notes.txt: is no EXR or PNG file",
        "FAIL gone.exr: is not there",
        "FAIL e: holds no images",
        "FAIL gone/a.####.exr: ",
        "6 whole files, 5 failed",
    ] {
        assert!(lines.iter().any(|line| line.starts_with(part)), "{part}: {lines:?}");
    }
    assert_eq!(stage.check(&[]).0, Some(2));
    assert_eq!(stage.check(&["--manifest", "gone.json"]).0, Some(66));
    assert_eq!(stage.check(&["--manifest", "notes.txt"]).0, Some(65));
}

#[test]
fn damaged_tiles_are_not_merged() {
    let stage = Stage::new();
    let whole = stage.bytes("out/a.0001.exr");
    for crop in ["0,0,24,8", "0,8,24,16"] {
        let part = stage.path("part");
        let output = stage.render(&["--crop", crop, "--overwrite"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        std::fs::create_dir_all(&part).unwrap();
        std::fs::rename(stage.path("out/a.0001.exr"), part.join(format!("{}.exr", &crop[2..3]))).unwrap();
    }
    std::fs::rename(stage.path("part/0.exr"), stage.path("t1.exr")).unwrap();
    std::fs::rename(stage.path("part/8.exr"), stage.path("t2.exr")).unwrap();
    let merged = stage.run(&["merge", "t1.exr", "t2.exr", "-o", "whole.exr"]);
    assert_eq!(merged.status.code(), Some(0), "{merged:?}");
    assert!(stage.bytes("whole.exr") == whole);
    let mut tile = stage.bytes("t2.exr");
    let last = tile.len() - 1;
    tile[last] ^= 1;
    stage.write("t2.exr", &tile);
    let merged = stage.run(&["merge", "t1.exr", "t2.exr", "-o", "again.exr"]);
    let text = String::from_utf8_lossy(&merged.stderr);
    assert_eq!(merged.status.code(), Some(65), "{text}");
    assert!(text.contains("t2.exr: is damaged") && !stage.path("again.exr").exists(), "{text}");
}

#[cfg(unix)]
#[test]
fn links_to_nothing_are_missing() {
    let stage = Stage::new();
    std::os::unix::fs::symlink("gone.exr", stage.path("out/a.0004.exr")).unwrap();
    assert_eq!(stage.check(&["out", "-q"]), (Some(1), vec!["FAIL out/a.0004.exr: is not there".to_owned()]));
}
