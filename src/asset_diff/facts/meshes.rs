//! Meshes and their primitives.

use crate::asset_diff::group_kind::GroupKind;
use crate::asset_diff::item::Item;
use crate::asset_diff::value::Value;
use crate::scene::{Mesh, Primitive, Scene};

/// Meshes. Those without a name go by the node that holds them.
pub(super) fn meshes(scene: &Scene) -> Vec<Item> {
    // Of several holders the first.
    let mut holders = vec![None; scene.meshes.len()];
    for node in scene.nodes.iter().rev() {
        if let Some(mesh) = node.mesh {
            holders[mesh.index()] = node.name.as_deref();
        }
    }
    let items = scene.meshes.iter().zip(holders).enumerate();
    items.map(|(index, (item, holder))| mesh(scene, index, (item, holder))).collect()
}

fn mesh(scene: &Scene, index: usize, (mesh, holder): (&Mesh, Option<&str>)) -> Item {
    let mut item = Item::new(mesh.name.as_deref(), index);
    item.alias = holder.map(ToOwned::to_owned);
    item.set("primitives", Value::count(mesh.primitives.len()));
    item.set("vertices", Value::count(mesh.vertex_count()));
    item.set("triangles", Value::count(mesh.triangle_count()));
    item.set("morph targets", Value::count(mesh.morph_target_count()));
    if !mesh.weights.is_empty() {
        item.set("morph weights", Value::Vector(mesh.weights.clone()));
    }
    // Points and lines are stored and not imported; then there is no telling which primitive has which attributes.
    let stored = scene.storage.attributes.get(index).filter(|stored| stored.len() == mesh.primitives.len());
    for (number, part) in mesh.primitives.iter().enumerate() {
        let attributes = stored.and_then(|stored| stored.get(number));
        let prefix = if mesh.primitives.len() == 1 { String::new() } else { format!("primitive {number} ") };
        if mesh.primitives.len() > 1 {
            item.set(format!("{prefix}vertices"), Value::count(part.positions.len()));
            item.set(format!("{prefix}triangles"), Value::count(part.triangles.len()));
        }
        primitive(&mut item, &prefix, scene, part);
        if let Some(attributes) = attributes {
            item.set(format!("{prefix}attributes"), Value::List(attributes.clone()));
        }
    }
    item
}

fn primitive(item: &mut Item, prefix: &str, scene: &Scene, primitive: &Primitive) {
    let material = |index: crate::scene::MaterialIndex| {
        let is_default = index.index() + 1 == scene.materials.len();
        let name = scene.materials.get(index.index()).and_then(|material| material.name.as_deref());
        let name = name.or_else(|| is_default.then_some("default"));
        Value::item(GroupKind::Materials, index.index(), name)
    };
    item.set(format!("{prefix}material"), material(primitive.material));
    for (variant, replacement) in &primitive.variants {
        if let Some(variant) = scene.variants.get(variant.index()) {
            item.set(format!("{prefix}material of {}", variant.name), material(*replacement));
        }
    }
}
