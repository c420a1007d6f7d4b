//! Tangents for normal-mapped primitives without stored tangents.
//!
//! Source: Morten S. Mikkelsen, *Simulation of Wrinkled Surfaces Revisited* (2008), as implemented by the crate
//! `bevy_mikktspace`. Its arc cosine is replaced by that of `libm`, so that tangents are the same on every machine.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::context::Context;
use super::normals::{face_normal, normalize_tangents};
use super::tangent_faces::corner_tangents;
use super::vertex_lists::{gather_vertices, vertex_bytes};
use crate::error::Result;
use crate::scene::{MorphTarget, Primitive};

/// Memory that MikkTSpace takes for a triangle, as measured: 350 bytes in large meshes, up to 560 where triangles share no vertices.
const WORKING_BYTES_PER_TRIANGLE: u64 = 560;

/// Computes MikkTSpace tangents of `primitive` from its texture coordinate set `uv_set`. Vertices are split where the
/// tangents of their triangles differ. Without vertex normals the face normals are used. Morph targets without stored tangents
/// get deltas of their own.
pub(super) fn generate(
    context: &mut Context,
    primitive: &mut Primitive,
    uv_set: usize,
    pointer: &str,
) -> Result<()> {
    let Some(uvs) = primitive.uvs.get(uv_set) else {
        return Ok(());
    };
    let triangles = primitive.triangles.len() as u64;
    let tangent_bytes = triangles.saturating_mul(size_of::<[Vec4; 3]>() as u64);
    let used_before = context.used_bytes();
    context.charge(tangent_bytes, pointer)?;
    context.charge(triangles.saturating_mul(WORKING_BYTES_PER_TRIANGLE), pointer)?;
    let corner_tangents = corner_tangents(primitive, uvs)
        .map_err(|error| context.invalid(pointer, format!("tangents cannot be computed: {error}")))?;
    context.release_temporaries(used_before, tangent_bytes);
    let corner_bytes = vertex_bytes(primitive) as u64;
    context.charge(triangles.saturating_mul(3).saturating_mul(corner_bytes), pointer)?;
    split_vertices(primitive, &corner_tangents);
    add_morph_deltas(context, primitive, uv_set, pointer)
}

/// Gives morph targets the deltas of generated tangents, so that the tangents follow the surface.
///
/// A tangent is the direction in which u grows, and ∂P/∂u of a triangle is linear in its positions. The delta of a vertex is
/// Σ ∂ΔP/∂u / Σ |∂P/∂u| over its triangles, weighted by their area in the texture: exact where the triangles agree, at any weight and
/// for sums of targets. Vertices that MikkTSpace takes for one have the triangles of all, as far as the target keeps them together.
fn add_morph_deltas(
    context: &mut Context,
    primitive: &mut Primitive,
    uv_set: usize,
    pointer: &str,
) -> Result<()> {
    let moves_tangents = |target: &&mut MorphTarget| target.positions.is_some() && target.tangents.is_none();
    if primitive.targets.iter_mut().all(|target| !moves_tangents(&target)) {
        return Ok(());
    }
    let shared = SharedVertices::new(primitive, uv_set);
    let Primitive { positions, triangles, uvs, targets, .. } = primitive;
    let Some(uvs) = uvs.get(uv_set) else { return Ok(()) };
    for target in targets.iter_mut().filter(moves_tangents) {
        context.charge((positions.len() as u64).saturating_mul(size_of::<Vec3>() as u64), pointer)?;
        let Some(moves) = &target.positions else { continue };
        let first_of = shared.moved_by(moves);
        let first_of = |vertex: u32| first_of.get(vertex as usize).map_or(0, |&first| first as usize);
        let mut sums = vec![(Vec3::ZERO, 0.0); positions.len()];
        for triangle in triangles.iter() {
            let Some(u_axis) = UAxis::new(uvs, triangle) else { continue };
            let (delta, length) = (u_axis.of(moves, triangle), u_axis.of(positions, triangle).length());
            for &vertex in triangle {
                if let Some((deltas, lengths)) = sums.get_mut(first_of(vertex)) {
                    *deltas += delta;
                    *lengths += length;
                }
            }
        }
        let delta = |vertex: u32| {
            let (deltas, lengths) = sums.get(first_of(vertex)).copied().unwrap_or_default();
            let delta: Vec3 = deltas / lengths;
            if delta.is_finite() { delta } else { Vec3::ZERO }
        };
        target.tangents = Some((0..positions.len() as u32).map(delta).collect());
    }
    Ok(())
}

/// The vertices that differ for MikkTSpace in nothing: files store one for each triangle, or several where other attributes have a seam.
struct SharedVertices {
    /// For each vertex the first of its equals.
    first: Vec<u32>,
    /// Vertices that have equals.
    vertices: Vec<u32>,
}

