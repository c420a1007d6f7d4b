//! Sizes and formats of a file's content as stored.

use std::collections::BTreeSet;

use gltf::json::Accessor;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use serde_json::Value;

use super::component::ElementLayout;
use super::document::Document;
use super::meshopt;
use super::raw::Raw;
use crate::scene::{FileStorage, StoredImage};

/// The storage of `document`, whose scene file and named files have `file_bytes`. `images` are the encoded images that are loaded.
pub(super) fn file_storage(document: &Document, file_bytes: u64, images: Vec<StoredImage>) -> FileStorage {
    let root = &document.root;
    let stored = root.buffers.iter().enumerate().filter(|(index, _)| !meshopt::is_fallback(document, *index));
    let keyframes = root.animations.iter().flat_map(|clip| &clip.samplers);
    let keyframes = keyframes.flat_map(|sampler| [sampler.input.value(), sampler.output.value()]);
    FileStorage {
        generator: root.asset.generator.clone(),
        file_bytes,
        buffer_bytes: stored.fold(0, |sum: u64, (_, buffer)| sum.saturating_add(buffer.byte_length.0)),
        geometry_bytes: accessors_bytes(document, geometry_accessors(document)),
        keyframe_bytes: accessors_bytes(document, keyframes.collect()),
        images,
        attributes: (0..root.meshes.len()).map(|mesh| attributes(document, mesh)).collect(),
    }
}

/// The JSON objects of the primitives of a mesh.
fn primitives<'a>(document: &'a Document, mesh: usize) -> impl Iterator<Item = &'a Value> + use<'a> {
    let mesh = document.element("meshes", mesh).and_then(|mesh: Raw<'a>| mesh.value.get("primitives"));
    mesh.and_then(Value::as_array).into_iter().flatten()
}

/// Accessors of vertices, morph targets and indices, each once.
fn geometry_accessors(document: &Document) -> BTreeSet<usize> {
    let mut accessors = BTreeSet::new();
    for primitive in (0..document.root.meshes.len()).flat_map(|mesh| primitives(document, mesh)) {
        let targets = primitive.get("targets").and_then(Value::as_array).into_iter().flatten();
        let lists = primitive.get("attributes").into_iter().chain(targets).filter_map(Value::as_object);
        let listed = lists.flat_map(|list| list.values()).chain(primitive.get("indices"));
        accessors.extend(listed.filter_map(Value::as_u64).map(|index| index as usize));
    }
    accessors
}

fn accessors_bytes(document: &Document, accessors: BTreeSet<usize>) -> u64 {
    let bytes = |index: usize| {
        let accessor = document.root.accessors.get(index)?;
        let (component, shape) = format_of(accessor)?;
        let element = ElementLayout::new(shape, component).packed_bytes as u64;
        Some(accessor.count.0.saturating_mul(element))
    };
    accessors.into_iter().filter_map(bytes).fold(0, u64::saturating_add)
}

/// The attributes of each primitive of a mesh, sorted by name.
fn attributes(document: &Document, mesh: usize) -> Vec<Vec<String>> {
    let named = |primitive: &Value| {
        let list = primitive.get("attributes").and_then(Value::as_object);
        let mut names: Vec<_> = list
            .into_iter()
            .flatten()
            .filter_map(|(name, accessor)| {
                let accessor = document.root.accessors.get(accessor.as_u64()? as usize)?;
                let (component, _) = format_of(accessor)?;
                let normalized = if accessor.normalized { " normalized" } else { "" };
                Some(format!("{name} {}{normalized}", component_name(component)))
            })
            .collect();
        names.sort();
        names
    };
    primitives(document, mesh).map(named).collect()
}

fn format_of(accessor: &Accessor) -> Option<(ComponentType, Type)> {
    match (accessor.component_type, accessor.type_) {
        (Checked::Valid(component), Checked::Valid(shape)) => Some((component.0, shape)),
        _ => None,
    }
}

fn component_name(component: ComponentType) -> &'static str {
    match component {
        ComponentType::I8 => "int8",
        ComponentType::U8 => "uint8",
        ComponentType::I16 => "int16",
        ComponentType::U16 => "uint16",
        ComponentType::U32 => "uint32",
        ComponentType::F32 => "float32",
    }
}
