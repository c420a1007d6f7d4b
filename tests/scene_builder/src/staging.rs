//! Parts that most scenes share: a camera, lights, floors and animation clips.

use glam::{Mat3, Quat, Vec3};

use crate::document::Gltf;
use crate::json::{Json, list, object};
use crate::material::Material;
use crate::node::Node;
use crate::shapes;

/// Aspect ratio of the cameras, width over height.
pub const ASPECT_RATIO: f32 = 16.0 / 9.0;

/// The upright rotation whose −Z axis points from `eye` towards `target`.
pub fn looking(eye: Vec3, target: Vec3) -> Quat {
    let backward = (eye - target).normalize();
    // For a view straight up or down, the top of the image is towards −Z.
    let up = if backward.y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y };
    let right = up.cross(backward).normalize();
    Quat::from_mat3(&Mat3::from_cols(right, backward.cross(right), backward)).normalize()
}

/// Adds a perspective camera; the angle is the whole vertical field of view.
pub fn perspective(gltf: &mut Gltf, fov_y_degrees: f32, aspect_ratio: Option<f32>) -> usize {
    let mut perspective = object([("yfov", fov_y_degrees.to_radians().into()), ("znear", 0.1.into())]);
    if let Some(aspect_ratio) = aspect_ratio {
        perspective.set("aspectRatio", aspect_ratio);
    }
    gltf.add("cameras", object([("type", "perspective".into()), ("perspective", perspective)]))
}

/// Adds a perspective camera of [`ASPECT_RATIO`] and its node.
pub fn camera(gltf: &mut Gltf, eye: Vec3, target: Vec3, fov_y_degrees: f32) -> usize {
    let camera = perspective(gltf, fov_y_degrees, Some(ASPECT_RATIO));
    gltf.node(
        Node { camera: Some(camera), ..Node::default() }
            .named("camera")
            .at(eye.x, eye.y, eye.z)
            .turned(looking(eye, target)),
    )
}

/// Adds a punctual light of `kind` "point" or "directional", in candela or lux.
pub fn light(gltf: &mut Gltf, kind: &str, color: [f32; 3], intensity: f32) -> usize {
    gltf.light(object([("type", kind.into()), ("color", list(color)), ("intensity", intensity.into())]))
}

/// Adds a white point light and its node; the intensity is in candela.
pub fn point_light(gltf: &mut Gltf, position: Vec3, intensity: f32) -> usize {
    let light = light(gltf, "point", [1.0; 3], intensity);
    gltf.node(Node { light: Some(light), ..Node::default() }.at(position.x, position.y, position.z))
}

/// Adds a white directional light, from `from` towards the origin, and its node; the intensity is in lux.
pub fn directional_light(gltf: &mut Gltf, from: Vec3, intensity: f32) -> usize {
    let light = light(gltf, "directional", [1.0; 3], intensity);
    gltf.node(Node { light: Some(light), ..Node::default() }.turned(looking(from, Vec3::ZERO)))
}

/// Adds a key light from the upper right of π lux, in which white diffuse surfaces that face it have radiance 1, and a
/// weak fill light from the upper left, so that shadows are not black.
pub fn key_and_fill(gltf: &mut Gltf) {
    directional_light(gltf, Vec3::new(1.0, 1.6, 1.4), std::f32::consts::PI);
    directional_light(gltf, Vec3::new(-1.0, 1.0, 1.2), 0.5);
}

/// Adds a camera and the key and fill lights, for scenes that are not about light.
pub fn lit_stage(gltf: &mut Gltf, eye: Vec3, target: Vec3, fov_y_degrees: f32) {
    camera(gltf, eye, target, fov_y_degrees);
    key_and_fill(gltf);
}

/// Adds a grey floor at y = 0 and its node.
pub fn grey_floor(gltf: &mut Gltf, width: f32, depth: f32) -> usize {
    let material = Material::matte("floor", [0.6, 0.6, 0.6]).add_to(gltf);
    let mesh = shapes::floor(width, depth).plain().add_to(gltf, material);
    gltf.node(Node::mesh(mesh).named("floor"))
}

