//! Solids of the showcase scenes: lofts of an outline along a profile (lathes, bevelled blocks, bottles), parametric surfaces,
//! tubes, limbs and rounded boxes. All have smooth normals where they are round.

use std::collections::BTreeMap;
use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3};

use scene_builder::shapes::{TriangleMesh, cuboid, grid_indices};

/// Cosine of the angle between two segments of a profile beyond which their edge stays sharp.
const CREASE: f32 = 0.72;

/// A closed curve in the plane y = 0: points (x, z) and outward normals. The last point is the first.
#[derive(Clone, Debug)]
pub(crate) struct Outline(Vec<[Vec2; 2]>);

impl Outline {
    /// The origin with normals in all directions; its loft is a surface of revolution.
    pub(crate) fn axis(segments: u32) -> Self {
        Self::closed(segments, |angle| {
            let (sin, cos) = libm::sincosf(angle);
            [Vec2::ZERO, Vec2::new(sin, cos)]
        })
    }

    /// A superellipse: |x / a|ⁿ + |z / b|ⁿ = 1.
    pub(crate) fn superellipse(half: Vec2, exponent: f32, segments: u32) -> Self {
        let power = |value: f32, exponent: f32| value.signum() * libm::powf(value.abs(), exponent);
        Self::closed(segments, |angle| {
            let (sin, cos) = libm::sincosf(angle);
            let unit = Vec2::new(power(sin, 2.0 / exponent), power(cos, 2.0 / exponent));
            let normal = Vec2::new(power(unit.x, exponent - 1.0), power(unit.y, exponent - 1.0)) / half;
            [unit * half, normal.normalize()]
        })
    }

    /// A rectangle whose corners are arcs of `radius`.
    pub(crate) fn rounded_rectangle(size: Vec2, radius: f32, steps: u32) -> Self {
        let inner = size / 2.0 - Vec2::splat(radius);
        let corner = |index: u32| {
            let (quarter, step) = (index / (steps + 1) % 4, index % (steps + 1));
            let (sin, cos) = libm::sincosf(TAU / 4.0 * (quarter as f32 + step as f32 / steps as f32));
            let sign = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)][quarter as usize];
            let normal = Vec2::new(sin, cos);
            [inner * Vec2::from(sign) + normal * radius, normal]
        };
        Self((0..=4 * (steps + 1)).map(corner).collect())
    }

    fn closed(segments: u32, point: impl Fn(f32) -> [Vec2; 2]) -> Self {
        Self((0..=segments).map(|index| point(TAU * (index % segments) as f32 / segments as f32)).collect())
    }
}

/// Points of a profile: distance from the outline, and height.
pub(crate) fn profile(points: &[(f32, f32)]) -> Vec<Vec2> {
    points.iter().copied().map(Vec2::from).collect()
}

/// The profile with its inner corners rounded by arcs that begin `radius` before them.
pub(crate) fn rounded(points: &[(f32, f32)], radius: f32, steps: u32) -> Vec<Vec2> {
    let points = profile(points);
    let mut result = vec![points[0]];
    for corner in points.windows(3) {
        let [before, middle, after] = [corner[0], corner[1], corner[2]];
        let toward = |end: Vec2| (end - middle) * (radius / middle.distance(end)).min(0.5);
        let (start, end) = (middle + toward(before), middle + toward(after));
        for step in 0..=steps {
            let share = step as f32 / steps as f32;
            result.push(start.lerp(middle, share).lerp(middle.lerp(end, share), share));
        }
    }
    result.push(points[points.len() - 1]);
    result
}

/// A Catmull-Rom spline through the points, `steps` segments between neighbours.
pub(crate) fn smooth(points: &[(f32, f32)], steps: u32) -> Vec<Vec2> {
    let points = profile(points);
    let at = |index: usize| points[index.saturating_sub(1).min(points.len() - 1)];
    let mut result = Vec::new();
    for index in 1..points.len() {
        let [a, b, c, d] = [at(index - 1), at(index), at(index + 1), at(index + 2)];
        for step in 0..steps {
            let t = step as f32 / steps as f32;
            let cubic = (b - c) * 3.0 + d - a;
            result.push(b + ((c - a) + (a * 2.0 - b * 5.0 + c * 4.0 - d + cubic * t) * t) * (0.5 * t));
        }
    }
    result.push(points[points.len() - 1]);
    result
}

