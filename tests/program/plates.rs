//! Image plates and the ground: exact values, composites, crops, missing files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rayframe::regression::Image;
use tempfile::TempDir;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const SIZE: (u32, u32) = (64, 36);

/// A folder with plates, in which the program runs.
struct Run {
    folder: TempDir,
}

impl Run {
    #[expect(clippy::unwrap_used, reason = "a helper of tests")]
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let run = Self { folder };
        // The size of the image and three times as large, with all values and a transparent corner.
        for (name, factor) in [("plate.png", 1), ("large.png", 3)] {
            let (width, height) = (SIZE.0 * factor, SIZE.1 * factor);
            let pixel = |index: u32| {
                let (x, y) = (index % width, index / width);
                let alpha = if x < 4 && y < 4 { 0 } else { 255 };
                [(x * 4 / factor) as u8, (y * 7 / factor) as u8, (x * y * 5) as u8, alpha]
            };
            let pixels: Vec<_> = (0..width * height).map(pixel).collect();
            std::fs::write(
                run.path(name),
                rayframe::image_file::encode_png((width, height), &pixels, "").unwrap(),
            )
            .unwrap();
        }
        run
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    #[expect(clippy::unwrap_used, reason = "a helper of tests")]
    fn try_render(&self, options: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .arg("render")
            .arg(Path::new(ROOT).join("scenes/environment/shadow_catcher.gltf"))
            .args(["--samples", "1", "--ground", "-q"])
            .args(if options.contains(&"-r") { &[][..] } else { &["-r", "64x36"] })
            .args(options)
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }

    /// Renders to the file `name` and reads it.
    #[expect(clippy::unwrap_used, reason = "a helper of tests")]
    fn render(&self, name: &str, options: &[&str]) -> Image {
        let output = self.try_render(&[options, &["--overwrite", "-o", name]].concat());
        assert!(output.status.success(), "{options:?}: {}", String::from_utf8_lossy(&output.stderr));
        Image::read(&self.path(name)).unwrap()
    }
}

/// Colours of a PNG file in eight bits.
fn codes(image: &Image) -> Vec<[u8; 4]> {
    let pixels = image.rgba().unwrap_or_default();
    pixels.into_iter().map(|pixel| pixel.map(|value| (value * 255.0).round() as u8)).collect()
}

/// The scene without its own floor, whose place the ground takes.
const NO_FLOOR: [&str; 2] = ["--shadow-catcher", "floor"];

#[test]
fn files_of_light_hold_the_scene_over_the_plate() {
    let run = Run::new();
    let scene = run.render("scene.exr", &[&NO_FLOOR[..], &["--background", "none"]].concat());
    let whole = run.render("whole.exr", &[&NO_FLOOR[..], &["--background", "plate.png"]].concat());
    let plate = Image::read(&run.path("plate.png")).unwrap().into_linear().rgba().unwrap();
    let alphas: Vec<f32> = scene.rgba().unwrap().iter().map(|pixel| pixel[3]).collect();
    for at in [0.0, 1.0] {
        assert!(alphas.contains(&at), "{at}");
    }
    assert!(alphas.iter().any(|alpha| *alpha > 0.0 && *alpha < 1.0));
    for ((scene, whole), plate) in scene.rgba().unwrap().iter().zip(whole.rgba().unwrap()).zip(plate) {
        for channel in 0..4 {
            let expected = scene[channel] + plate[channel] * (1.0 - scene[3]);
            let error = (whole[channel] - expected).abs();
            assert!(error <= 2e-3 * expected.max(0.01), "{whole:?} is not {expected}");
        }
    }
    // The scene alone is a layer of the file.
    assert_eq!(whole.layers(), ["beauty", "scene"]);
    let alone = whole.channel("scene.A").unwrap().samples.floats().unwrap();
    assert_eq!(alone.as_ref(), alphas);
}

#[test]
fn display_files_show_the_plate_as_it_is() {
    let run = Run::new();
    let plate = codes(&Image::read(&run.path("plate.png")).unwrap());
    let scene = run.render("scene.exr", &[&NO_FLOOR[..], &["--background", "none"]].concat()).rgba().unwrap();
    for (tone, exposure) in [("neutral", "auto"), ("agx", "-3"), ("aces", "4")] {
        let look = ["--tone", tone, "--exposure", exposure];
        let options = [&NO_FLOOR[..], &look, &["--background", "plate.png"]].concat();
        let png = codes(&run.render("a.png", &options));
        let mut count = 0;
        for (at, pixel) in scene.iter().enumerate().filter(|(_, pixel)| pixel[3] == 0.0) {
            assert_eq!((pixel[0], png[at][3]), (0.0, plate[at][3]), "{tone}");
            if plate[at][3] > 0 {
                assert_eq!(png[at], plate[at], "{tone}");
                count += 1;
            }
        }
        assert!(count > 500);
        // White where no shadow falls.
        let options = [&NO_FLOOR[..], &look, &["--background", "white"]].concat();
        let white = codes(&run.render("a.png", &options));
        assert!(scene.iter().zip(white).all(|(pixel, white)| pixel[3] > 0.0 || white == [255; 4]), "{tone}");
    }
}

