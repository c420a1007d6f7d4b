//! Likely causes of failures: one edit of each part of a scene, and the part that the failure names.

use rayframe::image_file::encode_png;

use super::Stage;
use super::coverage::scene;

/// Single values fail, so that small edits do, too.
const SUITE: &str = "[test]\npreset = 'exact'\n[shot]\nresolution = [64, 36]\nsamples = 1\nframes = 0\n";
/// Four posts about a point light on a floor, before a camera of the file.
const SCENE: &str = "light/point.gltf";

/// Names of edits, texts of the scene, what replaces them, and the beginning of the cause.
const EDITS: [(&str, &str, &str, &str); 9] = [
    ("a dimmer light", "\"intensity\": 3", "\"intensity\": 2.9", "likely light: red times 0.9"),
    ("a light that moved", "[0, 1, 0]", "[0.05, 1, 0]", "likely light: lights or the environment"),
    (
        "a darker floor, which looks like less light",
        "[0.6, 0.6, 0.6, 1]",
        "[0.5, 0.5, 0.5, 1]",
        "likely material:",
    ),
    (
        "a smoother post",
        "0.35, 1], \"metallicFactor\": 0, \"roughnessFactor\": 1",
        "0.35, 1], \"metallicFactor\": 0, \"roughnessFactor\": 0.2",
        "likely material:",
    ),
    ("a post that moved", "[-0.9, 0.3, -0.9]", "[-0.8, 0.3, -0.9]", "likely geometry:"),
    (
        "a post without a mesh",
        "[0.9, 0.3, 0.9], \"rotation\": [0, 0, 0, 1], \"mesh\": 1",
        "[0.9, 0.3, 0.9]",
        "likely geometry:",
    ),
    ("a camera that moved", "[0, 3.4, 4.6]", "[0.05, 3.4, 4.6]", "likely camera:"),
    (
        "a far plane that cuts posts off",
        "\"znear\": 0.1",
        "\"znear\": 0.1, \"zfar\": 5.2",
        "likely camera: its clip planes changed",
    ),
    ("a wider lens", "0.7853982", "0.8", "likely camera:"),
];

#[test]
fn a_failure_names_the_part_of_the_scene_that_was_edited() {
    let stage = Stage::accepted(SUITE, &[("point.gltf", SCENE)]);
    for (edit, from, to, cause) in EDITS {
        stage.scene("point.gltf", SCENE, from, to);
        let ran = stage.run(&["test"]);
        assert_eq!(ran.code, Some(1), "{edit}: {}", ran.text);
        assert!(ran.text.contains(cause), "{edit}: {}", ran.text);
    }
    // The same scene with other settings.
    stage.scene("point.gltf", SCENE, "", "");
    stage.write("suite.toml", &SUITE.replace("samples = 1", "samples = 4"));
    stage.run(&["test"]).ends(1, &["likely settings:"]);
}

#[test]
fn colours_of_instances_belong_to_materials() {
    let scene = "geometry/gpu_instancing.gltf";
    let stage = Stage::accepted(SUITE, &[("instances.gltf", scene)]);
    stage.scene("instances.gltf", scene, "\"SCALE\": 8", "\"SCALE\": 8, \"_COLOR_0\": 8");
    stage.run(&["test"]).ends(1, &["likely material:"]);
}

