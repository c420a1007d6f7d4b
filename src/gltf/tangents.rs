//! Tangents for normal-mapped primitives without stored tangents.
//!
//! Source: Morten S. Mikkelsen, *Simulation of Wrinkled Surfaces Revisited* (2008), as implemented by the crate
//! `bevy_mikktspace`. Its arc cosine is replaced by that of `libm`, so that tangents are the same on every machine.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};

use super::context::Context;
use super::normals::{face_normal, normalize_tangents};
use super::tangent_faces::corner_tangents;
use super::vertex_lists::{gather_vertices, vertex_bytes};
use crate::error::Result;
use crate::scene::{MorphTarget, Primitive};

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
    let corner_count = (primitive.triangles.len() as u64).saturating_mul(3);
    let corner_bytes = (vertex_bytes(primitive) as u64).saturating_add(size_of::<Vec4>() as u64);
    context.charge(corner_count.saturating_mul(corner_bytes), pointer)?;
    let corner_tangents = corner_tangents(primitive, uvs)
        .map_err(|error| context.invalid(pointer, format!("tangents cannot be computed: {error}")))?;
    split_vertices(primitive, &corner_tangents);
    add_morph_deltas(context, primitive, uv_set, pointer)
}

/// Gives morph targets the deltas of generated tangents, so that the tangents follow the surface.
///
/// A tangent is the direction in which u grows, and ∂P/∂u of a triangle is linear in its positions. The delta of a vertex is
/// Σ ∂ΔP/∂u / Σ |∂P/∂u| over its triangles, weighted by their area in the texture: exact where the triangles agree, at any weight and
/// for sums of targets.
fn add_morph_deltas(
    context: &mut Context,
    primitive: &mut Primitive,
    uv_set: usize,
    pointer: &str,
) -> Result<()> {
    let Primitive { positions, triangles, uvs, targets, .. } = primitive;
    let Some(uvs) = uvs.get(uv_set) else { return Ok(()) };
    let moves_tangents = |target: &&mut MorphTarget| target.positions.is_some() && target.tangents.is_none();
    for target in targets.iter_mut().filter(moves_tangents) {
        context.charge((positions.len() as u64).saturating_mul(size_of::<Vec3>() as u64), pointer)?;
        let Some(moves) = &target.positions else { continue };
        let mut sums = vec![(Vec3::ZERO, 0.0); positions.len()];
        for triangle in triangles.iter() {
            let Some(u_axis) = UAxis::new(uvs, triangle) else { continue };
            let (delta, length) = (u_axis.of(moves, triangle), u_axis.of(positions, triangle).length());
            for &vertex in triangle {
                if let Some((deltas, lengths)) = sums.get_mut(vertex as usize) {
                    *deltas += delta;
                    *lengths += length;
                }
            }
        }
        let delta = |(deltas, lengths): (Vec3, f32)| deltas / lengths;
        let finite = |delta: Vec3| if delta.is_finite() { delta } else { Vec3::ZERO };
        target.tangents = Some(sums.into_iter().map(delta).map(finite).collect());
    }
    Ok(())
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
