//! Passes of paths: sample ranges that are merged, checkpoints that are continued, and time limits.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rayframe::image::{Image, Samples};
use rayframe::image_file::decode_exr;

use crate::names;

/// A folder for renders of one frame.
struct Stage {
    folder: tempfile::TempDir,
    scene: &'static str,
}

impl Stage {
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn new(scene: &'static str) -> Self {
        Self { folder: tempfile::tempdir().unwrap(), scene }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn command(&self, output: &str, options: &[&str]) -> Command {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(self.scene);
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        command.current_dir(self.folder.path()).arg("render").arg(scene);
        command.args(["-o", output, "-r", "24x16", "--integrator", "path", "-f", "5", "-q"]).args(options);
        command
    }

    /// Exit code and standard error stream of a render.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn try_render(&self, output: &str, options: &[&str]) -> (Option<i32>, String) {
        let ended = self.command(output, options).output().unwrap();
        (ended.status.code(), String::from_utf8_lossy(&ended.stderr).into_owned())
    }

    fn render(&self, output: &str, options: &[&str]) {
        let (code, said) = self.try_render(output, options);
        assert_eq!(code, Some(0), "{options:?}: {said}");
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn start(&self, output: &str, options: &[&str]) -> Child {
        self.command(output, options).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// Exit code and standard error stream of a merge.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn merge(&self, parts: &[&str], output: &str) -> (Option<i32>, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        command.current_dir(self.folder.path()).arg("merge").args(parts).args(["-o", output]);
        let ended = command.output().unwrap();
        (ended.status.code(), String::from_utf8_lossy(&ended.stderr).into_owned())
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn image(&self, name: &str) -> Image {
        decode_exr(&self.path(name), &self.bytes(name), u64::MAX).unwrap()
    }
}

const SCENE: &str = "demo/whitted_1980.gltf";

#[test]
fn merged_sample_ranges_are_the_frame_to_the_last_byte() {
    let kinds: [&[&str]; 4] = [
        &["--samples", "16"],
        &["--samples", "16", "--filter", "mitchell", "--aovs", "all,noise", "--exr", "float,piz"],
        &["--samples", "16", "--crop", "5,3,19,14", "--aovs", "light", "--seed", "7"],
        &["--samples", "16", "--shutter", "0.5", "--time-samples", "4"],
    ];
    for options in kinds {
        let stage = Stage::new(SCENE);
        // Cryptomattes cannot be added up.
        let aovs: Vec<&str> =
            options.iter().map(|&word| if word == "all,noise" { "light,data,noise" } else { word }).collect();
        stage.render("whole.exr", &aovs);
        for (name, range) in [("a.exr", "0-6"), ("b.exr", "7-7"), ("c.exr", "8-15")] {
            stage.render(name, &[aovs.as_slice(), &["--sample-range", range]].concat());
        }
        let (code, said) = stage.merge(&["b.exr", "c.exr", "a.exr"], "merged.exr");
        assert_eq!((code, said.as_str()), (Some(0), "merged.exr: 3 sample ranges merged\n"), "{options:?}");
        assert!(stage.bytes("merged.exr") == stage.bytes("whole.exr"), "{options:?}");
        // The second time it is there already.
        let (code, said) = stage.merge(&["a.exr", "b.exr", "c.exr"], "merged.exr");
        assert_eq!((code, said.as_str()), (Some(0), "merged.exr: was there already\n"), "{options:?}");
    }
}

#[test]
fn sample_ranges_of_crops_are_merged_in_one_call_and_any_order() {
    let stage = Stage::new(SCENE);
    let options = ["--samples", "16", "--aovs", "light,data,noise"];
    stage.render("whole.exr", &options);
    let mut parts = Vec::new();
    // The crops of a run on a farm need not have the same ranges.
    for (crop, ranges) in [("0,0,9,16", &["0-6", "7-15"][..]), ("9,0,24,16", &["0-15"])] {
        for range in ranges {
            let name = format!("{}.exr", parts.len());
            stage.render(&name, &[&options[..], &["--crop", crop, "--sample-range", range]].concat());
            parts.push(name);
        }
    }
    let merge = |parts: &[&str], name: &str| stage.merge(parts, name);
    let [a, b, c] = [0, 1, 2].map(|index: usize| parts[index].as_str());
    let (code, said) = merge(&[b, c, a], "merged.exr");
    assert_eq!((code, said.as_str()), (Some(0), "merged.exr: 3 sample ranges merged\n"));
    assert!(stage.bytes("merged.exr") == stage.bytes("whole.exr"));
    assert_eq!(merge(&[a, b, c], "merged.exr").1, "merged.exr: was there already\n");
    // Samples of one crop are missing.
    let (code, said) = merge(&[c, a], "other.exr");
    assert!(
        code == Some(65) && said.contains("0.exr: cannot be merged: no file has the samples 7 to 15"),
        "{said}"
    );
    // Ranges of a single crop are that crop.
    let (code, said) = merge(&[a, b], "crop.exr");
    assert_eq!((code, said.as_str()), (Some(0), "crop.exr: 2 sample ranges merged\n"));
    stage.render("only.exr", &[&options[..], &["--crop", "0,0,9,16"]].concat());
    assert!(stage.bytes("crop.exr") == stage.bytes("only.exr"));
}

#[test]
fn a_sample_range_is_an_image_of_its_own() {
    let stage = Stage::new(SCENE);
    stage.render("part.exr", &["--samples", "16", "--sample-range", "4-7", "--aovs", "noise"]);
    let image = stage.image("part.exr");
    assert!(image.channel("R").is_some() && image.channel("sums.R3").is_some());
    let Some(Samples::Uint(counts)) = image.channel("sample_count").map(|channel| &channel.samples) else {
        panic!("no sample counts");
    };
    assert!(counts.iter().all(|&count| count == 4));
    // A whole frame of the same name is not kept for a part of it, nor a part for another.
    for options in [&["--samples", "16"][..], &["--samples", "16", "--sample-range", "0-3"]] {
        let (code, said) = stage.try_render("part.exr", &[options, &["--aovs", "noise"]].concat());
        assert_eq!(code, Some(73), "{said}");
        assert!(said.contains("other samples"), "{said}");
    }
}

#[test]
fn sample_ranges_that_do_not_add_up_are_refused() {
    let stage = Stage::new(SCENE);
    let ranges = [("a.exr", "0-3"), ("b.exr", "3-5"), ("c.exr", "4-7"), ("d.exr", "6-7"), ("e.exr", "0-1")];
    for (name, range) in ranges {
        stage.render(name, &["--samples", "8", "--sample-range", range]);
    }
    stage.render("whole.exr", &["--samples", "8"]);
    stage.render("crop.exr", &["--samples", "8", "--sample-range", "4-7", "--crop", "0,0,9,9"]);
    stage.render("other.exr", &["--samples", "8", "--sample-range", "4-7", "--seed", "3"]);
    let cases: [(&[&str], &str); 8] = [
        (&["a.exr"], "no file has the samples 4 to 7"),
        (&["c.exr"], "no file has the samples 0 to 3"),
        (&["a.exr", "d.exr"], "no file has the samples 4 to 5"),
        (&["b.exr", "d.exr", "e.exr"], "no file has sample 2; --sample-range renders it"),
        (&["a.exr", "b.exr", "d.exr"], "has sample 3, which another file has as well"),
        (&["a.exr", "c.exr", "whole.exr"], ""),
        (&["a.exr", "c.exr", "crop.exr"], "has the pixels 0,0,9,9 that "),
        (&["a.exr", "other.exr"], "other settings"),
    ];
    for (parts, words) in cases {
        let (code, said) = stage.merge(parts, "merged.exr");
        assert_eq!(code, Some(65), "{parts:?}: {said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{parts:?}: {said}");
        assert!(!stage.path("merged.exr").exists());
    }
}

#[test]
fn settings_that_sample_ranges_contradict_are_refused() {
    let stage = Stage::new(SCENE);
    let cases: [(&[&str], &str); 6] = [
        (&["--sample-range", "0-8"], "--samples 8 are 0 to 7"),
        (&["--sample-range", "3-1"], "such as 0-63"),
        (&["--sample-range", "0-3", "--noise", "0.1"], "--noise decides"),
        (&["--sample-range", "0-3", "--time-limit", "1s"], "--time-limit ends"),
        (&["--sample-range", "0-3", "--aovs", "crypto"], "Cryptomattes"),
        (&["--sample-range", "0-3", "--shutter", "1", "--time-samples", "3"], "multiple of --time-samples"),
    ];
    for (options, words) in cases {
        let (code, said) = stage.try_render("a.exr", &[&["--samples", "8"], options].concat());
        assert_eq!(code, Some(2), "{options:?}: {said}");
        assert!(said.contains(words), "{options:?}: {said}");
    }
    let (code, said) = stage.try_render("a.png", &["--samples", "8", "--sample-range", "0-3"]);
    assert!(code == Some(2) && said.contains("only EXR files"), "{said}");
    assert_eq!(names(stage.folder.path()), [""; 0]);
}

/// Renders by one thread until a checkpoint is there, and kills the program.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn kill_after_a_checkpoint(stage: &Stage, options: &[&str]) {
    let mut run = stage.start("frame.exr", &[options, &["-t", "1"]].concat());
    let checkpoint = stage.path("frame.exr.checkpoint");
    let started = Instant::now();
    while !checkpoint.is_file() {
        assert!(started.elapsed() < Duration::from_secs(60), "no checkpoint");
        assert!(run.try_wait().unwrap().is_none(), "the run was too short");
        std::thread::sleep(Duration::from_millis(1));
    }
    run.kill().unwrap();
    run.wait().unwrap();
}

/// The statistics of the frame.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn statistics(stage: &Stage, name: &str) -> serde_json::Value {
    let mut stats: serde_json::Value = serde_json::from_slice(&stage.bytes(name)).unwrap();
    stats["frames"][0].take()
}