/// The surface that the outline sweeps along a profile from bottom to top; flat faces close ends off the axis.
pub(crate) fn loft(outline: &Outline, profile: &[Vec2]) -> TriangleMesh {
    let mut mesh = open_loft(outline, profile);
    let ring = outline.0.len();
    for (start, up) in [(0, -1.0), (mesh.positions.len() - ring, 1.0)] {
        let mut first = start as u32;
        // A side that does not end level with the face has normals of its own.
        if mesh.normals[start].y * up < 0.999 {
            first = mesh.positions.len() as u32;
            mesh.positions.extend_from_within(start..start + ring);
            mesh.normals.extend(vec![Vec3::Y * up; ring]);
        }
        mesh.indices.extend((2..ring as u32).flat_map(|index| [first, first + index - 1, first + index]));
    }
    oriented(mesh.without_collapsed())
}

/// The same surface with open ends.
pub(crate) fn open_loft(outline: &Outline, profile: &[Vec2]) -> TriangleMesh {
    let rows = profile_rows(profile);
    let mut mesh = TriangleMesh::default();
    for [row, across] in &rows {
        for [point, normal] in &outline.0 {
            let around = *point + *normal * row.x;
            mesh.positions.push(Vec3::new(around.x, row.y, around.y));
            mesh.normals.push(Vec3::new(normal.x * across.x, across.y, normal.y * across.x));
        }
    }
    mesh.indices = grid_indices(outline.0.len() as u32 - 1, rows.len() as u32 - 1, false);
    oriented(mesh.without_collapsed())
}

/// A surface of revolution about Y.
pub(crate) fn lathe(profile: &[Vec2], segments: u32) -> TriangleMesh {
    loft(&Outline::axis(segments), profile)
}

/// Points of a profile with their normals, twice where the profile has a sharp edge. Long segments weigh more, so that flat sides
/// beside bevels look flat.
fn profile_rows(points: &[Vec2]) -> Vec<[Vec2; 2]> {
    let mut points = points.to_vec();
    points.dedup_by(|next, previous| next.distance(*previous) < 1e-6);
    let across: Vec<Vec2> = points.windows(2).map(|ends| (ends[1] - ends[0]).perp() * -1.0).collect();
    let mut rows = Vec::new();
    for (index, &point) in points.iter().enumerate() {
        let (before, after) = (across[index.max(1) - 1], across[index.min(across.len() - 1)]);
        let (first, second) = (before.normalize(), after.normalize());
        let is_end = index == 0 || index + 1 == points.len();
        if is_end && first.y.abs() > CREASE {
            rows.push([point, Vec2::new(0.0, first.y.signum())]);
        } else if first.dot(second) > CREASE {
            rows.push([point, (before + after).normalize()]);
        } else {
            rows.extend([[point, first], [point, second]]);
        }
    }
    rows
}

/// The mesh with the corners of each triangle counter-clockwise about its normals.
fn oriented(mut mesh: TriangleMesh) -> TriangleMesh {
    for triangle in mesh.indices.chunks_exact_mut(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|index| index as usize);
        let face = (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
        if face.dot(mesh.normals[a] + mesh.normals[b] + mesh.normals[c]) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    mesh
}

/// The surface of `point(u, v)`, u and v from 0 to 1, with the normals ∂u × ∂v.
pub(crate) fn surface(columns: u32, rows: u32, point: impl Fn(f32, f32) -> Vec3) -> TriangleMesh {
    let step = 2e-3;
    let mut mesh = TriangleMesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (column as f32 / columns as f32, row as f32 / rows as f32);
            // Beside poles, where ∂u vanishes.
            let beside = v.clamp(step, 1.0 - step);
            let along_u = point((u + step).min(1.0), beside) - point((u - step).max(0.0), beside);
            let along_v = point(u, (v + step).min(1.0)) - point(u, (v - step).max(0.0));
            mesh.positions.push(point(u, v));
            mesh.normals.push(along_u.cross(along_v).normalize_or(Vec3::Y));
        }
    }
    mesh.indices = grid_indices(columns, rows, false);
    oriented(mesh.without_collapsed())
}

/// A closed tube of `radius` along the curve `center(t)`, t from 0 to 1; `normal(t)` lies across the curve.
pub(crate) fn ring_tube(
    [segments, sides]: [u32; 2],
    radius: f32,
    center: impl Fn(f32) -> Vec3,
    normal: impl Fn(f32) -> Vec3,
) -> TriangleMesh {
    surface(segments, sides, |u, v| {
        let u = if u >= 1.0 { u - 1.0 } else { u };
        let tangent = (center(u + 1e-3) - center(u - 1e-3)).normalize();
        let across = normal(u).cross(tangent).normalize();
        let (sin, cos) = libm::sincosf(TAU * v);
        center(u) + (tangent.cross(across) * cos + across * sin) * radius
    })
}

