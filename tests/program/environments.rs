//! Environment options give the reference images of the scenes of `environment/`.

use std::path::Path;
use std::process::Command;

use rayframe::regression::{Image, Preset, compare};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Renders a scene of `environment/` with the settings of the suite and `options`, where `quarters.hdr` becomes a full path.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(scene: &str, options: &[&str]) -> Image {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.exr");
    let folder_of_scenes = Path::new(ROOT).join("scenes/environment");
    let options = options.iter().map(|option| match option.strip_prefix("quarters.hdr") {
        Some(rest) => format!("{}{rest}", folder_of_scenes.join("quarters.hdr").display()),
        None => (*option).to_owned(),
    });
    let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .arg("render")
        .arg(folder_of_scenes.join(scene).with_extension("gltf"))
        .args(["-r", "160x90", "--samples", "4", "--layers", "object_id,material_id", "-q", "-o"])
        .arg(&file)
        .args(options)
        .output()
        .unwrap();
    assert!(output.status.success(), "{scene}: {}", String::from_utf8_lossy(&output.stderr));
    Image::read(&file).unwrap()
}

#[test]
fn options_reproduce_the_reference_images() {
    let background = ["--env", "quarters.hdr", "--background", "0.06,0.02,0.1"];
    let catcher = ["--background", "none", "--shadow-catcher", "floor"];
    for (scene, options) in [
        ("picture", &["--env", "quarters.hdr"][..]),
        ("turned", &["--env", "quarters.hdr@90", "--env-intensity", "0.5"]),
        ("turned", &["--env", "quarters.hdr@-270", "--env-intensity", "0.5", "--background", "env"]),
        ("background", &background),
        ("shadow_catcher", &catcher),
    ] {
        let reference =
            Path::new(ROOT).join("reference_images/environment").join(scene).with_extension("exr");
        let reference = Image::read(&reference).unwrap();
        let comparison = compare(&render(scene, options), &reference, &Preset::Exact.limits());
        assert!(comparison.passes(), "{scene} {options:?}: {}", comparison.failures().join("\n"));
    }
}

#[test]
fn the_background_may_differ_from_the_environment() {
    let seen = render("picture", &["--env", "0,0,0", "--background", "quarters.hdr@90"]);
    let pixels = seen.rgba().unwrap();
    let corner = pixels[0];
    // Turned by 90°, blue lies to the left: (0.125, 0.25, 0.75).
    assert_eq!(corner, [0.125, 0.25, 0.75, 1.0]);
    // The balls are black.
    let middle = pixels[45 * 160 + 80];
    assert_eq!(middle, [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn missing_nodes_and_files_are_named() {
    let fails = |options: &[&str], code: i32, words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .args(["render", "scenes/environment/shadow_catcher.gltf", "-n"])
            .args(options)
            .current_dir(ROOT)
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{told}");
        assert!(words.iter().all(|word| told.contains(word)), "{told}");
    };
    fails(&["--shadow-catcher", "flor"], 2, &["--shadow-catcher", "\"flor\""]);
    fails(&["--background", "gone.hdr"], 66, &["gone.hdr", "--background takes env, white"]);
    fails(&["--background", "Cargo.toml"], 65, &["Cargo.toml"]);
}

#[test]
fn a_hint_names_the_studio_where_a_files_lamps_leave_most_black() {
    let folder = tempfile::tempdir().unwrap();
    let told = |name: &str, options: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .args(["render", "scenes/light/point.gltf", "-r", "64x36", "--samples", "1", "-o"])
            .arg(folder.path().join(name))
            .args(options)
            .current_dir(ROOT)
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{told}");
        told
    };
    for (name, options) in
        [("dark.exr", &["--light-scale", "1e-5"][..]), ("dark.png", &["--light-scale", "1e-5"])]
    {
        let told = told(name, options);
        assert!(told.contains("--env studio") && told.contains("--env-intensity"), "{told}");
    }
    // Not where the lamps suffice, nor where darkness was requested or only shadows show.
    for (name, options) in [
        ("lit.exr", &[][..]),
        ("lit.png", &[]),
        ("none.png", &["--light-scale", "1e-5", "--env", "none"]),
        ("studio.png", &["--light-scale", "1e-5", "--env", "studio"]),
        ("catcher.png", &["--light-scale", "1e-5", "--shadow-catcher", "floor"]),
    ] {
        let told = told(name, options);
        assert!(!told.contains("--env studio"), "{told}");
    }
}

#[test]
fn display_backgrounds_are_exact_in_png_files_and_transparent_in_exr_files() {
    let exr = render("picture", &["--env", "quarters.hdr", "--background", "white"]);
    assert_eq!(exr.rgba().unwrap()[0], [0.0; 4]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("shot.toml"),
        format!(
            "scene = '{ROOT}/scenes/demo/whitted_1980.gltf'\nbackground = '#20c0ff'\nframes = 0\nsamples = 1\n\
             resolution = [64, 36]\noutput = 'a.exr'\npreview = 'png'\norbit = '0,0,100'\n"
        ),
    )
    .unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .args(["render", "shot.toml"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("background #20c0ff"));
    let preview = Image::read(&folder.path().join("a.png")).unwrap();
    assert_eq!(Image::read(&folder.path().join("a.exr")).unwrap().rgba().unwrap()[0], [0.0; 4]);
    let corner = preview.rgba().unwrap()[0].map(|value| (value * 255.0).round());
    assert_eq!(corner, [32.0, 192.0, 255.0, 255.0]);
}
