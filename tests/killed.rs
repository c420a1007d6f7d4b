//! A run that is killed leaves whole frames alone under their final names, whatever it was doing.

#![cfg(unix)]

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const FRAMES: usize = 10;

/// When a run is killed.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// This long after the start, so most likely before the first frame.
    After(Duration),
    /// As soon as this many frames have been told of, and then this much later.
    FramesAnd(usize, Duration),
    /// As soon as a half-written file can be seen beside finished frames.
    MidWrite,
}

fn command(folder: &Path) -> Command {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo/whitted_1980.gltf");
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command
        .arg("render")
        .arg(scene)
        .arg("-o")
        .arg(folder.join("a.####.exr"))
        .args(["-r", "96x54", "--samples", "1", "--progress", "plain"])
        .args(["-f", &format!("0-{}", FRAMES - 1)]);
    command
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn names(folder: &Path) -> Vec<String> {
    // Perhaps not even the folder was made yet.
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Half-written files are hidden and named after their frame, so that no pattern for frames finds them.
fn is_temporary(name: &str) -> bool {
    name.starts_with(".a.") && Path::new(name).extension().is_some_and(|extension| extension == "tmp")
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
            // Taking no line more than needed is what makes this return at once.
            let seen = lines.filter(|line| line.contains(" written ")).take(count).count();
            assert_eq!(seen, count, "the run ended early");
            std::thread::sleep(delay);
        }
        Moment::MidWrite => {
            // Hidden names sort before those of frames.
            let is_mid_write = |names: &[String]| {
                names.first().is_some_and(|name| is_temporary(name))
                    && names.iter().any(|name| !is_temporary(name))
            };
            while child.try_wait().unwrap().is_none() && !is_mid_write(&names(folder)) {
                std::thread::yield_now();
            }
        }
    }
}

#[test]
fn only_whole_frames_are_left_and_resuming_completes_them() {
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

        // What has a frame's name is that frame; all else is hidden.
        let left = names(&killed);
        let (frames, others): (Vec<_>, Vec<_>) = left.iter().partition(|name| frame_names().contains(*name));
        for name in &frames {
            assert!(
                std::fs::read(killed.join(name)).unwrap() == expected(name),
                "{moment:?}: {name} is not whole"
            );
        }
        for name in others {
            assert!(is_temporary(name), "{moment:?}: {name} was left");
        }
        cut_short += usize::from(frames.len() < FRAMES);

        // Going on gives what a run without a break gives, and clears up.
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
