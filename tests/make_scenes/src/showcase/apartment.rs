//! An apartment of a living area, a bedroom and a study, seen by no camera: 10 x 7 metres with doors, windows and furniture.

use glam::{Quat, Vec2, Vec3};

use super::solids::{at, block, faceted, joined, rounded_box, surface};
use super::{Stage, furniture, gradient, metal, noise, paint, srgb};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image};
use scene_builder::material::{DiffuseTransmission, Material, Sheen, TextureUse};
use scene_builder::shapes::{TriangleMesh, floor, quad};

/// Half the width and depth inside the walls, and the height, metres.
const HALF: Vec2 = Vec2::new(5.0, 3.5);
const HEIGHT: f32 = 2.7;
const THICKNESS: f32 = 0.14;
/// The wall between the living area and the others, and the one between those.
const DIVIDER_X: f32 = 1.7;
const DIVIDER_Z: f32 = 0.2;
/// Windows: middle along the wall at z = −3.5.
const WINDOWS: [f32; 3] = [-3.5, -0.5, 3.4];
const WINDOW_WIDTH: f32 = 1.7;
const SILL: f32 = 0.55;
const LINTEL: f32 = 2.3;

pub(super) fn apartment() -> Built {
    let mut stage = Stage::matte(
        "The living area of an apartment, seen from inside at eye height: a sofa, an armchair, tables, shelves, lamps and prints, with \
         sunlight through the windows and doors to a bedroom and a study.",
    );
    shell(&mut stage)?;
    windows(&mut stage);
    living_area(&mut stage);
    dining_area(&mut stage);
    bedroom_and_study(&mut stage);
    lights(&mut stage);
    stage.finished("apartment", Vec3::new(0.17, 0.17, 0.175), Vec3::new(0.16, 0.14, 0.12))
}

/// A wall along X from `from` to `to`, on y = 0, with openings: middle, width, sill and lintel, from left to right.
fn wall([from, to]: [f32; 2], openings: &[[f32; 4]]) -> TriangleMesh {
    let part = |left: f32, right: f32, low: f32, high: f32| {
        block(Vec3::new(right - left, high - low, THICKNESS), Vec3::new(f32::midpoint(left, right), low, 0.0))
    };
    let mut parts = Vec::new();
    let mut left = from;
    for &[middle, width, sill, lintel] in openings {
        parts.push(part(left, middle - width / 2.0, 0.0, HEIGHT));
        if sill > 0.0 {
            parts.push(part(middle - width / 2.0, middle + width / 2.0, 0.0, sill));
        }
        parts.push(part(middle - width / 2.0, middle + width / 2.0, lintel, HEIGHT));
        left = middle + width / 2.0;
    }
    parts.push(part(left, to, 0.0, HEIGHT));
    joined(parts)
}

/// Beams below the ceiling.
fn beams(stage: &mut Stage, oak: usize) {
    let beam = stage.mesh(&[(block(Vec3::new(0.14, 0.16, 2.0 * HALF.y), Vec3::ZERO), oak)]);
    for x in [-4.2, -2.8, -1.4, 0.0] {
        stage.stand("ceiling beam", beam, [x + 0.3, HEIGHT - 0.16, 0.0], 0.0);
    }
}

