//! Interrupted runs leave only finished frames under final names.
//!
//! The interruptions are a kill, a signal, a full disk, and another run in the same folder. `tests/oracles/kill_many.py` does
//! the same hundreds of times at random moments.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::names;

const FRAMES: usize = 10;

/// The moment of a kill.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// A time after the start, most likely before the first frame.
    After(Duration),
    /// A time after this many frames have been reported.
    FramesAnd(usize, Duration),
    /// When a temporary file exists beside finished frames.
    MidWrite,
}

fn command(folder: &Path) -> Command {
    command_through(Command::new(env!("CARGO_BIN_EXE_rayframe")), folder)
}

/// Appends the arguments of the render to `command`.
fn command_through(mut command: Command, folder: &Path) -> Command {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo/whitted_1980.gltf");
    command
        .arg("render")
        .arg(scene)
        .arg("-o")
        .arg(folder.join("a.####.exr"))
        .args(["-r", "96x54", "--samples", "1", "--progress", "plain"])
        .args(["-f", &format!("0-{}", FRAMES - 1)]);
    command
}

/// Temporary files are hidden and named after their frame, so that no pattern for frames matches them.
fn is_temporary(name: &str) -> bool {
    has_extension(name, &["tmp"])
}

/// Files by which runs exclude each other and share frames.
fn is_lock(name: &str) -> bool {
    has_extension(name, &["lock", "run", "claim"])
}

fn has_extension(name: &str, extensions: &[&str]) -> bool {
    let extension = Path::new(name).extension();
    name.starts_with(".a.") && extensions.iter().any(|other| extension.is_some_and(|own| own == *other))
}

fn frame_names() -> Vec<String> {
    (0..FRAMES).map(|frame| format!("a.{frame:04}.exr")).collect()
}

/// Waits for `moment` or the end of the run, whichever comes first.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn wait_for(moment: Moment, child: &mut Child, folder: &Path) {
    match moment {
        Moment::After(delay) => std::thread::sleep(delay),
        Moment::FramesAnd(count, delay) => {
            let lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
            // Reads no more lines than needed, so that this returns at once.
            let seen = lines.filter(|line| line.contains(" written ")).take(count).count();
            assert_eq!(seen, count, "the run ended early");
            std::thread::sleep(delay);
        }
        Moment::MidWrite => {
            let is_mid_write = |names: &[String]| {
                names.iter().any(|name| is_temporary(name))
                    && frame_names().iter().any(|name| names.contains(name))
            };
            while child.try_wait().unwrap().is_none() && !is_mid_write(&names(folder)) {
                std::thread::yield_now();
            }
        }
    }
}

/// The frames of an uninterrupted run by name.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn whole_run(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    assert!(command(folder).stderr(Stdio::null()).status().unwrap().success());
    assert_eq!(names(folder), frame_names());
    frame_names().into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

/// Number of frames in `folder`. Asserts that all are finished and that there are no other files.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn whole_frames(folder: &Path, whole: &BTreeMap<String, Vec<u8>>) -> usize {
    let names = names(folder);
    for name in &names {
        assert!(whole.contains_key(name), "{name} was left");
        assert!(std::fs::read(folder.join(name)).unwrap() == whole[name], "{name} is not whole");
    }
    names.len()
}

#[test]
fn a_killed_run_leaves_finished_frames_and_resume_completes_them() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    assert!(command(&whole).stderr(Stdio::null()).status().unwrap().success());
    assert_eq!(names(&whole), frame_names());
    let expected = |name: &str| std::fs::read(whole.join(name)).unwrap();

    let mut cut_short = 0;
    for moment in [
        Moment::After(Duration::ZERO),
        Moment::After(Duration::from_millis(40)),
        Moment::FramesAnd(1, Duration::ZERO),
        Moment::FramesAnd(2, Duration::from_millis(3)),
        Moment::FramesAnd(3, Duration::from_millis(17)),
        Moment::MidWrite,
        Moment::MidWrite,
    ] {
        let killed = folder.path().join("killed");
        let mut child = command(&killed).stderr(Stdio::piped()).spawn().unwrap();
        wait_for(moment, &mut child, &killed);
        child.kill().unwrap();
        child.wait().unwrap();

        // A file with the name of a frame is that finished frame; all others are hidden.
        let left = names(&killed);
        let (frames, others): (Vec<_>, Vec<_>) = left.iter().partition(|name| frame_names().contains(*name));
        for name in &frames {
            assert!(
                std::fs::read(killed.join(name)).unwrap() == expected(name),
                "{moment:?}: {name} is not whole"
            );
        }
        for name in others {
            assert!(is_temporary(name) || is_lock(name), "{moment:?}: {name} was left");
        }
        cut_short += usize::from(frames.len() < FRAMES);

        // Resuming gives the files of an uninterrupted run and removes temporary files.
        let resumed = command(&killed).arg("--resume").stderr(Stdio::null()).status().unwrap();
        assert!(resumed.success(), "{moment:?}");
        assert_eq!(names(&killed), frame_names(), "{moment:?}");
        for name in frame_names() {
            assert!(
                std::fs::read(killed.join(&name)).unwrap() == expected(&name),
                "{moment:?}: {name} differs"
            );
        }
        std::fs::remove_dir_all(&killed).unwrap();
    }
    assert!(cut_short > 0, "every run ended before it was killed; give it more frames");
}

