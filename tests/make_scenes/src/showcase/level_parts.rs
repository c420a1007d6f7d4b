//! Parts of the game level: platforms, trees, towers, crates and the sky.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use super::solids::{at, block, faceted, joined, lathe, limb, profile, rounded, rounded_box};
use super::{Parts, gradient, noise};
use scene_builder::shapes::{TriangleMesh, cuboid, grid_indices, ico_sphere, uv_sphere};

/// Corners of a platform.
const CORNERS: u32 = 18;

/// A faceted closed surface of rings of irregular radius: radius and height of each ring from the top down.
fn crag(rings: &[(f32, f32)], seed: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for (row, &(radius, height)) in rings.iter().enumerate() {
        for corner in 0..=CORNERS {
            let index = corner % CORNERS;
            let (sin, cos) = libm::sincosf(TAU * index as f32 / CORNERS as f32);
            let wide = 0.86 + 0.28 * noise(seed * 97 + index);
            let rough =
                1.0 + if row > 2 { 0.16 * (noise(seed * 31 + row as u32 * 41 + index) - 0.5) } else { 0.0 };
            let drop =
                if row > 2 { 0.12 * (noise(seed + row as u32 * 17 + index) - 0.5) * radius } else { 0.0 };
            mesh.positions.push(Vec3::new(
                sin * radius * wide * rough,
                height + drop,
                cos * radius * wide * rough,
            ));
        }
    }
    mesh.normals = vec![Vec3::Y; mesh.positions.len()];
    mesh.indices = grid_indices(CORNERS, rings.len() as u32 - 1, false);
    faceted(&mesh.without_collapsed())
}

/// Grass over rock: a flat top at y = 0 with a soft edge, and sides down to `depth`, which end in a point where `floats`.
pub(super) fn platform(radius: f32, depth: f32, floats: bool, seed: u32, [grass, rock]: [usize; 2]) -> Parts {
    let top =
        [(0.0, 0.0), (radius - 0.2, 0.0), (radius, -0.16), (radius * 1.01, -0.42), (radius * 0.975, -0.62)];
    let side = if floats {
        vec![
            (radius * 0.97, -0.4),
            (radius * 0.96, -0.14 * depth),
            (radius * 0.78, -0.30 * depth),
            (radius * 0.55, -0.55 * depth),
            (radius * 0.26, -0.80 * depth),
            (0.0, -depth),
        ]
    } else {
        vec![(radius * 0.97, -0.4), (radius * 0.99, -0.55 * depth), (radius * 1.02, -depth)]
    };
    vec![(crag(&top, seed), grass), (crag(&side, seed), rock)]
}

/// A conifer of three tiers.
pub(super) fn conifer([bark, needles]: [usize; 2]) -> Parts {
    let trunk = lathe(&profile(&[(0.17, -0.1), (0.12, 0.9), (0.0, 0.9)]), 8);
    let tier = |base: f32, radius: f32, height: f32| {
        let cone = lathe(
            &profile(&[
                (0.0, base + 0.12),
                (radius, base),
                (radius * 0.45, base + height * 0.55),
                (0.0, base + height),
            ]),
            9,
        );
        faceted(&cone)
    };
    let tiers = joined([tier(0.55, 0.95, 1.25), tier(1.2, 0.75, 1.1), tier(1.8, 0.52, 1.05)]);
    vec![(faceted(&trunk), bark), (tiers, needles)]
}

/// A tree with three round crowns.
pub(super) fn round_tree([bark, leaves]: [usize; 2]) -> Parts {
    let trunk = joined([
        limb([Vec3::ZERO, Vec3::Y * 1.3], [0.16, 0.11], [8, 2]),
        limb([Vec3::Y * 0.9, Vec3::new(0.5, 1.5, 0.1)], [0.08, 0.06], [7, 2]),
    ]);
    let crown = |center: Vec3, radius: f32, seed: u32| {
        faceted(&pebble(radius, seed).moved(1.0, Quat::IDENTITY, center))
    };
    let crowns = [
        crown(Vec3::new(-0.15, 1.95, 0.0), 0.85, 3),
        crown(Vec3::new(0.6, 1.75, 0.15), 0.58, 4),
        crown(Vec3::new(0.1, 2.55, -0.1), 0.6, 5),
    ];
    vec![(faceted(&trunk), bark), (joined(crowns), leaves)]
}