#[test]
fn previews_of_kept_frames_equal_new_ones() {
    let run = Run::new();
    let options =
        [&NO_FLOOR[..], &["--background", "large.png", "--preview", "png", "--exposure", "1"]].concat();
    let exr = [&options[..], &["--resume", "-o", "a.exr"]].concat();
    assert!(run.try_render(&exr).status.success());
    let new = std::fs::read(run.path("a.png")).unwrap();
    std::fs::remove_file(run.path("a.png")).unwrap();
    let told = run.try_render(&exr);
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    assert_eq!(std::fs::read(run.path("a.png")).unwrap(), new);
    // A PNG frame shows the same.
    let direct =
        run.render("b.png", &[&NO_FLOOR[..], &["--background", "large.png", "--exposure", "1"]].concat());
    assert_eq!(codes(&direct), codes(&Image::read(&run.path("a.png")).unwrap()));
}

#[test]
fn a_crop_equals_its_part_of_the_whole() {
    let run = Run::new();
    for fit in ["fill", "fit", "stretch"] {
        let options = [
            &NO_FLOOR[..],
            &["--background", "large.png", "--background-fit", fit, "-r", "48x48", "--exr", "float"],
        ]
        .concat();
        let whole = run.render("whole.exr", &options).rgba().unwrap();
        let crop = run.render("crop.exr", &[&options[..], &["--crop", "5,7,31,40"]].concat()).rgba().unwrap();
        for (index, pixel) in crop.iter().enumerate() {
            assert_eq!(*pixel, whole[(7 + index / 26) * 48 + 5 + index % 26], "{fit} {index}");
        }
        // Above and below a wide image in a square one nothing is left unless it is fitted.
        assert_eq!(whole[47][3] == 0.0, fit == "fit");
    }
}

/// One frame of a sequence has the name that it has among the others.
#[test]
fn single_frames_of_moving_sequences_have_numbered_names() {
    for moving in [&["--turntable", "8"][..], &["--background", "p.####.png"]] {
        let run = Run::new();
        for frame in ["2", "3"] {
            std::fs::copy(run.path("plate.png"), run.path(&format!("p.000{frame}.png"))).unwrap();
            let ended = run.try_render(&[moving, &["-r", "16x9", "-f", frame, "--resume"]].concat());
            assert!(ended.status.success(), "{}", crate::stderr(&ended));
        }
        let mut frames = crate::names(run.folder.path());
        frames.retain(|name| name.starts_with("shadow_catcher."));
        assert_eq!(frames, ["shadow_catcher.0002.exr", "shadow_catcher.0003.exr"], "{moving:?}");
    }
    // One plate behind a still
    let run = Run::new();
    assert!(run.try_render(&["--background", "plate.png", "-r", "16x9"]).status.success());
    assert!(run.path("shadow_catcher.exr").exists());
}

#[test]
fn plates_of_light_are_exposed_with_the_scene() {
    let run = Run::new();
    let light = run.render("light.exr", &["--background", "0.5,0.25,0.125", "--orbit", "0,0,100"]);
    let flat = |exposure: &str, background: &str| {
        let options = ["--background", background, "--exposure", exposure, "--orbit", "0,-5,100"];
        codes(&run.render("a.png", &options))[0]
    };
    assert_eq!(light.rgba().unwrap()[0], [0.5, 0.25, 0.125, 1.0]);
    assert_eq!(flat("1", "plate:light.exr"), flat("1", "0.5,0.25,0.125"));
    std::fs::copy(run.path("light.exr"), run.path("light.0000.exr")).unwrap();
    assert_eq!(flat("-2", "light.####.exr"), flat("-2", "0.5,0.25,0.125"));
}

#[test]
fn shots_never_write_what_an_earlier_or_later_one_reads() {
    let run = Run::new();
    run.render("sky.exr", &["--env", "studio"]);
    let scene = Path::new(ROOT).join("scenes/environment/shadow_catcher.gltf");
    let shot = |name: &str, lines: &str| {
        let text = format!("scene = '{}'\nresolution = '8x8'\nsamples = 1\n{lines}\n", scene.display());
        std::fs::write(run.path(name), text).unwrap();
    };
    for (setting, input) in [("background", "plate.png"), ("env", "sky.exr")] {
        let before = std::fs::read(run.path(input)).unwrap();
        shot("writer.toml", &format!("output = '{input}'"));
        shot("reader.toml", &format!("output = 'b.png'\n{setting} = '{input}'"));
        for shots in [["reader.toml", "writer.toml"], ["writer.toml", "reader.toml"]] {
            let refused = Command::new(env!("CARGO_BIN_EXE_rayframe"))
                .args(["render", shots[0], shots[1], "--overwrite"])
                .current_dir(run.folder.path())
                .output()
                .unwrap();
            let message = String::from_utf8_lossy(&refused.stderr);
            assert_eq!(refused.status.code(), Some(65), "{shots:?} {message}");
            assert!(message.contains("is an input"), "{message}");
            assert!(std::fs::read(run.path(input)).unwrap() == before, "{shots:?}");
        }
    }
}