/// Floor, ceiling, walls, door frames and skirting.
fn shell(stage: &mut Stage) -> Built<()> {
    let planks = planks(&mut stage.gltf)?;
    let wood =
        Material { base_color_texture: Some(TextureUse::of(planks)), ..paint("planks", 0xffffff, 0.32) };
    let wood = wood.add_to(&mut stage.gltf);
    let white = paint("ceiling", 0xece7dc, 0.95).add_to(&mut stage.gltf);
    let plaster = paint("plaster", 0xdfd5c5, 0.95).add_to(&mut stage.gltf);
    let sage = paint("sage wall", 0xa3ad98, 0.95).add_to(&mut stage.gltf);
    let trim = paint("white lacquer", 0xf2efe8, 0.4).add_to(&mut stage.gltf);
    let mut ground = floor(2.0 * HALF.x, 2.0 * HALF.y);
    ground.uvs = ground.positions.iter().map(|position| Vec2::new(position.x, position.z) / 1.6).collect();
    stage.add("floor", &[(ground, wood)], [0.0; 3], 0.0);
    let lid = block(Vec3::new(2.0 * HALF.x + 0.2, 0.12, 2.0 * HALF.y + 0.2), Vec3::Y * HEIGHT);
    stage.add("ceiling", &[(lid, white)], [0.0; 3], 0.0);

    let (out, back) = (THICKNESS / 2.0, HALF.y + THICKNESS / 2.0);
    let window_holes = WINDOWS.map(|middle| [middle, WINDOW_WIDTH, SILL, LINTEL]);
    let ends = [-HALF.x - THICKNESS, HALF.x + THICKNESS];
    let skirting = |length: f32| block(Vec3::new(length, 0.08, 0.02), Vec3::Z * (out + 0.008));
    stage.add(
        "window wall",
        &[(wall(ends, &window_holes), plaster), (skirting(2.0 * HALF.x), trim)],
        [0.0, 0.0, -back],
        0.0,
    );
    stage.add(
        "long wall",
        &[(wall(ends, &[]), plaster), (skirting(2.0 * HALF.x), trim)],
        [0.0, 0.0, back],
        180.0,
    );
    let side = [-HALF.y, HALF.y];
    stage.add(
        "sage wall",
        &[(wall(side, &[]), sage), (skirting(2.0 * HALF.y), trim)],
        [-HALF.x - out, 0.0, 0.0],
        90.0,
    );
    stage.add(
        "end wall",
        &[(wall(side, &[]), plaster), (skirting(2.0 * HALF.y), trim)],
        [HALF.x + out, 0.0, 0.0],
        -90.0,
    );
    // Doors: turned by 90°, x along the wall is −z.
    let doors = [-2.35, 1.35].map(|middle| [middle, 0.95, 0.0, 2.1]);
    stage.add("divider", &[(wall(side, &doors), plaster)], [DIVIDER_X, 0.0, 0.0], 90.0);
    let inner = [DIVIDER_X + out, HALF.x];
    stage.add("bedroom wall", &[(wall(inner, &[]), plaster)], [0.0, 0.0, DIVIDER_Z], 0.0);
    let oak = paint("oak beams", 0xa98663, 0.6).add_to(&mut stage.gltf);
    // Ajar, so that the living area is a space of its own.
    let brass = metal("door handles", 0xc9a86a, 0.25).add_to(&mut stage.gltf);
    let leaf = stage.mesh(&furniture::door([trim, brass], Vec2::new(0.88, 2.06)));
    for (name, [middle, ..]) in ["study door", "bedroom door"].into_iter().zip(doors) {
        let ajar = if name == "study door" { 22.0 } else { 6.0 };
        stage.stand(name, leaf, [DIVIDER_X + out, 0.0, 0.44 - middle], 90.0 - ajar);
    }
    beams(stage, oak);
    let jamb = |middle: f32| {
        let depth = THICKNESS + 0.04;
        joined([
            block(Vec3::new(0.07, 2.13, depth), Vec3::X * (middle - 0.48)),
            block(Vec3::new(0.07, 2.13, depth), Vec3::X * (middle + 0.48)),
            block(Vec3::new(1.03, 0.07, depth), Vec3::new(middle, 2.07, 0.0)),
        ])
    };
    stage.add("door frames", &[(joined(doors.map(|door| jamb(door[0]))), trim)], [DIVIDER_X, 0.0, 0.0], 90.0);
    Ok(())
}

/// Boards in staggered rows, each with its own tone and grain.
fn planks(gltf: &mut Gltf) -> Built<usize> {
    let image = Image::new(128, 128, |x, y| {
        let (row, across) = (y / 16, y % 16);
        let along = (x + (noise(row + 900) * 128.0) as u32) % 128;
        let board = row * 2 + along / 64;
        let gap = across == 0 || along.is_multiple_of(64);
        let grain = noise(y * 7 + (x + board * 50) / 24 * 977) * 0.06 + noise(x * 131 + y * 17) * 0.03;
        let tone = if gap { 0.62 } else { 0.90 + 0.14 * noise(board + 40) - grain };
        let channel = |value: f32| (value * tone).min(255.0) as u8;
        [channel(196.0), channel(154.0), channel(112.0), 255]
    });
    image.texture(gltf, "planks", Filter::Mipmapped)
}

