//! Meshes: lists of primitives and their shared morph weights.
//!
//! Source: glTF 2.0 specification, section 3.7.2 (geometry).

use gltf::json;
use gltf::json::validation::Checked;

use super::accessor::Data;
use super::context::Context;
use super::flat_volume;
use super::primitive::{import_primitive, unsupported_topology};
use super::raw::{ANY, Raw, check_range};
use super::vertex_lists::vertex_bytes;
use crate::error::Result;
use crate::scene::{Material, Mesh, Primitive};

/// Imports all meshes. The last of `materials` is the default material.
pub(super) fn import(context: &mut Context, data: &Data, materials: &[Material]) -> Result<Vec<Mesh>> {
    check_triangle_bytes(context, data)?;
    let meshes = data.document.root.meshes.iter().enumerate();
    meshes.map(|(i, mesh)| import_mesh(context, data, materials, i, mesh)).collect()
}

/// Refuses meshes whose triangle indices alone exceed the memory limit. Many primitives can share one accessor, so a
/// small file can require much memory.
fn check_triangle_bytes(context: &Context, data: &Data) -> Result<()> {
    const INDEX_BYTES: u64 = 4;
    let accessors = &data.document.root.accessors;
    let count = |index: usize| accessors.get(index).map_or(0, |accessor| accessor.count.0);
    let position = Checked::Valid(json::mesh::Semantic::Positions);
    let mut total: u64 = 0;
    for (i, mesh) in data.document.root.meshes.iter().enumerate() {
        for (j, primitive) in mesh.primitives.iter().enumerate() {
            let has_triangles =
                matches!(primitive.mode, Checked::Valid(mode) if unsupported_topology(mode).is_none());
            let positions = primitive.attributes.get(&position);
            let listed = primitive.indices.map(|indices| indices.value());
            let list = listed.or(positions.map(json::Index::value));
            if let Some(list) = list.filter(|_| has_triangles) {
                total = total.saturating_add(count(list).saturating_mul(INDEX_BYTES));
            }
            let needed = context.used_bytes().saturating_add(total);
            if needed > context.limit_bytes() {
                return Err(context.too_large(needed, &format!("/meshes/{i}/primitives/{j}")));
            }
        }
    }
    Ok(())
}

fn import_mesh(
    context: &mut Context,
    data: &Data,
    materials: &[Material],
    index: usize,
    mesh: &json::Mesh,
) -> Result<Mesh> {
    let pointer = format!("/meshes/{index}");
    if mesh.primitives.is_empty() {
        context.warn(format!("{pointer}/primitives"), "meshes without primitives are not rendered");
    }
    let mut primitives = Vec::new();
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let Some(raw) = Raw::at(&data.document.value, format!("{pointer}/primitives/{i}")) else {
            continue;
        };
        let used_before = context.used_bytes();
        let imported = import_primitive(context, data, materials, primitive, &raw)?;
        let kept = imported.as_ref().map_or(0, kept_bytes);
        context.release_temporaries(used_before, kept);
        context.keep(kept);
        primitives.extend(imported);
    }
    let target_count = primitives.first().map_or(0, |first: &Primitive| first.targets.len());
    if primitives.iter().any(|other| other.targets.len() != target_count) {
        let message = "all primitives of a mesh must have the same number of morph targets";
        return Err(context.invalid(format!("{pointer}/primitives"), message));
    }
    let weights = match &mesh.weights {
        Some(weights) => check_weights(context, weights, target_count, &primitives, &pointer)?,
        None => vec![0.0; target_count],
    };
    flat_volume::check(context, materials, &primitives, &pointer);
    Ok(Mesh { name: mesh.name.clone(), primitives, weights })
}

/// Checks that `weights` has `target_count` values. A mesh without primitives may have any number.
pub(super) fn check_weights(
    context: &Context,
    weights: &[f32],
    target_count: usize,
    primitives: &[Primitive],
    pointer: &str,
) -> Result<Vec<f32>> {
    let pointer = format!("{pointer}/weights");
    if primitives.is_empty() {
        return Ok(Vec::new());
    }
    if weights.len() != target_count {
        let message = format!("has {} weights for {target_count} morph targets", weights.len());
        return Err(context.invalid(pointer, message));
    }
    let finite = |&weight: &f32| check_range(context, weight, &ANY, &pointer);
    weights.iter().map(finite).collect()
}

fn kept_bytes(primitive: &Primitive) -> u64 {
    let vertices = (primitive.positions.len() as u64).saturating_mul(vertex_bytes(primitive) as u64);
    let triangles = (primitive.triangles.len() as u64).saturating_mul(size_of::<[u32; 3]>() as u64);
    vertices.saturating_add(triangles)
}