/// An uneven ball.
pub(super) fn pebble(radius: f32, seed: u32) -> TriangleMesh {
    let mut shape = ico_sphere(radius, 1);
    for (index, position) in shape.positions.iter_mut().enumerate() {
        *position *= 0.85 + 0.3 * noise(seed * 131 + index as u32);
    }
    shape
}

/// A round tower: stone, a dark door, lit windows, battlements, and a pointed roof on a smaller storey.
pub(super) fn tower([stone, trim, roof, dark, glow]: [usize; 5]) -> Parts {
    let wall = rounded(
        &[(1.55, -0.2), (1.5, 0.35), (1.3, 0.45), (1.2, 3.4), (1.5, 3.75), (1.5, 4.0), (0.0, 4.0)],
        0.06,
        1,
    );
    let storey = profile(&[(0.85, 3.9), (0.8, 5.3), (0.0, 5.3)]);
    let bands = [(0.45, 1.33), (2.2, 1.27), (3.42, 1.24)].map(|(height, radius)| {
        at(
            lathe(
                &rounded(
                    &[(radius - 0.1, 0.0), (radius + 0.06, 0.0), (radius + 0.06, 0.16), (radius - 0.1, 0.16)],
                    0.03,
                    1,
                ),
                16,
            ),
            0.0,
            height,
            0.0,
        )
    });
    let battlements = (0..10).map(|index| {
        let turn = Quat::from_rotation_y(TAU * index as f32 / 10.0);
        let merlon = cuboid(0.5, 0.5, 0.26).plain();
        merlon.moved(1.0, turn, turn * Vec3::new(0.0, 4.2, 1.36))
    });
    let cone = lathe(&profile(&[(0.0, 5.2), (1.18, 5.15), (1.1, 5.3), (0.45, 6.5), (0.0, 7.5)]), 14);
    let around = |degrees: f32, part: TriangleMesh, radius: f32, height: f32| {
        let turn = Quat::from_rotation_y(degrees.to_radians());
        part.moved(1.0, turn, turn * Vec3::new(0.0, height, radius))
    };
    let arch = |width: f32, height: f32| {
        joined([
            rounded_box(Vec3::new(width, height, 0.2), 0.02, 1),
            lathe(&profile(&[(width / 2.0, -0.1), (width / 2.0, 0.1), (0.0, 0.1)]), 14).moved(
                1.0,
                Quat::from_rotation_x(TAU / 4.0),
                Vec3::Y * (height / 2.0),
            ),
        ])
    };
    let windows = [(70.0, 1.22, 2.9), (-20.0, 1.22, 2.8), (30.0, 0.78, 4.75), (110.0, 0.78, 4.75)];
    let frames =
        windows.map(|(degrees, radius, height)| around(degrees, arch(0.42, 0.5), radius - 0.02, height));
    let panes =
        windows.map(|(degrees, radius, height)| around(degrees, arch(0.28, 0.42), radius + 0.03, height));
    vec![
        (faceted(&joined([lathe(&wall, 16), lathe(&storey, 14)])), stone),
        (faceted(&joined(bands.into_iter().chain(battlements).chain(frames))), trim),
        (faceted(&cone), roof),
        (faceted(&around(35.0, arch(0.85, 1.3), 1.3, 0.85)), dark),
        (faceted(&joined(panes)), glow),
    ]
}

/// A flight of steps that rise towards −Z from the origin.
pub(super) fn stairs(steps: u32, rise: f32, width: f32, [stone, trim]: [usize; 2]) -> Parts {
    let tread = 0.36;
    let step = |index: u32| {
        let height = rise * (index + 1) as f32 / steps as f32;
        at(
            rounded_box(Vec3::new(width, height + 0.3, tread + 0.02), 0.03, 1),
            0.0,
            height / 2.0 - 0.15,
            -tread * (index as f32 + 0.5),
        )
    };
    let length = tread * steps as f32;
    let cheek = |side: f32| {
        let ends =
            [Vec3::new(side * width / 2.0, 0.12, 0.05), Vec3::new(side * width / 2.0, rise + 0.12, -length)];
        limb(ends, [0.13; 2], [6, 1])
    };
    vec![(faceted(&joined((0..steps).map(step))), stone), (faceted(&joined([cheek(1.0), cheek(-1.0)])), trim)]
}

