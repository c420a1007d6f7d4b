//! Scenes of `skin/`.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{Mat4, Quat, Vec3, Vec4};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{self, TriangleMesh, strip};
use scene_builder::staging::{Track, clip, flat4, lit_stage};

pub(crate) const SCENES: [Entry; 3] = [
    entry("skin/two_bone_strip", two_bone_strip),
    entry("skin/many_influences", many_influences),
    entry("skin/mesh_transform_ignored", mesh_transform_ignored),
];

fn wall(gltf: &mut Gltf) {
    let material = Material::matte("wall", [0.6; 3]).add_to(gltf);
    let wall = shapes::quad(9.0, 6.0).plain().add_to(gltf, material);
    gltf.node(Node::mesh(wall).named("wall").at(0.0, 1.0, -1.2));
}

fn paint(gltf: &mut Gltf) -> usize {
    Material::matte("strip", [0.65, 0.25, 0.05]).two_sided().add_to(gltf)
}

/// Adds a strip, 2 m high, whose upper half follows the second of two joints; in between the weights blend over
/// the middle half metre. Gives the mesh.
fn blended_strip(gltf: &mut Gltf, material: usize) -> usize {
    let shape = strip(0.4, 2.0, 8).plain();
    let mut attributes = shape.attributes(gltf);
    let weights: Vec<[u8; 4]> = shape
        .positions
        .iter()
        .map(|position| {
            let upper = scene_builder::image::byte((position.y - 0.75) / 0.5);
            [255 - upper, upper, 0, 0]
        })
        .collect();
    let (joints, weights) = gltf.influences(&vec![[0, 1, 0, 0]; weights.len()], &weights);
    attributes.set("JOINTS_0", joints);
    attributes.set("WEIGHTS_0", weights);
    let indices = gltf.indices(&shape.indices);
    shapes::mesh(gltf, attributes, indices, material)
}

/// Adds two joints, at `base` and 1 m above it. Gives them and the skin.
fn two_joints(gltf: &mut Gltf, base: Vec3) -> ([usize; 2], usize) {
    let upper = gltf.node(Node::default().named("upper").at(0.0, 1.0, 0.0));
    let lower = gltf.node(Node::group(&[upper]).named("lower").at(base.x, base.y, base.z));
    // Bound with the strip's foot at the lower joint.
    let inverse_bind = [Mat4::IDENTITY, Mat4::from_translation(Vec3::NEG_Y)];
    let skin = gltf.skin(&[lower, upper], &inverse_bind);
    ([lower, upper], skin)
}

fn two_bone_strip() -> Built {
    let mut gltf = Gltf::new(
        "An upright strip bends to the right at half its height, by 0°, 45° and 90° after 0, 0.5 and 1 s: the lower half \
         stands still, the upper half stays straight, and the bend is narrower than the strip, as linear blending gives.",
    );
    gltf.reference_frames(&[0, 12, 24]);
    lit_stage(&mut gltf, Vec3::new(0.2, 1.0, 5.5), Vec3::new(0.2, 1.0, 0.0), 28.0);
    wall(&mut gltf);
    let material = paint(&mut gltf);
    let mesh = blended_strip(&mut gltf, material);
    let (joints, skin) = two_joints(&mut gltf, Vec3::ZERO);
    gltf.node(Node { skin: Some(skin), ..Node::mesh(mesh).named("strip") });
    bend(&mut gltf, joints[1]);
    Ok(gltf)
}

fn bend(gltf: &mut Gltf, joint: usize) {
    let values = flat4(&[Quat::IDENTITY, Quat::from_rotation_z(-FRAC_PI_2)]);
    clip(
        gltf,
        "bend",
        &[Track { node: joint, path: "rotation", interpolation: "LINEAR", times: &[0.0, 1.0], values }],
    );
}