#[test]
fn a_signal_ends_the_run_within_a_second_and_keeps_finished_frames() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole_run(&folder.path().join("whole"));
    // The numbers of SIGINT and SIGTERM are the same on all systems.
    for (name, number, frames) in [("-INT", 2, 1), ("-TERM", 15, 1), ("-TERM", 15, 4)] {
        let stopped = folder.path().join("stopped");
        let mut child = command(&stopped).stderr(Stdio::piped()).spawn().unwrap();
        wait_for(Moment::FramesAnd(frames, Duration::ZERO), &mut child, &stopped);
        let asked = Instant::now();
        assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
        let ended = child.wait().unwrap();
        assert!(asked.elapsed() < Duration::from_secs(1), "{:?}", asked.elapsed());
        assert_eq!(ended.signal(), Some(number), "{ended}");
        let left = whole_frames(&stopped, &whole);
        assert!((frames..FRAMES).contains(&left), "{left} frames");
        assert!(command(&stopped).stderr(Stdio::null()).status().unwrap().success());
        assert_eq!(whole_frames(&stopped, &whole), FRAMES);
        std::fs::remove_dir_all(&stopped).unwrap();
    }
}

#[test]
fn two_runs_in_one_folder_both_succeed() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole_run(&folder.path().join("whole"));
    let shared = folder.path().join("shared");
    let mut runs = [1, 2].map(|_| command(&shared).arg("--resume").stderr(Stdio::null()).spawn().unwrap());
    // While they run, every file with the name of a frame is finished.
    while runs.iter_mut().any(|run| run.try_wait().unwrap().is_none()) {
        for (name, expected) in &whole {
            if let Ok(read) = std::fs::read(shared.join(name)) {
                assert!(read == *expected, "{name} is not whole");
            }
        }
    }
    assert!(runs.iter_mut().all(|run| run.wait().unwrap().success()));
    assert_eq!(whole_frames(&shared, &whole), FRAMES);
}

#[test]
fn a_file_size_limit_is_a_failed_write() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole_run(&folder.path().join("whole"));
    let limited = folder.path().join("limited");
    // Blocks are 512 or 1024 bytes; a frame is longer than eight of either.
    assert!(whole.values().all(|frame| frame.len() > 8 * 1024));
    let mut shell = Command::new("sh");
    shell.args(["-c", "ulimit -f 8; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_rayframe")]);
    let output = command_through(shell, &limited).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(74), "{said}");
    assert!(said.contains("a.0000.exr: write failed: "), "{said}");
    assert_eq!(whole_frames(&limited, &whole), 0);
}

#[test]
fn a_failed_movie_is_told_whether_the_run_keeps_going_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let movie = folder.path().join("a.apng");
    for options in [&[][..], &["--keep-going"], &["--keep-going", "--progress", "json"]] {
        let mut shell = Command::new("sh");
        shell.args(["-c", "ulimit -f 8; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_rayframe")]);
        shell.arg("render").arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo/whitted_1980.gltf"));
        shell.args(["-r", "128x72", "-f", "0-3", "--samples", "1", "-q", "-o"]).arg(&movie);
        let output = shell.args(options).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(74), "{options:?}: {said}");
        assert_eq!(said.matches("a.apng: write failed: ").count(), 1, "{options:?}: {said}");
        assert!(!movie.exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_refused_allocation_has_an_exit_code_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let limited = folder.path().join("limited");
    // The film alone has 576 MB.
    let mut shell = Command::new("sh");
    shell.args(["-c", "ulimit -v 400000; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_rayframe")]);
    shell.arg("render").arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo/whitted_1980.gltf"));
    shell.args(["-r", "6000x6000", "-f", "0", "--samples", "1", "--max-memory", "64G", "-t", "2", "-o"]);
    let output = shell.arg(limited.join("a.exr")).env_remove("RUST_BACKTRACE").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(77), "{said}");
    assert_eq!(said.lines().filter(|line| line.starts_with("memory allocation of ")).count(), 1, "{said}");
    assert!(names(&limited).iter().all(|name| is_lock(name)), "{:?}", names(&limited));
}

/// A mounted memory file system; dropping it unmounts.
#[cfg(target_os = "linux")]
struct SmallDisk<'a>(&'a Path);

#[cfg(target_os = "linux")]
impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_frames_that_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole_run(&folder.path().join("whole"));
    let bytes: usize = whole.values().map(Vec::len).sum();
    let small = folder.path().join("small");
    std::fs::create_dir(&small).unwrap();
    let mount = |options: String| {
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", &options, "tmpfs"]).arg(&small).output();
        mount.is_ok_and(|output| output.status.success())
    };
    if !mount(format!("size={}", bytes / 2)) {
        return crate::skipped("mounting a file system needs root");
    }
    let disk = SmallDisk(&small);
    let output = command(&small).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(74), "{said}");
    assert!(said.contains(".exr: write failed: No space left on device"), "{said}");
    let left = whole_frames(&small, &whole);
    assert!((1..FRAMES).contains(&left), "{left} frames");

    // With enough space the same command continues.
    assert!(mount(format!("remount,size={}", bytes * 3)));
    assert!(command(&small).stderr(Stdio::null()).status().unwrap().success());
    assert_eq!(whole_frames(&small, &whole), FRAMES);
    drop(disk);
}
