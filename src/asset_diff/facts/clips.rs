//! Animation clips.

use crate::asset_diff::item::Item;
use crate::asset_diff::value::Value;
use crate::scene::{Animation, AnimationTarget, NodeIndex, Scene};

use super::nodes::{node_name, paths};

/// Clips with what they move.
pub(super) fn clips(scene: &Scene) -> Vec<Item> {
    let paths = paths(scene);
    let item = |(index, clip): (usize, &Animation)| {
        let mut item = Item { is_content: true, ..Item::new(clip.name.as_deref(), index) };
        let keyframes = clip.channels.iter().map(|channel| channel.keyframes.times_seconds.len()).sum();
        let mut targets: Vec<_> =
            clip.channels.iter().map(|channel| target_text(scene, channel.target, &paths)).collect();
        targets.sort();
        item.set("duration", Value::Number(clip.duration_seconds(), "s"));
        item.set("channels", Value::count(clip.channels.len()));
        item.set("keyframes", Value::count(keyframes));
        item.set("moves", Value::Flag(clip.moves()));
        item.set("targets", Value::List(targets));
        let ignored = scene.ignored_channels.get(index).copied().unwrap_or(0);
        if ignored > 0 {
            item.set("channels without support", Value::count(ignored));
        }
        item
    };
    scene.animations.iter().enumerate().map(item).collect()
}

/// What a channel moves, by the names of things.
fn target_text(scene: &Scene, target: AnimationTarget, paths: &[String]) -> String {
    let of_node = |node: NodeIndex, what: &str| format!("{} {what}", node_name(scene, node, paths));
    let named = |kind: &str, name: Option<&str>, index: usize| match name {
        Some(name) => format!("{kind} {name}"),
        None => format!("{kind} #{index}"),
    };
    let mesh =
        |index: usize| named("mesh", scene.meshes.get(index).and_then(|mesh| mesh.name.as_deref()), index);
    match target {
        AnimationTarget::Translation(node) => of_node(node, "translation"),
        AnimationTarget::Rotation(node) => of_node(node, "rotation"),
        AnimationTarget::Scale(node) => of_node(node, "scale"),
        AnimationTarget::Weights(node) => of_node(node, "weights"),
        AnimationTarget::Visibility(node) => of_node(node, "visibility"),
        AnimationTarget::Weight(node, target) => of_node(node, &format!("weight {target}")),
        AnimationTarget::MeshWeights(index) => format!("{} weights", mesh(index.index())),
        AnimationTarget::MeshWeight(index, target) => format!("{} weight {target}", mesh(index.index())),
        AnimationTarget::Material(index, property) => {
            let name = scene.materials.get(index.index()).and_then(|material| material.name.as_deref());
            format!("{} {property:?}", named("material", name, index.index()))
        }
        AnimationTarget::Light(index, property) => {
            format!("{} {property:?}", named("light", scene.light_name(index), index.index()))
        }
        AnimationTarget::Camera(index, property) => {
            format!("{} {property:?}", named("camera", scene.camera_name(index), index.index()))
        }
        AnimationTarget::ImageLight(index, property) => {
            let name = scene.image_lights.get(index.index()).and_then(|light| light.name.as_deref());
            format!("{} {property:?}", named("image-based light", name, index.index()))
        }
    }
}
