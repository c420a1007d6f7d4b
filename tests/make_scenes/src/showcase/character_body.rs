//! The body of the character: joints, and meshes bound to them.

use glam::{Mat4, Quat, Vec2, Vec3};

use super::solids::{
    Outline, at, joined, jointed_limb, limb, loft, ring_tube, rounded, rounded_box, smooth, surface,
};
use super::{matte_attributes, paint};
use scene_builder::document::Gltf;
use scene_builder::image::byte;
use scene_builder::json::{Json, list, object};
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, uv_sphere};

/// Name, parent and position of each joint in the bind pose; left is +X.
pub(super) const JOINTS: [(&str, usize, Vec3); 19] = [
    ("hips", 0, Vec3::new(0.0, 0.72, 0.0)),
    ("spine", 0, Vec3::new(0.0, 0.84, 0.0)),
    ("chest", 1, Vec3::new(0.0, 0.97, 0.0)),
    ("neck", 2, Vec3::new(0.0, 1.13, 0.0)),
    ("head", 3, Vec3::new(0.0, 1.18, 0.0)),
    ("upper arm left", 2, Vec3::new(0.155, 1.07, 0.0)),
    ("forearm left", 5, Vec3::new(0.255, 0.89, 0.0)),
    ("hand left", 6, Vec3::new(0.335, 0.72, 0.02)),
    ("upper arm right", 2, Vec3::new(-0.155, 1.07, 0.0)),
    ("forearm right", 8, Vec3::new(-0.255, 0.89, 0.0)),
    ("hand right", 9, Vec3::new(-0.335, 0.72, 0.02)),
    ("thigh left", 0, Vec3::new(0.085, 0.70, 0.0)),
    ("shin left", 11, Vec3::new(0.09, 0.40, 0.0)),
    ("foot left", 12, Vec3::new(0.09, 0.10, 0.0)),
    ("thigh right", 0, Vec3::new(-0.085, 0.70, 0.0)),
    ("shin right", 14, Vec3::new(-0.09, 0.40, 0.0)),
    ("foot right", 15, Vec3::new(-0.09, 0.10, 0.0)),
    ("scarf", 2, Vec3::new(0.05, 1.10, -0.12)),
    ("scarf end", 17, Vec3::new(0.07, 0.93, -0.25)),
];

/// Half of the length along a limb over which weights blend at a joint, metres.
const BLEND: f32 = 0.07;

/// A mesh with the joints that move it: a chain along which the weights pass from joint to joint.
struct Bound {
    shape: TriangleMesh,
    chain: &'static [usize],
}

fn bound(shape: TriangleMesh, chain: &'static [usize]) -> Bound {
    Bound { shape, chain }
}

/// Adds the joints, the first of them the root, and returns their nodes.
pub(super) fn joints(gltf: &mut Gltf) -> Vec<usize> {
    let mut nodes = vec![0; JOINTS.len()];
    // Children come before their parents.
    for index in (0..JOINTS.len()).rev() {
        let (name, parent, position) = JOINTS[index];
        let children = (1..JOINTS.len()).filter(|&child| JOINTS[child].1 == index && child > index);
        let children: Vec<usize> = children.map(|child| nodes[child]).collect();
        let offset = if index == 0 { position } else { position - JOINTS[parent].2 };
        nodes[index] = gltf.node(Node::group(&children).named(name).at(offset.x, offset.y, offset.z));
    }
    nodes
}

/// Adds the skin and the skinned node.
pub(super) fn body(gltf: &mut Gltf, joints: &[usize]) {
    let primitives = [
        (paint("jacket", 0xd9a046, 0.75), jacket()),
        (paint("trousers", 0x42566b, 0.85), trousers()),
        (paint("leather", 0x6e4c38, 0.5), leather()),
        (paint("skin", 0xe6b595, 0.6), skin()),
        (paint("wool", 0x3f8586, 0.95), beanie()),
        (paint("scarf", 0xc65a4d, 0.95), scarf()),
        (paint("canvas", 0x74805a, 0.9), backpack()),
        (paint("eyes", 0x1d1a1c, 0.12), eyes()),
        (paint("hair", 0x4a3128, 0.7), hair()),
        (paint("buckles", 0xd8d2c4, 0.3), buckles()),
    ]
    .map(|(material, parts)| {
        let material = material.add_to(gltf);
        primitive(gltf, &parts, material)
    });
    let mesh = gltf.add("meshes", object([("primitives", list(primitives))]));
    let inverse_bind: Vec<Mat4> =
        JOINTS.iter().map(|(_, _, position)| Mat4::from_translation(-*position)).collect();
    let skin = gltf.skin(joints, &inverse_bind);
    gltf.node(Node { skin: Some(skin), ..Node::mesh(mesh).named("hiker") });
}

