//! Furniture of the apartment. Every piece stands on y = 0, its front towards +Z.

use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3};

use super::solids::{
    Outline, at, block, faceted, joined, lathe, limb, loft, open_loft, profile, ring_tube, rounded,
    rounded_box, smooth, surface,
};
use super::{Parts, noise};
use scene_builder::shapes::TriangleMesh;

fn padded(size: [f32; 3], radius: f32, center: [f32; 3]) -> TriangleMesh {
    at(rounded_box(Vec3::from(size), radius, 2), center[0], center[1], center[2])
}

/// A box with chamfered edges and flat faces.
fn bevelled(size: [f32; 3], center: [f32; 3]) -> TriangleMesh {
    faceted(&at(rounded_box(Vec3::from(size), 0.006, 1), center[0], center[1], center[2]))
}

/// Four tapered legs at the corners of a rectangle.
fn legs(half: Vec2, height: f32, radii: [f32; 2]) -> TriangleMesh {
    let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].map(|(x, z)| {
        let foot = Vec3::new(x * half.x, radii[0], z * half.y);
        limb([foot, Vec3::new(foot.x * 0.92, height, foot.z * 0.92)], radii, [8, 1])
    });
    joined(corners)
}

/// A sofa with loose cushions and two throw pillows.
pub(super) fn sofa([fabric, wood, accent]: [usize; 3], width: f32, seats: u32) -> Parts {
    let inner = width - 0.44;
    let seat_width = inner / seats as f32;
    let middle = |index: u32| (index as f32 + 0.5) * seat_width - inner / 2.0;
    let mut upholstery = vec![
        padded([width, 0.22, 0.9], 0.05, [0.0, 0.25, 0.0]),
        padded([0.21, 0.46, 0.9], 0.08, [width / 2.0 - 0.105, 0.42, 0.0]),
        padded([0.21, 0.46, 0.9], 0.08, [0.105 - width / 2.0, 0.42, 0.0]),
        padded([width - 0.1, 0.6, 0.22], 0.09, [0.0, 0.5, -0.36]),
    ];
    for seat in 0..seats {
        upholstery.push(padded([seat_width - 0.01, 0.17, 0.68], 0.06, [middle(seat), 0.42, 0.1]));
        let back = rounded_box(Vec3::new(seat_width - 0.02, 0.42, 0.19), 0.08, 2);
        upholstery.push(back.moved(1.0, Quat::from_rotation_x(-0.2), Vec3::new(middle(seat), 0.68, -0.2)));
    }
    let pillow = |x: f32, turn: f32| {
        let shape = rounded_box(Vec3::new(0.42, 0.42, 0.15), 0.072, 2);
        let turn = Quat::from_rotation_y(turn) * Quat::from_rotation_x(-0.35) * Quat::from_rotation_z(0.12);
        shape.moved(1.0, turn, Vec3::new(x, 0.68, -0.02))
    };
    let pillows = joined([pillow(inner / 2.0 - 0.2, -0.25), pillow(0.2 - inner / 2.0, 0.3)]);
    vec![
        (joined(upholstery), fabric),
        (legs(Vec2::new(width / 2.0 - 0.12, 0.36), 0.16, [0.02, 0.03]), wood),
        (pillows, accent),
    ]
}

/// A round table on a turned foot or on legs.
pub(super) fn round_table([top, foot]: [usize; 2], radius: f32, height: f32) -> Parts {
    let plate = rounded(
        &[(0.0, height - 0.035), (radius, height - 0.035), (radius, height), (0.0, height)],
        0.012,
        3,
    );
    let stem = smooth(
        &[
            (radius * 0.5, 0.0),
            (radius * 0.48, 0.02),
            (radius * 0.14, 0.05),
            (0.045, 0.16),
            (0.04, height - 0.12),
            (radius * 0.3, height - 0.035),
        ],
        3,
    );
    vec![(lathe(&plate, 26), top), (lathe(&stem, 14), foot)]
}

/// A long table with rounded corners.
pub(super) fn table([top, wood]: [usize; 2], size: Vec2, height: f32) -> Parts {
    let outline = Outline::rounded_rectangle(size, 0.12, 5);
    let plate =
        rounded(&[(-0.05, height - 0.04), (0.0, height - 0.025), (0.0, height), (-0.05, height)], 0.01, 2);
    vec![
        (loft(&outline, &plate), top),
        (legs(size / 2.0 - Vec2::splat(0.14), height - 0.03, [0.024, 0.036]), wood),
    ]
}

