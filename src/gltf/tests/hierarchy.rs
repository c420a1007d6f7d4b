use serde_json::{Value, json};

use super::{Document, error_text, import_bytes};
use crate::scene::{LocalTransform, NodeIndex};

/// Document of nodes only, in one scene with root node 0.
fn nodes(nodes: &Value) -> Vec<u8> {
    let document = json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": nodes});
    document.to_string().into_bytes()
}

#[test]
fn nodes_must_form_trees() {
    for graph in [
        json!([{"children": [0]}]),
        json!([{"children": [1]}, {"children": [0]}]),
        json!([{}, {"children": [2]}, {"children": [1]}]),
        json!([{"children": [1, 1]}, {}]),
        json!([{"children": [1, 2]}, {"children": [2]}, {}]),
        json!([{"children": [1]}]),
    ] {
        error_text(import_bytes("a.gltf", &nodes(&graph)), 65);
    }
    let child_as_root = json!([{}, {"children": [0]}]);
    let text = error_text(import_bytes("a.gltf", &nodes(&child_as_root)), 65);
    assert!(text.contains("/scenes/0/nodes/0"), "{text}");
}

#[test]
fn parents_come_before_children_at_any_depth() {
    // A chain of 100 000 nodes, listed from the leaf to the root.
    let count = 100_000_u32;
    let mut list: Vec<Value> = vec![json!({})];
    list.extend((0..count - 1).map(|child| json!({"children": [child]})));
    let document = json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": [count - 1]}], "nodes": list});
    let scene = import_bytes("a.gltf", document.to_string().as_bytes()).unwrap();
    assert_eq!(scene.node_order.len(), count as usize);
    assert_eq!(scene.node_order[0], NodeIndex(count - 1));
    assert_eq!(scene.nodes[0].parent, Some(NodeIndex(1)));
}

#[test]
fn transforms_are_checked() {
    for (node, expected) in [
        (json!({"scale": [1e39, 1, 1]}), "/nodes/0/scale"),
        (json!({"rotation": [0, 0, 0, 0]}), "length zero"),
        (json!({"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], "scale": [1,1,1]}), "both"),
        (json!({"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}), "not affine"),
        (json!({"mesh": 3}), "no mesh 3"),
        (json!({"camera": 0}), "no camera 0"),
    ] {
        let text = error_text(import_bytes("a.gltf", &nodes(&json!([node]))), 65);
        assert!(text.contains(expected), "{text}");
    }
    let scene = import_bytes("a.gltf", &nodes(&json!([{"rotation": [0, 2, 0, 0]}]))).unwrap();
    let LocalTransform::Trs { rotation, .. } = scene.nodes[0].local else {
        panic!("not translation, rotation and scale");
    };
    assert_eq!(rotation.to_array(), [0.0, 1.0, 0.0, 0.0]);
    assert_eq!(scene.warnings.len(), 1);
}

#[test]
fn triangles_of_all_instances_are_counted() {
    // One triangle per node is accepted. 12 000 instances of 400 000 triangles exceed 2^32.
    let mut document = Document::triangle();
    let indices: Vec<u8> = [0_u8, 1, 2].repeat(400_000);
    let accessor = document.accessor(5121, "SCALAR", indices.len(), &indices);
    document.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
    let count = 12_000_usize;
    document.json["nodes"] = json!(vec![json!({"mesh": 0}); count]);
    document.json["scenes"] = json!([{"nodes": (0..count).collect::<Vec<_>>()}]);
    assert!(document.error(77).contains("4800000000 triangles"));
}

#[test]
fn a_file_without_scenes_shows_all_roots() {
    let text = json!({"asset": {"version": "2.0"}, "nodes": [{}, {"children": [0]}, {}]}).to_string();
    let scene = import_bytes("a.gltf", text.as_bytes()).unwrap();
    assert_eq!(scene.scenes[0].roots, [NodeIndex(1), NodeIndex(2)]);
    let text = json!({"asset": {"version": "2.0"}}).to_string();
    let scene = import_bytes("a.gltf", text.as_bytes()).unwrap();
    assert_eq!((scene.scenes.len(), scene.default_scene), (1, 0));
}

#[test]
fn documents_are_repaired() {
    // A byte order mark, a scene without nodes, integers written as floats, and extras of any shape.
    let mut bytes = vec![0xef, 0xbb, 0xbf];
    bytes.extend(
        br#"{"asset": {"version": "2.0"}, "scene": 0.0, "scenes": [{"extras": 5}], "nodes": [{"children": [1e0]}, {}]}"#,
    );
    let scene = import_bytes("a.gltf", &bytes).unwrap();
    assert_eq!(scene.nodes[1].parent, Some(NodeIndex(0)));
    assert!(scene.scenes[0].roots.is_empty());
}

#[test]
fn malformed_documents_are_errors() {
    let deep =
        format!(r#"{{"asset":{{"version":"2.0"}},"extras":{}{}}}"#, "[".repeat(100_000), "]".repeat(100_000));
    for text in [
        "",
        "{",
        "[]",
        "{}",
        r#"{"asset": {"version": "1.0"}}"#,
        r#"{"asset": {"version": "2.0", "minVersion": "2.1"}}"#,
        r#"{"asset": {"version": "two"}}"#,
        r#"{"asset": {"version": "2.0"}, "nodes": {}}"#,
        r#"{"asset": {"version": "2.0"}, "nodes": [7]}"#,
        r#"{"asset": {"version": "2.0"}, "nodes": [{"extensions": 7}]}"#,
        &deep,
    ] {
        error_text(import_bytes("a.gltf", text.as_bytes()), 65);
    }
}

#[test]
fn cameras_are_checked() {
    let camera = |camera: Value| {
        let document = json!({"asset": {"version": "2.0"}, "cameras": [camera]});
        import_bytes("a.gltf", document.to_string().as_bytes())
    };
    let good = json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}});
    assert_eq!(camera(good).unwrap().cameras.len(), 1);
    for bad in [
        json!({"type": "perspective", "perspective": {"yfov": 0, "znear": 0.1}}),
        json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0}}),
        json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1, "zfar": 1}}),
        json!({"type": "orthographic", "perspective": {"yfov": 1, "znear": 1}}),
        json!({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1, "znear": 0, "zfar": 1}}),
        json!({"type": "fisheye"}),
    ] {
        error_text(camera(bad), 65);
    }
}