impl SharedVertices {
    fn new(primitive: &Primitive, uv_set: usize) -> Self {
        let Primitive { positions, normals, tangents, uvs, .. } = primitive;
        let uvs = uvs.get(uv_set);
        let key = |vertex: u32| {
            let index = vertex as usize;
            let of = |list: Option<&Vec<Vec3>>| {
                list.and_then(|list| list.get(index)).copied().unwrap_or_default().to_array()
            };
            let uv = uvs.and_then(|uvs| uvs.get(index)).copied().unwrap_or_default();
            let tangent = tangents.as_ref().and_then(|list| list.get(index)).copied().unwrap_or_default();
            (
                bits(of(Some(positions))),
                bits(of(normals.as_ref())),
                bits(uv.to_array()),
                bits(tangent.to_array()),
            )
        };
        let all = 0..positions.len() as u32;
        let mut first: Vec<_> = all.clone().collect();
        let vertices = unite_equals(&mut first, all.collect(), key);
        Self { first, vertices }
    }

    /// For each vertex the first of its equals that a morph target moves by the same of `moves`: those that it tears apart share no tangent.
    fn moved_by(&self, moves: &[Vec3]) -> Vec<u32> {
        let key = |vertex: u32| {
            let delta = moves.get(vertex as usize).copied().unwrap_or_default();
            (self.first.get(vertex as usize), bits(delta.to_array()))
        };
        let mut first: Vec<_> = (0..self.first.len() as u32).collect();
        unite_equals(&mut first, self.vertices.clone(), key);
        first
    }
}

/// Writes the first vertex of the same key into `first`, for each of `vertices`. Returns those that are not alone.
fn unite_equals<K: Ord>(
    first: &mut [u32],
    mut vertices: Vec<u32>,
    key: impl Fn(u32) -> K + Sync,
) -> Vec<u32> {
    vertices.par_sort_unstable_by(|&a, &b| key(a).cmp(&key(b)).then(a.cmp(&b)));
    let mut united = Vec::new();
    for equals in vertices.chunk_by(|&a, &b| key(a) == key(b)).filter(|equals| equals.len() > 1) {
        for &vertex in equals {
            if let (Some(slot), Some(&lowest)) = (first.get_mut(vertex as usize), equals.first()) {
                *slot = lowest;
            }
        }
        united.extend_from_slice(equals);
    }
    united
}

/// Bits that are equal where numbers are: negative zero equals zero.
fn bits<const N: usize>(values: [f32; N]) -> [u32; N] {
    values.map(|value| (value + 0.0).to_bits())
}

/// The derivative by u of what is linear over a triangle, times its area in the texture, as weights of its two edges.
struct UAxis([f32; 2]);

impl UAxis {
    /// `None` where texture coordinates have no area.
    fn new(uvs: &[Vec2], triangle: &[u32; 3]) -> Option<Self> {
        let [origin, first, second] = corners(uvs, triangle)?;
        let [first, second] = [first - origin, second - origin];
        let area = first.perp_dot(second);
        (area != 0.0).then(|| Self([second.y * area.signum(), -first.y * area.signum()]))
    }

    fn of(&self, values: &[Vec3], triangle: &[u32; 3]) -> Vec3 {
        let [origin, first, second] = corners(values, triangle).unwrap_or_default();
        (first - origin) * self.0[0] + (second - origin) * self.0[1]
    }
}

fn corners<T: Copy>(values: &[T], triangle: &[u32; 3]) -> Option<[T; 3]> {
    let [Some(&a), Some(&b), Some(&c)] = triangle.map(|vertex| values.get(vertex as usize)) else {
        return None;
    };
    Some([a, b, c])
}

/// Splits every vertex into one for each distinct tangent, in triangle order.
fn split_vertices(primitive: &mut Primitive, corner_tangents: &[[Vec4; 3]]) {
    let mut split: BTreeMap<(u32, [u32; 4]), u32> = BTreeMap::new();
    let mut sources: Vec<u32> = Vec::new();
    let mut tangents: Vec<Vec4> = Vec::new();
    let mut normals: Vec<Vec3> = Vec::new();
    for (triangle, corner_tangents) in primitive.triangles.iter_mut().zip(corner_tangents) {
        let flat = face_normal(&primitive.positions, triangle);
        for (corner, tangent) in triangle.iter_mut().zip(corner_tangents) {
            let vertex = *corner;
            let key = (vertex, tangent.to_array().map(f32::to_bits));
            *corner = *split.entry(key).or_insert_with(|| {
                let smooth = primitive.normals.as_ref();
                normals
                    .push(smooth.and_then(|normals| normals.get(vertex as usize).copied()).unwrap_or(flat));
                tangents.push(*tangent);
                sources.push(vertex);
                u32::try_from(sources.len().saturating_sub(1)).unwrap_or(u32::MAX)
            });
        }
    }
    normalize_tangents(&mut tangents, &normals);
    gather_vertices(primitive, &sources);
    primitive.tangents = Some(tangents);
}

