//! Movies alone: `-o` with the name of a movie.

use std::path::Path;
use std::process::{Command, Output};

use image::AnimationDecoder as _;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;

use crate::{names, stderr};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/animation/hierarchy.gltf");

/// Runs `rayframe render` in `folder` with tiny images.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(folder: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(["render", SCENE, "-r", "16x9", "--samples", "1", "--exposure", "0"]);
    command.args(options).current_dir(folder).output().unwrap()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn frames(path: &Path) -> Vec<image::RgbaImage> {
    let bytes = std::io::Cursor::new(std::fs::read(path).unwrap());
    let frames = match path.extension().unwrap().to_str().unwrap() {
        "gif" => GifDecoder::new(bytes).unwrap().into_frames().collect_frames(),
        "webp" => WebPDecoder::new(bytes).unwrap().into_frames().collect_frames(),
        _ => PngDecoder::new(bytes).unwrap().apng().unwrap().into_frames().collect_frames(),
    };
    frames.unwrap().into_iter().map(image::Frame::into_buffer).collect()
}

#[test]
fn a_movie_is_all_that_is_left_and_holds_the_frames_in_the_order_of_time() {
    let stills = tempfile::tempdir().unwrap();
    assert!(render(stills.path(), &["-f", "0-2", "-o", "#.png"]).status.success());
    for name in ["a.apng", "a.webp", "a.gif"] {
        let folder = tempfile::tempdir().unwrap();
        let output = render(folder.path(), &["-f", "2,0,1", "-o", name]);
        assert!(output.status.success(), "{name}: {}", stderr(&output));
        assert_eq!(names(folder.path()), [name]);
        let frames = frames(&folder.path().join(name));
        assert_eq!(frames.len(), 3);
        for (number, frame) in frames.iter().enumerate().filter(|_| name != "a.gif") {
            let still = image::open(stills.path().join(format!("{number}.png"))).unwrap().into_rgba8();
            assert!(*frame == still, "{name} frame {number}");
        }
        // Made again, it is replaced as one of `--movie` is, by a single frame, too.
        for again in [&["-f", "0-2", "-o", name][..], &["-f", "0", "-o", name]] {
            let output = render(folder.path(), again);
            assert!(output.status.success(), "{name}: {}", stderr(&output));
        }
    }
}

#[test]
fn a_contact_sheet_goes_with_a_movie() {
    let folder = tempfile::tempdir().unwrap();
    let output = render(folder.path(), &["-f", "0-2", "-o", "a.webp", "--contact-sheet", "s.png"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(names(folder.path()), ["a.webp", "s.png"]);
}

#[cfg(unix)]
#[test]
fn a_movie_that_cannot_be_finished_leaves_nothing() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    // An encoder that ends at once.
    let tools = tempfile::tempdir().unwrap();
    let fake = tools.path().join("ffmpeg");
    std::fs::write(&fake, "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\necho no codec >&2\nexit 1\n").unwrap();
    std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(["render", SCENE, "-r", "16x9", "--samples", "1", "-f", "0-2", "-o", "a.mp4"]);
    let output = command.current_dir(folder.path()).env("PATH", tools.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(74), "{}", stderr(&output));
    assert!(stderr(&output).contains("no codec") && stderr(&output).contains("was not made"));
    assert_eq!(names(folder.path()), [] as [&str; 0]);
}

#[test]
fn settings_without_a_place_in_a_movie_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (options, word) in [
        (&["--movie", "b.gif"][..], "--movie: --output names a movie already"),
        (&["--preview", "png"], "--preview"),
        (&["--aovs", "depth"], "--aovs"),
        (&["--split-aovs", "--aovs", "depth"], "--split-aovs"),
        (&["--stamp"], "--stamp"),
        (&["--resume"], "--resume: keeps finished frames"),
        (&["--manifest", "m.json"], "--manifest"),
        (&["-o", "a.####.gif"], "one movie of all frames"),
        (&["-o", "a.webp", "-r", "16385x1"], "16384"),
    ] {
        let named: &[&str] = if options.contains(&"-o") { &[] } else { &["-o", "a.gif"] };
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .args([&["render", SCENE, "--samples", "1"], options, named].concat())
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{options:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(word), "{options:?}: {}", stderr(&output));
        assert_eq!(names(folder.path()), [] as [&str; 0], "{options:?}");
    }
}