fn primitive(gltf: &mut Gltf, parts: &[Bound], material: usize) -> Json {
    let shape = joined(parts.iter().map(|part| part.shape.clone()));
    let influences =
        parts.iter().flat_map(|part| part.shape.positions.iter().map(|&p| influence(p, part.chain)));
    let (joints, weights): (Vec<_>, Vec<_>) = influences.unzip();
    let mut attributes = matte_attributes(gltf, &shape);
    let (joints, weights) = gltf.influences(&joints, &weights);
    attributes.set("JOINTS_0", joints);
    attributes.set("WEIGHTS_0", weights);
    let indices = gltf.indices(&shape.indices);
    object([("attributes", attributes), ("indices", indices.into()), ("material", material.into())])
}

/// The two joints of the chain nearest to `position` and their weights.
fn influence(position: Vec3, chain: &[usize]) -> ([u8; 4], [u8; 4]) {
    for link in chain.windows(2).rev() {
        let (start, joint) = (JOINTS[link[0]].2, JOINTS[link[1]].2);
        let along = (joint - start).normalize().dot(position - joint);
        if along > -BLEND {
            let share = ((along + BLEND) / (2.0 * BLEND)).min(1.0);
            let weight = byte(share * share * (3.0 - 2.0 * share));
            return ([link[0] as u8, link[1] as u8, 0, 0], [255 - weight, weight, 0, 0]);
        }
    }
    ([chain[0] as u8, 0, 0, 0], [255, 0, 0, 0])
}

/// The same part on the left and on the right.
fn both(left: &'static [usize], right: &'static [usize], part: impl Fn(f32) -> TriangleMesh) -> [Bound; 2] {
    [bound(part(1.0), left), bound(part(-1.0), right)]
}

/// The position of a joint on the left (1) or right (−1).
fn joint(index: usize, side: f32) -> Vec3 {
    JOINTS[index].2 * Vec3::new(side, 1.0, 1.0)
}

fn ellipsoid(half: Vec3, center: Vec3, segments: u32) -> TriangleMesh {
    let mut shape = uv_sphere(1.0, segments, segments / 2).plain();
    for (position, normal) in shape.positions.iter_mut().zip(&mut shape.normals) {
        *normal = (*normal / half).normalize();
        *position = *position * half + center;
    }
    shape
}

fn jacket() -> Vec<Bound> {
    let outline = Outline::superellipse(Vec2::new(0.145, 0.10), 2.5, 24);
    let points = [
        (0.0, 0.655),
        (0.022, 0.66),
        (0.016, 0.70),
        (-0.004, 0.78),
        (0.006, 0.90),
        (0.012, 1.0),
        (-0.02, 1.08),
        (-0.075, 1.135),
    ];
    let torso = loft(&outline, &smooth(&points, 2));
    let mut parts = vec![bound(torso, &[0, 1, 2])];
    parts.extend(both(&[5, 6], &[8, 9], |side| {
        jointed_limb([joint(5, side), joint(6, side)], [0.066, 0.056], [12, 3], 4)
    }));
    parts.extend(both(&[5, 6], &[8, 9], |side| {
        jointed_limb([joint(6, side), joint(6, side).lerp(joint(7, side), 0.82)], [0.056, 0.052], [12, 3], 4)
    }));
    parts
}