fn mesh_transform_ignored() -> Built {
    let mut gltf = Gltf::new(
        "The same bent strip twice, side by side, upright and of one size: the right one's mesh node is moved, turned and \
         scaled by a parent, which a skinned mesh ignores; only the joints place it.",
    );
    gltf.reference_frames(&[12]);
    lit_stage(&mut gltf, Vec3::new(0.3, 1.0, 5.5), Vec3::new(0.3, 1.0, 0.0), 28.0);
    wall(&mut gltf);
    let material = paint(&mut gltf);
    let mesh = blended_strip(&mut gltf, material);
    let mut tracks = Vec::new();
    for x in [-1.0, 1.0] {
        let (joints, skin) = two_joints(&mut gltf, Vec3::new(x, 0.0, 0.0));
        let strip_node = Node { skin: Some(skin), ..Node::mesh(mesh).named("strip") };
        if x < 0.0 {
            gltf.node(strip_node);
        } else {
            let child = gltf.node(strip_node.at(3.0, 1.0, -2.0).turned(Quat::from_rotation_y(FRAC_PI_4)));
            gltf.node(Node::group(&[child]).named("parent").at(0.0, -5.0, 0.0).scaled(2.0, 0.5, 2.0));
        }
        let values = flat4(&[Quat::IDENTITY, Quat::from_rotation_z(-FRAC_PI_2)]);
        tracks.push(Track {
            node: joints[1],
            path: "rotation",
            interpolation: "LINEAR",
            times: &[0.0, 1.0],
            values,
        });
    }
    clip(&mut gltf, "bend", &tracks);
    Ok(gltf)
}

fn many_influences() -> Built {
    let mut gltf = Gltf::new(
        "Two strips hang on six joints, the even ones moved to the left, the odd ones to the right. The left strip follows \
         all six equally, by two sets of joints and weights, and stays straight; the right strip follows one joint a \
         row and zigzags.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.0, 5.5), Vec3::new(0.0, 1.0, 0.0), 28.0);
    wall(&mut gltf);
    let material = paint(&mut gltf);
    for (x, spread) in [(-0.9, true), (0.9, false)] {
        let shape = strip(0.4, 2.0, 5).plain();
        let side = |joint: usize| if joint.is_multiple_of(2) { -0.2 } else { 0.2 };
        let joints: Vec<usize> =
            (0..6).map(|joint| gltf.node(Node::default().at(side(joint), 0.0, 0.0))).collect();
        gltf.node(Node::group(&joints).named("joints").at(x, 0.0, 0.0));
        let mesh = influenced(&mut gltf, &shape, material, spread);
        let skin = gltf.skin(&joints, &[Mat4::IDENTITY; 6]);
        gltf.node(Node { skin: Some(skin), ..Node::mesh(mesh) });
    }
    Ok(gltf)
}

/// The mesh of a strip whose vertices follow all six joints, or only the joint of their row.
fn influenced(gltf: &mut Gltf, shape: &TriangleMesh, material: usize, spread: bool) -> usize {
    let vertices = shape.positions.len();
    let mut attributes = shape.attributes(gltf);
    if spread {
        attributes.set("JOINTS_0", gltf.bytes4(&vec![[0, 1, 2, 3]; vertices], false));
        attributes.set("WEIGHTS_0", gltf.vec4s(&vec![Vec4::splat(1.0 / 6.0); vertices]));
        attributes.set("JOINTS_1", gltf.bytes4(&vec![[4, 5, 0, 0]; vertices], false));
        let rest = Vec4::new(1.0 / 6.0, 1.0 / 6.0, 0.0, 0.0);
        attributes.set("WEIGHTS_1", gltf.vec4s(&vec![rest; vertices]));
    } else {
        let joints: Vec<[u8; 4]> = (0..vertices).map(|vertex| [(vertex / 2) as u8, 0, 0, 0]).collect();
        attributes.set("JOINTS_0", gltf.bytes4(&joints, false));
        attributes.set("WEIGHTS_0", gltf.vec4s(&vec![Vec4::X; vertices]));
    }
    let indices = gltf.indices(&shape.indices);
    shapes::mesh(gltf, attributes, indices, material)
}
