//! Frames beyond the memory limit: bands of rows, and what the program says of them.

use std::path::Path;
use std::process::Output;

use crate::{rayframe, stderr};

const SCENE: &str = "scenes/path/box.gltf";

/// Renders 1024 x 1024 pixels, which need 33 MB besides program and scene.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(output: &Path, options: &[&str]) -> Output {
    let output = output.to_str().unwrap();
    let all = ["render", SCENE, "-o", output, "-r", "1024x1024", "--samples", "1", "--env-samples", "0"];
    rayframe(&[&all[..], options].concat())
}

#[test]
fn limited_memory_gives_the_same_file_in_bands() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let (whole, bands, statistics) = (path("whole.exr"), path("bands.exr"), path("stats.json"));
    assert_eq!(render(&whole, &["--progress", "none"]).status.code(), Some(0));

    let limit = ["--max-memory", "40M"];
    let stats = ["--stats", statistics.to_str().unwrap()];
    let run = render(&bands, &[&limit[..], &stats].concat());
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    assert!(stderr(&run).contains("frames are rendered in bands of "), "{}", stderr(&run));
    assert!(std::fs::read(&bands).unwrap() == std::fs::read(&whole).unwrap());
    let statistics: serde_json::Value = serde_json::from_slice(&std::fs::read(&statistics).unwrap()).unwrap();
    assert_eq!(statistics["frames"][0]["bytes"], std::fs::metadata(&whole).unwrap().len());
    let peak = statistics["frames"][0]["peak_memory_bytes"].as_u64();
    assert!(peak.is_none_or(|peak| peak < 40_000_000), "{peak:?}");

    let checked = rayframe(&["check", bands.to_str().unwrap()]);
    assert_eq!(checked.status.code(), Some(0));
    // A whole frame of the same hash is kept.
    let resumed = render(&bands, &[&limit[..], &["--resume"]].concat());
    let said = stderr(&resumed);
    assert!(said.contains("the frame was there already") && !said.contains("bands"), "{said}");
}

#[test]
fn dry_runs_name_bands_and_refusals_the_setting_that_rules_them_out() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.exr");
    let limit = ["--max-memory", "40M", "--dry-run"];
    let planned = render(&output, &limit);
    let text = String::from_utf8_lossy(&planned.stdout).into_owned();
    assert!(text.contains("a.exr in bands of ") && text.contains(" rows"), "{text}");
    let planned = render(&output, &[&limit[..], &["--progress", "json"]].concat());
    let plan: serde_json::Value = serde_json::from_slice(&planned.stdout).unwrap();
    assert!(plan["frames"][0]["band_rows"].as_u64().is_some_and(|rows| rows.is_multiple_of(32)), "{plan}");
    let whole = render(&output, &["--dry-run", "--progress", "json"]);
    let plan: serde_json::Value = serde_json::from_slice(&whole.stdout).unwrap();
    assert!(plan["frames"][0].get("band_rows").is_none(), "{plan}");

    let refused = render(&output, &[&limit[..], &["--preview", "png"]].concat());
    let said = stderr(&refused);
    assert!(
        refused.status.code() == Some(77) && said.contains("without --preview it is rendered in bands"),
        "{said}"
    );
    let refused = render(&output.with_extension("png"), &limit);
    let said = stderr(&refused);
    assert!(
        refused.status.code() == Some(77) && said.contains("with EXR files as --output it is rendered"),
        "{said}"
    );
}
