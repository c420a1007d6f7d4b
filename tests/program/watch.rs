//! `rayframe watch`.

#![cfg(unix)]

use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rayframe::image_file::inspect_png;

use crate::names;

/// Time limit, far beyond what any step takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
const SIZE: [&str; 2] = ["-r", "96x54"];

/// Writes a scene of one unlit triangle whose positions are in `corners.bin`.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn write_scene(folder: &Path, color: &str) {
    let scene = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
        "materials": [{{"doubleSided": true, "pbrMetallicRoughness": {{"baseColorFactor": [{color}, 1]}},
            "extensions": {{"KHR_materials_unlit": {{}}}}}}], "extensionsUsed": ["KHR_materials_unlit"],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [-9, -9, -9], "max": [9, 9, 9]}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "buffers": [{{"uri": "corners.bin", "byteLength": 36}}]}}"#
    );
    std::fs::write(folder.join("a.gltf"), scene).unwrap();
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn write_corners(folder: &Path, top: f32) {
    let corners = [-1.0_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, top, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(folder.join("corners.bin"), bytes).unwrap();
}

/// A process that is killed when dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn watch(folder: &Path, arguments: &[&str]) -> Running {
    let told = std::fs::File::create(folder.join("told")).unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .current_dir(folder)
        .arg("watch")
        .args(arguments)
        .stderr(told)
        .stdout(Stdio::null())
        .spawn();
    Running(child.unwrap())
}

/// The file that `rayframe render` writes.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn rendered(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let file = folder.join("expected.png");
    let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .current_dir(folder)
        .arg("render")
        .args(arguments)
        .args(["--overwrite", "-o", "expected.png"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let bytes = std::fs::read(&file).unwrap();
    std::fs::remove_file(file).unwrap();
    bytes
}

fn told(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("told")).unwrap_or_default()
}

fn wait_until(folder: &Path, what: &str, is_so: impl Fn() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "{what} did not come; told was\n{}", told(folder));
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn wait_for(folder: &Path, what: &str, expected: &[u8]) {
    let look: PathBuf = folder.join("look.png");
    wait_until(folder, what, || std::fs::read(&look).is_ok_and(|bytes| bytes == expected));
}

/// Sends SIGTERM to the process; returns the signal that ended it.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn terminate(running: &mut Running) -> Option<i32> {
    let id = running.0.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
    running.0.wait().unwrap().signal()
}

#[test]
fn changes_of_the_scene_and_its_buffer_are_rendered_and_errors_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    let scene = [&["a.gltf"][..], &SIZE].concat();
    let red = rendered(folder, &scene);
    let mut running = watch(folder, &[&scene[..], &["-o", "look.png"]].concat());
    wait_for(folder, "the red image", &red);

    write_scene(folder, "0, 0, 1");
    let blue = rendered(folder, &scene);
    assert_ne!(red, blue);
    wait_for(folder, "the blue image", &blue);

    write_corners(folder, -0.5);
    let flat = rendered(folder, &scene);
    assert_ne!(blue, flat);
    wait_for(folder, "the flat image", &flat);

    // A truncated file is reported in one line, and the image is kept.
    std::fs::write(folder.join("a.gltf"), "{\"asset\": ").unwrap();
    wait_until(folder, "an error", || told(folder).contains("rayframe: error: a.gltf"));
    assert!(std::fs::read(folder.join("look.png")).unwrap() == flat);
    std::fs::remove_file(folder.join("a.gltf")).unwrap();
    wait_until(folder, "another error", || told(folder).contains("cannot be read"));
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    wait_for(folder, "the red image again", &red);

    assert_eq!(terminate(&mut running), Some(15));
    assert_eq!(names(folder), ["a.gltf", "corners.bin", "look.png", "told"]);
}

#[test]
fn a_buffer_that_was_truncated_at_first_is_watched() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    let whole = std::fs::read(folder.join("corners.bin")).unwrap();
    std::fs::write(folder.join("corners.bin"), &whole[..20]).unwrap();
    let mut watching = watch(folder, &[&["a.gltf", "-o", "look.png"], &SIZE[..]].concat());
    wait_until(folder, "the error", || told(folder).contains("truncated"));
    write_corners(folder, 1.0);
    let expected = rendered(folder, &[&["a.gltf"], &SIZE[..]].concat());
    wait_for(folder, "the image of the whole buffer", &expected);
    assert_eq!(terminate(&mut watching), Some(15));
}

