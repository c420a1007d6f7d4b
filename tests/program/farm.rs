//! `rayframe farm`: the job files, what they may replace, and what is refused.

#[cfg(unix)]
mod denoising;
mod memory;
mod outputs;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::progress::schema::Schema;
use crate::{both, names, rayframe, stderr};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Writes the job files of an engine into `job` of a folder, with the frames in `out`.
fn farm(folder: &Path, engine: &str, more: &[&str]) -> Output {
    let (job, out) = (folder.join("job"), folder.join("out/a.####.exr"));
    let given = ["farm", engine, SCENE, "-r", "16x9", "-o", text(&out), "--out-dir", text(&job)];
    rayframe(&both(&given, more))
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn each_engine_has_its_files() {
    let common = ["assets.list", "job.json"];
    for (engine, own) in [
        (
            "openjd",
            vec!["asset_references.json", "parameter_values.json", "parameters.json", "template.json"],
        ),
        ("slurm", vec!["array.sbatch", "shot.toml", "submit.sh", "task.sh", "tasks.txt"]),
        ("k8s", vec!["job.k8s.json", "submit.sh", "tasks.txt"]),
        ("parallel", vec!["run.sh", "shot.toml", "task.sh", "tasks", "tasks.txt"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let wrote = farm(folder.path(), engine, &["-f", "0-9"]);
        assert_eq!(wrote.status.code(), Some(0), "{engine}: {}", stderr(&wrote));
        let mut expected = both(&common, &own);
        expected.sort_unstable();
        assert_eq!(names(&folder.path().join("job")), expected, "{engine}");
        assert_eq!(names(&folder.path().join("out")), [] as [&str; 0], "nothing is rendered");
        // The assets are those of the scene.
        let assets = std::fs::read_to_string(folder.path().join("job/assets.list")).unwrap();
        assert!(assets.ends_with("whitted_1980.gltf\0"), "{assets}");
    }
}

#[test]
fn job_lists_match_the_schema() {
    let schema = Schema::read("job");
    for engine in ["openjd", "slurm", "k8s", "parallel"] {
        for more in [&["-f", "0-9"][..], &["-f", "3", "--tiles", "2x1"]] {
            let folder = tempfile::tempdir().unwrap();
            let wrote = farm(folder.path(), engine, more);
            assert_eq!(wrote.status.code(), Some(0), "{engine}: {}", stderr(&wrote));
            let job = json(&folder.path().join("job/job.json"));
            schema.check(&job);
            assert_eq!(job["engine"], engine);
            let listed: Vec<&String> = job["job_files"].as_object().unwrap().keys().collect();
            let mut written = names(&folder.path().join("job"));
            written.retain(|name| name != "job.json");
            assert_eq!(listed, written.iter().collect::<Vec<_>>());
        }
    }
    let folder = tempfile::tempdir().unwrap();
    farm(folder.path(), "slurm", &["-f", "0"]);
    let mut job = json(&folder.path().join("job/job.json"));
    job["job_files"]["task.sh"] = Value::from(vec!["no hash"]);
    assert!(!schema.accepts(&job));
}

#[test]
fn chunks_cover_every_frame_once() {
    for more in [&["--chunk", "7"][..], &["--chunk", "1"], &["--interleaved", "--chunk", "4"], &[]] {
        let folder = tempfile::tempdir().unwrap();
        let wrote = farm(folder.path(), "parallel", &both(&["-f", "-3-20,40"], more));
        assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
        let job = json(&folder.path().join("job/job.json"));
        let mut counts = BTreeMap::new();
        for task in job["tasks"].as_array().unwrap() {
            let plan =
                rayframe(&["render", SCENE, "-n", "--progress", "json", "-q", "-f", task.as_str().unwrap()]);
            let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
            for frame in plan["frames"].as_array().unwrap() {
                *counts.entry(frame["frame"].as_i64().unwrap()).or_insert(0) += 1;
            }
        }
        let expected: BTreeMap<i64, i32> = (-3..=20).chain([40]).map(|frame| (frame, 1)).collect();
        assert_eq!(counts, expected, "{more:?}");
    }
}

#[test]
fn files_of_all_frames_are_refused() {
    for (lines, options) in [
        ("", &["-o", "all.gif"][..]),
        ("", &["-o", "all.png", "-f", "0", "--movie", "all.gif"]),
        ("", &["--stats", "all.json"]),
        ("output = 'all.webp'", &[]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (shot, job) = (folder.path().join("a.toml"), folder.path().join("job"));
        std::fs::write(&shot, format!("scene = '{SCENE}'\nresolution = [16, 9]\n{lines}")).unwrap();
        let refused = rayframe(&both(&["farm", "parallel", text(&shot), "--out-dir", text(&job)], options));
        let code = if lines.is_empty() { 2 } else { 65 };
        assert_eq!(refused.status.code(), Some(code), "{lines}{options:?}: {}", stderr(&refused));
        assert!(stderr(&refused).contains("cannot write together"), "{}", stderr(&refused));
        assert!(!job.exists());
    }
}

#[test]
fn costly_frames_have_tasks_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let stats = folder.path().join("stats.json");
    // 10 s a frame at a quarter of the pixels and on half of the threads makes 20 s; the last frame takes 2000 s.
    let frame =
        |frame: i64, seconds: f64| format!(r#"{{"frame": {frame}, "seconds": {{"total": {seconds}}}}}"#);
    let frames = [frame(0, 10.0), frame(8, 10.0), frame(9, 1000.0)].join(", ");
    let content = format!(r#"{{"resolution": [8, 9], "samples": 2, "threads": 2, "frames": [{frames}]}}"#);
    std::fs::write(&stats, content).unwrap();
    let wrote =
        farm(folder.path(), "slurm", &["-f", "0-9", "--samples", "4", "-t", "4", "--cost", text(&stats)]);
    assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
    let tasks = json(&folder.path().join("job/job.json"))["tasks"].clone();
    let tasks: Vec<_> = tasks.as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(tasks.last(), Some(&"9"), "{tasks:?}");
    std::fs::write(&stats, "{}").unwrap();
    let refused = farm(folder.path(), "slurm", &["-f", "0-9", "--cost", text(&stats)]);
    assert_eq!(refused.status.code(), Some(65), "{}", stderr(&refused));
}

#[test]
fn files_of_others_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join("job").join(name);
    assert_eq!(farm(folder.path(), "parallel", &["-f", "0-9"]).status.code(), Some(0));
    // Its own files are replaced.
    assert_eq!(farm(folder.path(), "parallel", &["-f", "0-5"]).status.code(), Some(0));
    assert_eq!(
        farm(folder.path(), "slurm", &["-f", "0-5"]).status.code(),
        Some(0),
        "two engines share a folder"
    );
    // What was changed since, and what others made, is not.
    for (name, engine) in [("run.sh", "parallel"), ("template.json", "openjd"), ("job.json", "slurm")] {
        std::fs::write(at(name), "of somebody else\n").unwrap();
        let before = names(&folder.path().join("job"));
        let refused = farm(folder.path(), engine, &["-f", "0-3"]);
        assert_eq!(refused.status.code(), Some(73), "{name}: {}", stderr(&refused));
        assert!(stderr(&refused).contains(name), "{}", stderr(&refused));
        assert_eq!(std::fs::read(at(name)).unwrap(), b"of somebody else\n");
        assert_eq!(names(&folder.path().join("job")), before);
        assert_eq!(farm(folder.path(), engine, &["-f", "0-3", "--overwrite"]).status.code(), Some(0));
    }
}

#[test]
fn what_cannot_be_divided_is_refused() {
    for (options, why) in [
        (&["--tiles", "2x2", "-f", "0-3"][..], "divides a still"),
        (&["--tiles", "2x2", "-f", "3", "--exr", "half,dwaa"], "lossless"),
        (&["--tiles", "2x2", "-f", "3", "--preview", "png"], "previews"),
        (&["--tiles", "2x2", "-f", "3", "--crop", "0,0,8,8"], "--tiles"),
        (
            &["--tiles", "2x2", "-f", "3", "--integrator", "path", "--time-limit", "9s"],
            "another number of samples",
        ),
        (&["--tiles", "0x2", "-f", "3"], "4x2"),
        (&["--sample-ranges", "4", "-f", "3"], "--integrator path"),
        (&["-f", "0-3", "--stats", "s.json"], "one file of all frames"),
        (&["-f", "0-3", "--camera", "each"], "name one camera"),
        (&["-f", "0-3", "--variant", "each"], "name one variant"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let refused = farm(folder.path(), "slurm", options);
        assert_eq!(refused.status.code(), Some(2), "{options:?}: {}", stderr(&refused));
        assert!(stderr(&refused).contains(why), "{options:?}: {}", stderr(&refused));
        assert_eq!(names(&folder.path().join("job")), [] as [&str; 0]);
    }
}

#[test]
fn tasks_start_a_program_wherever_they_run() {
    let program = |engine: &str, more: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        let wrote = farm(folder.path(), engine, &both(&["-f", "0"], more));
        assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
        let script = std::fs::read_to_string(folder.path().join("job/task.sh")).unwrap();
        let line = script.lines().find(|line| line.starts_with("rayframe=")).unwrap();
        line.to_owned()
    };
    assert_eq!(program("slurm", &[]), "rayframe=${RAYFRAME:-'rayframe'}");
    assert_eq!(program("slurm", &["--program", "rayframe-2"]), "rayframe=${RAYFRAME:-'rayframe-2'}");
    // GNU parallel starts on this machine, and tasks run in the folder of the job.
    let this = std::fs::canonicalize(env!("CARGO_BIN_EXE_rayframe")).unwrap();
    assert!(program("parallel", &[]).contains(text(&this)));
    let here = std::env::current_dir().unwrap().canonicalize().unwrap();
    assert!(program("slurm", &["--program", "./Cargo.toml"]).contains(text(&here.join("Cargo.toml"))));
}

#[test]
fn options_of_another_engine_are_refused() {
    for engine in ["openjd", "slurm", "parallel"] {
        for (option, value) in [("--image", "rayframe:1"), ("--claim", "shots=/shots")] {
            let folder = tempfile::tempdir().unwrap();
            let refused = farm(folder.path(), engine, &["-f", "0-3", option, value]);
            assert_eq!(refused.status.code(), Some(2), "{engine}: {}", stderr(&refused));
            let why = format!("{option} applies to k8s only; leave it out for {engine}");
            assert!(stderr(&refused).contains(&why), "{}", stderr(&refused));
            assert_eq!(names(&folder.path().join("job")), [] as [&str; 0]);
        }
    }
}

#[test]
fn options_without_a_meaning_are_refused() {
    for options in [&["--resume"][..], &["--dry-run"], &["-n"], &["--progress", "json"]] {
        let folder = tempfile::tempdir().unwrap();
        let refused = farm(folder.path(), "slurm", &both(&["-f", "0-3"], options));
        assert_eq!(refused.status.code(), Some(2), "{options:?}: {}", stderr(&refused));
        let option = if options[0] == "-n" { "--dry-run" } else { options[0] };
        assert!(
            stderr(&refused).contains(&format!("{option} has no meaning here: ")),
            "{}",
            stderr(&refused)
        );
        assert_eq!(names(&folder.path().join("job")), [] as [&str; 0]);
    }
}

#[test]
fn several_shots_have_a_folder_each() {
    let folder = tempfile::tempdir().unwrap();
    let shots = ["one", "two"].map(|name| folder.path().join(name).join("shot.toml"));
    for shot in &shots {
        std::fs::create_dir(shot.parent().unwrap()).unwrap();
        std::fs::write(shot, format!("scene = '{SCENE}'\noutput = 'a.####.exr'\nframes = '0-3'\n")).unwrap();
    }
    let [one, two] = shots.each_ref().map(|shot| text(shot));
    let wrote = rayframe(&["farm", "k8s", one, two, "--out-dir", text(&folder.path().join("job"))]);
    assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
    assert_eq!(names(&folder.path().join("job")), ["shot", "shot-2"]);
}

#[cfg(unix)]
mod run {
    use std::os::unix::ffi::OsStrExt as _;
    use std::process::Command;

    use super::*;

    const DIFFICULT: &str = "it's \"a\" $HOME\n`b` 100%#é";

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn task(job: &Path, task: &str) -> Output {
        Command::new("sh").arg(job.join("task.sh")).arg(task).output().unwrap()
    }

    #[test]
    fn scripts_render_frames_of_difficult_names() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join(DIFFICULT);
        std::fs::create_dir(&folder).unwrap();
        let scene = folder.join("s.gltf");
        std::fs::copy(SCENE, &scene).unwrap();
        let shot = folder.join("s.toml");
        std::fs::write(&shot, "scene = \"s.gltf\"\nresolution = \"16x9\"\nsamples = 1\n").unwrap();
        let (job, plain) = (folder.join("job"), root.path().join("plain.####.exr"));
        let wrote = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .args([
                "farm",
                "slurm",
                "s.toml",
                "-o",
                "out/a.####.exr",
                "-f",
                "0-3",
                "--chunk",
                "2",
                "--out-dir",
                "job",
            ])
            .args(["--program", env!("CARGO_BIN_EXE_rayframe"), "-t", "1"])
            .current_dir(&folder)
            .output()
            .unwrap();
        assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
        for index in ["0", "1"] {
            let ran = task(&job, index);
            assert_eq!(ran.status.code(), Some(0), "{}", stderr(&ran));
        }
        assert_eq!(
            rayframe(&[
                "render",
                SCENE,
                "-r",
                "16x9",
                "--samples",
                "1",
                "-f",
                "0-3",
                "-q",
                "-o",
                text(&plain)
            ])
            .status
            .code(),
            Some(0)
        );
        for frame in 0..4 {
            let plain = std::fs::read(root.path().join(format!("plain.{frame:04}.exr"))).unwrap();
            assert_eq!(std::fs::read(folder.join(format!("out/a.{frame:04}.exr"))).unwrap(), plain);
        }
        // A scene that changed since is refused before the first frame.
        std::fs::write(&scene, std::fs::read_to_string(SCENE).unwrap() + " ").unwrap();
        let ran = task(&job, "0");
        assert_eq!(ran.status.code(), Some(65), "{}", stderr(&ran));
        assert!(stderr(&ran).contains("has changed since"), "{}", stderr(&ran));
        assert_eq!(task(&job, "9").status.code(), Some(2));
    }

    #[test]
    fn tasks_find_images_paths_and_the_cache_where_a_worker_has_them() {
        let root = tempfile::tempdir().unwrap();
        let here = |name: &str| root.path().join(name);
        std::fs::create_dir_all(here("assets")).unwrap();
        let sky = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/environment/quarters.hdr");
        std::fs::copy(sky, here("assets/it's 50% sky.hdr")).unwrap();
        let keys = "[[key]]\ntime = 0.0\nposition = [0, 1, 6]\nlook_at = [0, 0, 0]\n[[key]]\ntime = 1.0\nposition = [1, 1, 6]\nlook_at = [0, 0, 0]\n";
        std::fs::write(here("assets/walk.toml"), keys).unwrap();
        let plate = here("assets/plate.0000.png");
        let made =
            rayframe(&["render", SCENE, "-f", "0", "-r", "16x9", "--samples", "1", "-q", "-o", text(&plate)]);
        assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
        let (env, walk) = (here("assets/it's 50% sky.hdr@90"), here("assets/walk.toml"));
        let (plates, cache) = (here("assets/plate.####.png"), here("cache"));
        let options = ["-f", "0", "--program", env!("CARGO_BIN_EXE_rayframe"), "--asset-cache", text(&cache)];
        let named = ["--env", text(&env), "--camera-path", text(&walk), "--background", text(&plates)];
        let wrote = farm(root.path(), "slurm", &both(&options, &named));
        assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
        let shot = std::fs::read_to_string(here("job/shot.toml")).unwrap();
        assert!(!shot.contains("assets") && !shot.contains("cache"), "{shot}");
        assert!(shot.contains("write_behind = \"off\""), "{shot}");

        // The worker has the assets elsewhere.
        let elsewhere = here("else # where");
        std::fs::rename(here("assets"), &elsewhere).unwrap();
        let lost = task(&here("job"), "0");
        assert_eq!(lost.status.code(), Some(66), "{}", stderr(&lost));
        let mut mapped = Command::new("sh");
        mapped.arg(here("job/task.sh")).arg("0").env("RAYFRAME_ASSET_CACHE", here("cache of the worker"));
        for variable in ["RAYFRAME_ENV_FOLDER", "RAYFRAME_CAMERA_PATH_FOLDER", "RAYFRAME_BACKGROUND_FOLDER"] {
            mapped.env(variable, &elsewhere);
        }
        let ran = mapped.output().unwrap();
        assert_eq!(ran.status.code(), Some(0), "{}", stderr(&ran));
        assert_eq!(names(&here("out")), ["a.0000.exr"]);
        // Templates have a parameter for each.
        std::fs::rename(&elsewhere, here("assets")).unwrap();
        let wrote = farm(root.path(), "openjd", &both(&options, &named));
        assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
        let template = json(&here("job/template.json"));
        let parameters = template["parameterDefinitions"].as_array().unwrap();
        let parameters: Vec<_> = parameters.iter().filter_map(|one| one["name"].as_str()).collect();
        let own = ["EnvFolder", "BackgroundFolder", "CameraPathFolder", "AssetCache"];
        assert_eq!(parameters, both(&["Scene", "OutputFolder", "Rayframe"], &own));
        let variables = &template["jobEnvironments"][0]["variables"];
        assert_eq!(variables["RAYFRAME_ENV_FOLDER"], "{{Param.EnvFolder}}");
        assert_eq!(json(&here("job/parameters.json"))["EnvFolder"], text(&here("assets")));
    }

    #[test]
    fn names_that_are_not_unicode_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let out = root.path().join(std::ffi::OsStr::from_bytes(b"a\xff.exr"));
        let refused = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .args(["farm", "slurm", SCENE, "-f", "0", "--out-dir"])
            .arg(root.path().join("job"))
            .arg("-o")
            .arg(out)
            .output()
            .unwrap();
        assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
        assert!(stderr(&refused).contains("is not Unicode"), "{}", stderr(&refused));
    }
}
