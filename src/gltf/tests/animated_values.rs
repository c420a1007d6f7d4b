//! Keyframe values that break a rule for the values in the file itself: the same rule, with the same message.

use serde_json::{Value, json};

use super::Document;
use super::pointers::{animatable, animate};
use super::properties::frame;
use crate::scene::{Projection, Scene};

const SPOT: &str = "/extensions/KHR_lights_punctual/lights/0/spot";

/// The pointers and messages of all warnings.
fn warnings(scene: &Scene) -> Vec<(&str, &str)> {
    scene.warnings.iter().map(|warning| (warning.pointer.as_str(), warning.message.as_str())).collect()
}

/// Adds the only channel of the last animation to the first.
fn join_last(document: &mut Document) {
    let animations = document.json["animations"].as_array_mut().unwrap();
    let mut last = animations.pop().unwrap();
    last["channels"][0]["sampler"] = json!(animations[0]["samplers"].as_array().unwrap().len());
    for list in ["channels", "samplers"] {
        animations[0][list].as_array_mut().unwrap().push(last[list][0].take());
    }
}

#[test]
fn an_animated_index_below_one_is_told_as_a_static_one() {
    let message = "is 0.5, but must be 0 or at least 1; it is taken for 1";
    let pointer = "/materials/0/extensions/KHR_materials_ior/ior";
    let mut document = animatable();
    document.json["materials"][0]["extensions"] = json!({"KHR_materials_ior": {"ior": 0.5}});
    assert_eq!(warnings(&document.import().unwrap()), [(pointer, message)]);
    // Told once, of the first. 0 is none of them.
    document.json["materials"][0]["extensions"] = json!({"KHR_materials_ior": {"ior": 1.5}});
    animate(&mut document, pointer, "CUBICSPLINE", "SCALAR", &[0.7, 0.5, 0.7, 0.7, 0.25, 0.7]);
    animate(&mut document, pointer, "LINEAR", "SCALAR", &[0.0, 1.0]);
    let scene = document.import().unwrap();
    assert_eq!(warnings(&scene), [("/animations/0/samplers/0/output", message)]);
    assert_eq!(frame(&scene, 0.5).materials[0].ior, 1.0);
}

