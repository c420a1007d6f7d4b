//! Animated properties, visibility and instancing.

use glam::Vec3;
use serde_json::{Value, json};

use super::{Document, ImportOptions, import};
use crate::frame::Frame;
use crate::scene::{
    AnimationTarget, CameraIndex, CameraProperty, ImageLightIndex, ImageLightProperty, LightIndex,
    LightProperty, MaterialIndex, MaterialProperty, MeshIndex, NodeIndex, Scene, Selection, SelectionRequest,
    TextureSlot,
};

/// Triangle document with every property that the pointer tests animate.
fn animatable() -> Document {
    let mut document = Document::triangle();
    let transform = json!({"index": 0, "extensions": {"KHR_texture_transform": {}}});
    document.json["images"] = json!([{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}]);
    document.json["textures"] = json!([{"source": 0}]);
    document.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorTexture": transform},
        "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}}
    }]);
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    document.attribute("TEXCOORD_0", "VEC2", &[0.0; 6]);
    document.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    document.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "spot": {}, "range": 4}
    ]}});
    let light = json!({"irradianceCoefficients": vec![[1, 1, 1]; 9], "specularImageSize": 1, "specularImages": [[0, 0, 0, 0, 0, 0]]});
    document.json["extensions"]["EXT_lights_image_based"] = json!({"lights": [light]});
    document.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 0}});
    document.push(
        "materials",
        json!({"extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {},
            "KHR_materials_pbrSpecularGlossiness": {"specularGlossinessTexture": transform}
        }}),
    );
    document.json["nodes"] = json!([
        {"mesh": 0, "children": [1], "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]);
    document.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    document
}

/// Adds an animation of `pointer` from time 0 to 1.
fn animate(document: &mut Document, pointer: &str, interpolation: &str, shape: &str, values: &[f32]) {
    let output = document.floats(shape, values);
    animate_with(document, pointer, interpolation, output);
}

fn animate_with(document: &mut Document, pointer: &str, interpolation: &str, output: usize) {
    let input = document.floats("SCALAR", &[0.0, 1.0]);
    let clip = json!({
        "channels": [{"sampler": 0, "target": {
            "path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}
        }}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
    });
    document.push("animations", clip);
}

fn frame(scene: &Scene, time_seconds: f64) -> Frame {
    let (selection, _) = Selection::resolve(&SelectionRequest::default(), scene).unwrap();
    Frame::at(scene, &selection, time_seconds)
}

#[test]
fn pointers_name_properties_of_every_kind() {
    let material = |property| AnimationTarget::Material(MaterialIndex(0), property);
    let light = |property| AnimationTarget::Light(LightIndex(0), property);
    let image_light = |property| AnimationTarget::ImageLight(ImageLightIndex(0), property);
    let slot = TextureSlot::BaseColor;
    for (pointer, shape, width, expected) in [
        ("/nodes/0/translation", "VEC3", 3, AnimationTarget::Translation(NodeIndex(0))),
        ("/nodes/1/rotation", "VEC4", 4, AnimationTarget::Rotation(NodeIndex(1))),
        (
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            "VEC4",
            4,
            material(MaterialProperty::BaseColor),
        ),
        (
            "/materials/0/pbrMetallicRoughness/roughnessFactor",
            "SCALAR",
            1,
            material(MaterialProperty::Roughness),
        ),
        ("/materials/0/emissiveFactor", "VEC3", 3, material(MaterialProperty::EmissiveFactor)),
        (
            "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength",
            "SCALAR",
            1,
            material(MaterialProperty::EmissiveStrength),
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset",
            "VEC2",
            2,
            material(MaterialProperty::TextureOffset(slot)),
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/rotation",
            "SCALAR",
            1,
            material(MaterialProperty::TextureRotation(slot)),
        ),
        ("/extensions/KHR_lights_punctual/lights/0/color", "VEC3", 3, light(LightProperty::Color)),
        ("/extensions/KHR_lights_punctual/lights/0/range", "SCALAR", 1, light(LightProperty::Range)),
        (
            "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle",
            "SCALAR",
            1,
            light(LightProperty::OuterCone),
        ),
        (
            "/materials/1/extensions/KHR_materials_volume/thicknessFactor",
            "SCALAR",
            1,
            AnimationTarget::Material(MaterialIndex(1), MaterialProperty::Thickness),
        ),
        (
            "/materials/1/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture/extensions/\
             KHR_texture_transform/scale",
            "VEC2",
            2,
            AnimationTarget::Material(
                MaterialIndex(1),
                MaterialProperty::TextureScale(TextureSlot::SpecularGlossiness),
            ),
        ),
        (
            "/extensions/EXT_lights_image_based/lights/0/intensity",
            "SCALAR",
            1,
            image_light(ImageLightProperty::Intensity),
        ),
        (
            "/extensions/EXT_lights_image_based/lights/0/rotation",
            "VEC4",
            4,
            image_light(ImageLightProperty::Rotation),
        ),
        (
            "/cameras/0/perspective/yfov",
            "SCALAR",
            1,
            AnimationTarget::Camera(CameraIndex(0), CameraProperty::FieldOfView),
        ),
    ] {
        let mut document = animatable();
        animate(&mut document, pointer, "LINEAR", shape, &vec![0.5; 2 * width]);
        let scene = document.import().unwrap();
        assert!(scene.warnings.is_empty(), "{pointer}: {:?}", scene.warnings);
        let channel = &scene.animations[0].channels[0];
        assert_eq!((channel.target, channel.keyframes.width), (expected, width), "{pointer}");
    }
}

#[test]
fn unknown_pointers_are_named_and_the_rest_plays() {
    for pointer in [
        "/materials/2/emissiveFactor",
        "/materials/0/name",
        "/nodes/9/weights/0",
        "/nodes/0/weights/+0",
        "/cameras/0/weights/0",
        "/materials/0/normalTexture/scale",
        "/cameras/0/perspective/zfar",
        "/cameras/0/orthographic/xmag",
        "/nodes/0/children",
        "nonsense",
        "/nodes/+0/scale",
    ] {
        let mut document = animatable();
        animate(&mut document, pointer, "LINEAR", "SCALAR", &[0.5; 2]);
        animate(&mut document, "/nodes/0/scale", "LINEAR", "VEC3", &[0.5; 6]);
        let scene = document.import().unwrap();
        assert!(scene.animations[0].channels.is_empty() && scene.animations[1].channels.len() == 1);
        assert_eq!(scene.warnings.len(), 1, "{pointer}");
        assert!(scene.warnings[0].message.contains(pointer), "{:?}", scene.warnings);
    }
}

#[test]
fn wrong_values_of_properties_are_errors() {
    let base_color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    let visible = "/nodes/0/extensions/KHR_node_visibility/visible";
    for (pointer, interpolation, shape, values, expected) in [
        (base_color, "LINEAR", "VEC3", &[0.5; 6][..], "VEC3 of floats"),
        (base_color, "LINEAR", "VEC4", &[0.5; 4], "has 4 numbers"),
        (base_color, "LINEAR", "VEC4", &[1.5; 8], "must lie between 0 and 1"),
        ("/cameras/0/perspective/yfov", "LINEAR", "SCALAR", &[4.0; 2], "/output"),
        (visible, "STEP", "SCALAR", &[0.0; 2], "SCALAR of floats"),
    ] {
        let mut document = animatable();
        animate(&mut document, pointer, interpolation, shape, values);
        let text = document.error(65);
        assert!(text.contains(expected), "{text}");
    }
    let mut document = animatable();
    let switch = document.accessor(5121, "SCALAR", 2, &[0, 1]);
    animate_with(&mut document, visible, "LINEAR", switch);
    assert!(document.error(65).contains("must be STEP"));
    // The same node is animated by a pointer and by a node path.
    let mut document = animatable();
    animate(&mut document, "/nodes/0/scale", "LINEAR", "VEC3", &[0.5; 6]);
    let named = json!({"sampler": 0, "target": {"node": 0, "path": "scale"}});
    document.json["animations"][0]["channels"].as_array_mut().unwrap().push(named);
    assert!(document.error(65).contains("another channel"));
}

#[test]
fn frames_carry_moved_materials_lights_and_cameras() {
    let mut document = animatable();
    let strength = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
    animate(&mut document, strength, "LINEAR", "SCALAR", &[0.0, 8.0]);
    animate(&mut document, "/materials/0/emissiveFactor", "LINEAR", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.5, 0.0]);
    animate(
        &mut document,
        "/extensions/KHR_lights_punctual/lights/0/intensity",
        "LINEAR",
        "SCALAR",
        &[2.0, 6.0],
    );
    animate(&mut document, "/cameras/0/perspective/yfov", "LINEAR", "SCALAR", &[0.5, 1.5]);
    // A cubic spline that overshoots its keyframes of 1 is clamped to the range of colours.
    let base_color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    let (zero, one, steep) = ([0.0; 4], [1.0; 4], [9.0; 4]);
    animate(&mut document, base_color, "CUBICSPLINE", "VEC4", &[zero, one, steep, zero, one, zero].concat());
    let scene = document.import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let frame = frame(&scene, 0.5);
    // At half time: factor (1/2, 1/4, 0), strength 4, intensity 4, field of view 1.
    assert_eq!(frame.materials[0].emissive, Vec3::new(2.0, 1.0, 0.0));
    assert_eq!(frame.materials[0].base_color, glam::Vec4::ONE);
    assert_eq!(frame.lights[0].light.intensity, 4.0);
    let crate::scene::Projection::Perspective { fov_y_radians, .. } = frame.camera.projection else {
        panic!("perspective");
    };
    assert_eq!(fov_y_radians, 1.0);
    assert_eq!(scene.materials[0].emissive, Vec3::splat(2.0), "the scene itself stays");
}

#[test]
fn thickness_makes_a_wall_a_volume_and_an_image_light_turns() {
    let mut document = animatable();
    document.json["meshes"][0]["primitives"][0]["material"] = json!(1);
    let thickness = "/materials/1/extensions/KHR_materials_volume/thicknessFactor";
    animate(&mut document, thickness, "STEP", "SCALAR", &[0.0, 2.0]);
    let lights = "/extensions/EXT_lights_image_based/lights/0";
    animate(&mut document, &format!("{lights}/intensity"), "LINEAR", "SCALAR", &[0.0, 4.0]);
    // Rotation by half a turn about +Y: a quarter turn at half time.
    let turn = [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
    animate(&mut document, &format!("{lights}/rotation"), "LINEAR", "VEC4", &turn);
    let scene = document.import().unwrap();
    assert!(
        scene.warnings.iter().all(|warning| !warning.message.contains("not animated")),
        "{:?}",
        scene.warnings
    );
    let is_volume = |time| crate::frame::is_volume(&frame(&scene, time).materials[1]);
    assert!(!is_volume(0.5) && is_volume(1.0));
    let pose = frame(&scene, 0.5).image_light.unwrap();
    assert_eq!(pose.intensity, 2.0);
    assert!(
        (pose.rotation.y - 0.5_f32.sqrt()).abs() < 1e-6 && (pose.rotation.w - 0.5_f32.sqrt()).abs() < 1e-6
    );
    // A quaternion of length zero is no rotation.
    let mut document = animatable();
    animate(&mut document, &format!("{lights}/rotation"), "LINEAR", "VEC4", &[0.0; 8]);
    assert!(document.error(65).contains("length zero"));
}

/// Triangle with two morph targets, which raise its vertices by 1 and by 10, with weights 1/2 and 1.
fn morphing() -> Document {
    let mut document = Document::triangle();
    let by = |height: f32| [0.0, 0.0, height].repeat(3);
    let targets = [document.floats("VEC3", &by(1.0)), document.floats("VEC3", &by(10.0))];
    document.json["meshes"][0]["primitives"][0]["targets"] =
        json!(targets.map(|index| json!({"POSITION": index})));
    document.json["meshes"][0]["weights"] = json!([0.5, 1.0]);
    document.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    document
}

#[test]
fn single_weights_leave_the_others_as_they_are() {
    let height = |document: &Document, time| {
        let scene = document.import().unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        frame(&scene, time).triangles[0].vertices[0].z
    };
    let mut document = morphing();
    assert_eq!(height(&document, 0.0), 10.5);
    // The mesh's second weight is animated to 0: 0.5 · 1 + 0.5 · 10 at half time.
    animate(&mut document, "/meshes/0/weights/1", "LINEAR", "SCALAR", &[1.0, 0.0]);
    assert_eq!(height(&document, 0.5), 5.5);
    // The node's first weight overrides the mesh's: 2 · 1 + 0.5 · 10.
    animate(&mut document, "/nodes/0/weights/0", "LINEAR", "SCALAR", &[1.0, 3.0]);
    assert_eq!(height(&document, 0.5), 7.0);
    // The node's own weights override the mesh's: 2 · 1 + 0.25 · 10.
    document.json["nodes"][0]["weights"] = json!([0.0, 0.25]);
    assert_eq!(height(&document, 0.5), 4.5);
}

#[test]
fn single_weights_that_are_not_there_or_moved_twice_are_errors() {
    let mut document = morphing();
    animate(&mut document, "/nodes/0/weights/2", "LINEAR", "SCALAR", &[1.0, 0.0]);
    assert!(document.error(65).contains("no morph target 2"));
    let mut document = morphing();
    animate(&mut document, "/nodes/0/weights/1", "LINEAR", "SCALAR", &[1.0, 0.0]);
    let all = document.floats("SCALAR", &[0.0; 4]);
    let input = document.floats("SCALAR", &[0.0, 1.0]);
    let clip = &mut document.json["animations"][0];
    clip["samplers"].as_array_mut().unwrap().push(json!({"input": input, "output": all}));
    let named = json!({"sampler": 1, "target": {"node": 0, "path": "weights"}});
    clip["channels"].as_array_mut().unwrap().push(named);
    assert!(document.error(65).contains("another channel"));
}

#[test]
fn hidden_nodes_hide_what_is_below_but_not_the_camera() {
    let mut document = animatable();
    let switch = document.accessor(5121, "SCALAR", 2, &[1, 0]);
    animate_with(&mut document, "/nodes/0/extensions/KHR_node_visibility/visible", "STEP", switch);
    let scene = document.import().unwrap();
    let hidden = |time| frame(&scene, time).flags[0].has(crate::bvh::TriangleFlags::HIDDEN);
    assert!(!hidden(0.5) && hidden(1.0));
    assert_eq!((frame(&scene, 0.5).lights.len(), frame(&scene, 1.0).lights.len()), (1, 0));
    assert_eq!(frame(&scene, 0.5).camera, frame(&scene, 1.0).camera);
    // Hidden without animation, and an invalid value.
    let mut document = animatable();
    document.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(false);
    assert!(frame(&document.import().unwrap(), 0.0).lights.is_empty());
    document.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(0);
    assert!(document.error(65).contains("/nodes/0/extensions/KHR_node_visibility/visible"));
}

/// Triangle with three instances: translated, rotated and scaled.
fn instanced() -> Document {
    let mut document = Document::triangle();
    let translation = document.floats("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let half = (i16::MAX as f32 * std::f32::consts::FRAC_1_SQRT_2) as i16;
    let turns = [[0, 0, 0, i16::MAX], [0, 0, half, half], [0, 0, 0, i16::MAX]];
    let bytes: Vec<u8> = turns.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let rotation = document.accessor(5122, "VEC4", 3, &bytes);
    document.json["accessors"][rotation]["normalized"] = json!(true);
    let scale = document.floats("VEC3", &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -2.0, 1.0, 1.0]);
    let attributes = json!({"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale});
    document.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    document.json["nodes"][0]["translation"] = json!([0, 0, 7]);
    document
}

fn attributes(document: &mut Document) -> &mut Value {
    &mut document.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
}

#[test]
fn instances_take_the_place_of_the_mesh() {
    let scene = instanced().import().unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let frame = frame(&scene, 0.0);
    // The node translates by 7 along z. (1, 0, 0) is the second vertex.
    assert_eq!((frame.triangles.len(), frame.instances.len()), (3, 3));
    assert_eq!(frame.triangles[0].vertices[1], Vec3::new(1.0, 0.0, 7.0));
    // Rotated by 90° about z, then translated by 5 along x.
    assert!(frame.triangles[1].vertices[1].abs_diff_eq(Vec3::new(5.0, 1.0, 7.0), 1e-4));
    // Mirrored: the last two vertices are swapped.
    assert_eq!(frame.triangles[2].vertices[2], Vec3::new(-2.0, 0.0, 7.0));
    assert!(frame.instances[2].mirrored && !frame.instances[1].mirrored);
    assert_eq!(frame.instances.iter().map(|instance| instance.node_instance).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(frame.instances[2].mesh, MeshIndex(0));
}

#[test]
fn wrong_instances_name_their_place() {
    let mut document = instanced();
    let two = document.floats("VEC3", &[0.0; 6]);
    attributes(&mut document)["SCALE"] = json!(two);
    assert!(document.error(65).contains("/attributes/SCALE"), "counts differ");
    let mut document = instanced();
    let zeros = document.floats("VEC4", &[0.0; 12]);
    attributes(&mut document)["ROTATION"] = json!(zeros);
    assert!(document.error(65).contains("length zero"));
    let mut document = instanced();
    *attributes(&mut document) = json!({});
    assert!(document.error(65).contains("must not be empty"));
    // The instances of one triangle exceed the memory limit.
    let mut document = Document::triangle();
    let many = json!({"componentType": 5126, "type": "VEC3", "count": 100_000_000});
    let many = document.push("accessors", many);
    document.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": many}}});
    assert!(document.error(77).contains("--max-memory"));
    // Each instance takes its own memory besides its matrix and triangle: 20 000 · (12 + 64 + 160 + 256) B.
    let mut document = Document::triangle();
    let often = document.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 20_000}));
    document.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": often}}});
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document.to_json().to_string()).unwrap();
    let within =
        |max_memory_bytes| import(&path, &ImportOptions { max_memory_bytes, ..ImportOptions::default() });
    assert!(within(12_000_000).is_ok());
    assert!(within(7_000_000).unwrap_err().to_string().contains("/scenes/0"));
}
