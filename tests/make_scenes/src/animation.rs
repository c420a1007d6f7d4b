//! Scenes of `animation/`. Frames are at 24 fps: frame 12 is 0.5 s.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, cuboid, ico_sphere};
use scene_builder::staging::{Track, clip, flat3, flat4, grey_floor, lit_stage};

pub(crate) const SCENES: [Entry; 5] = [
    entry("animation/step_linear_cubic", step_linear_cubic),
    entry("animation/rotation_shortest_arc", rotation_shortest_arc),
    entry("animation/hierarchy", hierarchy),
    entry("animation/cubic_quaternion", cubic_quaternion),
    entry("animation/before_first_key", before_first_key),
];

fn step_linear_cubic() -> Built {
    let mut gltf = Gltf::new(
        "Three cubes rise from 0.3 to 2.1 m between 0 and 1 s: red jumps at the end (STEP), green moves evenly (LINEAR), \
         blue starts and ends slowly and is at 0.58, 1.2 and 1.82 m after a quarter, half and three quarters (CUBICSPLINE \
         with zero tangents).",
    );
    gltf.reference_frames(&[0, 6, 18, 24]);
    lit_stage(&mut gltf, Vec3::new(0.0, 1.4, 6.0), Vec3::new(0.0, 1.2, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    let colors = [("step", [0.7, 0.07, 0.05]), ("linear", [0.08, 0.5, 0.1]), ("cubic", [0.06, 0.15, 0.65])];
    let materials = colors.map(|(name, color)| Material::matte(name, color).add_to(&mut gltf));
    let cubes = cuboid(0.6, 0.6, 0.6).plain().add_with_each(&mut gltf, &materials);
    let mut tracks = Vec::new();
    for (index, interpolation) in ["STEP", "LINEAR", "CUBICSPLINE"].into_iter().enumerate() {
        let x = index as f32 - 1.0;
        let node = gltf.node(Node::mesh(cubes[index]).named(colors[index].0).at(x, 0.3, 0.0));
        let (low, high) = (Vec3::new(x, 0.3, 0.0), Vec3::new(x, 2.1, 0.0));
        let values = match interpolation {
            "CUBICSPLINE" => flat3(&[Vec3::ZERO, low, Vec3::ZERO, Vec3::ZERO, high, Vec3::ZERO]),
            _ => flat3(&[low, high]),
        };
        tracks.push(Track { node, path: "translation", interpolation, times: &[0.0, 1.0], values });
    }
    clip(&mut gltf, "rise", &tracks);
    Ok(gltf)
}

/// An arrow along +Y from the origin, one unit long.
fn arrow() -> TriangleMesh {
    let mut arrow = cuboid(0.08, 0.8, 0.08).moved(1.0, Quat::IDENTITY, Vec3::new(0.0, 0.4, 0.0));
    let head =
        cuboid(0.22, 0.22, 0.08).moved(1.0, Quat::from_rotation_z(PI / 4.0), Vec3::new(0.0, 0.85, 0.0));
    arrow.join(&head);
    arrow.plain()
}

fn rotation_shortest_arc() -> Built {
    let mut gltf = Gltf::new(
        "Two clock hands turn from 12 to 4 o'clock in 1 s, by 120° clockwise. The right one's last quaternion is \
         negated, which is the same rotation: both point to 1, 2 and 4 o'clock after a quarter, a half and all.",
    );
    gltf.reference_frames(&[6, 12, 24]);
    lit_stage(&mut gltf, Vec3::new(0.0, 0.9, 4.5), Vec3::new(0.0, 0.9, 0.0), 32.0);
    let wall = Material::matte("wall", [0.6; 3]).add_to(&mut gltf);
    let wall = scene_builder::shapes::quad(8.0, 5.0).plain().add_to(&mut gltf, wall);
    gltf.node(Node::mesh(wall).at(0.0, 0.9, -0.3));
    let paint = Material::matte("arrow", [0.65, 0.3, 0.05]).add_to(&mut gltf);
    let arrow = arrow().add_to(&mut gltf, paint);
    let turned = Quat::from_rotation_z(-2.0 * PI / 3.0);
    let mut tracks = Vec::new();
    for (x, last) in [(-1.0, turned), (1.0, -turned)] {
        let node = gltf.node(Node::mesh(arrow).at(x, 0.9, 0.0));
        let values = flat4(&[Quat::IDENTITY, last]);
        tracks.push(Track { node, path: "rotation", interpolation: "LINEAR", times: &[0.0, 1.0], values });
    }
    clip(&mut gltf, "turn", &tracks);
    Ok(gltf)
}

fn hierarchy() -> Built {
    let mut gltf = Gltf::new(
        "A planet circles a sun in 2 s and a moon circles the planet in 1 s: after 0.5 s the planet is behind the sun's \
         axis and the moon, half way round, between the two. Sizes set on the balls do not reach their children.",
    );
    gltf.reference_frames(&[0, 6, 12]);
    lit_stage(&mut gltf, Vec3::new(0.0, 4.0, 4.5), Vec3::ZERO, 32.0);
    let colors = [("sun", [0.8, 0.6, 0.1]), ("planet", [0.1, 0.3, 0.7]), ("moon", [0.6; 3])];
    let materials = colors.map(|(name, color)| Material::matte(name, color).add_to(&mut gltf));
    let balls = ico_sphere(1.0, 2).add_with_each(&mut gltf, &materials);
    let moon = gltf.node(Node::mesh(balls[2]).named("moon").at(0.5, 0.0, 0.0).scaled(0.1, 0.1, 0.1));
    let moon_orbit = gltf.node(Node::group(&[moon]).named("moon orbit"));
    let planet = gltf.node(Node::mesh(balls[1]).named("planet").scaled(0.25, 0.25, 0.25));
    let place = gltf.node(Node::group(&[planet, moon_orbit]).named("planet's place").at(1.5, 0.0, 0.0));
    let planet_orbit = gltf.node(Node::group(&[place]).named("planet orbit"));
    gltf.node(Node::mesh(balls[0]).named("sun").scaled(0.5, 0.5, 0.5));
    // Quarter turns, so that every step is shorter than half a turn.
    let quarters: Vec<Quat> =
        (0..=4).map(|quarter| Quat::from_rotation_y(FRAC_PI_2 * quarter as f32)).collect();
    let slow = [0.0, 0.5, 1.0, 1.5, 2.0];
    let fast = [0.0, 0.25, 0.5, 0.75, 1.0];
    let track = |node, times| Track {
        node,
        path: "rotation",
        interpolation: "LINEAR",
        times,
        values: flat4(&quarters),
    };
    clip(&mut gltf, "orbits", &[track(planet_orbit, &slow), track(moon_orbit, &fast)]);
    Ok(gltf)
}

fn cubic_quaternion() -> Built {
    let mut gltf = Gltf::new(
        "A plank swings from 60° left to 60° right about the view axis by a CUBICSPLINE of quaternions whose blends are shorter \
         than one: it keeps its size, leans 43° to the left after a quarter of the time and is upright after half.",
    );
    gltf.reference_frames(&[0, 6, 12, 24]);
    lit_stage(&mut gltf, Vec3::new(0.0, 0.6, 4.5), Vec3::new(0.0, 0.6, 0.0), 32.0);
    let paint = Material::matte("plank", [0.5, 0.25, 0.08]).add_to(&mut gltf);
    let plank = cuboid(0.3, 1.6, 0.1).plain().add_to(&mut gltf, paint);
    let node = gltf.node(Node::mesh(plank).at(0.0, 0.6, 0.0));
    let (from, to) = (Quat::from_rotation_z(PI / 3.0), Quat::from_rotation_z(-PI / 3.0));
    let none = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let values = flat4(&[none, from, none, none, to, none]);
    let track = Track { node, path: "rotation", interpolation: "CUBICSPLINE", times: &[0.0, 1.0], values };
    clip(&mut gltf, "swing", &[track]);
    Ok(gltf)
}

fn before_first_key() -> Built {
    let mut gltf = Gltf::new(
        "A cube whose keys lie at 0.5 and 1 s: it waits at the left, at its first key and not at its node's place, until \
         0.5 s, is in the middle at 0.75 s and stays at the right after 1 s, while a small ball goes round until 1.5 s.",
    );
    gltf.reference_frames(&[0, 18, 30]);
    lit_stage(&mut gltf, Vec3::new(0.0, 1.2, 4.5), Vec3::new(0.0, 0.5, 0.0), 32.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    let red = Material::matte("cube", [0.7, 0.07, 0.05]).add_to(&mut gltf);
    let blue = Material::matte("ball", [0.06, 0.15, 0.65]).add_to(&mut gltf);
    let cube = cuboid(0.5, 0.5, 0.5).plain().add_to(&mut gltf, red);
    let ball = ico_sphere(0.12, 1).add_to(&mut gltf, blue);
    let cube = gltf.node(Node::mesh(cube).at(0.0, 0.25, -1.5));
    let ball = gltf.node(Node::mesh(ball).at(0.0, 1.2, 0.0));
    let cube_values = flat3(&[Vec3::new(-1.2, 0.25, 0.0), Vec3::new(1.2, 0.25, 0.0)]);
    let times: Vec<f32> = (0..=12).map(|key| key as f32 * 0.125).collect();
    let circle: Vec<Vec3> = (0..=12)
        .map(|key| {
            let (sin, cos) = libm::sincosf(TAU * key as f32 / 12.0);
            Vec3::new(1.3 * sin, 0.9 + 0.35 * cos, 0.0)
        })
        .collect();
    let tracks = [
        Track {
            node: cube,
            path: "translation",
            interpolation: "LINEAR",
            times: &[0.5, 1.0],
            values: cube_values,
        },
        Track {
            node: ball,
            path: "translation",
            interpolation: "LINEAR",
            times: &times,
            values: flat3(&circle),
        },
    ];
    clip(&mut gltf, "wait and go", &tracks);
    Ok(gltf)
}