/// Frames and panes, curtains, and a bright garden outside.
fn windows(stage: &mut Stage) {
    let trim = paint("window frames", 0xf5f3ee, 0.35).add_to(&mut stage.gltf);
    let pane = Material {
        roughness: 0.0,
        transmission: Some(1.0),
        double_sided: true,
        ..Material::matte("panes", [1.0; 3])
    };
    let pane = pane.add_to(&mut stage.gltf);
    let cloth = Material {
        double_sided: true,
        diffuse_transmission: Some(DiffuseTransmission { factor: 0.4, color: srgb(0xf3e7d2) }),
        ..paint("linen", 0xf0e6d4, 1.0)
    };
    let cloth = cloth.add_to(&mut stage.gltf);
    let rod = metal("curtain rod", 0xb08d57, 0.3).add_to(&mut stage.gltf);
    let (width, height) = (WINDOW_WIDTH, LINTEL - SILL);
    let beam = |size: [f32; 3], x: f32, y: f32| at(rounded_box(Vec3::from(size), 0.008, 1), x, y, 0.0);
    let frame = joined([
        beam([0.06, height, 0.1], 0.03 - width / 2.0, height / 2.0),
        beam([0.06, height, 0.1], width / 2.0 - 0.03, height / 2.0),
        beam([0.05, height, 0.07], 0.0, height / 2.0),
        beam([width, 0.06, 0.1], 0.0, 0.03),
        beam([width, 0.06, 0.1], 0.0, height - 0.03),
        beam([width, 0.035, 0.06], 0.0, height * 0.68),
        at(rounded_box(Vec3::new(width + 0.16, 0.035, 0.26), 0.01, 1), 0.0, -0.01, 0.11),
    ]);
    let glass = quad(width, height).plain().moved(1.0, Quat::IDENTITY, Vec3::Y * (height / 2.0));
    let window = stage.mesh(&[(faceted(&frame), trim), (glass, pane)]);
    for middle in WINDOWS {
        stage.stand("window", window, [middle, SILL, -HALF.y - THICKNESS / 2.0], 0.0);
    }
    let curtain = stage.mesh(&furniture::curtain(cloth, rod, 0.62, 2.38));
    for x in [-4.62, -2.36, -1.64, 0.64] {
        stage.stand("curtain", curtain, [x, 2.42, -HALF.y + 0.14], 0.0);
    }
    let garden = Material::unlit("garden", [1.0; 3]).add_to(&mut stage.gltf);
    let stops = [(0.0, 0x8d9a70), (0.40, 0x708560), (0.47, 0xa5b493), (0.5, 0xdfe9e6), (1.0, 0xa9cbe6)];
    let mut view = surface(1, 40, |u, v| Vec3::new(-11.0 + 20.0 * u, -0.8 + 4.0 * v, -HALF.y - 3.0));
    view.colors = view.positions.iter().map(|position| gradient(&stops, (position.y + 0.8) / 4.0)).collect();
    stage.add("garden", &[(view, garden)], [0.0; 3], 0.0);
}

fn living_area(stage: &mut Stage) {
    let sheen = Some(Sheen { color: [0.12, 0.13, 0.14], roughness: 0.5 });
    let fabric = Material { sheen, ..paint("petrol fabric", 0x47676b, 0.95) }.add_to(&mut stage.gltf);
    let ochre = Material { sheen, ..paint("ochre fabric", 0xcf9a52, 0.95) }.add_to(&mut stage.gltf);
    let rust = Material { sheen, ..paint("rust fabric", 0xb5654a, 0.95) }.add_to(&mut stage.gltf);
    let walnut = paint("walnut", 0x7a5539, 0.45).add_to(&mut stage.gltf);
    let oak = paint("oak", 0xc39b6d, 0.5).add_to(&mut stage.gltf);
    let brass = metal("brass", 0xd9b36c, 0.22).add_to(&mut stage.gltf);
    let cream = paint("cream wool", 0xeee4d0, 1.0).add_to(&mut stage.gltf);
    let grey = paint("grey wool", 0x8f9a9c, 1.0).add_to(&mut stage.gltf);
    let ceramic = paint("ceramic", 0xdcd3c3, 0.25).add_to(&mut stage.gltf);
    let navy = paint("navy", 0x36455c, 0.6).add_to(&mut stage.gltf);
    let paper = paint("paper", 0xf3eee2, 0.9).add_to(&mut stage.gltf);
    let leaf = paint("leaf", 0x5d8655, 0.45).two_sided().add_to(&mut stage.gltf);
    let soil = paint("soil", 0x47382d, 1.0).add_to(&mut stage.gltf);

    let back = HALF.y;
    stage.add("rug", &furniture::rug([cream, grey], Vec2::new(3.0, 2.2)), [-0.85, 0.0, 1.65], 0.0);
    stage.add("sofa", &furniture::sofa([fabric, walnut, ochre], 2.35, 2), [-0.85, 0.0, back - 0.55], 180.0);
    stage.add("armchair", &furniture::sofa([rust, walnut, cream], 1.05, 1), [0.85, 0.0, 0.75], -50.0);
    stage.add("coffee table", &furniture::round_table([oak, walnut], 0.5, 0.4), [-0.85, 0.0, 1.65], 0.0);
    let still_life = stage.mesh(&furniture::table_still_life([rust, paper, ceramic]));
    stage.stand("books and bowl", still_life, [-0.85, 0.401, 1.65], 110.0);
    stage.stand("table ware", still_life, [-0.55, 0.751, -1.75], -15.0);
    let shelf = furniture::shelf([oak, navy, rust, cream, ceramic]);
    stage.add("shelf", &shelf, [-3.5, 0.0, back - 0.19], 180.0);
    stage.add("plant", &furniture::plant([ceramic, leaf, soil]), [0.95, 0.0, back - 0.5], 0.0);
    let lit = Material { emissive: srgb(0xe9b877), ..paint("lamp shade", 0xf2e2c4, 0.9) }.two_sided();
    let lit = lit.add_to(&mut stage.gltf);
    let lamp = stage.mesh(&furniture::floor_lamp([brass, lit]));
    stage.stand("floor lamp", lamp, [-2.42, 0.0, back - 0.4], 0.0);
    stage.stand("study lamp", lamp, [4.5, 0.0, 3.05], 0.0);
    let size = Vec2::new(0.72, 0.95);
    let first = furniture::painting([walnut, paper, rust, navy, grey], size);
    stage.add("hill print", &first, [-1.3, 1.62, back - 0.02], 180.0);
    let second = furniture::painting([walnut, paper, ochre, fabric, grey], size);
    stage.add("lake print", &second, [-0.4, 1.62, back - 0.02], 180.0);
    let sideboard = furniture::cabinet([walnut, oak, brass], 1.5, 3);
    stage.add("sideboard", &sideboard, [DIVIDER_X - 0.3, 0.0, 0.35], -90.0);
    let third = furniture::painting([oak, paper, ochre, rust, fabric], Vec2::new(1.1, 0.75));
    stage.add("dune print", &third, [DIVIDER_X - 0.09, 1.55, 0.35], -90.0);
}

