//! Lost content that no tested image shows.

use serde_json::{Value, json};

use super::Stage;
use super::coverage::{SUITE, accepted, scene};

#[test]
fn lost_morph_targets_fail_though_their_weights_are_zero() {
    let stage = Stage::new(&format!("{SUITE}frames = 0\nanimation = 'none'\nview = 'front'\n"));
    let robot = |targets: usize| {
        let mut robot = scene(0);
        let mesh = &mut robot["meshes"][0];
        mesh["name"] = json!(format!("mesh {targets}"));
        for primitive in mesh["primitives"].as_array_mut().unwrap() {
            let positions = primitive["attributes"]["POSITION"].clone();
            if targets > 0 {
                primitive["targets"] = json!(vec![json!({ "POSITION": positions }); targets]);
            }
        }
        robot.to_string()
    };
    stage.write("robot.gltf", &robot(3));
    assert_eq!(accepted(&stage), ["robot.exr"]);
    for (targets, lost) in [(2, "lost: 1 morph target of \"hat\"\n"), (0, "lost: 3 morph targets of \"hat\"")]
    {
        stage.write("robot.gltf", &robot(targets));
        stage.run(&["test"]).ends(1, &["FAIL robot", lost]);
    }
    stage.write("robot.gltf", &robot(4));
    stage.run(&["test"]).ends(0, &["changed robot", "new: 1 morph target of \"body\""]);
}

