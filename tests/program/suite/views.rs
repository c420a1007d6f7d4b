//! Which of the settings of a shot count for the views that `[test]` lists, and for those of a scene without a shot file.

use rayframe::image_file::encode_png;

use super::Stage;
use super::coverage::{SUITE, accepted, scene};

#[test]
fn cameras_that_are_listed_are_shown_whatever_view_the_settings_hold() {
    let suite = |lines: &str| format!("{SUITE}frames = 0\n{lines}\n[test]\ncameras = 'each'\n");
    let stage = Stage::new(&suite(""));
    stage.write("robot.gltf", &scene(2).to_string());
    assert_eq!(accepted(&stage), ["robot@lens 0.exr", "robot@lens 1.exr"]);
    for view in [
        "camera = 'lens 1'",
        "orbit = '80,10'",
        "view = 'left'",
        "camera_position = [1, 1, 9]",
        "look_at = [9, 0, 0]",
        "frame_node = 'hat'",
    ] {
        stage.write("suite.toml", &suite(view));
        stage.run(&["test"]).ends(0, &["2 images identical"]);
        // In a shot file they are its own.
        stage.write("suite.toml", &suite(""));
        let shot = format!("scene = 'robot.gltf'\n{view}\n");
        std::fs::rename(stage.path("robot.gltf"), stage.path("base.gltf")).unwrap();
        stage.write("robot.toml", &shot.replace("robot.gltf", "base.gltf"));
        stage.run(&["test"]).ends(0, &["2 images identical"]);
        std::fs::remove_file(stage.path("robot.toml")).unwrap();
        std::fs::rename(stage.path("base.gltf"), stage.path("robot.gltf")).unwrap();
    }
    // Lenses are no views.
    stage.write("suite.toml", &suite("fov = 20"));
    stage.run(&["test"]).ends(1, &["2 failed"]);
}

#[test]
fn views_that_are_listed_are_those_of_the_automatic_camera() {
    let suite = |lines: &str| format!("{SUITE}frames = 0\n{lines}\n[test]\nviews = ['back', 'front']\n");
    let stage = Stage::new(&suite(""));
    stage.write("robot.gltf", &scene(2).to_string());
    assert_eq!(accepted(&stage), ["robot@back.exr", "robot@front.exr"]);
    for camera in ["camera = 'lens 1'", "orbit = '80,10'", "camera_position = [1, 1, 9]"] {
        stage.write("suite.toml", &suite(camera));
        stage.run(&["test"]).ends(0, &["2 images identical"]);
    }
    stage.write("suite.toml", &suite("frame_node = 'hat'"));
    stage.run(&["test"]).ends(1, &["2 failed"]);
}

#[test]
fn a_scene_before_one_plate_is_tested_whole_and_one_before_a_sequence_is_not() {
    let stage = Stage::new(SUITE);
    stage.write("robot.gltf", &scene(0).to_string());
    let whole = stage.run(&["test", "--list-images"]).stdout;
    assert_eq!(whole.lines().count(), 11, "{whole}");
    let png = encode_png((2, 1), &[[60, 60, 60, 255]; 2], "").unwrap();
    for name in (0..=24).map(|frame| format!("sky.{frame:04}.png")) {
        std::fs::write(stage.path(&name), &png).unwrap();
    }
    stage.write("suite.toml", &format!("{SUITE}background = 'plate:sky.0000.png'\n"));
    assert_eq!(stage.run(&["test", "--list-images"]).stdout, whole);
    stage.write("suite.toml", &format!("{SUITE}background = 'sky.####.png'\n"));
    let listed = stage.run(&["test", "--list-images"]).stdout;
    let frames: Vec<_> = (0..=24).map(|frame| format!("  robot.{frame:04}\n")).collect();
    assert_eq!(listed, format!("robot\n{}", frames.concat()));
}
