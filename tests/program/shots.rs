//! Shot files, settings by name and dry runs through the program.

use std::path::Path;
use std::process::{Command, Output};

const DEMO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");
const SMALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/light/point.gltf");
const PICTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/environment/quarters.hdr");

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn rayframe(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rayframe")).current_dir(folder).args(arguments).output().unwrap()
}

fn rendered(folder: &Path, arguments: &[&str]) -> String {
    let output = rayframe(folder, arguments);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {told}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()))
        .collect();
    files.sort();
    files
}

/// Everything that is printed stands for itself: defaults, what the scene decides, and what was typed, from anywhere.
#[test]
fn a_dry_run_prints_a_shot_that_makes_the_same_files() {
    // A name with all that has a meaning in patterns, and with characters that a terminal does not show.
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("50% #1 {frame} می\u{200c}شود\u{ad}");
    std::fs::create_dir(&folder).unwrap();
    let environment = format!("{PICTURE}@30");
    let much = "-r 64x36 --scale 50% -s 1 -e 4 -j 3 --fps 24000/1001 --samples 2 --max-samples 4 --aa-threshold 0.10 \
        --filter mitchell --shutter 180deg --time-samples 2 --aperture f/2.8 --focus 6.5 --depth 3 --camera #0 \
        --crop 4,2,30,17 --light-scale 1.25 --sun-angle 0.53 --background 0.1,0.2,0.3 --env-intensity .5 \
        --preview png --exposure -1.5 --tone agx --threads 1 --aovs depth,uv --exr float,zips --split-aovs \
        --contact-sheet much/sheet.png --keep-going";
    let mut much: Vec<&str> = much.split_whitespace().collect();
    much.extend(["--env", &environment]);
    for (name, options) in [("plain", &["-f", "0", "-W", "32", "--samples", "1"][..]), ("much", &much)] {
        let pattern = format!("{name}/a.%04d.exr");
        let render = [&["render", DEMO, "-o", &pattern][..], options].concat();
        let shot = rendered(&folder, &[&render[..], &["-n"]].concat());
        assert!(!folder.join(name).exists(), "nothing is written");
        assert!(shot.contains("# frame "), "{shot}");
        // The shot lies in another folder than that where it was made.
        let path = outer.path().join(format!("{name}.toml"));
        std::fs::write(&path, &shot).unwrap();
        let path = path.to_str().unwrap();

        rendered(&folder, &render);
        let typed = files(&folder.join(name));
        assert!(typed.iter().any(|(name, _)| name.starts_with("a.0")));
        std::fs::remove_dir_all(folder.join(name)).unwrap();
        rendered(outer.path(), &["render", path]);
        assert!(files(&folder.join(name)) == typed, "{name}: other files\n{shot}");
        // What is there is recognised, and printed the same but for that.
        let again = rendered(outer.path(), &["render", path, "-n"]);
        let settings =
            |shot: &str| shot.split_once("\n# Frames and ").map(|(settings, _)| settings.to_owned());
        assert_eq!(settings(&again), settings(&shot));
        assert!(again.contains(" s keep ") && !again.contains(" s render "), "{again}");
    }
}

/// What takes the place of a default is printed without it.
#[test]
fn a_dry_run_of_a_turntable_with_a_view_prints_a_shot_that_can_be_rendered() {
    let folder = tempfile::tempdir().unwrap();
    for (name, view) in [
        ("orbit", &["--orbit", "30,3"][..]),
        ("view", &["--view", "back"]),
        ("plain", &[]),
        ("elevation", &["--elevation", "5"]),
    ] {
        let pattern = format!("{name}/a.####.exr");
        let options = ["render", SMALL, "-o", &pattern, "-r", "16x9", "--samples", "1", "--turntable", "2"];
        let render = [&options[..], view].concat();
        let shot = rendered(folder.path(), &[&render[..], &["-n"]].concat());
        assert_eq!(shot.contains("\nelevation = "), name == "plain" || name == "elevation", "{shot}");
        std::fs::write(folder.path().join("t.toml"), shot).unwrap();
        rendered(folder.path(), &["render", "t.toml", "-q"]);
        let frames = files(&folder.path().join(name));
        rendered(folder.path(), &[&render[..], &["--overwrite", "-q"]].concat());
        assert!(frames.len() == 2 && frames == files(&folder.path().join(name)), "{name}");
    }
}

/// The name, the camera and the frames that nobody chose.
#[test]
fn what_the_scene_decides_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().canonicalize().unwrap();
    let shot = rendered(&folder, &["render", DEMO, "-n", "--height", "72", "-j", "30"]);
    let output = format!("output = \"{}/whitted_1980.####.exr\"", folder.display());
    for line in
        [&format!("scene = \"{DEMO}\""), &output, "resolution = \"128x72\"", "camera = \"#0\"", "samples = 4"]
    {
        assert!(shot.lines().any(|printed| printed == line), "{line} is missing in\n{shot}");
    }
    assert!(shot.contains("\nframes = \"0-"), "{shot}");
    for absent in ["\nheight =", "\nstep =", "\nscale =", "time_samples", "dry_run", "config"] {
        assert!(!shot.contains(absent), "{absent} is in\n{shot}");
    }
}

