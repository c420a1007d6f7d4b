//! Plans for the tests of the engines.

use super::job_plan::{JobPlan, Pin, Resources, Task};

/// A sequence of three frames in two tasks, with a name that needs quoting.
pub(super) fn plan() -> JobPlan {
    let task = |name: &str| Task {
        name: name.to_owned(),
        options: vec![format!("--frames={name}")],
        output_name: "a.####.exr".to_owned(),
    };
    let scene = "/shots/it's \"new\"\n.glb".to_owned();
    JobPlan {
        name: "it's \"new\"".to_owned(),
        folder: "/jobs/two words".to_owned(),
        program: "rayframe".to_owned(),
        version: "rayframe 0.1.0".to_owned(),
        assets: vec![scene.clone(), "/shots/sky.hdr".to_owned()],
        scene,
        shot_file: "resolution = \"64x36\"\n".to_owned(),
        asset_folders: Vec::new(),
        oidn: None,
        asset_cache: None,
        output_folder: "/out".to_owned(),
        output_name: "a.####.exr".to_owned(),
        pin: Pin { frame: 1, render_hash: "00ff".to_owned() },
        tasks: vec![task("1-2"), task("3")],
        parts: Vec::new(),
        replaces_output: false,
        resources: Resources { threads: 4, memory_bytes: 300 << 20, limit_bytes: 240 << 20 },
        retries: 3,
        at_most: Some(7),
        image: None,
        claims: vec![("projects".to_owned(), "/shots".to_owned())],
    }
}

/// A still in two tiles.
pub(super) fn still() -> JobPlan {
    let part = |index: u32| format!("parts/s.{index:04}.exr");
    let task = |index: u32, crop: &str| Task {
        name: format!("tile {crop}"),
        options: vec!["--frames=0".to_owned(), format!("--crop={crop}")],
        output_name: part(index),
    };
    JobPlan {
        name: "s".to_owned(),
        output_name: "s.exr".to_owned(),
        tasks: vec![task(0, "0,0,32,36"), task(1, "32,0,64,36")],
        parts: vec![part(0), part(1)],
        at_most: None,
        ..plan()
    }
}
