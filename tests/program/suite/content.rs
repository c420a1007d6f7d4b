//! Lost content that no tested image shows.

use serde_json::json;

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
