//! `rayframe diff` of two versions of an asset.

use std::path::Path;

use serde_json::{Value, json as value};

use super::{Stage, json, printed, rayframe};
use crate::progress::schema::Schema;

const SMALL: [&str; 4] = ["-r", "64x36", "--samples", "1"];

impl Stage {
    /// Writes a changed scene of the repository.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    pub(super) fn version(&self, name: &str, scene: &str, change: impl Fn(&mut Value)) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let mut text: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        change(&mut text);
        std::fs::write(self.at(name), text.to_string()).unwrap();
        self.at(name)
    }

    /// The JSON and the exit code of a comparison of two versions of `scene`.
    fn compared(&self, scene: &str, change: impl Fn(&mut Value), options: &[&str]) -> (Value, Option<i32>) {
        let (old, new) = (self.version("old.gltf", scene, |_| {}), self.version("new.gltf", scene, change));
        let output = rayframe(&[&["diff", &new, &old, "--json"], &SMALL[..], options].concat());
        assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
        let report = json(&output);
        Schema::read("diff").check(&report);
        (report, output.status.code())
    }
}

/// Group, kind and name of every change but those of the file's sizes.
fn changes(report: &Value) -> Vec<(String, String, String)> {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let all = report["asset"]["changes"].as_array().into_iter().flatten();
    let all = all.map(|change| (text(&change["group"]), text(&change["kind"]), text(&change["name"])));
    all.filter(|(group, ..)| group != "file").collect()
}

fn owned(changes: &[(&str, &str, &str)]) -> Vec<(String, String, String)> {
    changes.iter().map(|(group, kind, name)| ((*group).into(), (*kind).into(), (*name).into())).collect()
}

const BALLS: &str = "material/metal_roughness_row.gltf";

#[test]
fn equal_assets_are_identical_in_all_views() {
    let (report, code) = Stage::new().compared(BALLS, |_| {}, &["--preset", "exact"]);
    assert_eq!((code, &report["same"]), (Some(0), &true.into()));
    assert_eq!(changes(&report), owned(&[]));
    assert!(report["frames"].as_array().unwrap().iter().all(|frame| frame["identical"] == true));
}

#[test]
fn a_material_that_changes_is_told_with_old_and_new_value() {
    let change =
        |scene: &mut Value| scene["materials"][1]["pbrMetallicRoughness"]["roughnessFactor"] = value!(0.125);
    let (report, _) = Stage::new().compared(BALLS, change, &[]);
    let told = changes(&report);
    assert_eq!((told.len(), told[0].0.as_str(), told[0].1.as_str()), (1, "materials", "changed"));
    let change =
        report["asset"]["changes"].as_array().unwrap().iter().find(|change| change["group"] == "materials");
    let properties = change.unwrap()["properties"].as_array().unwrap();
    assert_eq!((properties.len(), &properties[0]["property"]), (1, &"roughness".into()));
    assert_eq!(properties[0]["actual"], 0.125);
    assert!(properties[0]["reference"].as_f64().is_some_and(|before| before != 0.125), "{properties:?}");
}

#[test]
fn views_without_cameras_have_the_names_of_named_views() {
    let (report, code) = Stage::new().compared("camera/no_camera.gltf", |_| {}, &[]);
    let view = |at: usize| report["frames"][at]["view"].as_str();
    let views = ["three-quarter", "three-quarter-back", "clip \"move\""];
    assert_eq!((code, [view(0), view(1), view(2)]), (Some(0), views.map(Some)));
}

