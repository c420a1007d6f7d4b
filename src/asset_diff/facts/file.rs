//! The file as a whole: sizes, memory, extensions and scenes.

use std::collections::BTreeSet;

use crate::asset_diff::item::Item;
use crate::asset_diff::value::Value;
use crate::scene::{FileStorage, Scene};
use crate::sequence::triangle_count;

use super::textures::texture_memory_bytes;

/// Sizes of the file, and the memory that a viewer takes for it.
pub(super) fn file(scene: &Scene) -> Item {
    let FileStorage { generator, file_bytes, buffer_bytes, geometry_bytes, keyframe_bytes, images, .. } =
        &scene.storage;
    let texture_bytes = (0..scene.images.len()).map(|image| texture_memory_bytes(scene, image)).sum::<u64>();
    let roots = scene.scenes.get(scene.default_scene).map_or(&[][..], |scene| &scene.roots);
    let mut item = Item { name: "file".to_owned(), is_named: true, ..Item::default() };
    item.set("size", Value::Bytes(*file_bytes));
    item.set("buffers", Value::Bytes(*buffer_bytes));
    item.set("encoded images", Value::Bytes(images.iter().map(|image| image.bytes).sum()));
    item.set("memory", Value::Bytes(geometry_bytes + keyframe_bytes + texture_bytes));
    item.set("memory of geometry", Value::Bytes(*geometry_bytes));
    item.set("memory of keyframes", Value::Bytes(*keyframe_bytes));
    item.set("memory of textures", Value::Bytes(texture_bytes));
    item.set("rendered triangles", Value::Count(triangle_count(scene, roots)));
    item.set("vertices", Value::count(scene.meshes.iter().map(crate::scene::Mesh::vertex_count).sum()));
    item.set("textures without use", Value::count(scene.unused_textures));
    if let Some(generator) = generator {
        item.set("generator", Value::Text(generator.clone()));
    }
    item
}

/// Extensions, sorted by name.
pub(super) fn extensions(scene: &Scene) -> Vec<Item> {
    let named: BTreeSet<_> = scene.extensions_used.iter().chain(&scene.extensions_required).collect();
    let item = |(index, name): (usize, &String)| {
        let mut item = Item::new(Some(name), index);
        item.set("required", Value::Flag(scene.extensions_required.contains(name)));
        item
    };
    named.into_iter().enumerate().map(item).collect()
}

/// Sets of root nodes.
pub(super) fn scenes(scene: &Scene) -> Vec<Item> {
    let item = |(index, roots): (usize, &crate::scene::SceneRoots)| {
        let mut item = Item::new(roots.name.as_deref(), index);
        item.set("default", Value::Flag(index == scene.default_scene));
        item.set("root nodes", Value::count(roots.roots.len()));
        item.set("triangles", Value::Count(triangle_count(scene, &roots.roots)));
        item
    };
    scene.scenes.iter().enumerate().map(item).collect()
}
