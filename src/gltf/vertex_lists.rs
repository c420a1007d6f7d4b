//! All vertex lists of a primitive at once.

use glam::{Vec2, Vec4};

use crate::scene::{Primitive, SkinInfluences};

/// Replaces the vertices of `primitive` with the old vertices at the indices `sources`. Triangles are not changed.
pub(super) fn gather_vertices(primitive: &mut Primitive, sources: &[u32]) {
    gather(&mut primitive.positions, sources);
    primitive.normals.iter_mut().for_each(|list| gather(list, sources));
    primitive.tangents.iter_mut().for_each(|list| gather(list, sources));
    primitive.colors.iter_mut().for_each(|list| gather(list, sources));
    primitive.uvs.iter_mut().for_each(|list| gather(list, sources));
    if let Some(SkinInfluences { per_vertex, joints, weights }) = &mut primitive.influences {
        gather_groups(joints, *per_vertex, sources);
        gather_groups(weights, *per_vertex, sources);
    }
    for target in &mut primitive.targets {
        target.positions.iter_mut().for_each(|list| gather(list, sources));
        target.normals.iter_mut().for_each(|list| gather(list, sources));
        target.tangents.iter_mut().for_each(|list| gather(list, sources));
        target.colors.iter_mut().for_each(|list| gather(list, sources));
        target.uvs.iter_mut().for_each(|(_, list)| gather(list, sources));
    }
}

fn gather<T: Copy>(list: &mut Vec<T>, sources: &[u32]) {
    gather_groups(list, 1, sources);
}

fn gather_groups<T: Copy>(list: &mut Vec<T>, size: usize, sources: &[u32]) {
    let group = |&source: &u32| {
        let start = (source as usize).saturating_mul(size);
        list.get(start..start.saturating_add(size)).unwrap_or_default()
    };
    *list = sources.iter().flat_map(group).copied().collect();
}

/// Bytes per vertex of `primitive`, rounded up.
pub(super) fn vertex_bytes(primitive: &Primitive) -> usize {
    let influences = primitive.influences.as_ref().map_or(0, |i| i.per_vertex);
    let morphs = primitive.targets.iter().map(|target| {
        let vectors = [&target.positions, &target.normals, &target.tangents];
        let vector_bytes = vectors.iter().filter(|list| list.is_some()).count().saturating_mul(12);
        let color_bytes = if target.colors.is_some() { 16 } else { 0 };
        vector_bytes.saturating_add(color_bytes).saturating_add(target.uvs.len().saturating_mul(8))
    });
    morphs
        .sum::<usize>()
        .saturating_add(size_of::<[Vec4; 4]>())
        .saturating_add(primitive.uvs.len().saturating_mul(size_of::<Vec2>()))
        .saturating_add(influences.saturating_mul(8))
}
