//! The demo: a homage to the glass and mirror spheres over a chequered floor of Turner Whitted, "An Improved
//! Illumination Model for Shaded Display", 1980, with things that move beside them.
//!
//! Light. There is no environment in the file: the sky is a dome that emits its colour and has all lamps inside, so
//! that it shades nothing. The key lamp is far away, I / d² = 18500 / 5525 = 3.35 lux at the origin, where it stands at
//! cos θ = 0.74 over the floor: yellow squares get 0.85 · 3.35 · 0.74 / π = 0.67, red ones 0.51. A bluish fill of
//! 0.5 lux keeps shadows from being black.

use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3, Vec4};

use crate::demo_bodies::{KEYS, star_mesh, sway, tentacle_joints, tentacle_mesh};
use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image};
use scene_builder::material::{Alpha, Material, TextureUse, Volume};
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, grid_indices, uv_sphere};
use scene_builder::staging::{ASPECT_RATIO, Track, clip, flat3, flat4, light, looking, perspective};

pub(crate) const SCENES: [Entry; 1] = [entry("demo/whitted_1980", whitted_1980)];

/// Length of the looping clip, seconds.
const SECONDS: f32 = 3.0;
/// Radius of the sky.
const SKY_RADIUS: f32 = 140.0;
/// Metres that one repeat of the chequer, four squares, covers.
const TILE_OF_CHEQUER: f32 = 5.0;
/// Centre and radius of the camera's orbit.
const PIVOT: Vec3 = Vec3::new(0.1, 1.3, 0.0);
const CAMERA_DISTANCE: f32 = 8.2;

fn whitted_1980() -> Built {
    let mut gltf = Gltf::new(
        "A clear glass ball floats before a mirror ball over a red and yellow chequered floor under a blue sky; behind them \
         two tentacles sway, before them a golden star swells and shrinks, and the camera drifts from side to side. After \
         3 s all is as at the start.",
    );
    gltf.reference_frames(&[0, 30]);
    let times: Vec<f32> = (0..=KEYS).map(|key| SECONDS * key as f32 / KEYS as f32).collect();
    let mut tracks = vec![drifting_camera(&mut gltf, &times)];
    lamps(&mut gltf);
    sky(&mut gltf);
    chequered_ground(&mut gltf)?;
    tracks.extend(balls(&mut gltf, &times));
    tracks.extend(tentacles(&mut gltf, &times));
    tracks.extend(star(&mut gltf, &times));
    clip(&mut gltf, "drift", &tracks);
    Ok(gltf)
}

/// `count` values of a closed movement, by its phase from 0 to a whole turn; the last is exactly the first.
fn cycle<T>(value: impl Fn(f32) -> T) -> Vec<T> {
    (0..=KEYS).map(|key| value(TAU * (key % KEYS) as f32 / KEYS as f32)).collect()
}

/// The values of a closed movement, `width` numbers a key, as a smooth CUBICSPLINE: the tangents are half the
/// difference of the keys before and after, a second.
fn smooth(values: &[f32], width: usize) -> Vec<f32> {
    let keys: Vec<&[f32]> = values.chunks_exact(width).collect();
    let (count, step) = (KEYS as usize, SECONDS / KEYS as f32);
    let mut spline = Vec::with_capacity(3 * values.len());
    for (index, key) in keys.iter().enumerate() {
        let (before, after) = (keys[(index + count - 1) % count], keys[(index + 1) % count]);
        let tangent: Vec<f32> = before.iter().zip(after).map(|(a, b)| (b - a) / (2.0 * step)).collect();
        spline.extend(&tangent);
        spline.extend(*key);
        spline.extend(&tangent);
    }
    spline
}

fn drifting_camera<'a>(gltf: &mut Gltf, times: &'a [f32]) -> Track<'a> {
    let camera = perspective(gltf, 34.0, Some(ASPECT_RATIO));
    let eye = Vec3::new(0.0, 0.85, CAMERA_DISTANCE);
    let camera = Node { camera: Some(camera), ..Node::default() }.named("camera").at(eye.x, eye.y, eye.z);
    let camera = gltf.node(camera.turned(looking(eye, Vec3::ZERO)));
    let pivot = gltf.node(Node::group(&[camera]).named("camera pivot").at(PIVOT.x, PIVOT.y, PIVOT.z));
    let turns = cycle(|phase| Quat::from_rotation_y(0.12 * libm::sinf(phase)));
    Track { node: pivot, path: "rotation", interpolation: "LINEAR", times, values: flat4(&turns) }
}

fn lamps(gltf: &mut Gltf) {
    let key = light(gltf, "point", [1.0, 0.96, 0.88], 18500.0);
    gltf.node(Node { light: Some(key), ..Node::default() }.named("key").at(-30.0, 55.0, 40.0));
    let fill = light(gltf, "point", [0.65, 0.8, 1.0], 1950.0);
    gltf.node(Node { light: Some(fill), ..Node::default() }.named("fill").at(35.0, 25.0, 45.0));
}

fn sky(gltf: &mut Gltf) {
    let mut dome = uv_sphere(SKY_RADIUS, 32, 64).plain().inverted();
    dome.normals.clear();
    let horizon = Vec3::new(0.6, 0.77, 0.95);
    let zenith = Vec3::new(0.06, 0.2, 0.6);
    dome.colors = dome
        .positions
        .iter()
        .map(|position| {
            let height = (position.y / SKY_RADIUS).clamp(0.0, 1.0);
            // Most of the change is near the horizon, where the camera looks.
            let below = (1.0 - height) * (1.0 - height) * (1.0 - height);
            let rise = 1.0 - below * below;
            horizon.lerp(zenith, rise).extend(1.0)
        })
        .collect();
    let material = Material::unlit("sky", [1.0; 3]).add_to(gltf);
    let mesh = dome.add_to(gltf, material);
    gltf.node(Node::mesh(mesh).named("sky"));
}

