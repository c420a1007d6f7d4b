//! Temporary files that killed runs left are removed by the next run that writes the same files.

#![cfg(target_os = "linux")]

use std::path::{Path, PathBuf};
use std::process::Command;

use sha2::{Digest as _, Sha256};

use crate::stderr;

const SUITE: &str = "[shot]\nresolution = [16, 9]\nsamples = 1\n";
const SIZE: [&str; 8] = ["render", "s.gltf", "-f", "0", "-r", "16x9", "--samples", "1"];

/// Runs a command in `folder` without `CI` set.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
#[track_caller]
fn run(folder: &Path, arguments: &[&str], code: i32) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    let output = command.args(arguments).current_dir(folder).env_remove("CI").output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
}

/// The files below `folder` that are no temporary files, and those that are.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn files(folder: &Path) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let (mut all, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            if entry.path().is_dir() {
                folders.push(entry.path());
            } else {
                all.push(entry.path());
            }
        }
    }
    all.into_iter().partition(|path| path.extension().is_none_or(|extension| extension != "tmp"))
}

/// Leaves a temporary file beside each file below `folder`, as a run on this machine does that is killed.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn leave_temporaries(folder: &Path, inputs: &[&str]) -> usize {
    let mut seed = std::fs::read("/proc/sys/kernel/random/boot_id").unwrap();
    seed.extend_from_slice(std::fs::read_link("/proc/self/ns/pid").unwrap().as_os_str().as_encoded_bytes());
    let digest = Sha256::digest(&seed);
    // Process ids stay below 2²², so no process has this one.
    let mark = format!("{:02x}{:02x}{:02x}{:02x}-4194999", digest[0], digest[1], digest[2], digest[3]);
    let mut count = 0;
    for path in files(folder).0 {
        let name = path.file_name().unwrap().to_str().unwrap();
        if !inputs.contains(&name) {
            std::fs::write(path.with_file_name(format!(".{name}.{mark}.abcdef.tmp")), "partial").unwrap();
            count += 1;
        }
    }
    count
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn stage() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/light/point.gltf");
    std::fs::copy(scene, folder.path().join("s.gltf")).unwrap();
    folder
}

/// Runs the command, leaves temporary files beside all it made, and runs it again. Returns their number.
#[track_caller]
fn runs_clean_up(folder: &Path, inputs: &[&str], arguments: &[&str], code: i32) -> usize {
    run(folder, arguments, code);
    let count = leave_temporaries(folder, inputs);
    assert_eq!(files(folder).1.len(), count);
    run(folder, arguments, code);
    assert_eq!(files(folder).1, [] as [PathBuf; 0], "{arguments:?}");
    count
}

#[test]
fn renders_and_merges_remove_what_killed_runs_left() {
    let folder = stage();
    let more = [
        "-o",
        "a.####.exr",
        "--preview",
        "png",
        "--aovs",
        "depth",
        "--split-aovs",
        "--stats",
        "s.json",
        "-q",
    ];
    let sidecars = ["--manifest", "m.json", "--movie", "m.apng", "--contact-sheet", "c.png", "--resume"];
    let arguments = [&SIZE[..], &more, &sidecars].concat();
    assert_eq!(runs_clean_up(folder.path(), &["s.gltf"], &arguments, 0), 7);

    let folder = stage();
    for (name, crop) in [("t1.exr", "0,0,16,4"), ("t2.exr", "0,4,16,9")] {
        run(folder.path(), &[&SIZE[..], &["-o", name, "--crop", crop, "-q"]].concat(), 0);
    }
    let merge = ["merge", "t1.exr", "t2.exr", "-o", "whole.exr"];
    assert_eq!(runs_clean_up(folder.path(), &["s.gltf", "t1.exr", "t2.exr"], &merge, 0), 1);
}

#[test]
fn claims_of_killed_runs_are_removed() {
    let folder = stage();
    let render = [&SIZE[..], &["-o", "a.####.exr", "-q"]].concat();
    run(folder.path(), &render, 0);
    let claim = folder.path().join(".a.0000.exr.claim");
    for option in ["--resume", "--overwrite", "-q"] {
        std::fs::write(&claim, "").unwrap();
        let arguments = if option == "-q" { render.clone() } else { [&render[..], &[option]].concat() };
        run(folder.path(), &arguments, 0);
        assert!(!claim.exists(), "{option}");
    }
}

#[test]
fn comparisons_remove_what_killed_runs_left() {
    let folder = stage();
    for (name, light) in [("a.exr", "1"), ("b.exr", "3")] {
        run(folder.path(), &[&SIZE[..], &["-o", name, "--light-scale", light, "-q"]].concat(), 0);
    }
    let maps = ["diff", "a.exr", "b.exr", "--heat-map", "h.png", "--flip-map", "f.exr"];
    let arguments = [&maps[..], &["--report", "page", "--summary", "s.md"]].concat();
    assert!(runs_clean_up(folder.path(), &["s.gltf", "a.exr", "b.exr"], &arguments, 1) >= 4);
}

#[test]
fn tests_remove_what_killed_runs_left() {
    let folder = stage();
    std::fs::write(folder.path().join("suite.toml"), SUITE).unwrap();
    run(folder.path(), &["test", "-q"], 1);
    run(folder.path(), &["accept"], 0);
    let inputs = ["s.gltf", "suite.toml"];
    let arguments = ["test", "-q", "--junit", "j.xml", "--code-quality", "q.json", "--summary", "s.md"];
    // The reference, its verdict and the marks of the cache, and the files of the report.
    assert!(runs_clean_up(folder.path(), &inputs, &arguments, 0) >= 9);
    // A failing suite has a pending image and thumbnails, too.
    std::fs::write(folder.path().join("suite.toml"), format!("{SUITE}light_scale = 3\n")).unwrap();
    assert!(runs_clean_up(folder.path(), &inputs, &arguments, 1) >= 12);
}