/// Scene of a skinned triangle at node 0, with joints 1 and 2 below or beside it.
fn skinned(roots: &Value) -> Document {
    let mut document = Document::triangle();
    let joints: Vec<u8> = [[0_u8, 1, 0, 0]; 3].concat();
    let joints = document.accessor(5121, "VEC4", 3, &joints);
    document.set_attribute("JOINTS_0", joints);
    document.attribute("WEIGHTS_0", "VEC4", &[0.5, 0.5, 0.0, 0.0].repeat(3));
    document.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {}, {}, {"children": [1, 2]}]);
    document.json["skins"] = json!([{"joints": [1, 2]}]);
    document.json["scenes"][0]["nodes"] = roots.clone();
    document
}

#[test]
fn joints_outside_the_scene_and_of_several_trees_are_named() {
    assert_eq!(skinned(&json!([0, 3])).import().unwrap().warnings, []);
    let warnings = skinned(&json!([0])).import().unwrap().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let text = warnings[0].to_string();
    assert!(text.contains("/nodes/0/skin") && text.contains("not in scene 0"), "{text}");
    let mut document = skinned(&json!([0, 1, 2]));
    document.json["nodes"][3] = json!({});
    let warnings = document.import().unwrap().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let text = warnings[0].to_string();
    assert!(text.contains("/skins/0/joints") && text.contains("no common root"), "{text}");
}

#[test]
fn a_scene_names_one_joint_that_it_does_not_have() {
    // Many meshes with skins of their own, in many scenes that lack their joints: one warning a scene.
    let mut document = skinned(&json!([0]));
    let nodes: Vec<u32> = (4..54).collect();
    for index in 0..50 {
        document.json["skins"].as_array_mut().unwrap().push(json!({"joints": [1, 2]}));
        document.push("nodes", json!({"mesh": 0, "skin": 1 + index}));
    }
    document.json["nodes"][0]["children"] = json!(nodes);
    document.json["scenes"] = json!(vec![json!({"nodes": [0]}); 50]);
    let warnings = document.import().unwrap().warnings;
    assert_eq!(warnings.len(), 50, "{}", warnings.len());
    assert!(warnings.iter().all(|warning| warning.pointer == "/nodes/0/skin"), "{warnings:?}");
    // None where the scene has the joints, too.
    document.json["scenes"] = json!([{"nodes": [3, 0]}]);
    assert_eq!(document.import().unwrap().warnings, []);
}

#[test]
fn skins_must_have_the_joints_of_all_primitives() {
    let mut document = skinned(&json!([0, 3]));
    document.json["skins"][0]["joints"] = json!([1]);
    assert!(
        document.error(65).contains("/nodes/0/skin: the mesh uses joint 1, but the skin has only 1 joints")
    );
    let mut document = skinned(&json!([0, 3]));
    let rigid = json!({"attributes": {"POSITION": 0}});
    document.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(rigid);
    assert!(
        document.error(65).contains("/nodes/0/skin: the mesh of this node has primitives without JOINTS_0")
    );
    // Without a skin they are not deformed, and a skin without a mesh deforms nothing.
    document.json["nodes"][0] = json!({"mesh": 0});
    document.json["nodes"][1] = json!({"skin": 0});
    let warnings = document.import().unwrap().warnings;
    let pointers: Vec<_> = warnings.iter().map(|warning| warning.pointer.as_str()).collect();
    assert_eq!(pointers, ["/nodes/0/mesh", "/nodes/1/skin"], "{warnings:?}");
}
