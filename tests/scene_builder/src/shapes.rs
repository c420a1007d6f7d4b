//! Triangle meshes of simple solids and sheets, with normals and texture coordinates.
//!
//! Triangles run counter-clockwise seen from outside.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};

use crate::document::Gltf;
use crate::json::{Json, list, object};

/// A triangle mesh. Empty attributes are left out of the file.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub colors: Vec<Vec4>,
    pub indices: Vec<u32>,
}

impl TriangleMesh {
    /// Appends the vertices and triangles of `other`, which must have the same attributes.
    pub fn join(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.uvs.extend(&other.uvs);
        self.colors.extend(&other.colors);
        self.indices.extend(other.indices.iter().map(|index| first + index));
    }

    /// The mesh after a uniform scale, a rotation and a translation.
    #[must_use]
    pub fn moved(mut self, scale: f32, rotation: Quat, translation: Vec3) -> Self {
        let transform = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, translation);
        for position in &mut self.positions {
            *position = transform.transform_point3(*position);
        }
        for normal in &mut self.normals {
            *normal = rotation * *normal;
        }
        self
    }

    /// The mesh turned inside out.
    #[must_use]
    pub fn inverted(mut self) -> Self {
        for triangle in self.indices.chunks_exact_mut(3) {
            triangle.swap(1, 2);
        }
        for normal in &mut self.normals {
            *normal = -*normal;
        }
        self
    }

    /// The mesh without triangles of zero area, as grids have at their poles: those with two corners at one point.
    #[must_use]
    pub fn without_collapsed(mut self) -> Self {
        let corner = |index: u32| self.positions[index as usize];
        let whole = |triangle: &&[u32]| {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(corner);
            a != b && b != c && c != a
        };
        self.indices = self.indices.chunks_exact(3).filter(whole).flatten().copied().collect();
        self
    }

    /// The mesh without texture coordinates.
    #[must_use]
    pub fn plain(mut self) -> Self {
        self.uvs.clear();
        self
    }

    /// Adds the attributes' accessors and gives the `attributes` object of a primitive.
    pub fn attributes(&self, gltf: &mut Gltf) -> Json {
        let mut attributes = object([("POSITION", gltf.positions(&self.positions).into())]);
        if !self.normals.is_empty() {
            attributes.set("NORMAL", gltf.vec3s(&self.normals));
        }
        if !self.uvs.is_empty() {
            attributes.set("TEXCOORD_0", gltf.vec2s(&self.uvs));
        }
        if !self.colors.is_empty() {
            attributes.set("COLOR_0", gltf.vec4s(&self.colors));
        }
        attributes
    }

    /// Adds a mesh of one primitive.
    pub fn add_to(&self, gltf: &mut Gltf, material: usize) -> usize {
        let attributes = self.attributes(gltf);
        let indices = gltf.indices(&self.indices);
        mesh(gltf, attributes, indices, material)
    }

    /// Adds meshes that share the vertices and differ in the material.
    pub fn add_with_each(&self, gltf: &mut Gltf, materials: &[usize]) -> Vec<usize> {
        let attributes = self.attributes(gltf);
        let indices = gltf.indices(&self.indices);
        materials.iter().map(|&material| mesh(gltf, attributes.clone(), indices, material)).collect()
    }
}

/// Adds a mesh of one indexed primitive.
pub fn mesh(gltf: &mut Gltf, attributes: Json, indices: usize, material: usize) -> usize {
    let primitive =
        object([("attributes", attributes), ("indices", indices.into()), ("material", material.into())]);
    gltf.add("meshes", object([("primitives", list([primitive]))]))
}

/// A rectangle in the plane z = 0 that faces +Z, its texture upright.
pub fn quad(width: f32, height: f32) -> TriangleMesh {
    let (x, y) = (width / 2.0, height / 2.0);
    TriangleMesh {
        positions: [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| Vec2::new(u, v)).to_vec(),
        colors: Vec::new(),
        indices: vec![0, 1, 2, 0, 2, 3],
    }
}

/// A rectangle in the plane y = 0 that faces up; the texture's top is towards −Z.
pub fn floor(width: f32, depth: f32) -> TriangleMesh {
    quad(width, depth).moved(1.0, Quat::from_rotation_x(-PI / 2.0), Vec3::ZERO).flattened_at_y0()
}

