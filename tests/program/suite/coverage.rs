//! What of a scene is tested without a shot file, the lists of `[test]`, and content that is lost.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use rayframe::image_file::encode_png;
use serde_json::{Value, json};

use super::{Ran, Stage};

/// A suite that leaves to the scenes what is seen.
pub(super) const SUITE: &str = "[shot]\nresolution = [48, 27]\nsamples = 1\n";

/// A triangle on each of two nodes, with two clips of one second and half a second, two variants, and some cameras.
pub(super) fn scene(cameras: usize) -> Value {
    let positions = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let (times, translations) = ([0.0, 1.0, 0.0, 0.5], [0.0, 0.0, 0.0, 0.0, 0.5, 0.0]);
    let floats = positions.into_iter().chain(times).chain(translations);
    let bytes: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    let clip = |name: &str, times: usize| {
        json!({
            "name": name,
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": times, "output": 3}],
        })
    };
    let mut nodes =
        vec![json!({"name": "body", "mesh": 0}), json!({"name": "hat", "mesh": 0, "translation": [0, 1, 0]})];
    nodes.extend((0..cameras).map(|index| json!({"camera": index, "translation": [0.5, 0.5, 3 + index]})));
    let mut scene = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": {"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}},
        "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0},
            "material": 0,
            "extensions": {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}},
        }]}],
        "materials": [
            {"doubleSided": true},
            {"doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.1, 0.4, 1]}},
        ],
        "animations": [clip("walk", 1), clip("run", 2)],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
            {"bufferView": 0, "byteOffset": 44, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.5]},
            {"bufferView": 0, "byteOffset": 52, "componentType": 5126, "count": 2, "type": "VEC3"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": bytes.len()}],
        "buffers": [{"uri": uri, "byteLength": bytes.len()}],
    });
    if cameras > 0 {
        let lens = |index| json!({"name": format!("lens {index}"), "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}});
        scene["cameras"] = (0..cameras).map(lens).collect();
    }
    scene
}

/// Accepts all images, and returns the names of the references.
pub(super) fn accepted(stage: &Stage) -> Vec<String> {
    stage.run(&["test"]).ends(1, &["there is no reference"]);
    stage.run(&["accept"]).ends(0, &[]);
    stage.run(&["test"]).ends(0, &[" identical, 0 changed within limits, 0 failed"]);
    stage.references()
}

fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort();
    names
}

#[test]
fn a_scene_without_a_shot_file_is_tested_whole() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    let of_clips = ["robot@day", "robot@night", "robot@run.0000", "robot@run.0006", "robot@run.0012"];
    let rest = ["robot@three-quarter-back", "robot@three-quarter"];
    let rest = rest.into_iter().chain(["robot@walk.0000", "robot@walk.0012", "robot@walk.0024"]);
    let whole: Vec<_> = of_clips.into_iter().chain(rest).map(|name| format!("{name}.exr")).collect();
    assert_eq!(accepted(&stage), whole);
    // Cameras of the file replace the automatic views.
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(2).to_string());
    let names = accepted(&stage);
    assert_eq!(names.len(), whole.len());
    assert_eq!(names[1..3], ["robot@lens 0.exr", "robot@lens 1.exr"]);
    // Names select a shot, a view or one frame.
    let listed = |name: &str| {
        let ran = stage.run(&["test", name, "--json"]);
        let json: Value = serde_json::from_str(&ran.stdout).unwrap_or_default();
        json["shots"][0]["pictures"].as_array().map_or(0, Vec::len)
    };
    assert_eq!([listed("robot"), listed("robot@walk.0012"), listed("robot@night")], [whole.len(); 3]);
    // A suite that chooses frames, or any other part of the scene, tests what it chooses.
    for chosen in ["frames = 0", "animation = 'walk'\nframes = [0, 12]", "variant = 'night'\nframes = 3"] {
        let stage = Stage::new(&format!("{SUITE}{chosen}\n"));
        stage.write("robot.gltf", &scene(0).to_string());
        let expected: &[&str] =
            if chosen.contains("12") { &["robot.0000.exr", "robot.0012.exr"] } else { &["robot.exr"] };
        assert_eq!(accepted(&stage), expected, "{chosen}");
    }
}