/// A capsule from `from` to `to` with different radii at its ends.
pub(crate) fn limb(ends: [Vec3; 2], radii: [f32; 2], resolution: [u32; 2]) -> TriangleMesh {
    jointed_limb(ends, radii, resolution, 1)
}

/// The same in `rows` rows between the ends, at which joints can bend it.
pub(crate) fn jointed_limb(
    [from, to]: [Vec3; 2],
    [first, last]: [f32; 2],
    [segments, steps]: [u32; 2],
    rows: u32,
) -> TriangleMesh {
    let length = from.distance(to);
    let mut points = Vec::new();
    for step in 0..=steps {
        let (sin, cos) = libm::sincosf(TAU / 4.0 * step as f32 / steps as f32);
        points.push(Vec2::new(first * sin, -first * cos));
    }
    for row in 1..rows {
        let share = row as f32 / rows as f32;
        points.push(Vec2::new(first + (last - first) * share, length * share));
    }
    for step in 0..=steps {
        let (sin, cos) = libm::sincosf(TAU / 4.0 * step as f32 / steps as f32);
        points.push(Vec2::new(last * cos, length + last * sin));
    }
    points[0].x = 0.0;
    if let Some(tip) = points.last_mut() {
        tip.x = 0.0;
    }
    let axis = (to - from).try_normalize().unwrap_or(Vec3::Y);
    lathe(&points, segments).moved(1.0, Quat::from_rotation_arc(Vec3::Y, axis), from)
}

/// A box around the origin whose edges are rounded by `radius` in `steps` steps: 1 is a chamfer with smooth normals.
pub(crate) fn rounded_box(size: Vec3, radius: f32, steps: u32) -> TriangleMesh {
    let (x, y) = (size / 2.0 - Vec3::splat(radius), radius);
    let points = (0..=2 * steps + 1).map(|row| {
        let (upper, step) = (row > steps, row % (steps + 1));
        let (sin, cos) = libm::sincosf(TAU / 4.0 * step as f32 / steps as f32);
        // Inward offset of the row and its height; the lower quarter first.
        if upper { (y * (cos - 1.0), x.y + y * sin) } else { (y * (sin - 1.0), -x.y - y * cos) }
    });
    let outline = Outline::rounded_rectangle(Vec2::new(size.x, size.z), radius, steps);
    loft(&outline, &profile(&points.collect::<Vec<_>>()))
}

/// A box with sharp edges whose lower side is at `base`.
pub(crate) fn block(size: Vec3, base: Vec3) -> TriangleMesh {
    let center = base + Vec3::Y * (size.y / 2.0);
    cuboid(size.x, size.y, size.z).plain().moved(1.0, Quat::IDENTITY, center)
}

/// The mesh with flat triangles: without normals, and with one vertex a position.
pub(crate) fn faceted(mesh: &TriangleMesh) -> TriangleMesh {
    let mut flat = TriangleMesh::default();
    let mut vertices = BTreeMap::new();
    for &index in &mesh.indices {
        let position = mesh.positions[index as usize];
        let vertex = *vertices.entry(position.to_array().map(f32::to_bits)).or_insert_with(|| {
            flat.positions.push(position);
            flat.positions.len() as u32 - 1
        });
        flat.indices.push(vertex);
    }
    flat
}

/// The mesh as it is, or [`faceted`] where its normals are those of its triangles.
pub(crate) fn compact(mesh: &TriangleMesh) -> TriangleMesh {
    let is_flat = mesh.indices.chunks_exact(3).all(|triangle| {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|index| mesh.positions[index as usize]);
        let face = (b - a).cross(c - a).normalize_or_zero();
        triangle
            .iter()
            .all(|&index| mesh.normals.get(index as usize).is_none_or(|normal| normal.dot(face) > 0.9999))
    });
    if is_flat && mesh.uvs.is_empty() && mesh.colors.is_empty() { faceted(mesh) } else { mesh.clone() }
}

/// The union of meshes that have the same attributes.
pub(crate) fn joined(meshes: impl IntoIterator<Item = TriangleMesh>) -> TriangleMesh {
    meshes.into_iter().fold(TriangleMesh::default(), |mut all, mesh| {
        all.join(&mesh);
        all
    })
}

/// The mesh moved by (x, y, z).
pub(crate) fn at(mesh: TriangleMesh, x: f32, y: f32, z: f32) -> TriangleMesh {
    mesh.moved(1.0, Quat::IDENTITY, Vec3::new(x, y, z))
}