/// A box around the origin with flat sides.
pub fn cuboid(width: f32, height: f32, depth: f32) -> TriangleMesh {
    // Each side is a quad turned from +Z, pushed outwards.
    let sides = [
        (Quat::IDENTITY, width, height, depth),
        (Quat::from_rotation_y(PI), width, height, depth),
        (Quat::from_rotation_y(PI / 2.0), depth, height, width),
        (Quat::from_rotation_y(-PI / 2.0), depth, height, width),
        (Quat::from_rotation_x(-PI / 2.0), width, depth, height),
        (Quat::from_rotation_x(PI / 2.0), width, depth, height),
    ];
    let half = Vec3::new(width, height, depth) / 2.0;
    let mut mesh = TriangleMesh::default();
    for (rotation, side_width, side_height, distance) in sides {
        let normal = (rotation * Vec3::Z).round();
        let side = quad(side_width, side_height).moved(1.0, rotation, normal * (distance / 2.0));
        mesh.join(&side);
    }
    // Rounding by the rotations is removed: corners and normals lie exactly on the box.
    for (position, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        *position = half * position.signum();
        *normal = normal.round();
    }
    mesh
}

/// A sphere of quads between meridians and parallels, poles on the Y axis, smooth normals.
pub fn uv_sphere(radius: f32, segments: u32, rings: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for ring in 0..=rings {
        let (sin_polar, cos_polar) = libm::sincosf(PI * ring as f32 / rings as f32);
        for segment in 0..=segments {
            let azimuth = if segment == segments { 0.0 } else { TAU * segment as f32 / segments as f32 };
            let (sin_azimuth, cos_azimuth) = libm::sincosf(azimuth);
            let rim = if ring == 0 || ring == rings { 0.0 } else { sin_polar };
            let normal = Vec3::new(rim * sin_azimuth, cos_polar, rim * cos_azimuth).normalize();
            mesh.positions.push(normal * radius);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(segment as f32 / segments as f32, ring as f32 / rings as f32));
        }
    }
    mesh.indices = grid_indices(segments, rings, true);
    mesh
}

