//! Scenes that hierarchies are compared on: generated ones, triangle lists with a camera beside them, and glTF files.

use std::path::Path;

use glam::{Quat, Vec3};
use scene_builder::shapes::{TriangleMesh, cuboid, cylinder, ico_sphere, strip};

use rayframe::frame::Frame;
use rayframe::framing::resolve_camera;
use rayframe::geometry::{Aabb, Triangle};
use rayframe::gltf::{ImportOptions, import};
use rayframe::scene::{Projection, Scene, Selection, SelectionRequest, ViewRequest};

use super::Result;
use super::references::{bounds_of, whole};

/// Names of the generated scenes.
pub(crate) const GENERATED: [&str; 4] = ["scan", "mirror-hall", "mirror-hall-fine", "plant"];

/// Triangles with a camera and a lamp.
#[derive(Debug)]
pub(crate) struct TestScene {
    pub(crate) name: String,
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) view: View,
}

/// Camera and lamp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) eye: Vec3,
    pub(crate) target: Vec3,
    pub(crate) up: Vec3,
    /// Vertical field of view, degrees.
    pub(crate) degrees: f32,
    pub(crate) lamp: Vec3,
}

impl TestScene {
    /// A generated scene of that name, or the file.
    pub(crate) fn open(name: &str) -> Result<Self> {
        let (triangles, view) = match name {
            "scan" => scan(6),
            "mirror-hall" => mirror_hall(1),
            "mirror-hall-fine" => mirror_hall(24),
            "plant" => plant(7000),
            name if pipes_of(name).is_some() => plant(pipes_of(name).unwrap_or_default()),
            file if Path::new(file).extension().is_some_and(|ending| ending == "tri") => triangle_list(file)?,
            file => gltf(file)?,
        };
        let triangles: Vec<_> = triangles.into_iter().filter(super::references::is_finite).collect();
        let name = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if triangles.is_empty() {
            Err(format!("{name} has no triangles").into())
        } else {
            Ok(Self { name, triangles, view })
        }
    }

    /// Leaves out triangles whose box has more than a share of the area of the scene's box.
    ///
    /// # Errors
    /// Nothing is left.
    pub(crate) fn leave_out_large(&mut self, largest: f64) -> Result<()> {
        let references = whole(&self.triangles);
        let limit = largest * bounds_of(&references).area();
        let mut kept = references.iter().map(|reference| reference.bounds.area() <= limit);
        self.triangles.retain(|_| kept.next().unwrap_or(true));
        if self.triangles.is_empty() {
            return Err(format!("--largest {largest} leaves no triangle of {}", self.name).into());
        }
        Ok(())
    }
}

fn look(eye: [f32; 3], target: [f32; 3], lamp: [f32; 3]) -> View {
    View { eye: eye.into(), target: target.into(), up: Vec3::Y, degrees: 60.0, lamp: lamp.into() }
}

fn add(triangles: &mut Vec<Triangle>, mesh: &TriangleMesh) {
    let corner = |index: &u32| mesh.positions[*index as usize];
    triangles.extend(mesh.indices.chunks_exact(3).map(|corners| Triangle {
        vertices: [corner(&corners[0]), corner(&corners[1]), corner(&corners[2])],
    }));
}

/// A dense closed surface of about equal triangles, as scans have: 20 · 4^level.
pub(crate) fn scan(level: u32) -> (Vec<Triangle>, View) {
    let mut mesh = ico_sphere(1.0, level);
    for position in &mut mesh.positions {
        let p = *position * 5.0;
        let bumps = libm::sinf(p.x * 1.3 + libm::sinf(p.y * 2.1)) * libm::sinf(p.z * 1.7 + p.x) * 0.18;
        let wrinkles = libm::sinf(p.x * 9.0) * libm::sinf(p.y * 8.0) * libm::sinf(p.z * 10.0) * 0.02;
        *position *= 1.0 + bumps + wrinkles;
    }
    let mut triangles = Vec::new();
    add(&mut triangles, &mesh);
    (triangles, look([0.0, 0.6, 2.6], [0.0, 0.0, 0.0], [4.0, 6.0, 3.0]))
}