#[test]
fn a_likely_cause_names_materials_of_both_assets() {
    let change = |scene: &mut Value| {
        scene["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = value!([0.1, 0.75, 0.1, 1]);
    };
    let (report, code) = Stage::new().compared(BALLS, change, &[]);
    let view = &report["frames"][0];
    assert_eq!(code, Some(1), "{view:#}");
    assert_eq!(view["cause"]["materials"], value!(["\"light squares\""]));
    // A material that only the actual asset has.
    let added = |scene: &mut Value| {
        let mut new = scene["materials"][0].clone();
        new["name"] = value!("green squares");
        new["pbrMetallicRoughness"]["baseColorFactor"] = value!([0.1, 0.75, 0.1, 1]);
        scene["materials"][0] = new;
    };
    let (report, _) = Stage::new().compared(BALLS, added, &[]);
    assert_eq!(report["frames"][0]["cause"]["materials"], value!(["\"green squares\""]));
}

#[test]
fn a_node_that_moves_is_told_and_its_image_fails() {
    let moved = |scene: &mut Value| scene["nodes"][4]["translation"] = value!([0.0, 1.5, 0.0]);
    let (report, code) = Stage::new().compared(BALLS, moved, &[]);
    assert_eq!(code, Some(1));
    let change = report["asset"]["changes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|change| change["group"] == "nodes")
        .unwrap();
    assert_eq!(change["properties"][0]["property"], "translation");
    assert_eq!(change["properties"][0]["actual"], value!([0.0, 1.5, 0.0]));
    // The camera is that of the reference, whose other balls keep their pixels.
    let cause = report["frames"][0]["cause"]["kind"].as_str();
    assert_eq!(cause, Some("geometry"), "{report:#}");
}

#[test]
fn a_lost_clip_fails_unless_it_may_be_lost() {
    let scene = "animation/hierarchy.gltf";
    let lose = |scene: &mut Value| {
        scene.as_object_mut().unwrap().remove("animations");
    };
    let stage = Stage::new();
    let (report, code) = stage.compared(scene, lose, &[]);
    assert_eq!((code, report["same"].as_bool()), (Some(1), Some(false)));
    let losses = report["asset"]["losses"].as_array().unwrap();
    assert!(losses.len() == 1 && losses[0].as_str().unwrap().starts_with("lost: clip \""), "{losses:?}");
    // Without animation both look alike.
    assert!(report["frames"].as_array().unwrap().iter().all(|frame| frame["same"] == true));
    let (report, code) = stage.compared(scene, lose, &["--allow-lost", "clips"]);
    assert_eq!((code, &report["asset"]["losses"]), (Some(0), &value!([])));
    // A clip that is new loses nothing.
    let (old, new) = (stage.at("new.gltf"), stage.at("old.gltf"));
    assert_eq!(rayframe(&[&["diff", &new, &old], &SMALL[..]].concat()).status.code(), Some(0));
}

#[test]
fn clips_are_compared_at_their_first_middle_and_last_frame() {
    let (report, code) = Stage::new().compared("animation/hierarchy.gltf", |_| {}, &[]);
    let frames = report["series"]["frame"].as_array().unwrap();
    let numbers: Vec<_> = frames.iter().filter_map(Value::as_i64).collect();
    assert_eq!((code, numbers.len(), numbers[0]), (Some(0), 3, 0));
    assert_eq!(numbers[1], numbers[2] / 2);
}

#[test]
fn a_renamed_node_with_a_mesh_is_lost_and_found() {
    let stage = Stage::new();
    let rename = |scene: &mut Value| scene["nodes"][4]["name"] = "renamed".into();
    let named = stage.version("old.gltf", BALLS, |scene| scene["nodes"][4]["name"] = "ball".into());
    let renamed = stage.version("new.gltf", BALLS, rename);
    let report = json(&rayframe(&[&["diff", &renamed, &named, "--json"], &SMALL[..]].concat()));
    let told: Vec<_> = changes(&report).into_iter().filter(|(group, ..)| group == "nodes").collect();
    assert!(told[0].1 == "removed" && told[0].2.ends_with("ball"), "{told:?}");
    assert!(told[1].1 == "added" && told[1].2.ends_with("renamed"), "{told:?}");
    assert_eq!(report["asset"]["losses"].as_array().unwrap().len(), 1);
    assert!(report["frames"].as_array().unwrap().iter().all(|frame| frame["identical"] == true));
}

#[test]
fn renamed_materials_and_meshes_leave_images_identical() {
    let rename = |scene: &mut Value| {
        scene["materials"][0]["name"] = "renamed".into();
        scene["meshes"][1]["name"] = "renamed".into();
    };
    let (report, code) = Stage::new().compared(BALLS, rename, &["--preset", "exact", "--fail-on", "changed"]);
    assert_eq!(code, Some(0), "{report:#}");
    assert!(report["frames"].as_array().unwrap().iter().all(|frame| frame["identical"] == true));
}

#[test]
fn limits_replace_those_of_the_preset() {
    let stage = Stage::new();
    let a = stage.square("a.exr", (40, 24), 4);
    let b = stage.square("b.exr", (40, 24), 24);
    let output = rayframe(&["diff", &b, &a, "--mean-flip", "inf", "--tile-flip", "1", "--brightness=0.5"]);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(printed(&output).contains("visual with own limits"), "{}", printed(&output));
    let report = json(&rayframe(&["diff", &b, &a, "--tile-flip", "1", "--json"]));
    Schema::read("diff").check(&report);
    assert_eq!(
        (&report["limits"]["tile_flip"], &report["limits"]["mean_flip"]),
        (&value!(1.0), &value!(0.08))
    );
    for wrong in ["--mean-flip=-1", "--mean-flip=nan", "--mean-flip=low"] {
        assert_eq!(rayframe(&["diff", &b, &a, wrong]).status.code(), Some(2));
    }
}

#[test]
fn options_and_files_of_the_wrong_kind_are_refused() {
    let stage = Stage::new();
    let image = stage.square("a.exr", (40, 24), 4);
    let scene = stage.version("a.gltf", BALLS, |_| {});
    let told = |arguments: &[&str]| {
        let output = rayframe(&[&["diff"], arguments].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, text) = told(&[&scene, &image]);
    assert!(code == Some(2) && text.contains("one is a scene and the other is not"), "{text}");
    let (code, text) = told(&[&image, &image, "-r", "64x36"]);
    assert!(code == Some(2) && text.contains("--resolution applies to two scenes"), "{text}");
    let (code, text) = told(&[&scene, &scene, "--heat-map", "heat.png"]);
    assert!(code == Some(2) && text.contains("--heat-map applies to images"), "{text}");
    assert_eq!(told(&[&scene, &stage.at("gone.glb")]).0, Some(66));
    assert_eq!(told(&[&scene, &scene, "-r", "wide"]).0, Some(2));
}

#[test]
fn quiet_tells_warnings_only_where_something_fails() {
    let stage = Stage::new();
    let version = |name, red: f64| {
        stage.version(name, BALLS, |scene| {
            scene["nodes"][0]["extensions"]["EXT_unknown"] = value!({});
            scene["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"] = value!([red, 0.0, 0.0, 1.0]);
        })
    };
    let (dark, bright) = (version("dark.gltf", 0.01), version("bright.gltf", 0.9));
    let told = |reference: &str, options: &[&str]| {
        let output = rayframe(&[&["diff", &dark, reference], &SMALL[..], options].concat());
        let warned = String::from_utf8_lossy(&output.stderr).contains("EXT_unknown is not supported");
        (output.status.code(), warned)
    };
    assert_eq!([told(&dark, &[]), told(&dark, &["-q"])], [(Some(0), true), (Some(0), false)]);
    assert_eq!(told(&bright, &["-q"]), (Some(1), true));
}

#[test]
fn the_page_has_the_changes_and_all_images() {
    let stage = Stage::new();
    let old = stage.version("old.gltf", BALLS, |_| {});
    let new = stage.version("new.gltf", BALLS, |scene| scene["materials"][1]["name"] = "<b>&".into());
    let folder = stage.at("report");
    let output = rayframe(&[&["diff", &new, &old, "--report", &folder], &SMALL[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(printed(&output).starts_with(&format!("{new} against the reference {old}\n")));
    let html = std::fs::read_to_string(Path::new(&folder).join("index.html")).unwrap();
    let (_, rest) = html.split_once("id=\"data\">").unwrap();
    let data: Value = serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap();
    let group = &data["asset"]["groups"][0];
    assert!(
        data["asset"]["groups"].as_array().unwrap().iter().any(|group| group["title"] == "materials"),
        "{group}"
    );
    assert!(html.contains("&lt;b&gt;&amp;") && !html.contains("<b>&"));
    let shots = data["shots"].as_array().unwrap();
    assert!(!shots.is_empty());
    let frame = &shots[0]["frames"][0];
    assert!(frame["status"] == "passed" && frame["expected"].is_object() && frame["actual"].is_object());
    let again = rayframe(&[&["diff", &new, &old, "--report", &folder], &SMALL[..]].concat());
    assert_eq!(again.stdout, output.stdout);
    assert_eq!(std::fs::read_to_string(Path::new(&folder).join("index.html")).unwrap(), html);
}

#[test]
fn content_that_is_detached_is_lost() {
    let detach = |scene: &mut Value| {
        scene["nodes"][4].as_object_mut().unwrap().remove("mesh");
    };
    let (report, code) = Stage::new().compared(BALLS, detach, &["--mean-flip", "1", "--tile-flip", "1"]);
    assert_eq!(code, Some(1));
    let lost =
        report["asset"]["changes"].as_array().unwrap().iter().filter(|change| change["is_loss"] == true);
    let lost: Vec<_> = lost.map(|change| (&change["group"], &change["kind"])).collect();
    assert_eq!(lost, [(&value!("nodes"), &value!("changed"))], "{report}");
}

#[test]
fn content_that_leaves_the_scene_is_lost_though_the_file_keeps_it() {
    let stage = Stage::new();
    let scene = "light/point.gltf";
    let old = stage.version("old.gltf", scene, |_| {});
    for (node, lost) in [
        (0, "lost: camera \"camera\", which nothing uses any more"),
        (1, "lost: node \"floor\" with a mesh, which stands in no scene any more"),
        (6, "lost: light \"#0\", which nothing uses any more"),
    ] {
        let new = stage.version("new.gltf", scene, |scene| {
            scene["scenes"][0]["nodes"].as_array_mut().unwrap().retain(|index| *index != value!(node));
        });
        let output = rayframe(&[&["diff", &new, &old], &SMALL[..]].concat());
        assert_eq!(output.status.code(), Some(1));
        assert!(printed(&output).contains(lost), "{lost}: {}", printed(&output));
    }
}

#[test]
fn unnamed_items_that_only_have_other_indices_are_the_same() {
    let unnamed = |scene: &mut Value| {
        for material in scene["materials"].as_array_mut().unwrap() {
            material.as_object_mut().unwrap().remove("name");
        }
    };
    let stage = Stage::new();
    let old = stage.version("old.gltf", BALLS, unnamed);
    // A material that nothing uses comes first, so that every index is another.
    let new = stage.version("new.gltf", BALLS, |scene| {
        unnamed(scene);
        scene["materials"].as_array_mut().unwrap().insert(0, value!({"name": "unused"}));
        for mesh in scene["meshes"].as_array_mut().unwrap() {
            for primitive in mesh["primitives"].as_array_mut().unwrap() {
                primitive["material"] = value!(primitive["material"].as_u64().unwrap() + 1);
            }
        }
    });
    let report = json(&rayframe(&[&["diff", &new, &old, "--json"], &SMALL[..]].concat()));
    let told = changes(&report);
    assert_eq!(told, owned(&[("materials", "added", "unused")]));
}
