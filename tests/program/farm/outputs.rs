//! Outputs of jobs that others write or read, and older frames in their places.

use std::path::Path;

use super::{SCENE, farm, text};
use crate::{both, names, rayframe, stderr};

const OTHER_SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/camera/aspect_wide.gltf");

/// Job files of both scenes, whose frames are called `output`.
fn of_both(folder: &Path, output: &str) -> (Option<i32>, String) {
    let (job, out) = (folder.join("job"), folder.join(output));
    let given = ["farm", "parallel", SCENE, OTHER_SCENE, "-r", "16x9", "-f", "0"];
    let wrote = rayframe(&both(&given, &["-o", text(&out), "--out-dir", text(&job)]));
    (wrote.status.code(), stderr(&wrote))
}

#[test]
fn jobs_that_would_replace_frames_of_each_other_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (code, message) = of_both(folder.path(), "out/a.####.exr");
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains("would both be written to") && message.contains("{scene}"), "{message}");
    assert!(!folder.path().join("job").exists());
    assert_eq!(of_both(folder.path(), "out/{scene}.####.exr").0, Some(0));
    assert_eq!(names(&folder.path().join("job")), ["aspect_wide", "whitted_1980"]);
}

#[cfg(unix)]
#[test]
fn frames_are_written_into_their_folder_whatever_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().canonicalize().unwrap();
    for name in ["x", "x/x", "file", "out"] {
        let (job, out) = (folder.path().join("job").join(name), folder.path().join(name));
        let frames = out.join("a.####.exr");
        let given = ["farm", "parallel", SCENE, "-r", "16x9", "-f", "0", "-o", text(&frames)];
        let wrote = rayframe(&both(&given, &["--out-dir", text(&job)]));
        assert_eq!(wrote.status.code(), Some(0), "{name}: {}", stderr(&wrote));
        let script = std::fs::read_to_string(job.join("task.sh")).unwrap();
        let line = format!("output=${{RAYFRAME_OUTPUT_FOLDER:-'{}'}}", text(&whole.join(name)));
        assert!(script.lines().any(|written| written == line), "{line}\n{script}");
    }
}

#[test]
fn outputs_that_are_plates_or_files_of_others_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    let plate = out.join("p.0000.exr");
    let scene = ["render", SCENE, "-r", "16x9", "--samples", "1", "-f", "0"];
    assert_eq!(rayframe(&both(&scene, &["-o", text(&plate)])).status.code(), Some(0));
    std::fs::write(out.join("a.0001.exr"), "of somebody else\n").unwrap();
    let refused = farm(folder.path(), "parallel", &["-f", "0-1"]);
    assert_eq!(refused.status.code(), Some(73), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("a.0001.exr"), "{}", stderr(&refused));
    let plates = out.join("p.####.exr");
    let job = folder.path().join("job");
    let given = ["farm", "parallel", SCENE, "-r", "16x9", "-f", "0", "--background", text(&plates)];
    let refused = rayframe(&both(&given, &["-o", text(&plates), "--out-dir", text(&job)]));
    assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("is an input"), "{}", stderr(&refused));
    assert!(!job.exists());
}

#[test]
fn help_lists_no_option_that_is_refused() {
    let help = String::from_utf8(rayframe(&["farm", "--help"]).stdout).unwrap();
    assert!(help.contains("--sample-ranges"), "{help}");
    let folder = tempfile::tempdir().unwrap();
    for option in [
        &["--movie", "a.mp4"][..],
        &["--contact-sheet", "a.png"],
        &["--stats", "a.json"],
        &["--manifest", "a.json"],
        &["--show"],
        &["--dry-run"],
        &["--resume"],
        &["--progress", "json"],
    ] {
        let lists =
            |line: &str| line.trim_start().split(", ").take(2).any(|name| name.starts_with(option[0]));
        assert!(!help.lines().any(lists), "{}", option[0]);
        let refused = farm(folder.path(), "parallel", option);
        assert_eq!(refused.status.code(), Some(2), "{}: {}", option[0], stderr(&refused));
    }
}

#[test]
fn shot_files_that_show_frames_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (shot, job) = (folder.path().join("shot.toml"), folder.path().join("job"));
    for (show, code) in [("true", 65), ("false", 0)] {
        let settings = format!("scene = '{SCENE}'\nresolution = \"16x9\"\nframes = \"0\"\nshow = {show}\n");
        std::fs::write(&shot, settings).unwrap();
        let wrote = rayframe(&["farm", "parallel", text(&shot), "--out-dir", text(&job)]);
        assert_eq!(wrote.status.code(), Some(code), "{show}: {}", stderr(&wrote));
        assert_eq!(stderr(&wrote).contains("tasks have no terminal; leave it out"), code != 0);
        assert_eq!(job.exists(), code == 0);
    }
}

#[cfg(unix)]
#[test]
fn merged_parts_replace_an_older_frame() {
    let folder = tempfile::tempdir().unwrap();
    let (job, frame) = (folder.path().join("job"), folder.path().join("out/a.0000.exr"));
    let image_of = |samples: &str| {
        let options = ["-f", "0", "--tiles", "2x1", "--samples", samples];
        let wrote = farm(folder.path(), "parallel", &options);
        assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
        for task in ["0", "1", "merge"] {
            let done = std::process::Command::new("sh").arg(job.join("task.sh")).arg(task).output().unwrap();
            assert_eq!(done.status.code(), Some(0), "{task}: {}", stderr(&done));
        }
        std::fs::read(&frame).unwrap()
    };
    let (one, four) = (image_of("1"), image_of("4"));
    assert!(one != four);
    assert!(image_of("1") == one);
}
