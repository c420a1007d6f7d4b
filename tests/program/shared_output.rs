//! Runs that write to one pattern: the same frames exclude each other, equal runs that resume share the frames.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::{names, stderr};

const FRAMES: usize = 12;

fn command(folder: &Path, options: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command
        .arg("render")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo/whitted_1980.gltf"))
        .arg("-o")
        .arg(folder.join("a.####.exr"))
        .args(["-r", "96x54", "--samples", "1", "--progress", "plain", "-t", "1"])
        .args(options);
    command
}

/// A run that has written its first frame and is stopped then, until it is told to go on.
struct Stopped(Child);

impl Stopped {
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn new(folder: &Path, options: &[&str]) -> Self {
        let mut child = command(folder, options).stderr(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        assert_eq!(lines.filter(|line| line.contains(" written ")).take(1).count(), 1);
        let stopped = Self(child);
        stopped.signal("-STOP");
        stopped
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.0.id().to_string()]).status().unwrap().success());
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn go_on(&mut self) -> Option<i32> {
        self.signal("-CONT");
        self.0.wait().unwrap().code()
    }
}

impl Drop for Stopped {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn run(folder: &Path, options: &[&str]) -> Output {
    command(folder, options).output().unwrap()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    names(folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

fn written(output: &Output) -> usize {
    stderr(output).lines().filter(|line| line.contains(" written out") || line.contains(") written ")).count()
}

fn has_ending(name: &str, ending: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension == ending)
}

#[test]
fn a_second_run_of_the_same_frames_is_told_who_renders_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = Stopped::new(folder.path(), &["-f", "0-11"]);
    for options in [&["-f", "11"][..], &["-f", "0-11", "--overwrite"], &["-f", "5", "--resume"]] {
        let second = run(folder.path(), options);
        let said = stderr(&second);
        assert_eq!(second.status.code(), Some(75), "{said}");
        let who = format!("a.####.exr: process {}", first.0.id());
        assert!(
            said.contains(&who) && said.contains(" has been rendering frames 0-11 of it since 20"),
            "{said}"
        );
    }
    // Other frames, as of another chunk of a farm, are not concerned.
    let other = run(folder.path(), &["-f", "20-21"]);
    assert!(other.status.success(), "{}", stderr(&other));
    assert_eq!(first.go_on(), Some(0));
    assert_eq!(names(folder.path()).len(), FRAMES + 2);
    assert!(run(folder.path(), &["-f", "11"]).status.success());
}

#[test]
fn equal_runs_that_resume_share_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (alone, shared) = (folder.path().join("alone"), folder.path().join("shared"));
    assert!(run(&alone, &["-f", "0-11"]).status.success());
    let spawn = || command(&shared, &["-f", "0-11", "--resume"]).stderr(Stdio::piped()).spawn().unwrap();
    let runs: Vec<_> =
        [spawn(), spawn(), spawn()].into_iter().map(|run| run.wait_with_output().unwrap()).collect();
    for run in &runs {
        assert!(run.status.success(), "{}", stderr(run));
    }
    assert_eq!(runs.iter().map(written).sum::<usize>(), FRAMES, "each frame is rendered once");
    assert_eq!(contents(&shared), contents(&alone));
    // A run that resumes with other settings is not equal.
    let mut held = Stopped::new(&folder.path().join("held"), &["-f", "0-11", "--resume"]);
    let other = run(&folder.path().join("held"), &["-f", "0-11", "--resume", "--depth", "1"]);
    assert_eq!(other.status.code(), Some(75), "{}", stderr(&other));
    assert!(stderr(&other).contains("other settings"), "{}", stderr(&other));
    assert_eq!(held.go_on(), Some(0));
}

#[test]
fn frames_of_a_run_that_dies_are_rendered_by_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["-f", "0-11", "--resume"];
    let mut dying = Stopped::new(folder.path(), &options);
    let other = command(folder.path(), &options).stderr(Stdio::piped()).spawn().unwrap();
    // The stopped run has claimed the last of them: one that is written, and one that is traced.
    let start = Instant::now();
    while names(folder.path()).iter().filter(|name| name.starts_with("a.")).count() < FRAMES - 2 {
        assert!(start.elapsed() < Duration::from_secs(60), "{:?}", names(folder.path()));
        std::thread::sleep(Duration::from_millis(2));
    }
    dying.0.kill().unwrap();
    dying.0.wait().unwrap();
    let ended = other.wait_with_output().unwrap();
    assert!(ended.status.success(), "{}", stderr(&ended));
    let frames: Vec<_> = (0..FRAMES).map(|frame| format!("a.{frame:04}.exr")).collect();
    let left = names(folder.path());
    assert_eq!(left.iter().filter(|name| name.starts_with("a.")).cloned().collect::<Vec<_>>(), frames);
    // What the dead run left is removed by the next run.
    assert!(run(folder.path(), &options).status.success());
    assert_eq!(names(folder.path()), frames);
}