#[test]
fn lists_make_a_matrix() {
    let stage = Stage::new(&format!("{SUITE}[test]\nclips = 'each'\nframes = ['last']\n"));
    stage.write("robot.gltf", &scene(2).to_string());
    stage.write(
        "day.toml",
        "scene = 'robot.gltf'\n[test]\ncameras = ['lens 1']\nviews = ['left']\nclips = ['run']\nvariants = 'each'\nframes = [0, 5, 'middle']\n",
    );
    let mut expected = Vec::new();
    for from in ["left", "lens 1"] {
        for variant in ["day", "night"] {
            expected.extend(
                ["0000", "0005", "0006"].map(|frame| format!("day@{from}@run@{variant}.{frame}.exr")),
            );
        }
    }
    assert_eq!(accepted(&stage), expected);
    // Without a shot file, the suite's lists apply.
    std::fs::remove_file(stage.path("day.toml")).unwrap();
    std::fs::remove_dir_all(stage.path("references")).unwrap();
    assert_eq!(accepted(&stage), ["robot@run.exr", "robot@walk.exr"]);
    stage.write("day.toml", "scene = 'robot.gltf'\n[test]\nclips = ['jump']\n");
    let jump = "clips of [test]: there is no animation \"jump\"; choose one of: #0 \"walk\", #1 \"run\"";
    stage.run(&["test", "day"]).ends(1, &["FAIL day@jump", jump, "0 images identical"]);
    stage.write("day.toml", "scene = 'robot.gltf'\n[test]\nview = ['left']\n");
    stage.run(&["test", "day"]).ends(1, &["\"view\" is not a key of [test]; did you mean \"views\"?"]);
}

#[test]
fn images_of_two_views_may_not_share_a_name() {
    let stage = Stage::new(SUITE);
    let mut robot = scene(2);
    robot["cameras"][0]["name"] = json!("walk.0000");
    stage.write("robot.gltf", &robot.to_string());
    let shared = "would share the reference robot@walk.0000.exr; rename a camera, clip or variant";
    stage.run(&["test"]).ends(1, &["FAIL robot\n", "\"walk.0000\"", shared]);
    stage.run(&["test", "--list-images"]).ends(65, &["cannot be rendered", shared]);
    // Names that Blender gives to copies are no frame numbers: the lost camera is not the other one.
    for (camera, name) in ["first", "lens.001"].iter().enumerate() {
        robot["cameras"][camera]["name"] = json!(name);
    }
    stage.write("robot.gltf", &robot.to_string());
    let near = |cameras: &str| format!("scene = 'robot.gltf'\n[test]\ncameras = {cameras}\nframes = [0]\n");
    stage.write("near.toml", &near("['lens.001']"));
    assert_eq!(accepted(&stage), ["near@lens.001.exr"]);
    stage.write("near.toml", &near("['lens', 'lens.001']"));
    stage
        .run(&["test"])
        .ends(1, &["FAIL near@lens\n", "1 image identical, 0 changed within limits, 1 failed"]);
}

#[test]
fn lost_content_fails_with_its_name_where_no_pixel_shows_it() {
    let stage = Stage::new(&format!("{SUITE}frames = 0\nanimation = 'none'\nview = 'front'\n"));
    let mut robot = scene(0);
    // Behind the body, so that no pixel shows it.
    robot["nodes"][1]["scale"] = json!([0, 0, 0]);
    stage.write("robot.gltf", &robot.to_string());
    assert_eq!(accepted(&stage), ["robot.exr"]);
    let whole = robot.clone();
    robot["animations"].as_array_mut().unwrap().pop();
    robot["nodes"][1]["name"] = json!("cap");
    stage.write("robot.gltf", &robot.to_string());
    let lost = ["FAIL robot", "lost: node \"hat\"", "lost: clip \"run\""];
    stage.run(&["test"]).ends(1, &lost);
    let json: Value = serde_json::from_str(&stage.run(&["test", "--json"]).stdout).unwrap();
    let image = &json["shots"][0]["pictures"][0];
    assert_eq!(image["faults"][1], json!({"kind": "lost", "content": "clip", "name": "\"run\""}));
    assert_eq!(image["new_content"], json!(["new: node \"cap\""]));
    // Accepting it makes the new content the reference's.
    stage.run(&["accept"]).ends(0, &["replaced"]);
    stage.run(&["test"]).ends(0, &["1 image identical"]);
    // What is new is a change within the limits.
    stage.write("robot.gltf", &whole.to_string());
    stage.run(&["test"]).ends(1, &["lost: node \"cap\""]);
    robot["animations"] = whole["animations"].clone();
    stage.write("robot.gltf", &robot.to_string());
    stage.run(&["test"]).ends(0, &["changed robot", "new: clip \"run\""]);
    stage.run(&["accept", "--changed"]).ends(0, &["replaced"]);
    stage.run(&["test"]).ends(0, &["1 image identical"]);
}