#[test]
fn changes_of_the_shot_file_are_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    let write = |background: &str| {
        let text = format!("scene = 'a.gltf'\nresolution = [96, 54]\nbackground = '{background}'\n");
        std::fs::write(folder.join("a.toml"), text).unwrap();
    };
    write("none");
    let none = rendered(folder, &["a.toml"]);
    let mut running = watch(folder, &["a.toml", "-o", "look.png", "-q"]);
    wait_for(folder, "the first image", &none);
    write("0,1,0");
    wait_for(folder, "the green image", &rendered(folder, &["a.toml"]));
    std::fs::write(folder.join("a.toml"), "sampels = 4").unwrap();
    wait_until(folder, "an error", || told(folder).contains("did you mean \"samples\"?"));
    write("none");
    wait_for(folder, "the first image again", &none);
    assert_eq!(terminate(&mut running), Some(15));
    assert_eq!(names(folder), ["a.gltf", "a.toml", "corners.bin", "look.png", "told"]);
}

#[test]
fn frames_of_the_shot_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    std::fs::write(folder.join("frame.0000.png"), "a frame").unwrap();
    let shot = "scene = 'a.gltf'\nresolution = [96, 54]\noutput = 'frame.####.png'\n";
    std::fs::write(folder.join("a.toml"), shot).unwrap();
    let whole = rendered(folder, &["a.gltf", "-f", "0", "-r", "96x54"]);
    let mut running = watch(folder, &["a.toml", "-q"]);
    wait_until(folder, "the image", || {
        std::fs::read(folder.join("a.watch.png")).is_ok_and(|bytes| bytes == whole)
    });
    assert_eq!(terminate(&mut running), Some(15));
    assert_eq!(std::fs::read(folder.join("frame.0000.png")).unwrap(), b"a frame");

    // An output name on the command line does not overwrite one either.
    std::fs::rename(folder.join("a.watch.png"), folder.join("frame.0007.png")).unwrap();
    let mut running = watch(folder, &["a.gltf", "-f", "7", "-r", "64x36", "-o", "frame.####.png"]);
    assert_eq!(running.0.wait().unwrap().code(), Some(73), "{}", told(folder));
    assert!(told(folder).contains("is a frame of a sequence"), "{}", told(folder));

    // Those that the same run wrote it replaces.
    std::fs::write(folder.join("frame.0007.png"), &whole).unwrap();
    let mut running = watch(folder, &["a.gltf", "-f", "8", "-r", "96x54", "-o", "frame.####.png"]);
    for color in ["1, 0, 0", "0, 1, 0", "0, 0, 1"] {
        write_scene(folder, color);
        let expected = rendered(folder, &["a.gltf", "-f", "8", "-r", "96x54"]);
        wait_until(folder, "the image of the changed scene", || {
            std::fs::read(folder.join("frame.0008.png")).is_ok_and(|bytes| bytes == expected)
        });
    }
    assert_eq!(terminate(&mut running), Some(15));
    assert_eq!(std::fs::read(folder.join("frame.0007.png")).unwrap(), whole);
}

/// A render of minutes starts with a coarse image. A change of the scene or a signal cancels it.
#[test]
fn coarse_images_come_first_and_changes_cancel_the_render() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    let look = folder.join("look.png");
    let coarse = || {
        let stored = inspect_png(&look).ok()?;
        stored.render_hash?.strip_prefix("coarse ").map(str::to_owned)
    };
    let slow = ["a.gltf", "-r", "1920x1080", "--samples", "4096", "-o", "look.png"];
    let mut running = watch(folder, &slow);
    wait_until(folder, "the coarse image", || coarse().is_some());
    let first = coarse();
    // A broken file does not take the only image away.
    std::fs::write(folder.join("a.gltf"), "{\"asset\": ").unwrap();
    wait_until(folder, "an error", || told(folder).contains("rayframe: error: a.gltf"));
    assert_eq!(coarse(), first);
    write_scene(folder, "0, 0, 1");
    wait_until(folder, "another coarse image", || coarse().is_some_and(|hash| Some(hash) != first));
    // The end alone is no reason to render again, and nothing is left to resume.
    let again = "an input has changed, rendering begins again";
    wait_until(folder, "the reason", || told(folder).contains(again));
    assert_eq!(terminate(&mut running), Some(15));
    assert_eq!(names(folder), ["a.gltf", "corners.bin", "told"], "a coarse image was left");
    let told = told(folder);
    assert_eq!(told.matches(again).count(), 1, "{told}");
    assert!(told.trim_end().ends_with("; stopped before the end") && !told.contains("--resume"), "{told}");

    // The last finished image is restored.
    let whole = rendered(folder, &["a.gltf", "-r", "1920x1080", "--samples", "1"]);
    std::fs::write(&look, &whole).unwrap();
    let mut running = watch(folder, &slow);
    wait_until(folder, "the coarse image", || coarse().is_some());
    assert_eq!(terminate(&mut running), Some(15));
    assert!(std::fs::read(&look).unwrap() == whole);
}

