//! The triangles of a primitive as MikkTSpace takes them, bounded in time and depth.
//!
//! The algorithm recurs over the triangles around a vertex and compares each with each, and so it does with the corners at one position. It
//! searches all triangles for the vertices of those that have two equal corners. These are therefore kept from it and get the tangents that it
//! would copy, and positions with thousands of corners are told apart into parts of [`MOST_AT_A_POSITION`].

use std::collections::BTreeMap;

use bevy_mikktspace::{GenerateTangentSpaceError, Geometry, Ops, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use super::normals::face_normal;
use crate::scene::Primitive;

/// Corners at a position that share tangents.
const MOST_AT_A_POSITION: u32 = 1024;

struct PortableOps;

impl Ops for PortableOps {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}

/// Position, normal and texture coordinates of a corner. Corners with the same are one vertex, whatever their indices.
type CornerKey = [u32; 8];

/// The triangles of a primitive whose corners differ.
struct Faces<'a> {
    primitive: &'a Primitive,
    uvs: &'a [Vec2],
    /// Indices of the triangles.
    triangles: Vec<u32>,
    /// For the corners of each face, the part of the position that it belongs to. Empty where all positions have one part.
    parts: Vec<[u32; 3]>,
    /// The tangents of all triangles of the primitive.
    tangents: Vec<[Vec4; 3]>,
}

/// The MikkTSpace tangents of the corners of all triangles; zero where a triangle has equal corners and shares no vertex with others.
pub(super) fn corner_tangents(
    primitive: &Primitive,
    uvs: &[Vec2],
) -> Result<Vec<[Vec4; 3]>, GenerateTangentSpaceError> {
    let count = primitive.triangles.len();
    let mut faces = Faces {
        primitive,
        uvs,
        triangles: Vec::new(),
        parts: Vec::new(),
        tangents: vec![[Vec4::ZERO; 3]; count],
    };
    let (triangles, flat): (Vec<_>, Vec<_>) =
        (0..count as u32).partition(|&triangle| has_distinct_corners(primitive, triangle as usize));
    faces.triangles = triangles;
    faces.parts = faces.parts_of_positions();
    generate_tangents(&mut faces)?;
    faces.copy_to(&flat);
    Ok(faces.tangents)
}

/// Whether no two corners of a triangle coincide.
fn has_distinct_corners(primitive: &Primitive, triangle: usize) -> bool {
    let corner = |corner| position(primitive, triangle, corner);
    let [a, b, c] = [corner(0), corner(1), corner(2)];
    a != b && b != c && c != a
}

fn vertex(primitive: &Primitive, triangle: usize, corner: usize) -> usize {
    let triangle = primitive.triangles.get(triangle);
    triangle.and_then(|triangle| triangle.get(corner)).map_or(0, |&vertex| vertex as usize)
}

fn position(primitive: &Primitive, triangle: usize, corner: usize) -> Vec3 {
    primitive.positions.get(vertex(primitive, triangle, corner)).copied().unwrap_or_default()
}

impl Faces<'_> {
    fn triangle(&self, face: usize) -> usize {
        self.triangles.get(face).map_or(0, |&triangle| triangle as usize)
    }

    fn normal_of(&self, triangle: usize, corner: usize) -> Vec3 {
        let normal = match (&self.primitive.normals, self.primitive.triangles.get(triangle)) {
            (Some(normals), _) => normals.get(vertex(self.primitive, triangle, corner)).copied(),
            (None, Some(triangle)) => Some(face_normal(&self.primitive.positions, triangle)),
            (None, None) => None,
        };
        normal.unwrap_or(Vec3::Z)
    }

    fn uv_of(&self, triangle: usize, corner: usize) -> Vec2 {
        self.uvs.get(vertex(self.primitive, triangle, corner)).copied().unwrap_or_default()
    }

    fn key(&self, triangle: usize, corner: usize) -> CornerKey {
        let [x, y, z] = position(self.primitive, triangle, corner).to_array();
        let [nx, ny, nz] = self.normal_of(triangle, corner).to_array();
        let [u, v] = self.uv_of(triangle, corner).to_array();
        // Negative zero equals zero.
        [x, y, z, nx, ny, nz, u, v].map(|value| (value + 0.0).to_bits())
    }

    /// The parts of the positions at the corners of each face. Positions are counted by a hash: some that have few corners are told apart, too,
    /// which does no harm.
    fn parts_of_positions(&self) -> Vec<[u32; 3]> {
        if self.triangles.len() <= MOST_AT_A_POSITION as usize {
            return Vec::new();
        }
        let mut counts = vec![0_u32; self.triangles.len().next_power_of_two()];
        let mut part = |triangle: u32, corner: usize| {
            let slot = hash(position(self.primitive, triangle as usize, corner)) as usize;
            let slot = slot.checked_rem(counts.len())?;
            let count = counts.get_mut(slot)?;
            let part = *count / MOST_AT_A_POSITION;
            *count = count.saturating_add(1);
            Some(part)
        };
        let mut parts_of_face =
            |&triangle: &u32| [0, 1, 2].map(|corner| part(triangle, corner).unwrap_or_default());
        let parts: Vec<_> = self.triangles.iter().map(&mut parts_of_face).collect();
        if parts.iter().all(|parts| *parts == [0; 3]) { Vec::new() } else { parts }
    }

    /// Gives triangles with equal corners the tangents of the first faces that share their vertices.
    fn copy_to(&mut self, flat: &[u32]) {
        let corners = |triangles: &[u32]| -> Vec<(u32, usize)> {
            triangles.iter().flat_map(|&triangle| [0, 1, 2].map(|corner| (triangle, corner))).collect()
        };
        let targets = corners(flat);
        let mut found: BTreeMap<CornerKey, Option<Vec4>> =
            targets.iter().map(|&(triangle, corner)| (self.key(triangle as usize, corner), None)).collect();
        if found.is_empty() {
            return;
        }
        for (triangle, corner) in corners(&self.triangles) {
            if let Some(tangent @ None) = found.get_mut(&self.key(triangle as usize, corner)) {
                *tangent = self.tangents.get(triangle as usize).and_then(|face| face.get(corner)).copied();
            }
        }
        for (triangle, corner) in targets {
            let tangent = found.get(&self.key(triangle as usize, corner)).copied().flatten();
            self.set(triangle as usize, corner, tangent.unwrap_or_default());
        }
    }

    fn set(&mut self, triangle: usize, corner: usize, tangent: Vec4) {
        if let Some(slot) = self.tangents.get_mut(triangle).and_then(|face| face.get_mut(corner)) {
            *slot = tangent;
        }
    }
}