#[test]
fn a_killed_frame_continues_from_its_checkpoint() {
    let kinds: [&[&str]; 3] = [
        &["--samples", "512", "--aovs", "light,noise"],
        &["--samples", "1024", "--noise", "0.006", "--aovs", "crypto"],
        &["--samples", "512", "--sample-range", "128-511"],
    ];
    for options in kinds {
        let stage = Stage::new(SCENE);
        // Rows of two tiles
        let options = [options, &["--crop", "0,6,24,10", "--checkpoint"]].concat();
        kill_after_a_checkpoint(&stage, &options);
        stage.render("frame.exr", &[&options[..], &["--stats", "continued.json"]].concat());
        stage.render("expected.exr", &[&options[..], &["--stats", "whole.json"]].concat());
        assert!(stage.bytes("frame.exr") == stage.bytes("expected.exr"), "{options:?}");
        // Rays and seconds are those of both runs, and the period is that of the last one.
        let [continued, whole] = ["continued.json", "whole.json"].map(|name| statistics(&stage, name));
        for rays in ["camera", "reflection", "refraction", "shadow"] {
            assert_eq!(continued["rays"][rays], whole["rays"][rays], "{options:?} {rays}");
        }
        let seconds = |of: &serde_json::Value, phase: &str| of["seconds"][phase].as_f64().unwrap();
        assert_eq!(seconds(&whole, "period"), seconds(&whole, "total"));
        assert!(seconds(&continued, "period") < seconds(&continued, "total"), "{continued}");
        let rays: f64 = ["camera", "reflection", "refraction", "shadow"]
            .iter()
            .map(|kind| continued["rays"][kind].as_f64().unwrap())
            .sum();
        let per_second = rays / seconds(&continued, "trace");
        let told = continued["rays"]["per_second"].as_f64().unwrap();
        assert!((told / per_second - 1.0).abs() < 1e-6, "{continued}");
        let left = ["continued.json", "expected.exr", "frame.exr", "whole.json"];
        assert_eq!(names(stage.folder.path()), left);
    }
}