#[test]
fn missing_damaged_and_overwritten_plates_are_errors_before_the_first_frame() {
    let run = Run::new();
    let told = |options: &[&str]| {
        let output = run.try_render(options);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    std::fs::copy(run.path("plate.png"), run.path("p.0000.png")).unwrap();
    let (code, text) = told(&["--background", "p.####.png", "-f", "0-1", "-o", "a.####.exr"]);
    assert!(code == Some(66) && text.contains("p.0001.png") && text.contains("frame 1"), "{code:?} {text}");
    assert!(!run.path("a.0000.exr").exists());
    std::fs::write(run.path("text.png"), "hello").unwrap();
    let (code, text) = told(&["--background", "text.png", "-o", "a.exr"]);
    assert!(code == Some(65) && text.contains("text.png"), "{code:?} {text}");
    let (code, text) = told(&["--background", "plate.png", "-o", "plate.png", "--overwrite"]);
    assert!(code == Some(2) && text.contains("is an input"), "{code:?} {text}");
    // Plates of frames that are not rendered are inputs, too.
    let plates = std::fs::read(run.path("p.0000.png")).unwrap();
    std::fs::copy(run.path("plate.png"), run.path("p.0002.png")).unwrap();
    let of_two = ["--background", "p.####.png", "-f", "2", "--overwrite"];
    for options in [
        &["-o", "p.0000.png"][..],
        &["-o", "./p.-001.png"],
        &["-o", "a.exr", "--contact-sheet", "p.0000.png"],
    ] {
        let (code, text) = told(&[&of_two, options].concat());
        assert!(code == Some(2) && text.contains("is a plate and cannot be written"), "{code:?} {text}");
    }
    assert!(std::fs::read(run.path("p.0000.png")).unwrap() == plates);
    let (code, text) = told(&[&of_two[..], &["-o", "p.two.png"]].concat());
    assert!(code == Some(0), "{code:?} {text}");
    let (_, text) = told(&["--background-fit", "fit", "-o", "b.exr", "-n"]);
    assert!(text.contains("--background-fit does nothing"), "{text}");
}

#[test]
fn resuming_notices_another_plate() {
    let run = Run::new();
    let kept = |options: &[&str]| {
        let options = [options, &["--resume", "-o", "a.exr", "-n"]].concat();
        String::from_utf8_lossy(&run.try_render(&options).stdout).contains("keep")
    };
    let plate = ["--background", "plate.png"];
    run.render("a.exr", &plate);
    assert!(kept(&plate));
    assert!(!kept(&["--background", "large.png"]));
    assert!(!kept(&[&plate[..], &["--background-fit", "fit"]].concat()));
    std::fs::copy(run.path("large.png"), run.path("plate.png")).unwrap();
    assert!(!kept(&plate));
}

#[test]
fn shot_files_name_plates_beside_them_and_take_the_ground_as_a_flag() {
    let run = Run::new();
    let scene = format!("{ROOT}/scenes/environment/shadow_catcher.gltf");
    for (ground, shown) in [("true", "shadow"), ("\"reflection\"", "reflection"), ("false", "none")] {
        let shot =
            format!("scene = '{scene}'\nbackground = 'plate.png'\nground = {ground}\nresolution = [16, 9]\n");
        std::fs::write(run.path("shot.toml"), shot).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .args(["render", "-n"])
            .arg(run.path("shot.toml"))
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(text.contains(&format!("ground = \"{shown}\"")), "{text}");
        assert!(text.contains(&format!("background = \"{}\"", run.path("plate.png").display())), "{text}");
    }
}

#[test]
fn frames_before_different_plates_are_not_called_equal() {
    let run = Run::new();
    for (name, second) in [("same", "plate.png"), ("other", "large.png")] {
        for (frame, plate) in [(1, "plate.png"), (2, second)] {
            std::fs::copy(run.path(plate), run.path(&format!("{name}.{frame:04}.png"))).unwrap();
        }
        for output in [format!("{name}-frame.####.png"), format!("{name}-all.gif")] {
            let background = format!("{name}.####.png");
            let told = run.try_render(&["--background", &background, "-f", "1-2", "-o", &output]);
            let text = String::from_utf8_lossy(&told.stderr).into_owned();
            assert!(told.status.success(), "{text}");
            assert_eq!(text.contains("all 2 frames are equal"), name == "same", "{output}: {text}");
        }
    }
}