/// Adds a mesh of `columns` times `rows` squares in two materials in the plane z = 0, facing +Z.
pub fn chequered_wall(gltf: &mut Gltf, cells: [u32; 2], cell: f32, materials: [usize; 2]) -> usize {
    let [columns, rows] = cells;
    let mut positions = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let x = (column as f32 - columns as f32 / 2.0) * cell;
            positions.push(Vec3::new(x, (rows as f32 / 2.0 - row as f32) * cell, 0.0));
        }
    }
    let normals = vec![Vec3::Z; positions.len()];
    let attributes =
        object([("POSITION", gltf.positions(&positions).into()), ("NORMAL", gltf.vec3s(&normals).into())]);
    let cells = shapes::grid_indices(columns, rows, false);
    let primitives = [0, 1].map(|colour| {
        let chosen = cells.chunks_exact(6).enumerate().filter(|(index, _)| {
            let (row, column) = (*index as u32 / columns, *index as u32 % columns);
            (row + column) % 2 == colour
        });
        let indices: Vec<u32> = chosen.flat_map(|(_, corners)| corners.iter().copied()).collect();
        object([
            ("attributes", attributes.clone()),
            ("indices", gltf.indices(&indices).into()),
            ("material", materials[colour as usize].into()),
        ])
    });
    gltf.add("meshes", object([("primitives", list(primitives))]))
}

/// Adds a chequered floor at y = 0 in two greys and its node.
pub fn chequered_floor(gltf: &mut Gltf, cells: [u32; 2], cell: f32) -> usize {
    let light = Material::matte("light squares", [0.75, 0.75, 0.72]).add_to(gltf);
    let dark = Material::matte("dark squares", [0.12, 0.14, 0.2]).add_to(gltf);
    let mesh = chequered_wall(gltf, cells, cell, [light, dark]);
    gltf.node(Node::mesh(mesh).named("floor").turned(Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2)))
}

/// One channel of a clip.
#[derive(Clone, Debug)]
pub struct Track<'a> {
    pub node: usize,
    /// "translation", "rotation", "scale" or "weights".
    pub path: &'static str,
    /// "STEP", "LINEAR" or "CUBICSPLINE".
    pub interpolation: &'static str,
    pub times: &'a [f32],
    /// Flattened values; with CUBICSPLINE in-tangent, value and out-tangent for each key.
    pub values: Vec<f32>,
}

/// Adds a clip.
pub fn clip(gltf: &mut Gltf, name: &str, tracks: &[Track<'_>]) {
    let mut samplers: Vec<Json> = Vec::new();
    let mut channels: Vec<Json> = Vec::new();
    // Tracks with the same times share one accessor.
    let mut inputs: Vec<(&[f32], usize)> = Vec::new();
    for track in tracks {
        let known = inputs.iter().find(|(times, _)| *times == track.times).map(|(_, accessor)| *accessor);
        let input = known.unwrap_or_else(|| {
            let accessor = gltf.track("SCALAR", 1, track.times);
            inputs.push((track.times, accessor));
            accessor
        });
        let output = match track.path {
            "rotation" => gltf.track("VEC4", 4, &track.values),
            "weights" => gltf.track("SCALAR", 1, &track.values),
            _ => gltf.track("VEC3", 3, &track.values),
        };
        channels.push(object([
            ("sampler", samplers.len().into()),
            ("target", object([("node", track.node.into()), ("path", track.path.into())])),
        ]));
        samplers.push(object([
            ("input", input.into()),
            ("interpolation", track.interpolation.into()),
            ("output", output.into()),
        ]));
    }
    gltf.add(
        "animations",
        object([("name", name.into()), ("samplers", samplers.into()), ("channels", channels.into())]),
    );
}

/// The components of several vectors in a row.
pub fn flat3(values: &[Vec3]) -> Vec<f32> {
    values.iter().flat_map(Vec3::to_array).collect()
}

/// The components of several rotations in a row.
pub fn flat4(values: &[Quat]) -> Vec<f32> {
    values.iter().flat_map(Quat::to_array).collect()
}