#[test]
fn foreign_and_damaged_checkpoints_are_ignored() {
    let stage = Stage::new(SCENE);
    let options = ["--samples", "64", "--checkpoint"];
    stage.render("expected.exr", &options);
    kill_after_a_checkpoint(&stage, &["--samples", "1024", "--checkpoint"]);
    let foreign = stage.bytes("frame.exr.checkpoint");
    // Bytes of the pixels and of the table of offsets are damaged behind a whole header.
    let mut damaged = foreign.clone();
    let middle = foreign.len() / 2;
    damaged[middle..middle + 64].fill(0xff);
    for bytes in [&foreign[..], &foreign[..middle], b"no image", &damaged] {
        std::fs::write(stage.path("frame.exr.checkpoint"), bytes).unwrap();
        stage.render("frame.exr", &[&options[..], &["--overwrite"]].concat());
        assert!(stage.bytes("frame.exr") == stage.bytes("expected.exr"));
    }
}

#[test]
fn files_of_other_programs_are_no_checkpoints() {
    let stage = Stage::new(SCENE);
    let checkpoint = stage.path("frame.exr.checkpoint");
    std::fs::write(&checkpoint, "notes").unwrap();
    let options = ["--samples", "8", "--checkpoint"];
    let (code, said) = stage.try_render("frame.exr", &options);
    assert!(code == Some(73) && said.contains("is not a checkpoint of this program"), "{said}");
    assert!(stage.bytes("frame.exr.checkpoint") == b"notes" && !stage.path("frame.exr").exists());
    stage.render("frame.exr", &["--samples", "8", "--checkpoint", "--overwrite"]);
    assert!(!checkpoint.exists());
}

