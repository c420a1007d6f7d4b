//! Animated bodies of the demo: a tentacle skinned to eight joints and a morphing star.

use std::f32::consts::TAU;

use glam::{Mat4, Quat, Vec3};

use crate::morph::morph_mesh;
use scene_builder::document::Gltf;
use scene_builder::json::object;
use scene_builder::node::Node;
use scene_builder::shapes::{self, TriangleMesh, grid_indices, ico_sphere};
use scene_builder::staging::{Track, flat4};

/// Joints of a tentacle.
const JOINTS: u32 = 8;
/// Length of a tentacle, metres.
const LENGTH: f32 = 2.6;
/// Keys of a closed movement, the last like the first.
pub(crate) const KEYS: u32 = 24;

/// Radius of a tentacle at `share` of its length: thick below, thin above, round at the tip.
fn tentacle_radius(share: f32) -> f32 {
    let square = share * share;
    let power = square * square * square * square * square;
    0.3 * (1.0 - 0.78 * share) * libm::sqrtf(1.0 - power * power)
}

/// Adds the mesh of an upright tentacle with its foot at the origin, bound to joints `LENGTH / JOINTS` apart.
pub(crate) fn tentacle_mesh(gltf: &mut Gltf, material: usize) -> usize {
    let (sides, rows) = (32, 64);
    let mut shape = TriangleMesh::default();
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for row in 0..=rows {
        // Rows from the tip down, closer together near the tip.
        let down = row as f32 / rows as f32;
        let share = 1.0 - down * (0.25 + 0.75 * down);
        let radius = if row == 0 { 0.0 } else { tentacle_radius(share) };
        let slope = (tentacle_radius(share + 5e-4 * down) - tentacle_radius(share - 1e-3))
            / LENGTH
            / (1e-3 + 5e-4 * down);
        let (joint, weight) = influence(share);
        for side in 0..=sides {
            let (sin, cos) = libm::sincosf(TAU * (side % sides) as f32 / sides as f32);
            let outward = Vec3::new(sin, 0.0, cos);
            shape.positions.push(outward * radius + Vec3::Y * (share * LENGTH));
            shape.normals.push(if row == 0 { Vec3::Y } else { (outward - Vec3::Y * slope).normalize() });
            joints.push(joint);
            weights.push(weight);
        }
    }
    shape.indices = grid_indices(sides, rows, false);
    let shape = shape.without_collapsed();
    let mut attributes = shape.attributes(gltf);
    let (joints, weights) = gltf.influences(&joints, &weights);
    attributes.set("JOINTS_0", joints);
    attributes.set("WEIGHTS_0", weights);
    let indices = gltf.indices(&shape.indices);
    shapes::mesh(gltf, attributes, indices, material)
}

/// The two joints around `share` of the length and their weights, which blend smoothly from the middle of one
/// segment to the middle of the next.
fn influence(share: f32) -> ([u8; 4], [u8; 4]) {
    let place = (share * JOINTS as f32 - 0.5).clamp(0.0, (JOINTS - 1) as f32);
    let lower = libm::floorf(place).clamp(0.0, (JOINTS - 2) as f32);
    let part = place - lower;
    let upper = scene_builder::image::byte(part * part * (3.0 - 2.0 * part));
    let joint = lower as u8;
    ([joint, joint + 1, 0, 0], [255 - upper, upper, 0, 0])
}

/// Adds the joints of one tentacle at `foot`, and its skin. The joints come from the foot up.
pub(crate) fn tentacle_joints(gltf: &mut Gltf, foot: Vec3, scale: f32) -> (Vec<usize>, usize) {
    let segment = LENGTH / JOINTS as f32;
    let mut joints: Vec<usize> = Vec::new();
    for joint in (0..JOINTS).rev() {
        let children: Vec<usize> = joints.last().copied().into_iter().collect();
        let node = Node::group(&children);
        let node = if joint == 0 {
            node.named("tentacle foot").at(foot.x, foot.y, foot.z).scaled(scale, scale, scale)
        } else {
            node.at(0.0, segment, 0.0)
        };
        joints.push(gltf.node(node));
    }
    joints.reverse();
    let bind: Vec<Mat4> =
        (0..JOINTS).map(|joint| Mat4::from_translation(Vec3::NEG_Y * (segment * joint as f32))).collect();
    let skin = gltf.skin(&joints, &bind);
    (joints, skin)
}

/// The swaying of a tentacle: every joint curls a little towards +X (or −X with a negative `curl`) and a wave runs
/// from the foot to the tip.
pub(crate) fn sway<'a>(joints: &[usize], times: &'a [f32], curl: f32, phase: f32) -> Vec<Track<'a>> {
    let track = |(index, &node): (usize, &usize)| {
        let rise = index as f32 / JOINTS as f32;
        let rotations: Vec<Quat> = (0..=KEYS)
            .map(|key| {
                let angle = TAU * (key % KEYS) as f32 / KEYS as f32 + phase - 0.7 * index as f32;
                let (sin, cos) = libm::sincosf(angle);
                let sideways = curl * (0.06 + 0.2 * rise) + 0.09 * sin;
                Quat::from_rotation_z(-sideways) * Quat::from_rotation_x(0.05 * cos)
            })
            .collect();
        Track { node, path: "rotation", interpolation: "LINEAR", times, values: flat4(&rotations) }
    };
    joints.iter().enumerate().map(track).collect()
}

/// Adds the mesh of a ball of `radius` with two morph targets: twelve soft spikes, and a flattening.
pub(crate) fn star_mesh(gltf: &mut Gltf, radius: f32, material: usize) -> usize {
    let ball = ico_sphere(1.0, 4);
    let spikes = ico_sphere(1.0, 0).positions;
    let (mut spiky, mut spiky_normals) = (Vec::new(), Vec::new());
    let (mut flat, mut flat_normals) = (Vec::new(), Vec::new());
    for direction in &ball.normals {
        // r(d) = 1 + h Σ exp(k (d·s − 1)); the normal of r(d) d is along r d − ∇r, with ∇r tangent to the sphere.
        let (height, sharpness) = (0.75, 11.0);
        let mut distance = 0.92;
        let mut gradient = Vec3::ZERO;
        for spike in &spikes {
            let cosine = direction.dot(*spike);
            let bump = height * libm::expf(sharpness * (cosine - 1.0));
            distance += bump;
            gradient += (*spike - *direction * cosine) * (sharpness * bump);
        }
        spiky.push(*direction * ((distance - 1.0) * radius));
        spiky_normals.push((*direction * distance - gradient).normalize() - *direction);
        let squash = Vec3::new(1.18, 0.7, 1.18);
        flat.push((*direction * squash - *direction) * radius);
        flat_normals.push((*direction / squash).normalize() - *direction);
    }
    let shape =
        TriangleMesh { positions: ball.normals.iter().map(|normal| *normal * radius).collect(), ..ball };
    let attributes = shape.attributes(gltf);
    let indices = gltf.indices(&shape.indices);
    let mut target = |positions: &[Vec3], normals: &[Vec3]| {
        object([("POSITION", gltf.positions(positions).into()), ("NORMAL", gltf.vec3s(normals).into())])
    };
    let targets = vec![target(&spiky, &spiky_normals), target(&flat, &flat_normals)];
    morph_mesh(gltf, attributes, indices, material, targets, &[0.0, 0.0])
}
