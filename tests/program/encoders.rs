//! Films whose encoder misbehaves, and films that are there already.

#![cfg(unix)]

use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::{names, stderr};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/animation/hierarchy.gltf");
/// What an encoder says of itself, and the file that it is to write.
const PRELUDE: &str =
    "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor last; do :; done\nfilm=\"${last#file:}\"\n";

/// Folder with a program `ffmpeg` of these lines.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn encoder(lines: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("ffmpeg");
    std::fs::write(&program, format!("{PRELUDE}{lines}\n")).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    folder
}

/// The command that makes a film of three frames, of more bytes than a pipe holds, with the encoder in `tools`.
fn film(folder: &Path, tools: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(["render", SCENE, "-r", "160x90", "--samples", "1", "-f", "0-2", "-q", "-o", "a.mp4"]);
    let path = std::env::var("PATH").unwrap_or_default();
    command.current_dir(folder).env("PATH", format!("{}:{path}", tools.display()));
    command
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn run(folder: &Path, lines: &str) -> Output {
    film(folder, encoder(lines).path()).output().unwrap()
}

#[test]
fn an_encoder_that_says_megabytes_makes_its_film() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), "head -c 3000000 /dev/zero >&2; cat > \"$film\"");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "");
    assert_eq!(names(folder.path()), ["a.mp4"]);
    assert_eq!(std::fs::read(folder.path().join("a.mp4")).unwrap().len(), 3 * 160 * 90 * 4);
}

#[test]
fn an_encoder_that_fails_is_quoted_in_one_short_line_and_leaves_nothing() {
    for (lines, words) in [
        ("exit 3", "ffmpeg: "),
        (
            "head -c 3000000 /dev/zero | tr '\\0' x >&2; echo >&2; echo no codec >&2; exit 1",
            "ffmpeg: no codec",
        ),
        ("head -c 3000000 /dev/zero | tr '\\0' x >&2; exit 1", "ffmpeg: xxx"),
        // Dies in the middle.
        ("head -c 60000 > \"$film\"; echo no space >&2; exit 1", "ffmpeg: no space"),
        ("head -c 60000 > \"$film\"; kill -9 $$", "ffmpeg: "),
        // Succeeds without reading, without writing, and without the file.
        ("exit 0", "ffmpeg: "),
        ("cat > /dev/null; exit 0", "ffmpeg: it wrote no film"),
        ("cat > /dev/null; rm \"$film\"; exit 0", "ffmpeg: it wrote no film"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let output = run(folder.path(), lines);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(74), "{lines}: {said}");
        assert!(said.contains("a.mp4: write failed: ") && said.contains(words), "{lines}: {said}");
        assert!(said.len() < 1000, "{lines}: {} bytes", said.len());
        assert_eq!(said.lines().filter(|line| line.contains("error: ")).count(), 1, "{lines}: {said}");
        assert_eq!(names(folder.path()), [] as [&str; 0], "{lines}");
    }
}

#[test]
fn an_encoder_that_reads_nothing_does_not_outlast_a_signal() {
    for lines in ["touch started; exec sleep 60", "cat > \"$film\"; touch started; exec sleep 60"] {
        let folder = tempfile::tempdir().unwrap();
        let tools = encoder(lines);
        let mut child = film(folder.path(), tools.path()).stderr(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while !folder.path().join("started").exists() {
            assert!(start.elapsed() < Duration::from_secs(30), "{lines}: the encoder was not started");
            std::thread::sleep(Duration::from_millis(5));
        }
        let asked = Instant::now();
        assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
        let ended = child.wait().unwrap();
        assert!(asked.elapsed() < Duration::from_secs(5), "{lines}: {:?}", asked.elapsed());
        assert_eq!(ended.signal(), Some(15), "{lines}: {ended}");
        assert_eq!(names(folder.path()), ["started"], "{lines}");
    }
}

#[test]
fn films_of_this_program_are_replaced_and_others_are_not() {
    let has_ffmpeg =
        Command::new("ffmpeg").arg("-version").output().is_ok_and(|output| output.status.success());
    if !has_ffmpeg {
        return crate::skipped("ffmpeg is not installed");
    }
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (name, foreign) in [("a.mp4", "b.mp4"), ("a.mov", "b.mov"), ("a.webm", "b.webm"), ("a.mkv", "b.mkv")]
    {
        let make = |frames: &str, name: &str| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
            command.args([
                "render",
                SCENE,
                "-r",
                "16x10",
                "--samples",
                "1",
                "-q",
                "-f",
                frames,
                "-o",
                "f.#.png",
            ]);
            let output =
                command.args(["--movie", name, "--resume"]).current_dir(folder.path()).output().unwrap();
            (output.status.code(), stderr(&output))
        };
        let (code, said) = make("0-1", name);
        assert_eq!(code, Some(0), "{name}: {said}");
        let first = std::fs::read(at(name)).unwrap();
        let (code, said) = make("0-3", name);
        assert_eq!(code, Some(0), "{name}: {said}");
        assert_ne!(std::fs::read(at(name)).unwrap(), first, "{name}");

        // The same film as another program makes it.
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-loglevel", "error", "-i", name, "-c", "copy", "-map_metadata", "-1", foreign]);
        assert!(ffmpeg.current_dir(folder.path()).status().unwrap().success(), "{foreign}");
        let before = std::fs::read(at(foreign)).unwrap();
        let (code, said) = make("0-1", foreign);
        assert_eq!(code, Some(73), "{foreign}: {said}");
        assert!(said.contains(foreign) && said.contains("is not a movie of this program"), "{said}");
        assert!(std::fs::read(at(foreign)).unwrap() == before, "{foreign}");
    }
}