fn dining_area(stage: &mut Stage) {
    let oak = paint("table top", 0xb98f63, 0.35).add_to(&mut stage.gltf);
    let black = paint("blackened wood", 0x2c2a29, 0.5).add_to(&mut stage.gltf);
    let green = paint("chair shell", 0x6f8276, 0.6).add_to(&mut stage.gltf);
    let copper = Material { double_sided: true, ..metal("copper", 0xd29066, 0.25) }.add_to(&mut stage.gltf);
    let (x, z) = (-0.55, -1.75);
    let table = stage.mesh(&furniture::table([oak, black], Vec2::new(1.9, 0.92), 0.75));
    stage.stand("dining table", table, [x, 0.0, z], 0.0);
    stage.stand("desk", table, [4.4, 0.0, 1.9], 90.0);
    let chair = stage.mesh(&furniture::chair([green, black]));
    stage.stand("desk chair", chair, [3.75, 0.0, 1.9], 90.0);
    for (dx, dz, degrees) in
        [(-0.48, -0.62, 4.0), (0.45, -0.66, -8.0), (-0.46, 0.64, 176.0), (0.47, 0.62, 183.0)]
    {
        stage.stand("chair", chair, [x + dx, 0.0, z + dz], degrees);
    }
    stage.add("pendant lamp", &furniture::pendant([copper, black]), [x, HEIGHT, z], 0.0);
}

fn bedroom_and_study(stage: &mut Stage) {
    let wood = paint("ash", 0xcbb08a, 0.5).add_to(&mut stage.gltf);
    let linen = paint("white linen", 0xf1ede4, 1.0).add_to(&mut stage.gltf);
    let duvet = paint("rose linen", 0xc9a195, 1.0).add_to(&mut stage.gltf);
    stage.add("bed", &furniture::bed([wood, linen, duvet]), [3.85, 0.0, -1.45], -90.0);
}

/// The sun, and lamps in each part of the apartment.
fn lights(stage: &mut Stage) {
    stage.sun(0xffeccf, 3.0, Vec3::new(0.55, 1.15, -1.0));
    for (name, color, candela, at) in [
        ("floor lamp bulb", 0xffd9a6, 0.55, [-2.42, 1.52, 3.1]),
        ("pendant bulb", 0xffe2ba, 0.75, [-0.55, 1.62, -1.75]),
        ("bedroom bulb", 0xffe2ba, 1.2, [3.2, 2.2, -2.4]),
        ("study bulb", 0xffe2ba, 0.9, [3.4, 2.2, 1.6]),
    ] {
        stage.lamp(name, color, candela, at);
    }
}