#[test]
fn content_is_missed_after_the_first_view_went_and_where_nodes_are_detached() {
    let stage = Stage::new(SUITE);
    let mut robot = scene(2);
    robot["nodes"][1]["scale"] = json!([0, 0, 0]);
    stage.write("robot.gltf", &robot.to_string());
    accepted(&stage);
    // The first camera goes, so that another reference is the first.
    robot["scenes"][0]["nodes"] = json!([0, 1, 3]);
    stage.write("robot.gltf", &robot.to_string());
    stage.run(&["test"]).ends(1, &["lost: camera \"lens 0\""]);
    stage.run(&["accept"]).ends(0, &["removed references/robot@lens 0.exr"]);
    stage.run(&["test"]).ends(0, &["0 failed"]);
    robot["scenes"][0]["nodes"] = json!([0, 3]);
    stage.write("robot.gltf", &robot.to_string());
    stage.run(&["test"]).ends(1, &["lost: node \"hat\""]);
    // Shots with the name of an image of another are refused.
    stage.write("robot@walk.toml", "scene = 'robot.gltf'\n");
    stage.write("robot.toml", "scene = 'robot.gltf'\n");
    stage.run(&["test"]).ends(65, &["has the name of an image of"]);
}

#[test]
fn lost_content_is_told_with_the_first_image_that_has_a_reference() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    accepted(&stage);
    // The images of new cameras are the first.
    let mut robot = scene(4);
    robot["nodes"][1]["name"] = json!("cap");
    stage.write("robot.gltf", &robot.to_string());
    let lost = "lost: node \"hat\"";
    let told = |ran: &Ran| {
        ran.ends(1, &["14 failed", lost]);
        assert_eq!(ran.text.matches(lost).count(), 1, "{}", ran.text);
    };
    told(&stage.run(&["test"]));
    told(&stage.run(&["test", "--shard", "1/1", "--report", "r1"]));
    told(&stage.run(&["test", "--report", "merged", "--merge", "r1"]));
    stage.run(&["accept"]).ends(0, &["added references/robot@lens 0.exr"]);
    stage.run(&["test"]).ends(0, &["0 failed"]);
}

#[test]
fn a_lost_clip_is_told_once_and_its_images_are_orphaned() {
    let stage = Stage::new(SUITE);
    let mut robot = scene(0);
    stage.write("robot.gltf", &robot.to_string());
    accepted(&stage);
    robot["animations"].as_array_mut().unwrap().pop();
    stage.write("robot.gltf", &robot.to_string());
    let ran = stage.run_with(&["test"], "", Some("true"));
    // Every reference lists it.
    ran.ends(
        1,
        &["lost: clip \"run\"", "content differs as told with robot@", "FAIL robot@run.0006", "10 failed"],
    );
    assert_eq!(ran.text.matches("lost: clip").count(), 1, "{}", ran.text);
    // The images of a build server carry the names, too.
    stage
        .run(&["accept", "--from", "report"])
        .ends(0, &["replaced references/robot@three-quarter.exr", "removed"]);
    stage.run(&["test"]).ends(0, &["7 images identical"]);
}

