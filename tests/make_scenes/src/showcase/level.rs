//! A game level: a floating island with terraces, towers, trees, a pond and a bridge, inside a sky.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use super::level_parts::{
    barrel, bridge, conifer, crate_box, dome, pebble, platform, round_tree, stairs, tower,
};
use super::solids::{at, faceted, joined, lathe, limb, profile, rounded, surface};
use super::{Stage, metal, noise, paint};
use scene_builder::document::Built;
use scene_builder::material::Material;

/// Direction towards the sun.
const SUN: Vec3 = Vec3::new(1.0, 1.15, 0.15);

pub(super) fn level() -> Built {
    let mut stage = Stage::new(
        "A floating island in a sky: two terraces with stairs, a tall tower and a small one on an islet behind a rope bridge, \
         conifers and round trees, a pond, crates and barrels. The sun comes from the right. The sky dome is no part of what \
         the camera frames.",
    );
    let color = [
        paint("grass", 0x93b25c, 0.9),
        paint("rock", 0x94826f, 0.95),
        paint("stone", 0xcfc4b2, 0.9),
        paint("trim", 0xa99c8b, 0.9),
        paint("wood", 0x9c6f48, 0.8),
        paint("dark wood", 0x6d4a33, 0.8),
        paint("needles", 0x4f7f55, 0.9),
        paint("leaves", 0xc98f45, 0.9),
        paint("roof", 0xb4563f, 0.7),
    ]
    .map(|material| material.add_to(&mut stage.gltf));
    let [grass, rock, stone, trim, wood, dark, needles, leaves, roof] = color;
    let sky = Material::unlit("sky", [1.0; 3]).add_to(&mut stage.gltf);
    stage.add("sky dome", &[(dome(220.0, SUN), sky)], [0.0; 3], 0.0);
    for (name, radius, depth, floats, seed, position) in [
        ("island", 10.0, 8.5, true, 2, [0.0, 0.0, 0.0]),
        ("lower terrace", 5.0, 2.0, false, 5, [-3.2, 1.6, -3.2]),
        ("upper terrace", 2.9, 2.4, false, 7, [-4.4, 3.4, -4.6]),
        ("islet", 3.3, 4.5, true, 11, [14.6, 1.1, 2.6]),
    ] {
        stage.add(name, &platform(radius, depth, floats, seed, [grass, rock]), position, 0.0);
    }
    let glow = Material { emissive: [1.0, 0.72, 0.34], ..paint("lit window", 0xffd890, 0.5) };
    let glow = glow.add_to(&mut stage.gltf);
    let door = paint("door", 0x4b3527, 0.7).add_to(&mut stage.gltf);
    let keep = stage.mesh(&tower([stone, trim, roof, door, glow]));
    stage.stand("tower", keep, [-4.5, 3.4, -4.8], 0.0);
    stage.stand_scaled("watchtower", keep, [15.2, 1.1, 2.0], -30.0, 0.62);
    stage.add("lower stairs", &stairs(7, 1.6, 1.7, [stone, trim]), [-1.1, 0.0, 3.7], 8.0);
    stage.add("upper stairs", &stairs(8, 1.8, 1.4, [stone, trim]), [-2.2, 1.6, -0.5], 28.0);
    stage.add("bridge", &bridge(Vec3::new(3.2, 1.05, 0.0), [wood, dark]), [8.9, 0.05, 2.4], 0.0);
    trees(&mut stage, [dark, needles, leaves]);
    cargo(&mut stage, [wood, dark]);
    pond(&mut stage, rock);
    details(&mut stage, [wood, rock]);
    stage.sun(0xfff1dc, 3.4, SUN);
    stage.finished("level", Vec3::new(0.42, 0.56, 0.78), Vec3::new(0.30, 0.28, 0.25))
}

fn trees(stage: &mut Stage, [bark, needles, leaves]: [usize; 3]) {
    let conifers = stage.mesh(&conifer([bark, needles]));
    let round = stage.mesh(&round_tree([bark, leaves]));
    let spots = [
        (conifers, -7.9, 0.0, 1.2, 1.25),
        (conifers, -8.2, 0.0, -1.4, 0.95),
        (conifers, 0.4, 1.6, -6.0, 1.2),
        (conifers, -7.0, 1.6, -4.9, 1.0),
        (conifers, 2.2, 0.0, -7.6, 1.35),
        (conifers, 7.4, 0.0, -4.6, 1.15),
        (conifers, 4.6, 0.0, -8.0, 0.9),
        (round, -5.8, 0.0, 4.6, 1.1),
        (round, 7.6, 0.0, -1.2, 0.95),
        (round, -0.6, 1.6, -3.4, 0.7),
        (round, 13.2, 1.1, 4.2, 0.75),
        (conifers, 16.6, 1.1, 3.8, 0.8),
    ];
    for (index, (mesh, x, y, z, scale)) in spots.into_iter().enumerate() {
        let name = if mesh == round { "round tree" } else { "conifer" };
        stage.stand_scaled(name, mesh, [x, y, z], 77.0 * index as f32, scale);
    }
}