/// An interior of large faces with a mirror on a wall, as one of Ernst and Greiner's scenes: beams cross it, and furniture stands askew. Every
/// face is cut into `rows` strips.
fn mirror_hall(rows: u32) -> (Vec<Triangle>, View) {
    let mut triangles = Vec::new();
    let mut face = |width: f32, height: f32, turn: Quat, place: Vec3| {
        add(&mut triangles, &strip(width, height, rows).moved(1.0, turn, place));
    };
    let quarter = std::f32::consts::FRAC_PI_2;
    let (width, height, depth) = (8.0, 3.0, 6.0);
    face(width, depth, Quat::from_rotation_x(-quarter), Vec3::ZERO);
    face(width, depth, Quat::from_rotation_x(quarter), Vec3::Y * height);
    for (side, turn) in [(-1.0, 0.0), (1.0, std::f32::consts::PI)] {
        face(width, height, Quat::from_rotation_y(turn), Vec3::new(0.0, height / 2.0, side * depth / 2.0));
        face(
            depth,
            height,
            Quat::from_rotation_y(turn + quarter),
            Vec3::new(side * width / 2.0, height / 2.0, 0.0),
        );
    }
    face(3.0, 1.8, Quat::IDENTITY, Vec3::new(0.0, 1.5, 0.02 - depth / 2.0));
    // The six faces of each box.
    let mut block = |size: Vec3, turn: Quat, place: Vec3| {
        let half = size * 0.5;
        for (normal, width, height) in
            [(Vec3::X, size.z, size.y), (Vec3::Y, size.x, size.z), (Vec3::Z, size.x, size.y)]
        {
            for sign in [-1.0, 1.0] {
                let facing = Quat::from_rotation_arc(Vec3::Z, normal * sign);
                face(width, height, turn * facing, place + turn * (normal * sign * half));
            }
        }
    };
    for beam in 0..6 {
        let turn = Quat::from_rotation_y(0.35 + 0.1 * beam as f32) * Quat::from_rotation_z(0.25);
        let place = Vec3::new(0.4 * beam as f32 - 1.0, 2.2 - 0.1 * beam as f32, 0.9 * beam as f32 - 2.2);
        block(Vec3::new(6.5, 0.12, 0.12), turn, place);
    }
    for item in 0..24 {
        let at = item as f32;
        let turn = Quat::from_rotation_y(0.7 * at);
        let size = Vec3::new(0.9 + 0.1 * libm::sinf(at), 0.06, 0.5);
        let place = Vec3::new(3.2 * libm::sinf(2.4 * at), 0.5 + 0.02 * at, 2.2 * libm::cosf(1.7 * at));
        block(size, turn, place);
        for leg in [-0.4, 0.4] {
            block(Vec3::new(0.05, 0.5, 0.05), turn, place + turn * Vec3::new(leg, -0.28, 0.0));
        }
    }
    (triangles, look([2.6, 1.7, 2.6], [-0.6, 1.1, -2.0], [0.5, 2.8, 0.3]))
}

/// N of the name `plant-N`.
fn pipes_of(name: &str) -> Option<u32> {
    name.strip_prefix("plant-")?.parse().ok()
}

/// Long pipes and beams in all directions, as the paper's power plant: over a million triangles for 7000. The fewer, the less do
/// boxes overlap.
fn plant(pipes: u32) -> (Vec<Triangle>, View) {
    const SEGMENTS: u32 = 48;
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut triangles = Vec::new();
    for index in 0..pipes {
        let place = Vec3::new(random(), random(), random()) * Vec3::new(60.0, 24.0, 60.0)
            - Vec3::new(30.0, 0.0, 30.0);
        let turn = match index % 4 {
            0 => Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
            1 => Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
            2 => Quat::IDENTITY,
            _ => {
                Quat::from_rotation_y(std::f32::consts::TAU * random())
                    * Quat::from_rotation_z(std::f32::consts::PI * random())
            }
        };
        let length = 4.0 + 26.0 * random() * random();
        if index % 5 == 0 {
            add(&mut triangles, &cuboid(0.2, length, 0.12).moved(1.0, turn, place));
        } else {
            add(
                &mut triangles,
                &cylinder(0.04 + 0.2 * random() * random(), length, SEGMENTS).moved(1.0, turn, place),
            );
        }
    }
    (triangles, look([34.0, 14.0, 34.0], [0.0, 10.0, 0.0], [20.0, 40.0, 10.0]))
}

/// A file of nine little-endian floats a triangle, and a camera beside it: eye, target, up, vertical field of view in degrees, lamp.
fn triangle_list(file: &str) -> Result<(Vec<Triangle>, View)> {
    let bytes = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
    let (words, _) = bytes.as_chunks::<4>();
    let floats: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    let (corners, _) = floats.as_chunks::<3>();
    let (triples, _) = corners.as_chunks::<3>();
    let triangles = triples.iter().map(|triple| Triangle { vertices: triple.map(Vec3::from_array) });
    let camera = Path::new(file).with_extension("cam");
    let text = std::fs::read_to_string(&camera).map_err(|error| format!("{}: {error}", camera.display()))?;
    let numbers = text.split_whitespace().map(str::parse).collect::<std::result::Result<Vec<f32>, _>>()?;
    let [a, b, c, d, e, f, g, h, i, degrees, l, m, n] = numbers[..] else {
        return Err(format!("{}: 13 numbers are needed", camera.display()).into());
    };
    let [eye, target, up, lamp] = [[a, b, c], [d, e, f], [g, h, i], [l, m, n]].map(Vec3::from_array);
    Ok((triangles.collect(), View { eye, target, up, degrees, lamp }))
}

/// The first frame of a glTF file, from its camera.
fn gltf(file: &str) -> Result<(Vec<Triangle>, View)> {
    let scene: Scene = import(Path::new(file), &ImportOptions::default())?;
    let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene)?;
    let selection = resolve_camera(&scene, selection, &ViewRequest::default(), 1.0).selection;
    let mut frame = Frame::default();
    frame.pose(&scene, &selection, 0.0);
    let camera = frame.camera.world_from_camera;
    let eye = camera.w_axis.truncate();
    let degrees = match frame.camera.projection {
        Projection::Perspective { fov_y_radians, .. } => fov_y_radians.to_degrees(),
        Projection::Orthographic { .. } => 45.0,
    };
    let bounds = frame.triangles.iter().fold(Aabb::EMPTY, |all, triangle| all.union(triangle.bounds()));
    let lamp = bounds.center() + bounds.extent() * Vec3::new(0.3, 1.0, 0.2);
    let (target, up) = (eye - camera.z_axis.truncate(), camera.y_axis.truncate());
    Ok((frame.triangles, View { eye, target, up, degrees, lamp }))
}