fn chequered_ground(gltf: &mut Gltf) -> Built<()> {
    let chequer = Image::chequer(256, 64, [240, 210, 62], [208, 44, 30]);
    let texture = chequer.texture(gltf, "chequer", Filter::Mipmapped)?;
    let near = Material {
        base_color_texture: Some(TextureUse::of(texture)),
        roughness: 0.9,
        ..Material::matte("ground", [1.0; 3])
    };
    let far = Material { alpha: Alpha::Blend, name: "ground that fades into the sky", ..near };
    // The far ring fades out towards the horizon.
    let near_mesh = ring(&[0.0, 8.0, 20.0, 36.0], |_| 1.0);
    let far_mesh = ring(&[36.0, 48.0, 64.0, 84.0, 110.0], |radius| {
        let share = (110.0 - radius) / (110.0 - 36.0);
        share * share
    });
    for (shape, material, name) in [(near_mesh, near, "ground"), (far_mesh, far, "far ground")] {
        let material = material.add_to(gltf);
        let mesh = shape.add_to(gltf, material);
        gltf.node(Node::mesh(mesh).named(name));
    }
    Ok(())
}

/// A flat ring in the plane y = 0, facing up, with rows at `radii` from the inside out and its alpha by radius.
fn ring(radii: &[f32], alpha: impl Fn(f32) -> f32) -> TriangleMesh {
    let segments = 48;
    let mut shape = TriangleMesh::default();
    for &radius in radii {
        for segment in 0..=segments {
            let (sin, cos) = libm::sincosf(TAU * (segment % segments) as f32 / segments as f32);
            shape.positions.push(Vec3::new(sin, 0.0, cos) * radius);
            shape.normals.push(Vec3::Y);
            shape.uvs.push(Vec2::new(sin, cos) * (radius / TILE_OF_CHEQUER));
            shape.colors.push(Vec4::new(1.0, 1.0, 1.0, alpha(radius)));
        }
    }
    shape.indices = grid_indices(segments, radii.len() as u32 - 1, false);
    shape.without_collapsed()
}

fn balls<'a>(gltf: &mut Gltf, times: &'a [f32]) -> [Track<'a>; 2] {
    let glass = Material {
        volume: Some(Volume { thickness: 1.0, attenuation: Some((6.0, [0.86, 0.95, 0.92])) }),
        ..Material::glass("glass", 1.5)
    };
    let materials = [glass.add_to(gltf), Material::metal("mirror", [0.93, 0.94, 0.96], 0.0).add_to(gltf)];
    let balls = uv_sphere(1.0, 128, 64).plain().add_with_each(gltf, &materials);
    let glass = gltf.node(Node::mesh(balls[0]).named("glass ball").scaled(1.15, 1.15, 1.15));
    let mirror = gltf.node(Node::mesh(balls[1]).named("mirror ball").scaled(0.95, 0.95, 0.95));
    let around = |node, centre: Vec3, reach: Vec3, offset: f32| {
        let places = cycle(|phase| {
            let (sin, cos) = libm::sincosf(phase + offset);
            centre + reach * Vec3::new(cos, sin, sin)
        });
        Track {
            node,
            path: "translation",
            interpolation: "CUBICSPLINE",
            times,
            values: smooth(&flat3(&places), 3),
        }
    };
    [
        around(glass, Vec3::new(-0.6, 1.75, 1.3), Vec3::new(0.14, 0.16, 0.2), 0.4),
        around(mirror, Vec3::new(1.4, 1.2, -0.9), Vec3::new(0.22, 0.14, -0.3), 2.4),
    ]
}

fn tentacles<'a>(gltf: &mut Gltf, times: &'a [f32]) -> Vec<Track<'a>> {
    let skin = Material { roughness: 0.22, ..Material::matte("skin", [0.02, 0.3, 0.32]) };
    let material = skin.add_to(gltf);
    let mesh = tentacle_mesh(gltf, material);
    let mut tracks = Vec::new();
    let places = [(Vec3::new(-3.0, 0.0, -1.0), 1.15, 1.0, 0.0), (Vec3::new(3.6, 0.0, -3.0), 1.0, -0.9, 2.0)];
    for (foot, scale, curl, phase) in places {
        let (joints, skin) = tentacle_joints(gltf, foot, scale);
        gltf.node(Node { skin: Some(skin), ..Node::mesh(mesh).named("tentacle") });
        tracks.extend(sway(&joints, times, curl, phase));
    }
    tracks
}

fn star<'a>(gltf: &mut Gltf, times: &'a [f32]) -> [Track<'a>; 2] {
    let gold = Material::metal("gold", [1.0, 0.74, 0.32], 0.1).add_to(gltf);
    let mesh = star_mesh(gltf, 0.42, gold);
    let node = gltf.node(Node::mesh(mesh).named("star").at(2.2, 0.8, 1.7));
    let pulse: Vec<f32> = cycle(|phase| {
        let cos = libm::cosf(phase + 1.8);
        [0.55 - 0.45 * cos, 0.25 + 0.25 * cos]
    })
    .concat();
    // A fifth of a turn about a corner's axis brings the spikes back on themselves.
    let axis = scene_builder::shapes::ico_sphere(1.0, 0).positions[3];
    let rotations: Vec<Quat> =
        (0..=KEYS).map(|key| Quat::from_axis_angle(axis, TAU / 5.0 * key as f32 / KEYS as f32)).collect();
    [
        Track { node, path: "weights", interpolation: "CUBICSPLINE", times, values: smooth(&pulse, 2) },
        Track { node, path: "rotation", interpolation: "LINEAR", times, values: flat4(&rotations) },
    ]
}