#[test]
fn frozen_clips_fail_though_the_tested_frame_is_the_same() {
    let stage = Stage::new(&format!("{SUITE}frames = 0\nanimation = 'none'\nview = 'front'\n"));
    let mut robot = scene(0);
    stage.write("robot.gltf", &robot.to_string());
    stage.write("was.gltf", &robot.to_string());
    assert_eq!(accepted(&stage), ["robot.exr", "was.exr"]);
    // One key, of the clip "run" alone
    robot["accessors"].as_array_mut().unwrap().extend([
        json!({"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 1, "type": "SCALAR", "min": [0], "max": [0]}),
        json!({"bufferView": 0, "byteOffset": 52, "componentType": 5126, "count": 1, "type": "VEC3"}),
    ]);
    robot["animations"][1]["samplers"][0] = json!({"input": 4, "output": 5});
    stage.write("robot.gltf", &robot.to_string());
    let ran = stage.run(&["test"]);
    ran.ends(1, &["FAIL robot", "lost: motion of clip \"run\"", "1 image identical"]);
    assert!(!ran.text.contains("clip \"walk\""), "{}", ran.text);
    let lost = "lost: the motion of the clip \"run\"";
    stage.run(&["diff", "robot.gltf", "was.gltf"]).ends(1, &[lost]);
    let allowed = stage.run(&["diff", "robot.gltf", "was.gltf", "--allow-lost", "clips"]);
    assert!(allowed.text.contains("nothing lost"), "{}", allowed.text);
    stage.run(&["diff", "was.gltf", "robot.gltf", "--allow-lost", "clips"]).ends(0, &[]);
}

#[test]
fn every_reference_guards_the_content_that_it_lists() {
    let shot = |frames: &str| format!("scene = 'robot.gltf'\nframes = {frames}\n");
    let stage = Stage::new(SUITE);
    let with_hat = scene(0);
    let mut without = with_hat.clone();
    without["nodes"][1].as_object_mut().unwrap().remove("name");
    stage.write("robot.gltf", &with_hat.to_string());
    stage.write("walk.toml", &shot("[0, 12]"));
    accepted(&stage);
    // All references are replaced, so that none is stale when the frames of the shot change.
    stage.write("robot.gltf", &without.to_string());
    let ran = stage.run(&["test"]);
    ran.ends(1, &["lost: node \"hat\"", "content differs as told with walk.0000", "2 failed"]);
    assert_eq!(ran.text.matches("lost: ").count(), 1, "{}", ran.text);
    stage.run(&["accept"]).ends(0, &["replaced references/walk.0012.exr"]);
    stage.write("walk.toml", &shot("[12, 24]"));
    stage.run(&["test"]).ends(1, &["walk.0024.exr", "no shot renders this reference", "1 image identical"]);
    stage.run(&["accept"]).ends(0, &[]);
    // A reference that is not the first one alone lists the hat.
    stage.write("robot.gltf", &with_hat.to_string());
    stage.run(&["test"]).ends(0, &["new: node \"hat\"", "2 changed within limits"]);
    stage.run(&["accept", "walk.0024.exr"]).ends(0, &["replaced"]);
    stage.write("robot.gltf", &without.to_string());
    stage.run(&["test"]).ends(1, &["FAIL walk.0024", "lost: node \"hat\"", "1 image identical"]);
}

#[test]
fn changes_that_no_pixel_shows_are_told_and_pass() {
    let stage = Stage::new(&format!("{SUITE}frames = 0\nanimation = 'none'\nview = 'front'\n"));
    let mut robot = scene(0);
    robot["nodes"][1]["scale"] = json!([0, 0, 0]);
    stage.write("robot.gltf", &robot.to_string());
    stage.write("was.gltf", &robot.to_string());
    accepted(&stage);
    robot["nodes"][1]["translation"] = json!([0, 0.5, 0]);
    stage.write("robot.gltf", &robot.to_string());
    let hidden = "geometry changed where this image does not show it";
    let ran = stage.run(&["test"]);
    ran.ends(
        0,
        &[&format!("changed robot (preset visual): {hidden}\n"), "1 image identical, 1 changed within"],
    );
    stage.run(&["test", "--fail-on", "changed"]).ends(1, &["FAIL robot", "likely geometry"]);
    let json: Value = serde_json::from_str(&stage.run(&["test", "--json"]).stdout).unwrap();
    let image = &json["shots"][0]["pictures"][0];
    assert_eq!([&image["verdict"], &image["identical"]], [&json!("changed"), &json!(true)]);
    assert_eq!(image["scene_changes"], json!([hidden]));
    stage.run(&["accept"]).ends(0, &["rayframe accept --changed"]);
    stage.run(&["accept", "--changed"]).ends(0, &["replaced references/robot.exr"]);
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    // Two versions of an asset are compared so, too.
    let diff = ["diff", "robot.gltf", "was.gltf"];
    stage.run(&diff).ends(0, &[hidden]);
    stage.run(&[&diff[..], &["--fail-on", "changed"]].concat()).ends(1, &[hidden]);
    // Where the pixels differ, the likely cause tells.
    robot["nodes"][0]["scale"] = json!([1, 0.5, 1]);
    stage.write("robot.gltf", &robot.to_string());
    let ran = stage.run(&["test"]);
    assert!(ran.code == Some(1) && !ran.text.contains(hidden), "{}", ran.text);
}

#[test]
fn motion_between_tested_frames_is_compared() {
    let stage = Stage::new(SUITE);
    let mut robot = scene(0);
    stage.write("robot.gltf", &robot.to_string());
    stage.write("walk.toml", "scene = 'robot.gltf'\nanimation = 'walk'\nframes = [0, 24]\n");
    accepted(&stage);
    robot["animations"][1]["samplers"][0]["interpolation"] = json!("STEP");
    stage.write("robot.gltf", &robot.to_string());
    // The shot does not show the other clip.
    stage.run(&["test"]).ends(0, &["2 images identical"]);
    robot["animations"][0]["samplers"][0]["interpolation"] = json!("STEP");
    stage.write("robot.gltf", &robot.to_string());
    let ran = stage.run(&["test"]);
    let told = "motion of clip \"walk\" changed";
    ran.ends(0, &[told, "content differs as told with walk.0000", "2 changed within limits"]);
    assert_eq!(ran.text.matches(told).count(), 1, "{}", ran.text);
    let copy = |name: &str| {
        std::fs::copy(stage.path("references/walk.0000.exr"), stage.path(name)).unwrap();
    };
    copy("old.exr");
    stage.run(&["accept", "--changed"]).ends(0, &["replaced references/walk.0024.exr"]);
    copy("new.exr");
    stage.run(&["diff", "new.exr", "old.exr"]).ends(0, &["changed", told]);
    stage.run(&["test"]).ends(0, &["2 images identical"]);
}

#[test]
fn images_that_lost_content_tell_other_motion_as_well() {
    let stage = Stage::new(SUITE);
    let mut robot = scene(0);
    stage.write("robot.gltf", &robot.to_string());
    stage.write("walk.toml", "scene = 'robot.gltf'\nanimation = 'walk'\nframes = [0, 24]\n");
    accepted(&stage);
    robot["nodes"][1].as_object_mut().unwrap().remove("name");
    robot["animations"][0]["samplers"][0]["interpolation"] = json!("STEP");
    stage.write("robot.gltf", &robot.to_string());
    let (lost, motion) = ("lost: node \"hat\"", "motion of clip \"walk\" changed");
    let ran = stage.run(&["test"]);
    ran.ends(1, &["FAIL walk.0000", lost, motion, "content differs as told with walk.0000", "2 failed"]);
    for line in [lost, motion] {
        assert_eq!(ran.text.matches(line).count(), 1, "{}", ran.text);
    }
}

#[test]
fn lost_lights_fail_though_they_add_nothing() {
    let stage = Stage::new(&format!("{SUITE}frames = 0\nanimation = 'none'\nview = 'front'\n"));
    let mut robot = scene(0);
    robot["extensionsUsed"] = json!(["KHR_materials_variants", "KHR_lights_punctual"]);
    robot["extensions"]["KHR_lights_punctual"] = json!({"lights": [
        {"name": "sun", "type": "directional"}, {"name": "lamp", "type": "point", "intensity": 0},
    ]});
    for light in 0..2 {
        let node = json!({"extensions": {"KHR_lights_punctual": {"light": light}}});
        robot["nodes"].as_array_mut().unwrap().push(node);
    }
    robot["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    stage.write("robot.gltf", &robot.to_string());
    assert_eq!(accepted(&stage), ["robot.exr"]);
    robot["scenes"][0]["nodes"] = json!([0, 1, 2]);
    stage.write("robot.gltf", &robot.to_string());
    stage.run(&["test"]).ends(1, &["FAIL robot", "lost: light \"lamp\""]);
}

#[test]
fn lights_without_a_name_are_not_lost_in_another_order() {
    let stage = Stage::new(&format!("{SUITE}frames = 0\nanimation = 'none'\nview = 'front'\n"));
    let robot = |lights: [Value; 2]| {
        let mut robot = scene(0);
        robot["extensionsUsed"] = json!(["KHR_materials_variants", "KHR_lights_punctual"]);
        robot["extensions"]["KHR_lights_punctual"] = json!({"lights": lights});
        let node = json!({"extensions": {"KHR_lights_punctual": {"light": 1}}});
        robot["nodes"].as_array_mut().unwrap().push(node);
        robot["scenes"][0]["nodes"] = json!([0, 1, 2]);
        robot.to_string()
    };
    let (sun, lamp) = (json!({"type": "directional"}), json!({"type": "point", "intensity": 0}));
    stage.write("robot.gltf", &robot([lamp.clone(), sun.clone()]));
    assert_eq!(accepted(&stage), ["robot.exr"]);
    // The sun is the first light of the file now.
    let reordered = robot([sun.clone(), lamp.clone()]).replace("\"light\":1", "\"light\":0");
    stage.write("robot.gltf", &reordered);
    stage.run(&["test"]).ends(0, &["1 image identical"]);
    let named = json!({"name": "sun", "type": "directional"});
    stage.write("robot.gltf", &robot([lamp, named]));
    stage.run(&["test"]).ends(0, &["changed robot", "new: light \"sun\"", "1 changed within limits"]);
}

#[test]
fn a_clip_of_another_duration_explains_missing_and_orphaned_frames() {
    let stage = Stage::new(SUITE);
    let mut robot = scene(0);
    stage.write("robot.gltf", &robot.to_string());
    accepted(&stage);
    // The clip "run" lasts as long as "walk".
    robot["animations"][1]["samplers"][0]["input"] = json!(1);
    stage.write("robot.gltf", &robot.to_string());
    std::fs::remove_file(stage.path("references/robot@walk.0012.exr")).unwrap();
    let ran = stage.run(&["test"]);
    let duration = "duration of clip \"run\": 0.500 s → 1.000 s";
    ran.ends(1, &["FAIL robot@run.0024", duration]);
    let json: Value = serde_json::from_str(&stage.run(&["test", "--json"]).stdout).unwrap();
    let images = json["shots"][0]["pictures"].as_array().unwrap();
    let found = |name: &str| images.iter().find(|image| image["name"] == name).unwrap();
    for (name, is_told) in [("robot@run.0024", true), ("robot@walk.0012", false)] {
        let image = found(name);
        assert_eq!(image["status"], "missing", "{image}");
        assert_eq!(image["messages"].as_array().unwrap().contains(&json!(duration)), is_told, "{image}");
    }
    // The reference of the old middle
    let orphaned = ran.text.split("FAIL robot@run.0006").nth(1).unwrap_or_default();
    assert!(orphaned.contains(duration), "{}", ran.text);
}