/// Crates and barrels on the shore.
fn cargo(stage: &mut Stage, [wood, dark]: [usize; 2]) {
    let iron = metal("iron", 0x6f7074, 0.45).add_to(&mut stage.gltf);
    let boards = paint("boards", 0xc09a66, 0.8).add_to(&mut stage.gltf);
    let crates = stage.mesh(&crate_box([boards, wood]));
    let barrels = stage.mesh(&barrel([dark, iron]));
    let crate_spots =
        [(3.4, 0.0, 5.7, 12.0), (4.6, 0.0, 5.5, -8.0), (4.0, 0.9, 5.6, 24.0), (2.6, 0.0, 6.8, 40.0)];
    for (x, y, z, degrees) in crate_spots {
        stage.stand("crate", crates, [x, y, z], degrees);
    }
    for (x, z) in [(5.6, 6.1), (5.7, 5.2), (13.0, 1.2)] {
        stage.stand("barrel", barrels, [x, if x > 10.0 { 1.1 } else { 0.0 }, z], 0.0);
    }
}

/// A pond with a rim of stones, water lilies and faint waves.
fn pond(stage: &mut Stage, rock: usize) {
    let water = paint("water", 0x2f8496, 0.04).add_to(&mut stage.gltf);
    let lily = paint("lilies", 0x6fa25b, 0.6).add_to(&mut stage.gltf);
    let disc = surface(36, 8, |u, v| {
        let (sin, cos) = libm::sincosf(TAU * u);
        let radius = 2.75 * (1.0 - v);
        let (x, z) = (radius * sin, radius * cos);
        Vec3::new(x, 0.12 + 0.012 * libm::sinf(4.2 * x + 1.6 * z) * libm::cosf(3.1 * z), z)
    });
    let stones = (0..20).map(|index| {
        let (sin, cos) = libm::sincosf(TAU * index as f32 / 20.0);
        let size = 0.34 + 0.14 * noise(index + 50);
        faceted(&pebble(size, index)).moved(1.0, Quat::IDENTITY, Vec3::new(2.8 * sin, 0.08, 2.8 * cos))
    });
    let leaf = lathe(&profile(&[(0.3, 0.0), (0.28, 0.02), (0.0, 0.02)]), 12);
    let lilies = [(0.9, 1.0), (1.5, 0.6), (-0.9, -0.7), (-1.3, 0.4), (0.4, -1.5)];
    let lilies = lilies.map(|(x, z)| at(leaf.clone(), x, 0.135, z));
    let parts = [(disc, water), (joined(stones), rock), (faceted(&joined(lilies)), lily)];
    stage.add("pond", &parts, [3.9, 0.0, -3.0], 0.0);
}

/// Coins over the stairs, a fence, stones, and the tower's flag.
fn details(stage: &mut Stage, [wood, rock]: [usize; 2]) {
    let gold = metal("gold", 0xf0c15c, 0.2).add_to(&mut stage.gltf);
    let coin = lathe(
        &rounded(
            &[
                (0.0, -0.06),
                (0.17, -0.03),
                (0.19, -0.06),
                (0.26, -0.06),
                (0.26, 0.06),
                (0.19, 0.06),
                (0.17, 0.03),
                (0.0, 0.06),
            ],
            0.02,
            1,
        ),
        16,
    );
    let coin = stage.mesh(&[(coin.moved(1.0, Quat::from_rotation_x(TAU / 4.0), Vec3::ZERO), gold)]);
    for step in 0..5 {
        let share = step as f32;
        stage.stand("coin", coin, [0.4 + 0.75 * share, 0.75, 4.6 - 0.5 * share], 40.0 + 25.0 * share);
    }
    let post = |index: i32| {
        let (sin, cos) = libm::sincosf(0.13 * index as f32 - 0.75);
        Vec3::new(8.6 * sin, 0.0, 8.6 * cos)
    };
    let mut fence = Vec::new();
    for index in 0..10 {
        let (foot, next) = (post(index), post(index + 1));
        fence.push(limb([foot - Vec3::Y * 0.2, foot + Vec3::Y * 0.85], [0.09, 0.08], [7, 1]));
        if index < 9 && index != 4 {
            for height in [0.35, 0.65] {
                fence.push(limb([foot + Vec3::Y * height, next + Vec3::Y * height], [0.045; 2], [6, 1]));
            }
        }
    }
    stage.add("fence", &[(faceted(&joined(fence)), wood)], [0.0; 3], 0.0);
    let stones = (0..9).map(|index| {
        let (sin, cos) = libm::sincosf(TAU * noise(index * 3 + 1));
        let (distance, size) = (6.0 + 2.6 * noise(index * 3 + 2), 0.18 + 0.4 * noise(index * 3));
        faceted(&pebble(size, index + 80)).moved(
            1.0,
            Quat::IDENTITY,
            Vec3::new(distance * sin, 0.05, distance * cos),
        )
    });
    stage.add("stones", &[(joined(stones), rock)], [0.0; 3], 0.0);
    let cloth = paint("flag", 0xd9a441, 0.8).two_sided().add_to(&mut stage.gltf);
    let flag = surface(10, 3, |u, v| {
        Vec3::new(1.3 * u, (v - 0.5) * 0.75 * (1.0 - 0.55 * u), 0.12 * libm::sinf(6.0 * u) * u)
    });
    let pole = limb([Vec3::Y * -1.6, Vec3::Y * 0.55], [0.05, 0.04], [7, 1]);
    stage.add("flag", &[(flag, cloth), (pole, wood)], [-4.5, 12.0, -4.8], 20.0);
}