fn trousers() -> Vec<Bound> {
    let mut parts =
        vec![bound(ellipsoid(Vec3::new(0.145, 0.10, 0.105), Vec3::new(0.0, 0.68, 0.0), 16), &[0])];
    parts.extend(both(&[0, 11, 12], &[0, 14, 15], |side| {
        jointed_limb([joint(11, side) - Vec3::Y * 0.02, joint(12, side)], [0.083, 0.066], [14, 3], 4)
    }));
    parts.extend(both(&[11, 12], &[14, 15], |side| {
        jointed_limb([joint(12, side), joint(13, side) + Vec3::Y * 0.09], [0.066, 0.062], [14, 3], 4)
    }));
    parts
}

/// Boots, gloves and the belt.
fn leather() -> Vec<Bound> {
    let belt = loft(
        &Outline::superellipse(Vec2::new(0.145, 0.10), 2.5, 24),
        &rounded(&[(-0.03, 0.745), (0.014, 0.745), (0.014, 0.785), (-0.03, 0.785)], 0.008, 1),
    );
    let mut parts = vec![bound(belt, &[0, 1])];
    parts.extend(both(&[12, 13], &[15, 16], |side| {
        let shaft =
            [(0.066, -0.05), (0.064, 0.02), (0.074, 0.09), (0.080, 0.095), (0.080, 0.12), (0.06, 0.125)];
        let shaft = loft(&Outline::axis(16), &rounded(&shaft, 0.008, 1));
        at(shaft, joint(13, side).x, 0.10, 0.0)
    }));
    parts.extend(both(&[13], &[16], |side| {
        let foot = Outline::superellipse(Vec2::new(0.066, 0.125), 2.6, 20);
        let shoe = rounded(
            &[(0.0, 0.0), (0.004, 0.0), (0.004, 0.03), (-0.003, 0.034), (-0.012, 0.075), (-0.055, 0.118)],
            0.01,
            3,
        );
        at(loft(&foot, &shoe), joint(13, side).x, 0.0, 0.045)
    }));
    parts
}

/// The head with its nose and ears, and the hands.
fn skin() -> Vec<Bound> {
    let head = Vec3::new(0.0, 1.315, 0.005);
    let features = [
        ellipsoid(Vec3::new(0.158, 0.148, 0.15), head, 20),
        ellipsoid(Vec3::new(0.022, 0.02, 0.02), head + Vec3::new(0.0, -0.035, 0.15), 10),
        ellipsoid(Vec3::new(0.02, 0.036, 0.026), head + Vec3::new(0.155, -0.025, 0.0), 10),
        ellipsoid(Vec3::new(0.02, 0.036, 0.026), head + Vec3::new(-0.155, -0.025, 0.0), 10),
    ];
    let neck = limb([Vec3::new(0.0, 1.08, 0.0), Vec3::new(0.0, 1.2, 0.0)], [0.06, 0.055], [12, 2]);
    let mut parts = vec![bound(joined(features), &[4]), bound(neck, &[2, 3])];
    parts.extend(both(&[7], &[10], |side| {
        let wrist = joint(7, side);
        let away = (wrist - joint(6, side)).normalize();
        let palm = limb([wrist - away * 0.01, wrist + away * 0.05], [0.044, 0.038], [12, 3]);
        let thumb = limb(
            [
                wrist + away * 0.01 + Vec3::Z * 0.02,
                wrist + away * 0.035 + Vec3::new(-0.008 * side, 0.0, 0.05),
            ],
            [0.02, 0.016],
            [8, 2],
        );
        joined([palm, thumb])
    }));
    parts
}

/// A ribbed beanie with a folded brim and a bobble.
fn beanie() -> Vec<Bound> {
    let cap = surface(48, 7, |u, v| {
        let (sin, cos) = libm::sincosf(std::f32::consts::TAU * u);
        let (rise, across) = libm::sincosf(std::f32::consts::FRAC_PI_2 * v);
        let rib = 1.0 + 0.012 * libm::cosf(std::f32::consts::TAU * 24.0 * u) * (1.0 - v);
        Vec3::new(0.164 * sin * across * rib, 0.155 * rise, 0.158 * cos * across * rib)
    });
    let brim = loft(
        &Outline::superellipse(Vec2::new(0.16, 0.154), 2.0, 30),
        &rounded(&[(-0.02, -0.008), (0.014, -0.012), (0.012, 0.042), (-0.02, 0.046)], 0.012, 2),
    );
    let bobble = ellipsoid(Vec3::splat(0.05), Vec3::new(0.0, 0.185, 0.0), 12);
    let tilt = Quat::from_rotation_x(-0.16);
    vec![bound(joined([cap, brim, bobble]).moved(1.0, tilt, Vec3::new(0.0, 1.36, 0.0)), &[4])]
}