#[test]
fn the_last_full_image_comes_back_after_an_error_and_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    let look = folder.join("look.png");
    let whole = rendered(folder, &["a.gltf", "-r", "1920x1080", "--samples", "1"]);
    std::fs::write(&look, &whole).unwrap();
    let is_coarse = || {
        let stored = inspect_png(&look).ok().and_then(|stored| stored.render_hash);
        stored.is_some_and(|hash| hash.starts_with("coarse "))
    };
    let mut running = watch(folder, &["a.gltf", "-r", "1920x1080", "--samples", "4096", "-o", "look.png"]);
    wait_until(folder, "the coarse image", is_coarse);
    std::fs::write(folder.join("a.gltf"), "{\"asset\": ").unwrap();
    wait_until(folder, "an error", || told(folder).contains("rayframe: error: a.gltf"));
    wait_for(folder, "the last full image", &whole);

    // While a file keeps changing no render begins, and the signal comes before the next one.
    write_scene(folder, "0, 0, 1");
    wait_until(folder, "another coarse image", is_coarse);
    let ends = told(folder).matches("begins again").count();
    wait_until(folder, "the end of the render", || {
        write_scene(folder, &format!("0, {}, 1", Instant::now().elapsed().as_secs_f32()));
        told(folder).matches("begins again").count() > ends
    });
    assert_eq!(terminate(&mut running), Some(15));
    assert!(std::fs::read(&look).unwrap() == whole);
}

#[test]
fn invalid_watches_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    std::fs::write(folder.join("photo.png"), "not ours").unwrap();
    for (arguments, code, word) in [
        (&["gone.gltf"][..], 66, "gone.gltf"),
        (&["a.gltf", "-f", "1-3"], 2, "add -f 12"),
        (&["a.gltf", "-n"], 2, "rayframe render --dry-run"),
        (&["a.gltf", "-o", "photo.png"], 73, "made by another program; name the image"),
        (&["a.gltf", "-o", "photo.exr", "--preview", "png"], 73, "photo.png: the file is there"),
        (&["a.gltf", "-o", "a.jpg"], 2, "cannot be written"),
        (&["a.gltf", "--stats", "corners.bin"], 2, "is an input"),
    ] {
        let mut running = watch(folder, arguments);
        wait_until(folder, "the end", || told(folder).contains(word));
        assert_eq!(running.0.wait().unwrap().code(), Some(code), "{arguments:?}");
    }
    assert_eq!(std::fs::read(folder.join("photo.png")).unwrap(), b"not ours");
}

#[test]
fn an_image_is_watched_with_the_settings_of_a_shot_file_for_exr_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "1, 0, 0");
    write_corners(folder, 1.0);
    let image = "scene = 'a.gltf'\nresolution = [96, 54]\n";
    std::fs::write(folder.join("plain.toml"), image).unwrap();
    let files =
        "output = 'out/a.####.exr'\nframes = '1-9'\naovs = ['depth']\nsplit_aovs = true\nresume = true\n";
    std::fs::write(folder.join("a.toml"), format!("{image}{files}")).unwrap();
    let expected = rendered(folder, &["plain.toml", "-f", "2"]);
    let mut running = watch(folder, &["a.toml", "-f", "2", "-o", "look.png"]);
    wait_for(folder, "the image", &expected);
    assert_eq!(terminate(&mut running), Some(15));
    assert!(!folder.join("out").exists());
}

#[test]
fn a_measured_exposure_gives_the_bytes_of_render() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/light/point.gltf");
    std::fs::copy(scene, folder.join("a.gltf")).unwrap();
    let scene = [&["a.gltf"][..], &SIZE, &["-f", "0"]].concat();
    let expected = rendered(folder, &scene);
    let mut running = watch(folder, &[&scene[..], &["-o", "look.png"]].concat());
    wait_for(folder, "the image", &expected);
    assert_eq!(terminate(&mut running), Some(15));
    assert_eq!(told(folder).matches("chosen automatically").count(), 1, "{}", told(folder));
}