#[test]
fn what_a_list_names_and_the_scene_lost_fails_alone() {
    let stage = Stage::new(&format!("{SUITE}[test]\nframes = ['first', 'last']\n"));
    let mut robot = scene(2);
    stage.write("robot.gltf", &robot.to_string());
    let lists = "scene = 'robot.gltf'\n[test]\ncameras = ['lens 0', 'lens 1']\nclips = ['walk', 'run']\nvariants = ['day']\n";
    stage.write("each.toml", lists);
    let whole = accepted(&stage);
    assert_eq!(whole.len(), 8, "{whole:?}");
    robot["animations"].as_array_mut().unwrap().pop();
    stage.write("robot.gltf", &robot.to_string());
    let ran = stage.run(&["test"]);
    ran.ends(
        1,
        &[
            "lost: clip \"run\"",
            // The references of the clip that is left list the lost one, which three of them only repeat.
            "FAIL each@lens 0@run@day.0000",
            "0 images identical, 0 changed within limits, 8 failed",
        ],
    );
    assert!(!ran.text.contains("no shot renders this reference"), "{}", ran.text);
    // Nothing of the lost clip can be accepted, and its references stay until the list does not name it.
    stage.run(&["accept"]).ends(0, &["replaced references/each@lens 0@walk@day.0000.exr"]);
    assert_eq!(stage.references(), whole);
    stage.run(&["test"]).ends(
        1,
        &[
            "FAIL each@lens 0@run@day.0000",
            "lost: what references/each@lens 0@run@day.0000.exr shows",
            "clips of [test]: there is no animation \"run\"",
            "4 images identical, 0 changed within limits, 4 failed",
        ],
    );
    stage.write("each.toml", &lists.replace(", 'run'", ""));
    stage.run(&["test"]).ends(1, &["FAIL each@lens 1@run@day.0012", "no shot renders this reference"]);
    stage.run(&["accept"]).ends(0, &["removed references/each@lens 0@run@day.0000.exr"]);
    stage.run(&["test"]).ends(0, &["4 images identical"]);
    // A variant, and a camera that stands in no scene.
    robot["extensions"]["KHR_materials_variants"]["variants"][0]["name"] = json!("dawn");
    stage.write("robot.gltf", &robot.to_string());
    let day = "variants of [test]: there is no variant \"day\"";
    stage.run(&["test"]).ends(1, &[day, "FAIL each@lens 0@walk@day.0000", "4 failed"]);
    robot["scenes"][0]["nodes"] = json!([0, 1, 2]);
    stage.write("robot.gltf", &robot.to_string());
    stage.write("each.toml", "scene = 'robot.gltf'\n[test]\ncameras = ['lens 1']\nframes = ['first']\n");
    let detached = "cameras of [test]: #1 \"lens 1\" has no node in the selected scene";
    stage.run(&["test", "each"]).ends(1, &["FAIL each@lens 1", detached]);
}

#[test]
fn a_scene_that_a_shot_file_names_keeps_its_coverage_where_asked() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    let whole = accepted(&stage);
    stage.write("near.toml", "scene = 'robot.gltf'\nframes = 0\nview = 'front'\n");
    let why = "no shot renders this reference, because near.toml names the scene robot.gltf; `whole_scene = true` in [test] of near.toml tests both";
    let ran = stage.run(&["test"]);
    ran.ends(1, &["FAIL robot@walk.0012", "FAIL robot@night", why]);
    assert_eq!(ran.text.matches(why).count(), whole.len(), "{}", ran.text);
    stage
        .write("near.toml", "scene = 'robot.gltf'\nframes = 0\nview = 'front'\n[test]\nwhole_scene = true\n");
    stage.run(&["test"]).ends(1, &[&format!("{} images identical", whole.len()), "1 failed", "FAIL near"]);
    // In the suite it holds for all shot files, and a shot file may differ.
    let ran = stage.run(&["test", "--list"]);
    assert_eq!(ran.stdout, "near\nrobot\n");
    stage.write("near.toml", "scene = 'robot.gltf'\nframes = 0\nview = 'front'\n");
    stage.write("suite.toml", &format!("{SUITE}[test]\nwhole_scene = true\n"));
    assert_eq!(stage.run(&["test", "--list"]).stdout, "near\nrobot\n");
    stage.write("near.toml", "scene = 'robot.gltf'\nframes = 0\n[test]\nwhole_scene = false\n");
    assert_eq!(stage.run(&["test", "--list"]).stdout, "near\n");
}

