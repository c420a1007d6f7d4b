//! Progress output: JSON lines and the manifest against their schemas, Open Job Description lines, and estimates on a
//! terminal and in a pipe.

pub(crate) mod schema;

use std::path::Path;
use std::process::{Command, Output, Stdio};

use schema::Schema;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

const FRAMES: usize = 10;

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(folder: &Path, options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .current_dir(folder)
        .args(["render", &scene(), "-r", "48x27", "--samples", "1"])
        .args(options)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn scene() -> String {
    format!("{}/scenes/demo/whitted_1980.gltf", env!("CARGO_MANIFEST_DIR"))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn last_frame() -> String {
    format!("0-{}", FRAMES - 1)
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn events(output: &Output) -> Vec<Value> {
    text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn json_file(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes
        .iter()
        .flat_map(|byte| [byte >> 4, byte & 15])
        .filter_map(|digit| char::from_digit(digit.into(), 16))
        .collect()
}

/// Renders while a folder takes the name of frame 4, which makes its rename fail. An earlier folder would be refused.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render_with_an_obstacle(folder: &Path, options: &[&str]) -> Output {
    let child = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .current_dir(folder)
        .args(["render", &scene(), "-r", "240x135", "--samples", "2", "-o", "b.#.exr", "-f", "0-4"])
        .args(options)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !folder.join("b.0.exr").exists() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    std::fs::create_dir_all(folder.join("b.4.exr/x")).unwrap();
    child.wait_with_output().unwrap()
}

#[test]
fn warnings_about_movies_are_json_events_before_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    for (name, options) in [("a.#.exr", &["--movie", "a.gif"][..]), ("b.gif", &[])] {
        // GIF files show 50 frames a second at most.
        let told = ["-o", name, "-f", "0-1", "--fps", "60", "--progress", "json"];
        let run = render(folder.path(), &[&told, options].concat());
        assert_eq!(run.status.code(), Some(0), "{run:?}");
        let events = events(&run);
        let messages: Vec<_> = events.iter().filter(|event| event["event"] == "warning").collect();
        let is_about_rate =
            |event: &&&Value| event["message"].as_str().unwrap().contains("50 frames a second");
        assert_eq!(messages.iter().filter(is_about_rate).count(), 1, "{name}: {events:?}");
        for event in &messages {
            Schema::read("progress").check(event);
        }
        assert_eq!(events.last().unwrap()["event"], "summary");
        assert!(text(&run.stderr).contains("50 frames a second"));
    }
}

#[test]
fn warnings_about_the_scene_are_json_events_after_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let empty = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["ACME_glow"]}"#;
    std::fs::write(folder.path().join("a.gltf"), empty).unwrap();
    let warnings = |options: &[&str]| {
        let told = ["render", "a.gltf", "-r", "4x4", "--progress", "json"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        let run = command.current_dir(folder.path()).args(told).args(options).output().unwrap();
        assert_eq!(run.status.code(), Some(0), "{run:?}");
        let said = text(&run.stderr);
        let events = events(&run);
        assert_eq!(events[0]["event"], "start");
        let warnings = events[1..].iter().take_while(|event| event["event"] == "warning");
        let told = |event: &Value| {
            Schema::read("progress").check(event);
            let [pointer, message] = ["pointer", "message"].map(|key| event[key].as_str().unwrap());
            assert_eq!(said.matches(message).count(), 1, "{said}");
            (pointer.to_owned(), message.to_owned())
        };
        warnings.map(told).collect::<Vec<_>>()
    };
    let is_of = |(pointer, message): &(String, String), (at, word)| pointer == at && message.contains(word);
    let first = warnings(&[]);
    assert_eq!(first.len(), 2, "{first:?}");
    assert!(is_of(&first[0], ("/extensionsUsed/0", "ACME_glow")), "{first:?}");
    assert!(is_of(&first[1], ("", "no triangles")), "{first:?}");
    let second = warnings(&["--samples", "2", "--resume"]);
    assert_eq!((second.len(), &second[..2]), (3, &first[..]), "{second:?}");
    assert!(is_of(&second[2], ("", "1 file made from something else will be replaced")), "{second:?}");
}

#[test]
fn exr_runs_that_measure_the_exposure_tell_it() {
    let folder = tempfile::tempdir().unwrap();
    let exposures = |name: &str, options: &[&str]| -> Vec<Value> {
        let told = ["-o", name, "-f", "0-1", "--progress", "json", "--integrator", "path"];
        let run = render(folder.path(), &[&told, options].concat());
        assert_eq!(run.status.code(), Some(0), "{run:?}");
        events(&run).into_iter().filter(|event| event["event"] == "exposure").collect()
    };
    let noise = exposures("n.#.exr", &["--noise", "0.5"]);
    assert!(noise.len() == 1 && noise[0]["automatic"] == true, "{noise:?}");
    // Display values decide about nothing.
    assert_eq!(exposures("p.#.exr", &[]), [] as [Value; 0]);
    // Nothing is rendered.
    assert_eq!(exposures("n.#.exr", &["--noise", "0.5", "--resume"]), [] as [Value; 0]);
}

#[test]
fn json_lines_match_the_schema() {
    let schema = Schema::read("progress");
    let folder = tempfile::tempdir().unwrap();
    let runs = [
        render(
            folder.path(),
            &["-o", "a.#.exr", "-f", "0-1", "--progress", "json", "--layers", "depth", "--split-aovs"],
        ),
        render(folder.path(), &["-o", "p.#.exr", "-f", "0-2", "--progress", "json", "--preview", "png"]),
        render(folder.path(), &["-o", "p.#.exr", "-f", "0-3", "--progress", "json", "--preview", "png"]),
        render_with_an_obstacle(folder.path(), &["--progress", "json", "--keep-going"]),
    ];
    assert_eq!(runs.each_ref().map(|run| run.status.code()), [Some(0), Some(0), Some(0), Some(74)]);
    let mut seen = std::collections::BTreeSet::new();
    for run in &runs {
        let events = events(run);
        for event in &events {
            schema.check(event);
            seen.insert(event["event"].as_str().unwrap().to_owned());
        }
        assert_eq!(events[0]["event"], "start");
        assert_eq!(events.last().unwrap()["event"], "summary");
    }
    for name in [
        "start",
        "exposure",
        "frame_skipped",
        "frame_start",
        "progress",
        "frame_done",
        "frame_failed",
        "summary",
    ] {
        assert!(seen.contains(name), "{name} was never told");
    }
    // A dry run prints one line.
    let dry = render(
        folder.path(),
        &["-o", "p.#.exr", "-f", "2-4", "--progress", "json", "--preview", "png", "-n"],
    );
    let plan = events(&dry);
    schema.check(&plan[0]);
    assert_eq!((plan.len(), &plan[0]["event"]), (1, &json!("plan")));
    let actions = [2, 3, 4].map(|frame| &plan[0]["frames"][frame - 2]["action"]);
    assert_eq!(actions, ["keep", "keep", "render"]);
    // The schema rejects small deviations.
    let good = events(&runs[0]).into_iter().find(|event| event["event"] == "frame_done").unwrap();
    for (key, value) in [
        ("frame", json!("1")),
        ("schema", json!(2)),
        ("event", json!("done")),
        ("bytes", json!(-1)),
        ("new", json!(1)),
    ] {
        let mut bad = good.clone();
        bad[key] = value;
        assert!(!schema.accepts(&bad), "{key}");
    }
    let mut incomplete = good.clone();
    incomplete["tree"].as_object_mut().unwrap().remove("depth");
    assert!(schema.accepts(&good) && !schema.accepts(&incomplete));
}

#[test]
fn statistics_are_those_of_their_schema() {
    let schema = Schema::read("stats");
    let folder = tempfile::tempdir().unwrap();
    let statistics = |options: &[&str]| {
        let output = render(folder.path(), &[&["--stats", "s.json", "-q"], options].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let statistics = json_file(&folder.path().join("s.json"));
        schema.check(&statistics);
        statistics
    };
    // A split AOV, and the cache of a scene with a texture
    let first = statistics(&[
        "-o",
        "a.#.exr",
        "-f",
        "0-1",
        "--aovs",
        "depth",
        "--split-aovs",
        "--asset-cache",
        "cache",
    ]);
    assert!(first["frames"][1]["layers"][0]["bytes"].as_u64() > Some(0));
    assert_eq!(first["asset_cache"]["misses"].as_u64().map(|misses| misses > 0), Some(true));
    // A frame that is kept, and the names of each
    let kept = statistics(&["-o", "a.#.exr", "-f", "0-2", "--aovs", "depth", "--split-aovs", "--resume"]);
    assert_eq!(kept["kept"], json!([0, 1]));
    let named = statistics(&["-o", "{clip}.{camera}.exr", "-f", "0", "--animation", "each", "-c", "each"]);
    assert_eq!((&named["clip"], &named["camera"]), (&json!("drift"), &json!("camera")));
    // Parts of a movie, and a failure
    statistics(&["-o", "a.gif", "-f", "0-1"]);
    let output = render_with_an_obstacle(folder.path(), &["--stats", "s.json", "-q"]);
    assert_eq!(output.status.code(), Some(74), "{}", text(&output.stderr));
    let failed = json_file(&folder.path().join("s.json"));
    schema.check(&failed);
    assert_eq!(failed["failed"][0]["code"], 74);
    // Names and types are fixed.
    let mut renamed = named.clone();
    renamed["frames"][0]["tree"].as_object_mut().unwrap().remove("depth");
    assert!(schema.accepts(&named) && !schema.accepts(&renamed));
}

#[test]
fn the_manifest_lists_every_frame_and_its_files() {
    let schema = Schema::read("manifest");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/frames.json");
    let run = |frames: &str| {
        let options =
            ["-o", "a.#.exr", "-f", frames, "--manifest", "new/frames.json", "--preview", "png", "-q"];
        let layers = ["--layers", "depth", "--split-aovs"];
        let output = render(folder.path(), &[&options[..], &layers].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        json_file(&path)
    };
    run("1");
    let manifest = run("0-2");
    schema.check(&manifest);
    assert_eq!(manifest["complete"], true);
    let statuses: Vec<_> =
        manifest["frames"].as_array().unwrap().iter().map(|frame| &frame["status"]).collect();
    assert_eq!(statuses, ["written", "kept", "written"]);
    for frame in 0..3 {
        let files = manifest["frames"][frame]["files"].as_array().unwrap();
        let names: Vec<_> = files.iter().map(|file| file["path"].as_str().unwrap().to_owned()).collect();
        assert_eq!(
            names,
            [format!("a.{frame}.exr"), format!("a.depth.{frame}.exr"), format!("a.{frame}.png")]
        );
        for file in files {
            let content = std::fs::read(folder.path().join(file["path"].as_str().unwrap())).unwrap();
            let digest = hexadecimal(&Sha256::digest(&content));
            assert_eq!((&file["sha256"], &file["bytes"]), (&json!(digest), &json!(content.len())));
        }
    }
    // Equal runs write equal manifests.
    let all_kept = run("0-2");
    assert_eq!(all_kept, run("0-2"));

    // The manifest holds the failure and the frames that were not rendered.
    let output = render_with_an_obstacle(folder.path(), &["--manifest", "new/frames.json", "-q"]);
    assert_eq!(output.status.code(), Some(74), "{}", text(&output.stderr));
    let manifest = json_file(&path);
    schema.check(&manifest);
    assert_eq!((&manifest["complete"], &manifest["frames"][4]["status"]), (&json!(false), &json!("failed")));
    assert_eq!(manifest["frames"][4]["error"]["code"], 74);
    assert!(manifest["frames"][4]["error"]["message"].as_str().unwrap().contains("b.4.exr"));

    let collision = render(folder.path(), &["-o", "c.exr", "-f", "0", "--manifest", "./c.exr"]);
    assert_eq!(collision.status.code(), Some(2));
    assert!(text(&collision.stderr).contains("--manifest"), "{}", text(&collision.stderr));
}

#[test]
fn open_job_description_has_its_own_lines() {
    let folder = tempfile::tempdir().unwrap();
    let output = render(folder.path(), &["-o", "a.#.exr", "-f", "0-3", "--progress", "openjd"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let percents: Vec<f64> = said
        .lines()
        .filter_map(|line| line.strip_prefix("openjd_progress: "))
        .map(|p| p.parse().unwrap())
        .collect();
    assert!(
        percents.is_sorted() && percents.first() == Some(&0.0) && percents.last() == Some(&100.0),
        "{said}"
    );
    assert!(percents.contains(&25.0) && percents.contains(&75.0), "{said}");
    assert!(said.contains("openjd_status: frame 0 (1/4) written a.0.exr "), "{said}");
    assert!(said.lines().all(|line| line.starts_with("openjd_")), "{said}");

    let output = render_with_an_obstacle(folder.path(), &["--progress", "openjd"]);
    let said = text(&output.stdout);
    assert!(said.contains("openjd_fail: frame 4: b.4.exr: write failed"), "{said}");
    assert!(!said.contains("openjd_progress: 100"), "{said}");
    let output = render(folder.path(), &["-o", "a.jpg", "--progress", "openjd"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stdout).starts_with("openjd_fail: "), "{}", text(&output.stdout));
}

#[test]
fn a_pipe_gets_a_line_a_frame_with_the_remaining_time() {
    let folder = tempfile::tempdir().unwrap();
    let output = render(folder.path(), &["-o", "a.####.exr", "-f", &last_frame()]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.is_empty());
    let said = text(&output.stderr);
    let lines: Vec<_> = said.lines().filter(|line| line.contains(" written a.")).collect();
    assert_eq!(lines.len(), FRAMES, "{said}");
    for (frame, line) in lines.iter().enumerate() {
        let start = format!("frame {frame} ({}/{FRAMES}) written a.{frame:04}.exr ", frame + 1);
        assert!(line.starts_with(&start), "{line}");
        assert_eq!(line.contains(", eta "), frame + 1 < FRAMES, "{line}");
    }
    // Besides those, the settings and the summary.
    assert_eq!(said.lines().count(), FRAMES + 2, "{said}");
    assert!(said.ends_with(" s\n") && said.contains("10 frames written to a.####.exr in "), "{said}");
}

/// Needs the program `script`.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_shows_bars_with_the_remaining_time() {
    let folder = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_rayframe");
    let command = format!(
        "{program} render {} -o a.####.exr -r 192x108 --samples 4 --depth 1 -f {}",
        scene(),
        last_frame()
    );
    let output = Command::new("script")
        .args(["-qec", &command, "/dev/null"])
        .current_dir(folder.path())
        .env("TERM", "xterm")
        .stdin(Stdio::null())
        .output();
    let Ok(output) = output else { return crate::skipped("the program script is missing") };
    let said = text(&output.stdout);
    // Each bar overwrites the one before and shows more frames.
    let done: std::collections::BTreeSet<_> =
        said.match_indices("/10 eta ").map(|(at, _)| &said[at - 1..at]).collect();
    assert!(done.len() > 1, "{said}");
    assert!(
        said.trim_end().ends_with(" s") && said.contains("10 frames written to a.####.exr in "),
        "{said}"
    );
    assert!(said.contains("was cut off at depth 1: raise --depth"), "{said}");
}