fn scarf() -> Vec<Bound> {
    let ring = |height: f32, radius: f32, phase: f32| {
        let center = move |t: f32| {
            let (sin, cos) = libm::sincosf(std::f32::consts::TAU * t);
            Vec3::new(
                radius * sin,
                height + 0.012 * libm::sinf(std::f32::consts::TAU * t + phase),
                radius * 0.9 * cos,
            )
        };
        ring_tube([22, 7], 0.034, center, |_| Vec3::Y)
    };
    let tail = |from: Vec3, to: Vec3| {
        let mut flat = jointed_limb([Vec3::ZERO, Vec3::Y * from.distance(to)], [0.045, 0.055], [12, 3], 4);
        for (position, normal) in flat.positions.iter_mut().zip(&mut flat.normals) {
            position.z *= 0.32;
            *normal = (*normal / Vec3::new(1.0, 1.0, 0.32)).normalize();
        }
        flat.moved(1.0, Quat::from_rotation_arc(Vec3::Y, (to - from).normalize()), from)
    };
    let [root, middle] = [17, 18].map(|index| JOINTS[index].2);
    vec![
        bound(ring(1.125, 0.082, 0.4), &[2]),
        bound(ring(1.165, 0.074, 2.4), &[2, 3]),
        bound(tail(root, middle + (middle - root) * 0.85), &[17, 18]),
    ]
}

fn backpack() -> Vec<Bound> {
    let bag = at(rounded_box(Vec3::new(0.25, 0.29, 0.13), 0.045, 2), 0.0, 0.95, -0.165);
    let pocket = at(rounded_box(Vec3::new(0.17, 0.12, 0.06), 0.025, 2), 0.0, 0.89, -0.235);
    let mut parts = vec![bound(joined([bag, pocket]), &[2])];
    parts.extend(both(&[2], &[2], |side| {
        let x = 0.085 * side;
        let strap = [
            Vec3::new(x, 1.08, -0.11),
            Vec3::new(x, 1.115, -0.02),
            Vec3::new(x, 1.04, 0.10),
            Vec3::new(x * 1.25, 0.88, 0.10),
        ];
        joined(strap.windows(2).map(|ends| limb([ends[0], ends[1]], [0.018; 2], [8, 2])))
    }));
    parts
}

fn eyes() -> Vec<Bound> {
    let eye =
        |side: f32| ellipsoid(Vec3::new(0.019, 0.026, 0.012), Vec3::new(0.058 * side, 1.315, 0.142), 12);
    vec![bound(joined([eye(1.0), eye(-1.0)]), &[4])]
}

/// Brows and the hair below the beanie.
fn hair() -> Vec<Bound> {
    let brow = |side: f32| {
        limb(
            [Vec3::new(0.038 * side, 1.358, 0.146), Vec3::new(0.082 * side, 1.354, 0.132)],
            [0.0085, 0.006],
            [8, 2],
        )
    };
    let nape = ellipsoid(Vec3::new(0.152, 0.105, 0.10), Vec3::new(0.0, 1.305, -0.065), 16);
    vec![bound(joined([brow(1.0), brow(-1.0), nape]), &[4])]
}

/// The belt's buckle, and the bedroll's straps.
fn buckles() -> Vec<Bound> {
    let buckle = at(rounded_box(Vec3::new(0.05, 0.036, 0.016), 0.006, 2), 0.0, 0.765, 0.112);
    let roll = limb([Vec3::new(-0.14, 1.13, -0.17), Vec3::new(0.14, 1.13, -0.17)], [0.05; 2], [12, 3]);
    vec![bound(buckle, &[0, 1]), bound(roll, &[2])]
}