#[test]
fn a_dry_run_tells_programs_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["-f", "3", "--samples", "+2", "--shadow-catcher", "ground", "--progress", "json", "-n"];
    let printed = rendered(folder.path(), &[&["render", DEMO][..], &options].concat());
    let plan: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((&plan["schema"], &plan["event"]), (&1.into(), &"plan".into()));
    assert_eq!(plan["settings"]["samples"], 2);
    assert_eq!(plan["settings"]["frames"], "3");
    assert_eq!(plan["settings"]["shadow_catcher"][0], "ground");
    assert_eq!(plan["frames"][0]["frame"], 3);
    assert_eq!(plan["frames"][0]["action"], "render");
}

#[test]
fn a_shot_file_is_a_scene_with_settings_and_lies_beside_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let shots = folder.path().join("shots");
    std::fs::create_dir(&shots).unwrap();
    std::fs::copy(DEMO, shots.join("robot.gltf")).unwrap();
    let text =
        "scene = 'robot.gltf'\noutput = 'out/a.####.exr'\nframes = 0\nresolution = [32, 18]\nsamples = 1\n";
    std::fs::write(shots.join("a.toml"), text).unwrap();
    rendered(folder.path(), &["render", "shots/a.toml", "-f", "2"]);
    assert!(shots.join("out/a.0002.exr").is_file() && !shots.join("out/a.0000.exr").exists());
    // The same settings for another scene, with a name of its own.
    rendered(folder.path(), &["render", DEMO, "--config", "shots/a.toml", "-D", "output=b.png", "-q"]);
    assert!(folder.path().join("b.png").is_file());
    // What is typed is named from where it is typed.
    rendered(folder.path(), &["render", "shots/a.toml", "-o", "c.exr", "--resume"]);
    assert!(folder.path().join("c.exr").is_file());
}

#[test]
fn faults_of_a_shot_file_are_told_in_one_line_with_the_code_of_wrong_files() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("scene = '{DEMO}'\n");
    for (text, code, word) in [
        ("sampels = 4", 65, "a.toml:2:1: \"sampels\" is no setting; did you mean \"samples\"?"),
        ("samples = 'x'", 65, "a.toml:2:1: samples: expected a number, found a text"),
        ("fps = 0", 65, "a.toml:2:1: fps: "),
        ("asset_cache = ''", 65, "a.toml:2:1: asset_cache: is empty; write a path"),
        ("stats = ''", 65, "a.toml:2:1: stats: is empty; write a path"),
        ("\nframes = '9-1'", 65, "a.toml:3:1: frames: "),
        ("camera = 'nobody'", 65, ":2:1: camera: "),
        ("output = 'a.jpg'", 65, ":2:1: output: \".jpg\" cannot be written"),
        ("scene_choice = '#99'", 65, ":2:1: scene_choice: "),
        ("env = 'gone.hdr'", 66, "gone.hdr"),
        ("samples = 4 4", 65, "a.toml:2:"),
        ("frames = '1-2'\noutput = 'x.exr'", 65, ":3:1: output: 2 frames would all be written"),
        ("frames = 0\noutput = 'x.exr'\nstats = 'x.exr'", 65, ":4:1: stats: \"x.exr\" will hold a frame"),
    ] {
        std::fs::write(folder.path().join("a.toml"), format!("{scene}{text}\n")).unwrap();
        let output = rayframe(folder.path(), &["render", "a.toml", "-n"]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{text}: {told}");
        assert!(told.contains(word) && told.lines().count() == 1, "{text}: {told}");
    }
    std::fs::write(folder.path().join("a.toml"), format!("{scene}samples = 4 4\n")).unwrap();
    let typed = rayframe(folder.path(), &["render", "a.toml", "-D", "fps=0", "-n"]);
    assert_eq!(typed.status.code(), Some(65), "the file is broken whatever is typed");
    let missing = rayframe(folder.path(), &["render", "b.toml"]);
    assert_eq!(missing.status.code(), Some(66));
    // A shot file is read and must not be written over.
    std::fs::write(folder.path().join("a.toml"), format!("{scene}frames = 0")).unwrap();
    let over_itself = rayframe(folder.path(), &["render", "a.toml", "--stats", "a.toml", "-n"]);
    assert_eq!(over_itself.status.code(), Some(2));
}

#[test]
fn contact_sheets_whose_names_differ_in_case_only_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let render = |sheets: [&str; 2]| {
        for (name, sheet) in ["p", "q"].into_iter().zip(sheets) {
            let files = format!("output = '{name}.png'\ncontact_sheet = '{sheet}'");
            let text = format!("scene = '{DEMO}'\nframes = 0\n{files}\n");
            std::fs::write(folder.path().join(name).with_extension("toml"), text).unwrap();
        }
        rayframe(folder.path(), &["render", "p.toml", "q.toml", "-n"])
    };
    let common = render(["s.png", "s.png"]);
    assert_eq!(common.status.code(), Some(0), "{}", String::from_utf8_lossy(&common.stderr));
    let refused = render(["S.png", "s.png"]);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(65), "{told}");
    assert!(told.contains("differs in case only"), "{told}");
}