#[test]
fn runs_with_other_plates_or_previews_are_not_equal() {
    let folder = tempfile::tempdir().unwrap();
    for (name, color) in [("red", [255, 0, 0]), ("blue", [0, 0, 255])] {
        let plate = image::RgbImage::from_pixel(8, 8, image::Rgb(color));
        plate.save(folder.path().join(name).with_extension("png")).unwrap();
    }
    let plates = ["red", "blue"]
        .map(|name| format!("plate:{}", folder.path().join(name).with_extension("png").display()));
    let [red, blue] =
        plates.each_ref().map(|plate| vec!["-f", "0-11", "--resume", "--background", plate.as_str()]);
    let preview = |exposure| vec!["-f", "0-11", "--resume", "--preview=png", "--exposure", exposure];
    for (number, [first, second]) in [[red, blue], [preview("0"), preview("3")]].into_iter().enumerate() {
        let output = folder.path().join(format!("out{number}"));
        let mut held = Stopped::new(&output, &first);
        let refused = run(&output, &second);
        assert_eq!(refused.status.code(), Some(75), "{second:?}: {}", stderr(&refused));
        let equal = command(&output, &first).stderr(Stdio::piped()).spawn().unwrap();
        assert_eq!(held.go_on(), Some(0));
        let equal = equal.wait_with_output().unwrap();
        assert!(equal.status.success(), "{}", stderr(&equal));
    }
}

#[test]
fn a_refused_run_leaves_the_checkpoints_of_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["-f", "0-3", "--integrator", "path", "--checkpoint"];
    assert!(run(folder.path(), &paths).status.success());
    let mut held = Stopped::new(folder.path(), &[&paths[..], &["--overwrite", "--seed", "3"]].concat());
    let checkpoint = folder.path().join("a.0003.exr.checkpoint");
    // The marks of one.
    std::fs::write(&checkpoint, b"\x76\x2f\x31\x01 renderHash\0string\0 samplesTaken\0string\0").unwrap();
    let refused = run(folder.path(), &[&paths[..], &["--resume"]].concat());
    assert_eq!(refused.status.code(), Some(75), "{}", stderr(&refused));
    assert!(checkpoint.exists());
    assert_eq!(held.go_on(), Some(0));
}

#[test]
fn a_record_that_cannot_be_read_excludes_all_runs() {
    let folder = tempfile::tempdir().unwrap();
    let mut held = Stopped::new(folder.path(), &["-f", "0-5"]);
    let record = names(folder.path()).into_iter().find(|name| has_ending(name, "run")).unwrap();
    let record = std::fs::File::options().write(true).open(folder.path().join(record)).unwrap();
    record.set_len(0).unwrap();
    let refused = run(folder.path(), &["-f", "8-11"]);
    assert_eq!(refused.status.code(), Some(75), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("cannot be read"), "{}", stderr(&refused));
    assert_eq!(held.go_on(), Some(0));
}

#[test]
fn every_user_may_lock_what_a_run_makes() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let mut held = Stopped::new(folder.path(), &["-f", "0-47", "--resume"]);
    let modes = || -> Vec<(String, u32)> {
        let hidden = names(folder.path());
        let hidden = hidden.into_iter().filter(|name| has_ending(name, "run") || has_ending(name, "claim"));
        let mode = |name: &String| std::fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
        hidden.map(|name| (name.clone(), mode(&name) & 0o777)).collect()
    };
    let is_shared = |(_, mode): &(String, u32)| *mode == 0o666;
    let mut found = modes();
    for _ in 0..20 {
        if found.len() >= 2 && found.iter().all(is_shared) {
            break;
        }
        // It was stopped between two claims, or between making a file and sharing it.
        held.signal("-CONT");
        std::thread::sleep(std::time::Duration::from_millis(2));
        held.signal("-STOP");
        found = modes();
    }
    assert!(found.len() >= 2 && found.iter().all(is_shared), "{found:?}");
    assert_eq!(held.go_on(), Some(0));
}