/// A chair with a bent back.
pub(super) fn chair([seat, wood]: [usize; 2]) -> Parts {
    let shell = surface(8, 3, |u, v| {
        let angle = (u - 0.5) * 2.0;
        Vec3::new(0.23 * libm::sinf(angle), 0.60 + 0.24 * v, -0.02 - 0.24 * libm::cosf(angle) - 0.05 * v)
    });
    let mut back = shell.clone();
    for (position, normal) in back.positions.iter_mut().zip(&back.normals) {
        *position -= *normal * 0.022;
    }
    let rim = ring_tube(
        [24, 5],
        0.013,
        |t| {
            let (sin, cos) = libm::sincosf(TAU * t);
            let power = |value: f32| value.signum() * libm::powf(value.abs(), 0.4);
            let (angle, v) = (power(cos), 0.5 + 0.5 * power(sin));
            Vec3::new(0.23 * libm::sinf(angle), 0.60 + 0.24 * v, -0.015 - 0.25 * libm::cosf(angle) - 0.05 * v)
        },
        |_| Vec3::Z,
    );
    let rods = [-0.15, 0.15]
        .map(|x| limb([Vec3::new(x, 0.44, -0.17), Vec3::new(x, 0.62, -0.235)], [0.014; 2], [8, 2]));
    vec![
        (joined([padded([0.44, 0.055, 0.42], 0.025, [0.0, 0.455, 0.0]), shell, back.inverted()]), seat),
        (joined([legs(Vec2::new(0.2, 0.19), 0.44, [0.013, 0.02]), rim, joined(rods)]), wood),
    ]
}

/// Shelves with books in three colours, and a vase.
pub(super) fn shelf([wood, first, second, third, ceramic]: [usize; 5]) -> Parts {
    let (width, height, depth) = (1.5, 2.0, 0.32);
    let mut boards = vec![
        bevelled([0.035, height, depth], [width / 2.0, height / 2.0, 0.0]),
        bevelled([0.035, height, depth], [-width / 2.0, height / 2.0, 0.0]),
        bevelled([width, height - 0.1, 0.015], [0.0, height / 2.0 + 0.03, 0.01 - depth / 2.0]),
    ];
    let rows = [0.1, 0.57, 1.04, 1.51, 1.98];
    boards.extend(rows.map(|y| bevelled([width, 0.032, depth], [0.0, y, 0.0])));
    let mut books: [Vec<TriangleMesh>; 3] = Default::default();
    for (row, base) in rows[..4].iter().enumerate() {
        let seed = row as u32 * 64;
        let mut x = -width / 2.0 + 0.05 + 0.35 * noise(seed + 63) * (row % 2) as f32;
        let end = x + 0.75 + 0.3 * noise(seed + 62);
        let mut index = 0;
        while x < end {
            let random = |salt: u32| noise(seed + index * 5 + salt);
            let (thick, tall) = (0.04 + 0.045 * random(0), 0.24 + 0.12 * random(1));
            let size = Vec3::new(thick - 0.002, tall, 0.18 + 0.05 * random(2));
            let book = block(size, Vec3::new(x + thick / 2.0, base + 0.016, -0.02));
            books[(random(3) * 2.99) as usize].push(book);
            x += thick;
            index += 1;
        }
    }
    let [first_books, second_books, third_books] = books.map(joined);
    let pot = |x: f32, y: f32, scale: f32| {
        lathe(&vase_profile(), 16).moved(scale, Quat::IDENTITY, Vec3::new(x, y, 0.0))
    };
    let pots = joined([pot(0.52, 1.056, 0.8), pot(0.55, 0.116, 1.0)]);
    vec![
        (joined(boards), wood),
        (first_books, first),
        (second_books, second),
        (third_books, third),
        (pots, ceramic),
    ]
}

fn vase_profile() -> Vec<Vec2> {
    smooth(
        &[
            (0.0, 0.0),
            (0.06, 0.0),
            (0.105, 0.09),
            (0.09, 0.19),
            (0.038, 0.27),
            (0.05, 0.32),
            (0.042, 0.316),
            (0.0, 0.25),
        ],
        3,
    )
}

/// A shade, open above and below, of one wall seen from both sides.
fn shade(low: f32, high: f32, height: f32, base: f32) -> TriangleMesh {
    open_loft(&Outline::axis(24), &profile(&[(low, base), (high, base + height)]))
}

/// A standing lamp with a fabric shade 1.6 metres up.
pub(super) fn floor_lamp([brass, fabric]: [usize; 2]) -> Parts {
    let foot =
        rounded(&[(0.0, 0.0), (0.15, 0.0), (0.15, 0.025), (0.012, 0.035), (0.012, 1.5), (0.0, 1.5)], 0.01, 3);
    vec![(lathe(&foot, 18), brass), (shade(0.23, 0.17, 0.28, 1.38), fabric)]
}

