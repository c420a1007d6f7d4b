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
    fails(&["--background", "gone.hdr"], 66, &["gone.hdr", "--background takes env, none"]);
    fails(&["--background", "Cargo.toml"], 65, &["Cargo.toml"]);
}