#[test]
fn images_are_listed_without_rendering() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    stage.write("near.toml", "scene = 'robot.gltf'\nframes = [0, 7]\n[test]\nwhole_scene = true\n");
    let ran = stage.run(&["test", "--list-images"]);
    assert!(ran.stdout.starts_with("near\n  near.0000\n  near.0007\nrobot\n  robot@"), "{}", ran.text);
    let listed: Vec<_> = ran.stdout.lines().filter_map(|line| line.strip_prefix("  ")).collect();
    assert_eq!(listed.len(), 12);
    let listed: Vec<_> = listed.iter().map(|name| format!("{name}.exr")).collect();
    assert_eq!(accepted(&stage), sorted(listed));
    assert_eq!(stage.run(&["test", "--list-images", "near"]).stdout, "near\n  near.0000\n  near.0007\n");
    // A shot that cannot be opened does not hide the others.
    stage.write("broken.toml", "scene = 'gone.gltf'\n");
    let ran = stage.run(&["test", "--list-images"]);
    ran.ends(66, &["broken\n  cannot be rendered\nnear\n", "gone.gltf"]);
    stage.run(&["test", "--list", "--list-images"]).ends(2, &[]);
}

#[test]
fn frames_after_the_end_of_all_clips_are_a_warning() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    // Clips end with frames 24 and 12.
    stage.write("each.toml", "scene = 'robot.gltf'\n[test]\nclips = 'each'\nframes = [0, 20, 30, 40]\n");
    let ran = stage.run(&["test"]);
    let warning = "warning: each: frames of [test]: 30, 40: beyond the end of every clip, whose last frame is 24; its pose is repeated";
    ran.ends(1, &[warning]);
    assert_eq!(ran.text.matches("beyond the end").count(), 1);
    // Neither without such a frame, nor where the camera moves on.
    for quiet in ["clips = 'each'\nframes = [0, 20, 24]", "frames = ['last']"] {
        stage.write("each.toml", &format!("scene = 'robot.gltf'\n[test]\n{quiet}\n"));
        assert!(!stage.run(&["test"]).text.contains("beyond the end"));
    }
    stage.write("each.toml", "scene = 'robot.gltf'\nturntable = 48\n[test]\nframes = [0, 40]\n");
    assert!(!stage.run(&["test"]).text.contains("beyond the end"));
}

#[test]
fn only_the_frames_that_are_tested_need_plates() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    for (frame, level) in [(1, 60), (2, 200)] {
        let png = encode_png((2, 1), &[[level, level, level, 255]; 2], "").unwrap_or_default();
        std::fs::write(stage.path(&format!("plate.{frame:04}.png")), png).unwrap_or_default();
    }
    let shot = "scene = 'robot.gltf'\nbackground = 'plate.####.png'\n[test]\nframes = ";
    stage.write("shot.toml", &format!("{shot}[1, 2]\n"));
    assert_eq!(stage.run(&["test", "--list-images"]).stdout, "shot\n  shot.0001\n  shot.0002\n");
    assert_eq!(accepted(&stage), ["shot.0001.exr", "shot.0002.exr"]);
    stage.write("shot.toml", &format!("{shot}[1, 'last']\n"));
    stage.run(&["test"]).ends(1, &["plate.0024.png", "as the plate of frame 24"]);
}

#[test]
fn the_frames_of_a_turntable_are_those_of_its_turn() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    // The clip ends with frame 24.
    for (turntable, animation, frames) in
        [(5, "none", ["0000", "0002", "0004"]), (50, "walk", ["0000", "0024", "0049"])]
    {
        let shot = format!("scene = 'robot.gltf'\nanimation = '{animation}'\nturntable = {turntable}\n");
        stage.write("turn.toml", &format!("{shot}[test]\nframes = ['first', 'middle', 'last']\n"));
        let listed = stage.run(&["test", "--list-images"]).stdout;
        let images: Vec<_> = listed.lines().skip(1).collect();
        assert_eq!(images, frames.map(|frame| format!("  turn.{frame}")));
    }
}