#[test]
fn damaged_sample_ranges_are_refused_or_merged_without_a_panic() {
    let stage = Stage::new(SCENE);
    stage.render("b.exr", &["--samples", "8", "--sample-range", "4-7"]);
    stage.render("a.exr", &["--samples", "8", "--sample-range", "0-3"]);
    let whole = stage.bytes("a.exr");
    for at in (whole.len() / 4..whole.len()).step_by(whole.len() / 40) {
        let mut damaged = whole.clone();
        let end = damaged.len().min(at + 9);
        damaged[at..end].fill(0x80);
        std::fs::write(stage.path("a.exr"), damaged).unwrap();
        let (code, said) = stage.merge(&["a.exr", "b.exr"], &format!("{at}.exr"));
        assert!(matches!(code, Some(0 | 65 | 77)) && said.lines().count() == 1, "{at}: {code:?} {said}");
    }
}

#[test]
fn leftovers_of_checkpoints_are_removed() {
    let stage = Stage::new(SCENE);
    stage.render("frame.exr", &["--samples", "8"]);
    kill_after_a_checkpoint(&stage, &["--samples", "4096", "--checkpoint", "--overwrite"]);
    stage.render("frame.exr", &["--samples", "8", "--checkpoint", "--resume"]);
    assert_eq!(names(stage.folder.path()), ["frame.exr"]);
    let (code, said) = stage.try_render("film.webp", &["--samples", "8", "--checkpoint"]);
    assert!(code == Some(2) && said.contains("--checkpoint"), "{said}");
}

#[test]
fn runs_without_checkpoints_remove_those_of_the_frames_that_they_finish() {
    let options = ["--samples", "512"];
    let left = ["frame.exr", "frame.exr.checkpoint"];
    let stage = Stage::new(SCENE);
    kill_after_a_checkpoint(&stage, &[&options[..], &["--checkpoint"]].concat());
    let checkpoint = stage.bytes("frame.exr.checkpoint");
    let restore = || std::fs::write(stage.path("frame.exr.checkpoint"), &checkpoint).unwrap();
    stage.render("frame.exr", &options);
    assert_eq!(names(stage.folder.path()), left[..1]);
    // The same of a frame that is there already
    restore();
    stage.render("frame.exr", &[&options[..], &["--resume"]].concat());
    assert_eq!(names(stage.folder.path()), left[..1]);
    // That of other pixels or settings may still be needed, and files of other programs are no checkpoints.
    for other in [&["--crop", "0,0,9,9"][..], &["--seed", "3"]] {
        restore();
        stage.render("frame.exr", &[&options[..], other, &["--overwrite"]].concat());
        assert_eq!(names(stage.folder.path()), left, "{other:?}");
    }
    std::fs::write(stage.path("frame.exr.checkpoint"), "notes").unwrap();
    stage.render("frame.exr", &[&options[..], &["--overwrite"]].concat());
    assert_eq!(names(stage.folder.path()), left);
}

#[test]
fn a_time_limit_ends_a_frame() {
    let stage = Stage::new(SCENE);
    let options = ["--samples", "65536", "--time-limit", "0.3s", "--aovs", "noise"];
    stage.render("frame.exr", &options);
    let image = stage.image("frame.exr");
    let Some(Samples::Uint(counts)) = image.channel("sample_count").map(|channel| &channel.samples) else {
        panic!("no sample counts");
    };
    // Every pixel has the same number of samples, from the first pass on.
    assert!(
        (4..65536).contains(&counts[0]) && counts.iter().all(|&count| count == counts[0]),
        "{}",
        counts[0]
    );
}