/// A lamp that hangs from y = 0, its metal dome one metre below.
pub(super) fn pendant([outside, cord]: [usize; 2]) -> Parts {
    let dome =
        smooth(&[(0.27, -1.1), (0.25, -1.02), (0.16, -0.9), (0.05, -0.84), (0.03, -0.8), (0.0, -0.8)], 2);
    vec![
        (open_loft(&Outline::axis(24), &dome), outside),
        (limb([Vec3::Y * -0.8, Vec3::ZERO], [0.006; 2], [6, 1]), cord),
    ]
}

/// A plant with arching leaves in a pot.
pub(super) fn plant([pot, leaf, soil]: [usize; 3]) -> Parts {
    let body =
        rounded(&[(0.0, 0.0), (0.15, 0.0), (0.2, 0.36), (0.185, 0.36), (0.18, 0.3), (0.17, 0.3)], 0.015, 3);
    let leaves = (0..13).map(|index| {
        let turn = TAU * 0.381_966 * index as f32;
        let (reach, rise) = (0.28 + 0.34 * noise(index + 7), 0.55 + 0.6 * noise(index + 300));
        let blade = surface(2, 7, |u, v| {
            let width = 0.075 * libm::powf(libm::sinf(TAU / 2.0 * (0.06 + 0.94 * v)).max(0.0), 0.7);
            let across = 2.0 * u - 1.0;
            let along = reach * v * v.sqrt();
            Vec3::new(across * width, rise * (v - 0.42 * v * v * v) + 0.012 * across * across, along)
        });
        blade.moved(1.0, Quat::from_rotation_y(turn), Vec3::Y * 0.3)
    });
    let earth = at(lathe(&profile(&[(0.175, 0.0), (0.0, 0.02)]), 20), 0.0, 0.3, 0.0);
    vec![(lathe(&body, 20), pot), (joined(leaves), leaf), (earth, soil)]
}

/// A bed with a duvet and pillows, its head towards −Z.
pub(super) fn bed([wood, linen, duvet]: [usize; 3]) -> Parts {
    let frame = [
        padded([1.72, 0.2, 2.1], 0.02, [0.0, 0.22, 0.0]),
        padded([1.76, 0.95, 0.08], 0.03, [0.0, 0.52, -1.06]),
    ];
    let pillows = [-0.42, 0.42].map(|x| {
        rounded_box(Vec3::new(0.72, 0.16, 0.44), 0.075, 2).moved(
            1.0,
            Quat::from_rotation_x(0.25),
            Vec3::new(x, 0.62, -0.74),
        )
    });
    let mattress = padded([1.62, 0.22, 2.02], 0.06, [0.0, 0.42, 0.0]);
    vec![
        (joined([joined(frame), legs(Vec2::new(0.76, 0.94), 0.14, [0.03, 0.03])]), wood),
        (joined([mattress, joined(pillows)]), linen),
        (padded([1.7, 0.17, 1.42], 0.07, [0.0, 0.5, 0.31]), duvet),
    ]
}

/// A low cabinet with doors and knobs.
pub(super) fn cabinet([wood, front, brass]: [usize; 3], width: f32, doors: u32) -> Parts {
    let (height, depth) = (0.62, 0.42);
    let door_width = (width - 0.06) / doors as f32;
    let middle = |index: u32| (index as f32 + 0.5) * door_width - door_width * doors as f32 / 2.0;
    let panels = (0..doors).map(|index| {
        bevelled([door_width - 0.012, height - 0.22, 0.02], [middle(index), height / 2.0 + 0.08, depth / 2.0])
    });
    let knobs = (0..doors).map(|index| {
        let side = if index % 2 == 0 { 1.0 } else { -1.0 };
        let center = Vec3::new(
            middle(index) + side * (door_width / 2.0 - 0.05),
            height / 2.0 + 0.12,
            depth / 2.0 + 0.01,
        );
        limb([center, center + Vec3::Z * 0.022], [0.007, 0.012], [8, 2])
    });
    vec![
        (bevelled([width, height - 0.16, depth], [0.0, height / 2.0 + 0.08, 0.0]), wood),
        (legs(Vec2::new(width / 2.0 - 0.1, 0.15), 0.16, [0.014, 0.022]), brass),
        (joined(panels), front),
        (joined(knobs), brass),
    ]
}

