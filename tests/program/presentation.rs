//! Movies and contact sheets of whole sequences.

use std::path::Path;
use std::process::{Command, Output};

use image::AnimationDecoder as _;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;

use crate::names;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");

const OTHER_SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/light/point.gltf");

/// Renders three frames of 32x18 pixels to `folder`, with additional options.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(folder: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(["render", SCENE, "-f", "1-9x4", "-r", "32x18", "--samples", "1", "--depth", "1"]);
    command.args(options).current_dir(folder);
    if !options.contains(&"--exposure") {
        command.args(["--exposure", "0"]);
    }
    if !options.contains(&"-o") {
        command.args(["-o", "a.####.exr"]);
    }
    command.output().unwrap()
}

#[test]
fn a_movie_holds_the_frames_as_their_previews_show_them() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--movie", "all.apng", "--contact-sheet", "sheet.png", "--preview", "png"];
    let output = render(folder.path(), &options);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let movie = std::fs::read(folder.path().join("all.apng")).unwrap();
    let decoder = PngDecoder::new(std::io::Cursor::new(&movie)).unwrap().apng().unwrap();
    let frames = decoder.into_frames().collect_frames().unwrap();
    for (frame, number) in frames.iter().zip([1, 5, 9]) {
        let preview = image::open(folder.path().join(format!("a.{number:04}.png"))).unwrap().into_rgba8();
        assert!(frame.buffer() == &preview, "frame {number}");
        // 1000 / 24 milliseconds.
        assert_eq!(frame.delay().numer_denom_ms(), (125, 3));
    }
    assert_eq!(frames.len(), 3);
    // Two columns and two rows of 32x18 with gaps of 4.
    let sheet = image::open(folder.path().join("sheet.png")).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (76, 48));

    // A movie with kept frames is the same file.
    std::fs::remove_file(folder.path().join("all.apng")).unwrap();
    assert_eq!(render(folder.path(), &options).status.code(), Some(0));
    assert!(std::fs::read(folder.path().join("all.apng")).unwrap() == movie);
    assert_eq!(names(folder.path()).len(), 8);
}

#[test]
fn a_gif_of_png_frames() {
    let folder = tempfile::tempdir().unwrap();
    let output = render(folder.path(), &["-o", "b.####.png", "--movie", "b.gif"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let gif = std::fs::read(folder.path().join("b.gif")).unwrap();
    let frames = GifDecoder::new(std::io::Cursor::new(&gif)).unwrap().into_frames();
    assert_eq!(frames.collect_frames().unwrap().len(), 3);
}

#[test]
fn quiet_runs_print_nothing_of_the_files_of_all_frames() {
    let sheet = ["--contact-sheet", "sheet.png", "--movie", "all.gif"];
    for (options, is_quiet) in [(&["-q"][..], true), (&["-D", "quiet=true"], true), (&[], false)] {
        let folder = tempfile::tempdir().unwrap();
        let output = render(folder.path(), &[&sheet[..], options].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{message}");
        let has_warnings_alone = message.lines().all(|line| line.starts_with("rayframe: warning: "));
        assert_eq!(has_warnings_alone, is_quiet, "{options:?}: {message}");
        assert_eq!(message.contains("all frames together: "), !is_quiet, "{options:?}: {message}");
        // One sheet of two scenes.
        let two = [OTHER_SCENE, "-o", "{scene}.####.png", "--contact-sheet", "both.png"];
        let output = render(folder.path(), &[&two[..], options].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{message}");
        assert_eq!(message.contains("all together: "), !is_quiet, "{options:?}: {message}");
    }
}

#[test]
fn invalid_movies_fail_before_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    for (options, code, word) in [
        (&["--movie", "all.avi"][..], 2, ".apng"),
        (&["--movie", "all"], 2, ".apng"),
        (&["--contact-sheet", "sheet.jpg"], 2, ".png"),
        (&["--movie", "a.0001.png", "--preview", "png"], 2, "--movie"),
        (&["--movie", "/proc/all.gif"], 73, "/proc"),
    ] {
        let output = render(folder.path(), options);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{options:?}: {message}");
        assert!(message.contains(word), "{options:?}: {message}");
        assert_eq!(names(folder.path()), [] as [&str; 0], "{options:?}");
    }
    // Without ffmpeg, formats that need it are refused with its name.
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(["render", SCENE, "-f", "1", "--movie", "a.mp4"]).env("PATH", "/nowhere");
    let output = command.current_dir(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("ffmpeg"));
}

#[test]
fn exposure_and_tone_are_in_effect_where_a_movie_shows_them() {
    let folder = tempfile::tempdir().unwrap();
    let said = |options: &[&str]| {
        let output = render(folder.path(), &[&["--tone", "agx", "--exposure", "1", "-n"], options].concat());
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(said(&[]).contains("--tone does nothing"));
    // Pixels on edges are found in what a display shows.
    let samples = said(&["--max-samples", "16"]);
    assert!(samples.contains("--tone does nothing") && !samples.contains("--exposure does nothing"));
    for shown in [&["--movie", "a.gif"][..], &["--contact-sheet", "a.png"], &["--show"]] {
        assert!(!said(shown).contains("does nothing"), "{shown:?}");
    }
}