#[test]
fn names_and_the_order_of_meshes_change_nothing() {
    let suite = SUITE.replace("exact", "visual") + "aovs = ['object_id', 'material_id']\n";
    let stage = Stage::accepted(&suite, &[("point.gltf", SCENE)]);
    stage.scene("point.gltf", SCENE, "\"posts\"", "\"pillars\"");
    stage.run(&["test"]).ends(0, &["0 failed"]);
    // The floor is the second mesh and the posts the first: their ids are exchanged.
    let floor = "{ \"attributes\": { \"POSITION\": 0, \"NORMAL\": 1 }, \"indices\": 2, \"material\": 0 }";
    let posts = "{ \"attributes\": { \"POSITION\": 3, \"NORMAL\": 4 }, \"indices\": 5, \"material\": 1 }";
    stage.scene("point.gltf", SCENE, "", "");
    let text = std::fs::read_to_string(stage.path("point.gltf")).unwrap();
    assert!(text.contains(floor) && text.contains(posts), "{text}");
    let exchanged = text.replace(floor, "@").replace(posts, floor).replace('@', posts);
    let exchanged = exchanged.replace("\"mesh\": 0", "\"mesh\": 9").replace("\"mesh\": 1", "\"mesh\": 0");
    stage.write("point.gltf", &exchanged.replace("\"mesh\": 9", "\"mesh\": 1"));
    stage.run(&["test"]).ends(0, &["0 failed"]);
}

#[test]
fn a_paler_material_on_one_object_of_many_fails_by_its_object() {
    let suite = SUITE.replace("exact", "visual") + "aovs = ['object_id']\n";
    let stage = Stage::accepted(&suite, &[("point.gltf", SCENE)]);
    stage.scene("point.gltf", SCENE, "[0.6, 0.6, 0.6, 1]", "[0.56, 0.56, 0.56, 1]");
    stage.run(&["test"]).ends(1, &["FLIP of the worst object: 0.1", " > 0.06", "likely material:"]);
}

#[test]
fn a_material_is_named_where_its_ids_are_known() {
    for aovs in ["aovs = ['material_id']\n", "aovs = ['material_id', 'albedo']\n"] {
        let stage = Stage::accepted(&format!("{SUITE}{aovs}"), &[("point.gltf", SCENE)]);
        stage.scene("point.gltf", SCENE, EDITS[2].1, EDITS[2].2);
        let ran = stage.run(&["test"]);
        ran.ends(1, &["likely material: ", " \"floor\"\n"]);
        assert!(!ran.text.contains("posts"), "{}", ran.text);
        stage.scene("point.gltf", SCENE, EDITS[3].1, EDITS[3].2);
        stage.run(&["test"]).ends(1, &["likely material: ", " \"posts\"\n"]);
    }
    // Without a name it is numbered.
    let stage = Stage::accepted(&format!("{SUITE}aovs = ['material_id']\n"), &[("point.gltf", SCENE)]);
    stage.scene("point.gltf", SCENE, "\"name\": \"floor\",", "\"alphaCutoff\": 0.4,");
    let text = std::fs::read_to_string(stage.path("point.gltf")).unwrap();
    stage.write("point.gltf", &text.replace(EDITS[2].1, EDITS[2].2));
    stage.run(&["test"]).ends(1, &["likely material: materials or textures changed: #0\n"]);
}

#[test]
fn another_plate_is_a_background() {
    let stage = Stage::new(&format!("{SUITE}background = 'plate.png'\n"));
    stage.scene("point.gltf", SCENE, "", "");
    let plate = |color: [u8; 4]| {
        std::fs::write(stage.path("plate.png"), encode_png((2, 2), &[color; 4], "").unwrap()).unwrap();
    };
    plate([40, 60, 200, 255]);
    stage.run(&["test"]).ends(1, &["no reference"]);
    stage.run(&["accept"]).ends(0, &["added"]);
    plate([200, 60, 40, 255]);
    let told = "likely background: the plate behind the scene, or whether the environment shows, changed";
    stage.run(&["test"]).ends(1, &[told]);
    // There is no plate.
    let suite = |background: &str| format!("{SUITE}env = 'studio'\nbackground = '{background}'\n");
    let stage = Stage::new(&suite("none"));
    stage.write("robot.gltf", &scene(0).to_string());
    stage.run(&["test"]).ends(1, &["no reference"]);
    stage.run(&["accept"]).ends(0, &["added"]);
    stage.write("suite.toml", &suite("env"));
    stage.run(&["test"]).ends(1, &[told]);
}