/// A crate of 0.9 metres with a frame.
pub(super) fn crate_box([boards, frame]: [usize; 2]) -> Parts {
    let half = 0.45;
    let mut beams = Vec::new();
    for axis in 0..3 {
        for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut size = Vec3::splat(0.13);
            size[axis] = 2.0 * half;
            let mut center = Vec3::Y * half;
            center[(axis + 1) % 3] += a * (half - 0.05);
            center[(axis + 2) % 3] += b * (half - 0.05);
            beams.push(rounded_box(size, 0.015, 1).moved(1.0, Quat::IDENTITY, center));
        }
    }
    let boards_part =
        (0..4).map(|index| block(Vec3::new(0.8, 0.19, 0.8), Vec3::Y * (0.05 + 0.205 * index as f32)));
    vec![(joined(boards_part), boards), (faceted(&joined(beams)), frame)]
}

/// A barrel with two hoops.
pub(super) fn barrel([boards, iron]: [usize; 2]) -> Parts {
    let body = profile(&[
        (0.0, 0.0),
        (0.32, 0.0),
        (0.39, 0.28),
        (0.41, 0.5),
        (0.39, 0.72),
        (0.32, 1.0),
        (0.29, 1.0),
        (0.28, 0.95),
        (0.0, 0.95),
    ]);
    let hoop = |height: f32| {
        at(
            lathe(&profile(&[(0.36, -0.05), (0.405, -0.05), (0.415, 0.05), (0.36, 0.05)]), 16),
            0.0,
            height,
            0.0,
        )
    };
    vec![(faceted(&lathe(&body, 12)), boards), (faceted(&joined([hoop(0.26), hoop(0.74)])), iron)]
}

/// A hanging bridge along +X from the origin to `end`, with planks, posts and ropes.
pub(super) fn bridge(end: Vec3, [wood, rope]: [usize; 2]) -> Parts {
    let span = end.length();
    let count = (span / 0.42) as u32;
    let sag = |share: f32| end * share - Vec3::Y * (0.55 * 4.0 * share * (1.0 - share));
    let plank = |index: u32| {
        let share = (index as f32 + 0.5) / count as f32;
        let tilt = Quat::from_rotation_y(0.06 * (noise(index) - 0.5));
        rounded_box(Vec3::new(0.34, 0.09, 1.5), 0.02, 1).moved(1.0, tilt, sag(share))
    };
    let (mut posts, mut ropes) = (Vec::new(), Vec::new());
    for side in [-0.75, 0.75] {
        for corner in [Vec3::ZERO, end] {
            let foot = corner + Vec3::Z * side;
            posts.push(limb([foot - Vec3::Y * 0.3, foot + Vec3::Y * 1.0], [0.1, 0.09], [8, 2]));
        }
        for step in 0..6 {
            let [from, to] = [step, step + 1].map(|step| sag(step as f32 / 6.0) + Vec3::new(0.0, 0.85, side));
            ropes.push(limb([from, to], [0.035; 2], [6, 1]));
        }
    }
    vec![(faceted(&joined((0..count).map(plank).chain(posts))), wood), (faceted(&joined(ropes)), rope)]
}

/// The sky: an inverted sphere with colours by height. It is open around `sun`, since surfaces that glow shade as others do.
pub(super) fn dome(radius: f32, sun: Vec3) -> TriangleMesh {
    let mut shape = uv_sphere(radius, 32, 20).plain().inverted();
    shape.normals.clear();
    let stops = [
        (-1.0, 0x5d86ad),
        (-0.45, 0x86aecb),
        (-0.12, 0xbfd6df),
        (0.0, 0xf4e6cf),
        (0.14, 0xcfe0ea),
        (0.45, 0x8dbde3),
        (1.0, 0x5695d2),
    ];
    shape.colors = shape.positions.iter().map(|position| gradient(&stops, position.y / radius)).collect();
    let sun = sun.normalize();
    let is_kept = |triangle: &&[u32]| {
        let sum: Vec3 = triangle.iter().map(|&index| shape.positions[index as usize]).sum();
        sum.normalize().dot(sun) < 0.962
    };
    shape.indices = shape.indices.chunks_exact(3).filter(is_kept).flatten().copied().collect();
    shape
}