#[test]
fn first_guesses_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let beside = render(folder.path(), &["-f", "0-1", "--movie", "turn.gif"]);
    assert!(
        stderr(&beside).contains("--movie also writes hierarchy.####.exr; -o turn.gif"),
        "{}",
        stderr(&beside)
    );
    let still = render(folder.path(), &["--animation", "none", "-f", "0-47", "-n"]);
    assert!(
        stderr(&still).contains("all 48 frames are equal; --turntable 48 turns the camera"),
        "{}",
        stderr(&still)
    );
    for (options, says) in [
        (&["--aperture", "0.1", "--focus", "2"][..], "equal but for noise; "),
        (&["--ground", "--sun-angle", "5"], "equal but for noise; "),
        (&["--ground", "--env", "studio"], "equal but for noise; "),
        (&["--ground"], "equal; "),
        (&["--integrator", "path", "--sun-angle", "5"], "equal; "),
    ] {
        let noisy = render(folder.path(), &[&["--animation", "none", "-f", "0-47", "-n"], options].concat());
        assert!(
            stderr(&noisy).contains(&format!("all 48 frames are {says}")),
            "{options:?}: {}",
            stderr(&noisy)
        );
    }
    for (option, hint) in [
        ("--angle", "--orbit AZ,EL"),
        ("--rotate", "--orbit AZ,EL"),
        ("--zoom", "--orbit AZ,EL,DIST"),
        ("--quality", "--samples N"),
        ("--motion-blur", "--shutter"),
    ] {
        let output = render(folder.path(), &[option, "3"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(&format!("{option} is no option; ")), "{}", stderr(&output));
        assert!(
            stderr(&output).contains(hint) && stderr(&output).lines().count() == 1,
            "{}",
            stderr(&output)
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let output = render(folder.path(), &["-D", "zoom=2"]);
    assert!(stderr(&output).contains("\"zoom\" is no setting; "), "{}", stderr(&output));
    for alias in ["--spin=4", "--position=0,0,5", "--target=0,0,0", "--out=x.##.exr", "--bg=none"] {
        assert!(render(folder.path(), &[alias, "-n"]).status.success(), "{alias}");
    }
}

#[test]
fn errors_name_the_setting_that_was_given() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.hdr"), "no image").unwrap();
    std::fs::write(folder.path().join("sky.hdr"), "no image").unwrap();
    for (option, value) in [
        ("camera", "nobody"),
        ("orbit", "1"),
        ("view", "inside"),
        ("camera-position", "1,2"),
        ("look-at", "nobody"),
        ("up", "1"),
        ("frame-node", "nobody"),
        ("fov", "0"),
        ("focal-length", "0"),
        ("roll", "x"),
        ("camera-path", "x"),
        ("turntable", "0"),
        ("elevation", "91"),
        ("animation", "nobody"),
        ("scene", "nobody"),
        ("variant", "nobody"),
        ("light-scale", "x"),
        ("light-radius", "-1"),
        ("sun-angle", "91"),
        ("env", "nothing"),
        ("env", "sky.hdr@x"),
        ("env-intensity", "-1"),
        ("background", "nothing"),
        ("background", "#12"),
        ("background", "1,2"),
        ("background", "sky.hdr@x"),
        ("shadow-catcher", "nobody"),
    ] {
        let output = render(folder.path(), &[&format!("--{option}={value}")]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{option}={value}: {said}");
        assert!(said.contains(&format!("--{option}: ")), "{option}={value}: {said}");
        let key = option.replace('-', "_").replace("scene", "scene_choice");
        if key != "elevation" {
            let output = render(folder.path(), &["-D", &format!("{key}={value}")]);
            assert!(stderr(&output).contains(&format!("-D {key}={value}: ")), "{}", stderr(&output));
        }
    }
    // Errors of the image itself name its file, and its setting where they speak of one.
    for option in ["env", "background"] {
        for file in ["broken.hdr", "missing.hdr"] {
            let said = stderr(&render(folder.path(), &[&format!("--{option}={file}")]));
            let other = if option == "env" { "--background" } else { "--env" };
            assert!(said.contains(file) && !said.contains(other), "{option}={file}: {said}");
        }
    }
}