#[cfg(test)]
mod tests {
    #![expect(clippy::arithmetic_side_effects, reason = "numbers of tests are known")]

    use super::*;

    /// A grid of 3 x 3 vertices, and a target that bends it around the y axis.
    fn grid() -> Primitive {
        let at = |index: usize| Vec2::new((index % 3) as f32, (index / 3) as f32);
        let bent = |Vec2 { x, y }: Vec2| Vec3::new(libm::sinf(x), y, 1.0 - libm::cosf(x) + 0.1 * x * y);
        let points: Vec<_> = (0..9).map(at).collect();
        let quads = [0, 1, 3, 4];
        Primitive {
            positions: points.iter().map(|point| point.extend(0.0)).collect(),
            normals: Some(vec![Vec3::Z; 9]),
            uvs: vec![points.iter().map(|point| Vec2::new(point.x, -point.y)).collect()],
            triangles: quads.into_iter().flat_map(|a| [[a, a + 1, a + 4], [a, a + 4, a + 3]]).collect(),
            targets: vec![MorphTarget {
                positions: Some(points.iter().map(|&point| bent(point) - point.extend(0.0)).collect()),
                ..MorphTarget::default()
            }],
            ..Primitive::default()
        }
    }

    /// `primitive` with a vertex for each corner of a triangle.
    fn unwelded(mut primitive: Primitive) -> Primitive {
        let sources = primitive.triangles.concat();
        gather_vertices(&mut primitive, &sources);
        primitive.triangles = (0..sources.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        primitive
    }

    #[test]
    fn tangents_take_memory_while_they_are_computed() {
        let mut context = Context::new(std::path::Path::new("test.gltf"), 1 << 20);
        let mut primitive = Primitive { targets: Vec::new(), ..grid() };
        generate(&mut context, &mut primitive, 0, "").unwrap();
        // Eight triangles with tangents of 48 bytes: first beside what MikkTSpace takes, then beside three vertices each of 64 + 8.
        assert_eq!(context.memory().import_bytes, 8 * (48 + 560));
        assert_eq!(context.used_bytes(), 8 * (48 + 3 * 72));
    }

    /// Tangents and their deltas at the corners of all triangles.
    fn corner_deltas(mut primitive: Primitive) -> Vec<(Vec4, Vec3)> {
        let mut context = Context::new(std::path::Path::new("test.gltf"), 1 << 20);
        generate(&mut context, &mut primitive, 0, "").unwrap();
        let (tangents, deltas) =
            (primitive.tangents.unwrap(), primitive.targets[0].tangents.clone().unwrap());
        assert_eq!(deltas.len(), primitive.positions.len());
        let corners = primitive.triangles.as_flattened().iter();
        corners.map(|&vertex| (tangents[vertex as usize], deltas[vertex as usize])).collect()
    }

    #[test]
    fn deltas_of_vertices_that_are_not_welded_are_those_of_welded_ones() {
        let expected = corner_deltas(grid());
        // The target turns tangents.
        assert!(expected.iter().any(|(_, delta)| delta.length() > 0.1));
        assert_eq!(corner_deltas(unwelded(grid())), expected);
        let without_normals = Primitive { normals: None, ..grid() };
        assert_eq!(corner_deltas(unwelded(without_normals.clone())), corner_deltas(without_normals));
        // A seam in other texture coordinates, and zeros of both signs.
        let mut seam = unwelded(grid());
        seam.uvs.push((0..seam.positions.len()).map(|vertex| Vec2::splat(vertex as f32)).collect());
        for position in &mut seam.positions[..12] {
            position.z = -0.0;
        }
        assert_eq!(corner_deltas(seam), expected);
    }

    #[test]
    fn what_a_morph_tears_apart_has_tangents_of_its_own() {
        // Two quads share an edge along y. The target turns the second about the x axis and u to z, and leaves the first as it is.
        let mut torn = unwelded(Primitive { triangles: grid().triangles[..4].to_vec(), ..grid() });
        let turned = |position: &Vec3| Vec3::new(5.0, position.y, position.x) - *position;
        let (first, second) = (vec![Vec3::ZERO; 6], torn.positions[6..].iter().map(turned));
        torn.targets[0].positions = Some(first.into_iter().chain(second).collect());
        for (index, (tangent, delta)) in corner_deltas(torn).into_iter().enumerate() {
            let expected = if index < 6 { Vec3::X } else { Vec3::Z };
            assert!((tangent.truncate() + delta - expected).length() < 1e-5, "{index}: {tangent} {delta}");
        }
    }
}
