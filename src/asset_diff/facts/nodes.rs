//! Nodes by their paths, and skins.

use glam::Vec4;

use crate::asset_diff::group_kind::GroupKind;
use crate::asset_diff::item::Item;
use crate::asset_diff::value::Value;
use crate::scene::{
    CameraIndex, DecomposedMatrix, LightIndex, LocalTransform, MeshIndex, Node, NodeIndex, Scene,
};

/// The property of a node that stands in no scene of the file, so that nothing shows it.
pub(in crate::asset_diff) const IN_NO_SCENE: &str = "in no scene";
/// Bytes of a path to which no more names are added.
const LONGEST_PATH: usize = 1024;

/// Nodes in the order of the file. Their names are paths, such as `Robot/Arm`.
pub(super) fn nodes(scene: &Scene) -> Vec<Item> {
    let (paths, standing) = (paths(scene), scene.nodes_of_scenes());
    let item = |(index, (node, path)): (u32, (&Node, &String))| {
        let draws = node.mesh.is_some_and(|mesh| has_triangles(scene, mesh));
        let stands = standing.contains(&NodeIndex(index));
        let mut item = Item {
            name: path.clone(),
            is_named: node.name.is_some(),
            alias: Some(node.name.clone().unwrap_or_else(|| path.clone())),
            is_content: draws && stands,
            properties: Vec::new(),
        };
        describe(&mut item, scene, node, &paths);
        if !stands {
            item.set(IN_NO_SCENE, Value::Flag(true));
        }
        item
    };
    (0..).zip(scene.nodes.iter().zip(&paths)).map(item).collect()
}

/// Skins with the names of their joints.
pub(super) fn skins(scene: &Scene) -> Vec<Item> {
    let paths = paths(scene);
    let item = |(index, skin): (usize, &crate::scene::Skin)| {
        let mut item = Item::new(skin.name.as_deref(), index);
        let holder = scene.holder_name(|node| node.skin.is_some_and(|skin| skin.index() == index));
        item.alias = holder.map(ToOwned::to_owned);
        let mut names: Vec<_> = skin.joints.iter().map(|joint| node_name(scene, *joint, &paths)).collect();
        names.sort();
        item.set("joints", Value::count(names.len()));
        item.set("joint names", Value::List(names));
        item
    };
    scene.skins.iter().enumerate().map(item).collect()
}

/// The name of a node, or its path without one.
pub(super) fn node_name(scene: &Scene, node: NodeIndex, paths: &[String]) -> String {
    let own = scene.nodes.get(node.index()).and_then(|node| node.name.clone());
    own.or_else(|| paths.get(node.index()).cloned()).unwrap_or_default()
}

/// The path of each node: names from its root to it, or from a node on the way after `…`, so that paths of deep hierarchies stay short. For a node without a name stands its number among its siblings, such as `[0]`.
pub(super) fn paths(scene: &Scene) -> Vec<String> {
    let mut paths = vec![String::new(); scene.nodes.len()];
    let mut numbers = vec![0; scene.nodes.len()];
    let mut roots = 0..;
    for &index in &scene.node_order {
        let Some(node) = scene.nodes.get(index.index()) else { continue };
        for (number, child) in node.children.iter().enumerate() {
            numbers[child.index()] = number;
        }
        if node.parent.is_none() {
            numbers[index.index()] = roots.next().unwrap_or_default();
        }
        let own = node.name.clone().unwrap_or_else(|| format!("[{}]", numbers[index.index()]));
        paths[index.index()] = match node.parent.map(|parent| &paths[parent.index()]) {
            Some(parent) if parent.len() > LONGEST_PATH => format!("…/{own}"),
            Some(parent) => format!("{parent}/{own}"),
            None => own,
        };
    }
    paths
}

fn has_triangles(scene: &Scene, mesh: MeshIndex) -> bool {
    scene.meshes.get(mesh.index()).is_some_and(|mesh| mesh.triangle_count() > 0)
}

fn describe(item: &mut Item, scene: &Scene, node: &Node, paths: &[String]) {
    if let Some(parent) = node.parent {
        item.set("parent", Value::Text(node_name(scene, parent, paths)));
    }
    transform(item, &node.local);
    if let Some(mesh) = node.mesh {
        let name = scene.meshes.get(mesh.index()).and_then(|mesh| mesh.name.as_deref());
        item.set("mesh", Value::item(GroupKind::Meshes, mesh.index(), name));
    }
    if let Some(skin) = node.skin {
        let name = scene.skins.get(skin.index()).and_then(|skin| skin.name.as_deref());
        item.set("skin", Value::item(GroupKind::Skins, skin.index(), name));
    }
    if let Some(camera) = node.camera {
        let name = scene.camera_name(CameraIndex(camera.0));
        item.set("camera", Value::item(GroupKind::Cameras, camera.index(), name));
    }
    if let Some(light) = node.light {
        let name = scene.light_name(LightIndex(light.0));
        item.set("light", Value::item(GroupKind::Lights, light.index(), name));
    }
    if let Some(instances) = &node.instances {
        item.set("instances", Value::count(instances.len()));
        if !node.instance_colors.is_empty() {
            let mean = node.instance_colors.iter().sum::<Vec4>() / node.instance_colors.len() as f32;
            item.set("mean color of instances", Value::Vector(mean.to_array().to_vec()));
        }
    }
    if let Some(weights) = &node.weights {
        item.set("morph weights", Value::Vector(weights.clone()));
    }
    if node.is_hidden {
        item.set("hidden", Value::Flag(true));
    }
}

/// Translation, rotation and scale; a matrix that shears as it is.
fn transform(item: &mut Item, local: &LocalTransform) {
    let (scale, rotation, translation) = match local {
        LocalTransform::Trs { translation, rotation, scale } => (*scale, *rotation, *translation),
        LocalTransform::Matrix(matrix) => {
            let parts = DecomposedMatrix::new(matrix);
            if parts.has_shear {
                return item.set("matrix", Value::Vector(matrix.to_cols_array().to_vec()));
            }
            (parts.scale, parts.rotation, parts.translation)
        }
    };
    item.set("translation", Value::Vector(translation.to_array().to_vec()));
    item.set("rotation", Value::Rotation(rotation.to_array()));
    item.set("scale", Value::Vector(scale.to_array().to_vec()));
}