/// A sphere of nearly equal triangles: an icosahedron whose sides are halved `levels` times. No texture coordinates.
pub fn ico_sphere(radius: f32, levels: u32) -> TriangleMesh {
    let golden = 0.5 * (1.0 + libm::sqrtf(5.0));
    let mut normals: Vec<Vec3> = Vec::new();
    for axis in 0..3 {
        for (a, b) in [(-1.0, -golden), (1.0, -golden), (-1.0, golden), (1.0, golden)] {
            let mut corner = [0.0; 3];
            corner[(axis + 1) % 3] = a;
            corner[(axis + 2) % 3] = b;
            normals.push(Vec3::from_array(corner).normalize());
        }
    }
    // The sides are the triples of corners at the least distance from each other, turned outwards.
    let edge = 2.0 / libm::sqrtf(1.0 + golden * golden);
    let near = |a: usize, b: usize| (normals[a].distance(normals[b]) - edge).abs() < 0.01;
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outside = normals[a].dot((normals[b]).cross(normals[c])) > 0.0;
                    let [a, b, c] = [a as u32, b as u32, c as u32];
                    triangles.push(if outside { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..levels {
        triangles = halve_edges(&mut normals, &triangles);
    }
    TriangleMesh {
        positions: normals.iter().map(|normal| *normal * radius).collect(),
        normals,
        indices: triangles.concat(),
        ..TriangleMesh::default()
    }
}

/// A closed cylinder along Y around the origin, with flat caps.
pub fn cylinder(radius: f32, height: f32, segments: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let rim = |segment: u32| {
        let (sin, cos) = libm::sincosf(TAU * (segment % segments) as f32 / segments as f32);
        Vec3::new(sin, 0.0, cos)
    };
    for (row, y) in [height / 2.0, -height / 2.0].into_iter().enumerate() {
        for segment in 0..=segments {
            mesh.positions.push(rim(segment) * radius + Vec3::Y * y);
            mesh.normals.push(rim(segment));
            mesh.uvs.push(Vec2::new(segment as f32 / segments as f32, row as f32));
        }
    }
    mesh.indices = grid_indices(segments, 1, false);
    for (y, normal) in [(height / 2.0, Vec3::Y), (-height / 2.0, Vec3::NEG_Y)] {
        let mut cap = TriangleMesh::default();
        for segment in 0..segments {
            let outward = rim(segment);
            cap.positions.push(outward * radius + Vec3::Y * y);
            cap.normals.push(normal);
            cap.uvs.push(Vec2::new(0.5 + outward.x / 2.0, 0.5 + outward.z / 2.0));
        }
        for segment in 1..segments - 1 {
            let (b, c) = if normal.y > 0.0 { (segment, segment + 1) } else { (segment + 1, segment) };
            cap.indices.extend([0, b, c]);
        }
        mesh.join(&cap);
    }
    mesh
}

/// A ring around Y: a tube of `tube_radius` whose centre runs at `radius`.
pub fn torus(radius: f32, tube_radius: f32, segments: u32, sides: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for side in 0..=sides {
        let (up, out) = libm::sincosf(-TAU * (side % sides) as f32 / sides as f32);
        for segment in 0..=segments {
            let (sin, cos) = libm::sincosf(TAU * (segment % segments) as f32 / segments as f32);
            let outward = Vec3::new(sin, 0.0, cos);
            let normal = outward * out + Vec3::Y * up;
            mesh.positions.push(outward * radius + normal * tube_radius);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(segment as f32 / segments as f32, side as f32 / sides as f32));
        }
    }
    mesh.indices = grid_indices(segments, sides, false);
    mesh
}

/// A flat upright strip in the plane z = 0, facing +Z, from y = 0 to `height` in `rows` rows.
pub fn strip(width: f32, height: f32, rows: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for row in 0..=rows {
        let v = row as f32 / rows as f32;
        for u in [0.0, 1.0] {
            mesh.positions.push(Vec3::new((u - 0.5) * width, (1.0 - v) * height, 0.0));
            mesh.normals.push(Vec3::Z);
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    mesh.indices = grid_indices(1, rows, false);
    mesh
}

/// Two triangles a cell of a grid of `columns + 1` vertices a row, rows running down; `poles` leaves out the
/// triangles without area of the first and last row.
pub fn grid_indices(columns: u32, rows: u32, poles: bool) -> Vec<u32> {
    let mut indices = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let top_left = row * (columns + 1) + column;
            let bottom_left = top_left + columns + 1;
            if !(poles && row + 1 == rows) {
                indices.extend([top_left, bottom_left, bottom_left + 1]);
            }
            if !(poles && row == 0) {
                indices.extend([top_left, bottom_left + 1, top_left + 1]);
            }
        }
    }
    indices
}

fn halve_edges(corners: &mut Vec<Vec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = std::collections::BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        let key = if a < b { (a, b) } else { (b, a) };
        *middles.entry(key).or_insert_with(|| {
            corners.push((corners[a as usize] + corners[b as usize]).normalize());
            corners.len() as u32 - 1
        })
    };
    let mut halved = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        halved.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    halved
}

impl TriangleMesh {
    fn flattened_at_y0(mut self) -> Self {
        for position in &mut self.positions {
            *position = Vec3::new(position.x, 0.0, position.z);
        }
        self.normals.fill(Vec3::Y);
        self
    }
}

/// A prism along Y over a triangle of (x, z), counter-clockwise as seen from above, with flat faces.
pub fn upright_prism([a, b, c]: [(f32, f32); 3], half_height: f32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for ((x0, z0), (x1, z1)) in [(a, b), (b, c), (c, a)] {
        let along = Vec3::new(x1 - x0, 0.0, z1 - z0);
        mesh.join(&TriangleMesh {
            positions: vec![
                Vec3::new(x0, -half_height, z0),
                Vec3::new(x1, -half_height, z1),
                Vec3::new(x1, half_height, z1),
                Vec3::new(x0, half_height, z0),
            ],
            normals: vec![along.cross(Vec3::Y).normalize(); 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..TriangleMesh::default()
        });
    }
    for (y, normal, indices) in [(half_height, Vec3::Y, [0, 1, 2]), (-half_height, Vec3::NEG_Y, [0, 2, 1])] {
        mesh.join(&TriangleMesh {
            positions: [a, b, c].map(|(x, z)| Vec3::new(x, y, z)).to_vec(),
            normals: vec![normal; 3],
            indices: indices.to_vec(),
            ..TriangleMesh::default()
        });
    }
    mesh
}