/// A framed print of three hills below a sun, its middle at the origin.
pub(super) fn painting([frame, paper, sun, near, far]: [usize; 5], size: Vec2) -> Parts {
    let edge = 0.03;
    let beams = [-1.0, 1.0].map(|side| {
        joined([
            bevelled([size.x, edge, 0.035], [0.0, side * (size.y - edge) / 2.0, 0.018]),
            bevelled([edge, size.y - 2.0 * edge, 0.035], [side * (size.x - edge) / 2.0, 0.0, 0.018]),
        ])
    });
    let sheet =
        block(Vec3::new(size.x - edge, size.y - edge, 0.01), Vec3::new(0.0, (edge - size.y) / 2.0, 0.006));
    let inner = size / 2.0 - Vec2::splat(0.09);
    let hill = |phase: f32, height: f32, z: f32| {
        surface(18, 1, |u, v| {
            let top = inner.y * (height + 0.22 * libm::sinf(phase + 4.5 * u));
            Vec3::new((2.0 * u - 1.0) * inner.x, -inner.y + (top + inner.y) * v, z)
        })
    };
    let disc = lathe(&profile(&[(inner.x * 0.3, 0.0), (0.0, 0.0005)]), 24).moved(
        1.0,
        Quat::from_rotation_x(TAU / 4.0),
        Vec3::new(inner.x * 0.3, inner.y * 0.45, 0.013),
    );
    vec![
        (joined(beams), frame),
        (sheet, paper),
        (disc, sun),
        (hill(0.6, -0.1, 0.014), far),
        (hill(2.8, -0.5, 0.016), near),
    ]
}

/// A curtain with folds, hanging from y = 0.
pub(super) fn curtain(fabric: usize, rod: usize, width: f32, height: f32) -> Parts {
    let cloth = surface(49, 2, |u, v| {
        let wide = 1.0 + 0.06 * (1.0 - v);
        let fold = 0.04 * libm::sinf(TAU * 7.0 * u) + 0.012 * libm::sinf(TAU * 3.0 * u + 3.0 * v);
        Vec3::new((u - 0.5) * width * wide, height * (v - 1.0), fold)
    });
    let pole = limb(
        [Vec3::new(-width / 2.0 - 0.08, 0.02, 0.0), Vec3::new(width / 2.0 + 0.08, 0.02, 0.0)],
        [0.014; 2],
        [10, 2],
    );
    vec![(cloth, fabric), (pole, rod)]
}

/// A round rug in two colours.
pub(super) fn rug([field, border]: [usize; 2], size: Vec2) -> Parts {
    let layer = |inset: f32, height: f32| {
        let outline = Outline::rounded_rectangle(size, 0.25, 5);
        loft(&outline, &profile(&[(-inset, 0.0), (-inset, height)]))
    };
    vec![(layer(0.12, 0.014), field), (layer(0.0, 0.011), border)]
}

/// Books and a bowl for a table top.
pub(super) fn table_still_life([cover, pages, ceramic]: [usize; 3]) -> Parts {
    let book = |turn: f32, y: f32, size: [f32; 3]| {
        let shape =
            |part: TriangleMesh| part.moved(1.0, Quat::from_rotation_y(turn), Vec3::new(-0.16, y, 0.05));
        let [width, height, depth] = size;
        let covers = joined([
            block(Vec3::new(width, 0.004, depth), Vec3::ZERO),
            block(Vec3::new(width, 0.004, depth), Vec3::Y * (height - 0.004)),
        ]);
        (shape(covers), shape(block(Vec3::new(width - 0.01, height - 0.008, depth - 0.012), Vec3::Y * 0.004)))
    };
    let (first, first_pages) = book(0.3, 0.0, [0.26, 0.035, 0.19]);
    let (second, second_pages) = book(0.75, 0.035, [0.21, 0.028, 0.15]);
    let bowl = smooth(
        &[
            (0.0, 0.0),
            (0.05, 0.0),
            (0.06, 0.015),
            (0.12, 0.055),
            (0.145, 0.09),
            (0.138, 0.092),
            (0.1, 0.055),
            (0.0, 0.025),
        ],
        2,
    );
    vec![
        (joined([first, second]), cover),
        (joined([first_pages, second_pages]), pages),
        (at(lathe(&bowl, 20), 0.2, 0.0, -0.08), ceramic),
    ]
}

/// A door leaf of `size` with its hinge at the origin, a panel on either side and handles.
pub(super) fn door([lacquer, brass]: [usize; 2], size: Vec2) -> Parts {
    let leaf = bevelled([size.x, size.y, 0.04], [size.x / 2.0, size.y / 2.0, 0.0]);
    let panels = [(0.30, 0.42), (1.28, 1.3)]
        .map(|(middle, height)| bevelled([size.x - 0.26, height, 0.056], [size.x / 2.0, middle + 0.05, 0.0]));
    let handles = [-1.0, 1.0].map(|side| {
        let knuckle = Vec3::new(size.x - 0.07, 1.02, 0.055 * side);
        joined([
            limb([Vec3::new(knuckle.x, knuckle.y, 0.0), knuckle], [0.011; 2], [8, 1]),
            limb([knuckle, knuckle - Vec3::X * 0.11], [0.010; 2], [8, 2]),
        ])
    });
    vec![(joined([leaf, joined(panels)]), lacquer), (joined(handles), brass)]
}
