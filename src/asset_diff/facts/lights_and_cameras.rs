//! Cameras and lights.

use std::collections::BTreeSet;

use crate::asset_diff::item::Item;
use crate::asset_diff::value::Value;
use crate::scene::{Camera, CameraIndex, ImageLight, Light, LightIndex, LightKind, Node, Projection, Scene};

/// Cameras. Those without a name have that of their node. A camera that stands in no scene is no content.
pub(super) fn cameras(scene: &Scene) -> Vec<Item> {
    let shown: BTreeSet<_> = standing_nodes(scene).filter_map(|node| node.camera).collect();
    let item = |(index, camera): (usize, &Camera)| {
        let own = CameraIndex(index as u32);
        let mut item = Item::new(scene.camera_name(own), index);
        item.alias = scene.holder_name(|node| node.camera == Some(own)).map(ToOwned::to_owned);
        item.is_content = shown.contains(&own);
        projection(&mut item, &camera.projection);
        item
    };
    scene.cameras.iter().enumerate().map(item).collect()
}

fn projection(item: &mut Item, projection: &Projection) {
    let metres = |value| Value::Number(value, "m");
    item.set("projection", Value::Text(projection.name().to_owned()));
    match *projection {
        Projection::Perspective { fov_y_radians, aspect_ratio, z_near, z_far } => {
            item.set("field of view", Value::degrees(fov_y_radians));
            if let Some(aspect_ratio) = aspect_ratio {
                item.set("aspect ratio", Value::number(aspect_ratio));
            }
            item.set("near", metres(z_near));
            item.set("far", metres(z_far.unwrap_or(f32::INFINITY)));
        }
        Projection::Orthographic { x_mag, y_mag, z_near, z_far } => {
            item.set("half width", metres(x_mag));
            item.set("half height", metres(y_mag));
            item.set("near", metres(z_near));
            item.set("far", metres(z_far));
        }
    }
}

/// The nodes that stand in a scene.
fn standing_nodes(scene: &Scene) -> impl Iterator<Item = &Node> {
    scene.nodes_of_scenes().into_iter().filter_map(|node| scene.nodes.get(node.index()))
}

/// Punctual lights. Those without a name have that of their node. A light that stands in no scene is no content.
pub(super) fn lights(scene: &Scene) -> Vec<Item> {
    let shown: BTreeSet<_> = standing_nodes(scene).filter_map(|node| node.light).collect();
    let item = |(index, light): (usize, &Light)| {
        let own = LightIndex(index as u32);
        let mut item = Item::new(scene.light_name(own), index);
        item.alias = scene.holder_name(|node| node.light == Some(own)).map(ToOwned::to_owned);
        item.is_content = shown.contains(&own);
        let unit = if light.kind == LightKind::Directional { "lx" } else { "cd" };
        item.set("kind", Value::Text(light.kind.name().to_owned()));
        item.set("color", Value::Vector(light.color.to_array().to_vec()));
        item.set("intensity", Value::Number(light.intensity, unit));
        item.set("range", Value::Number(light.range.unwrap_or(f32::INFINITY), "m"));
        if let LightKind::Spot { inner_cone_radians, outer_cone_radians } = light.kind {
            item.set("inner cone", Value::degrees(inner_cone_radians));
            item.set("outer cone", Value::degrees(outer_cone_radians));
        }
        item
    };
    scene.lights.iter().enumerate().map(item).collect()
}

/// Image-based lights. One that no scene asks for is no content.
pub(super) fn image_lights(scene: &Scene) -> Vec<Item> {
    let item = |(index, light): (usize, &ImageLight)| {
        let mut item = Item::new(light.name.as_deref(), index);
        let is_used = |light: crate::scene::ImageLightIndex| light.index() == index;
        item.is_content = scene.scenes.iter().any(|scene| scene.image_light.is_some_and(is_used));
        item.set("intensity", Value::number(light.intensity));
        item.set("rotation", Value::Rotation(light.rotation.to_array()));
        item.set("size", Value::Count(light.levels.first().map_or(0, |level| level.size.into())));
        item
    };
    scene.image_lights.iter().enumerate().map(item).collect()
}