impl Geometry<PortableOps> for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        let [x, y, z] = position(self.primitive, self.triangle(face), corner).to_array();
        // The last bits tell the parts of a position apart.
        let part = self.parts.get(face).and_then(|parts| parts.get(corner)).copied().unwrap_or_default();
        [f32::from_bits(x.to_bits().wrapping_add(part)), y, z]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normal_of(self.triangle(face), corner).to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.uv_of(self.triangle(face), corner);
        // glTF's v axis points down the image, the algorithm's points up.
        [uv.x, -uv.y]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = space.map_or(Vec4::ZERO, |space| Vec4::from_array(space.tangent_encoded()));
        self.set(self.triangle(face), corner, tangent);
    }
}

/// FNV-1a over the words of a position, with the upper bits folded into the lower. Negative zero counts as zero.
fn hash(position: Vec3) -> u64 {
    let hash = position.to_array().iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, value| {
        (hash ^ u64::from((value + 0.0).to_bits())).wrapping_mul(0x0100_0000_01b3)
    });
    hash ^ (hash >> 32)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::arithmetic_side_effects, reason = "numbers of tests are known")]

    use super::*;

    /// A fan of triangles around a vertex.
    fn fan(count: u32) -> Primitive {
        let rim = (0..count).map(|index| {
            let (sin, cos) = libm::sincosf(index as f32 * std::f32::consts::TAU / count as f32);
            Vec3::new(cos, sin, 0.0)
        });
        let positions: Vec<_> = std::iter::once(Vec3::ZERO).chain(rim).collect();
        Primitive {
            uvs: vec![positions.iter().map(|position| Vec2::new(position.x, -position.y)).collect()],
            normals: Some(vec![Vec3::Z; positions.len()]),
            triangles: (0..count).map(|index| [0, index + 1, (index + 1) % count + 1]).collect(),
            positions,
            ..Primitive::default()
        }
    }

    #[test]
    fn a_vertex_of_any_number_of_triangles_has_tangents() {
        let primitive = fan(10_000);
        let tangents = corner_tangents(&primitive, &primitive.uvs[0]).unwrap();
        for tangent in tangents.iter().flatten() {
            assert!(tangent.abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, 1.0), 1e-4), "{tangent}");
        }
        // The algorithm alone takes minutes and overflows the stack. Angles are too small for it to find tangents in the middle.
        let primitive = fan(100_000);
        let tangents = corner_tangents(&primitive, &primitive.uvs[0]).unwrap();
        assert!(tangents.iter().all(|[_, a, b]| a.x > 0.999 && b.x > 0.999));
        // So do corners at one position whose normals differ.
        let mut cone = fan(40_000);
        cone.normals = None;
        cone.positions[0] = Vec3::Z;
        let tangents = corner_tangents(&cone, &cone.uvs[0]).unwrap();
        assert!(tangents.iter().flatten().all(|tangent| tangent.is_finite()));
    }

    #[test]
    fn vertices_of_few_triangles_are_whole() {
        let primitive = fan(300);
        let triangles: Vec<_> = (0..300).collect();
        let faces = Faces {
            primitive: &primitive,
            uvs: &primitive.uvs[0],
            triangles,
            parts: Vec::new(),
            tangents: Vec::new(),
        };
        assert!(faces.parts_of_positions().is_empty());
        assert_eq!(faces.position(7, 0), [0.0; 3]);
    }

    #[test]
    fn triangles_without_area_have_the_tangents_of_their_vertices() {
        let mut primitive = fan(8);
        let tangents = corner_tangents(&primitive, &primitive.uvs[0]).unwrap();
        primitive.positions.push(Vec3::splat(5.0));
        primitive.uvs[0].push(Vec2::ONE);
        primitive.normals.as_mut().unwrap().push(Vec3::Z);
        primitive.triangles.insert(0, [1, 2, 1]);
        primitive.triangles.insert(4, [9, 9, 4]);
        let more = corner_tangents(&primitive, &primitive.uvs[0]).unwrap();
        assert_eq!(more[0], [tangents[0][1], tangents[0][2], tangents[0][1]]);
        assert_eq!(more[4], [Vec4::ZERO, Vec4::ZERO, tangents[3][1]]);
        assert_eq!([&more[1..4], &more[5..]].concat(), tangents);
    }
}