#[test]
fn an_animated_attenuation_distance_of_0_is_infinite() {
    let mut document = animatable();
    let volume = json!({"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.5, 1, 1]});
    document.json["materials"][1]["extensions"]["KHR_materials_volume"] = volume;
    let pointer = "/materials/1/extensions/KHR_materials_volume/attenuationDistance";
    animate(&mut document, pointer, "LINEAR", "SCALAR", &[0.0, 4.0]);
    let scene = document.import().unwrap();
    let message = "is 0, but must be greater; it is taken for infinite";
    assert_eq!(warnings(&scene), [("/animations/0/samplers/0/output", message)]);
    let distance = |time| frame(&scene, time).materials[1].volume.unwrap().attenuation_distance;
    assert_eq!((distance(0.0), distance(1.0)), (f32::INFINITY, 4.0));
    // No absorption up to the key of 4.
    assert!(distance(0.99) > 1e30);
}

#[test]
fn animated_lights_are_told_as_static_ones() {
    let light = "/extensions/KHR_lights_punctual/lights/0";
    let mut document = animatable();
    animate(&mut document, &format!("{light}/intensity"), "LINEAR", "SCALAR", &[-3.0, 5.0]);
    animate(&mut document, &format!("{light}/color"), "LINEAR", "VEC3", &[1.0, 0.5, 0.0, 4.0, 1.0, 0.0]);
    let scene = document.import().unwrap();
    let expected = [
        ("/animations/0/samplers/0/output", "is -3, and light cannot be negative; the lamp is off"),
        (
            "/animations/1/samplers/0/output",
            "has values outside 0 to 1, such as 4; they are used as they are",
        ),
    ];
    assert_eq!(warnings(&scene), expected);
}

#[test]
fn animated_cones_in_the_wrong_order_are_told_as_static_ones() {
    let message = |inner: f32, outer: f32| {
        format!(
            "the inner cone, {inner}, must not be wider than the outer, {outer}; the edge of the light is hard"
        )
    };
    let of_spot = |spot: Value| {
        let mut document = animatable();
        document.json["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"] = spot;
        document
    };
    let scene = of_spot(json!({"innerConeAngle": 0.5, "outerConeAngle": 0.25})).import().unwrap();
    assert_eq!(warnings(&scene), [(SPOT, message(0.5, 0.25).as_str())]);

    // One is animated, and the other in the file.
    for (key, values) in [("innerConeAngle", [0.25, 0.75]), ("outerConeAngle", [0.75, 0.25])] {
        let mut document = of_spot(json!({"innerConeAngle": 0.5, "outerConeAngle": 0.5}));
        animate(&mut document, &format!("{SPOT}/{key}"), "LINEAR", "SCALAR", &values);
        let scene = document.import().unwrap();
        let expected = if key == "innerConeAngle" { message(0.75, 0.5) } else { message(0.5, 0.25) };
        assert_eq!(warnings(&scene), [("/animations/0/samplers/0/output", expected.as_str())]);
    }
    // Both are animated, and cross at the end: told once.
    let both_animated = |inner: [f32; 2], interpolation| {
        let mut document = of_spot(json!({}));
        animate(&mut document, &format!("{SPOT}/innerConeAngle"), interpolation, "SCALAR", &inner);
        animate(&mut document, &format!("{SPOT}/outerConeAngle"), "LINEAR", "SCALAR", &[1.0, 0.5]);
        join_last(&mut document);
        document.import().unwrap()
    };
    let scene = both_animated([0.25, 0.75], "LINEAR");
    assert_eq!(warnings(&scene), [("/animations/0/samplers/0/output", message(0.75, 0.5).as_str())]);
    // Equal cones are a hard edge.
    assert_eq!(warnings(&both_animated([1.0, 0.5], "LINEAR")), []);
    assert_eq!(warnings(&both_animated([0.25, 0.5], "STEP")), []);
}

#[test]
fn cones_of_two_animations_are_not_compared_in_either_order() {
    // The inner cone of an animation is wider than the outer one in the file, which another animation makes wider still.
    for order in [["innerConeAngle", "outerConeAngle"], ["outerConeAngle", "innerConeAngle"]] {
        let mut document = animatable();
        document.json["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"] =
            json!({"innerConeAngle": 0.25, "outerConeAngle": 0.5});
        for key in order {
            let end = if key == "innerConeAngle" { 0.75 } else { 1.0 };
            animate(&mut document, &format!("{SPOT}/{key}"), "LINEAR", "SCALAR", &[0.5, end]);
        }
        assert_eq!(warnings(&document.import().unwrap()), [], "{order:?}");
        // Two animations of the inner cone are both compared with the file.
        document.json["animations"].as_array_mut().unwrap().retain(|animation| {
            let target = &animation["channels"][0]["target"]["extensions"]["KHR_animation_pointer"];
            target["pointer"].as_str().unwrap().ends_with("innerConeAngle")
        });
        animate(&mut document, &format!("{SPOT}/innerConeAngle"), "LINEAR", "SCALAR", &[0.5, 0.625]);
        let scene = document.import().unwrap();
        let told: Vec<&str> = warnings(&scene).iter().map(|(pointer, _)| *pointer).collect();
        assert_eq!(told, ["/animations/0/samplers/0/output", "/animations/1/samplers/0/output"]);
    }
}

#[test]
fn cones_are_compared_at_the_keys_of_either() {
    // The outer cone is 0.5 at half time, where the inner has a key of 0.75.
    let mut document = animatable();
    animate(&mut document, &format!("{SPOT}/outerConeAngle"), "LINEAR", "SCALAR", &[1.0, 0.0]);
    animate(&mut document, &format!("{SPOT}/innerConeAngle"), "LINEAR", "SCALAR", &[0.0, 0.0]);
    let times = document.floats("SCALAR", &[0.0, 0.5, 1.0]);
    let values = document.floats("SCALAR", &[0.0, 0.75, 0.0]);
    document.json["animations"][1]["samplers"][0] = json!({"input": times, "output": values});
    join_last(&mut document);
    let scene = document.import().unwrap();
    let [(_, message)] = warnings(&scene)[..] else { panic!("{:?}", scene.warnings) };
    assert!(message.contains("the inner cone, 0.75, must not be wider than the outer, 0.5;"), "{message}");
}

#[test]
fn animated_planes_in_the_wrong_order_are_refused_as_static_ones() {
    let perspective = |near: f32, far: f32| {
        let mut document = animatable();
        document.json["cameras"][0]["perspective"] = json!({"yfov": 1, "znear": near, "zfar": far});
        document
    };
    let message = "zfar is 2, but must be greater than znear, 2";
    let error = perspective(2.0, 2.0).error(65);
    assert!(error.contains(&format!("/cameras/0/perspective: {message}")), "{error}");
    for (key, values) in [("zfar", [4.0, 2.0]), ("znear", [1.0, 8.0])] {
        let mut document = perspective(if key == "zfar" { 2.0 } else { 1.0 }, 8.0);
        animate(&mut document, &format!("/cameras/0/perspective/{key}"), "STEP", "SCALAR", &values);
        let expected = if key == "zfar" { message } else { "zfar is 8, but must be greater than znear, 8" };
        let error = document.error(65);
        assert!(error.contains(&format!("/animations/0/samplers/0/output: {expected}")), "{error}");
    }
    // Both move together, in two animations or in one.
    let mut document = perspective(1.0, 2.0);
    animate(&mut document, "/cameras/0/perspective/znear", "LINEAR", "SCALAR", &[1.0, 8.0]);
    animate(&mut document, "/cameras/0/perspective/zfar", "LINEAR", "SCALAR", &[2.0, 9.0]);
    assert_eq!(warnings(&document.import().unwrap()), []);
    join_last(&mut document);
    assert_eq!(warnings(&document.import().unwrap()), []);
    // The near plane jumps too late.
    let mut document = perspective(1.0, 10.0);
    animate(&mut document, "/cameras/0/perspective/znear", "STEP", "SCALAR", &[4.0, 0.5]);
    animate(&mut document, "/cameras/0/perspective/zfar", "LINEAR", "SCALAR", &[10.0, 2.0]);
    join_last(&mut document);
    assert!(document.error(65).contains("must be greater than znear, 4"));
}

#[test]
fn animated_negative_magnifications_are_positive_and_zero_is_refused() {
    let orthographic = |x: f32| {
        let mut document = animatable();
        document.json["cameras"][0] = json!({
            "type": "orthographic", "orthographic": {"xmag": x, "ymag": 1, "znear": 0, "zfar": 9}
        });
        document
    };
    let message = "negative magnifications of orthographic cameras are taken as positive";
    let scene = orthographic(-2.0).import().unwrap();
    assert_eq!(warnings(&scene), [("/cameras/0/orthographic", message)]);
    let zero = "is 0, but must be a finite number above 0";
    assert!(orthographic(0.0).error(65).contains(&format!("/cameras/0/orthographic/xmag: {zero}")));

    let animated = |interpolation, values: &[f32]| {
        let mut document = orthographic(1.0);
        animate(&mut document, "/cameras/0/orthographic/xmag", interpolation, "SCALAR", values);
        document
    };
    assert!(animated("LINEAR", &[1.0, 0.0]).error(65).contains(zero));
    // The second key is −4 with an in-tangent of −8: half way from 2, 1/2 · 2 + 1/2 · 4 − 1/8 · 8 = 2.
    for (interpolation, values, middle) in [
        ("LINEAR", &[-2.0, -4.0][..], 3.0),
        ("LINEAR", &[2.0, -4.0], 3.0),
        ("CUBICSPLINE", &[0.0, 2.0, 0.0, -8.0, -4.0, 0.0], 2.0),
    ] {
        let scene = animated(interpolation, values).import().unwrap();
        assert_eq!(warnings(&scene), [("/animations/0/samplers/0/output", message)]);
        let Projection::Orthographic { x_mag, .. } = frame(&scene, 0.5).camera.projection else {
            panic!("orthographic")
        };
        assert_eq!(x_mag, middle, "{values:?}");
    }
}
