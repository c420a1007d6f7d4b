//! A hiker skinned to 19 joints, with the clips "walk" and "wave".

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use super::Stage;
use super::character_body::{JOINTS, body, joints};
use scene_builder::document::Built;
use scene_builder::staging::{Track, clip, flat3, flat4};

/// Keys of a clip, the last like the first.
const KEYS: u32 = 16;
/// Duration of two steps, seconds.
const WALK_SECONDS: f32 = 1.0;
const WAVE_SECONDS: f32 = 2.0;
/// Points of a sole below the ankle: heel and tip.
const SOLE: [Vec3; 2] = [Vec3::new(0.0, -0.10, -0.07), Vec3::new(0.0, -0.10, 0.15)];

pub(super) fn character() -> Built {
    let mut stage = Stage::new(
        "A hiker with beanie, scarf and backpack walks on the spot towards the viewer: arms swing against the legs, the soles \
         touch y = 0, and joints bend without dents. In the clip \"wave\" the right hand waves.",
    );
    stage.gltf.reference_frames(&[0, 6, 18]);
    stage.gltf.shot("animation", "walk");
    let nodes = joints(&mut stage.gltf);
    body(&mut stage.gltf, &nodes);
    let times =
        |seconds: f32| -> Vec<f32> { (0..=KEYS).map(|key| seconds * key as f32 / KEYS as f32).collect() };
    clip(&mut stage.gltf, "walk", &walk(&nodes, &times(WALK_SECONDS)));
    clip(&mut stage.gltf, "wave", &wave(&nodes, &times(WAVE_SECONDS)));
    Ok(stage.gltf)
}

/// A rotation track of a joint by the phase of the clip, from 0 to a whole turn.
fn rotation(node: usize, times: &[f32], value: impl Fn(f32) -> Quat) -> Track<'_> {
    let values: Vec<Quat> = (0..=KEYS).map(|key| value(TAU * (key % KEYS) as f32 / KEYS as f32)).collect();
    Track { node, path: "rotation", interpolation: "LINEAR", times, values: flat4(&values) }
}

/// Rotations about X of thigh, shin and foot; positive is backwards for what hangs down.
fn leg(phase: f32) -> [f32; 3] {
    let (sin, cos) = libm::sincosf(phase);
    // The thigh swings; the knee bends while the leg moves forward; the foot stays level on the ground and lags in the air.
    let thigh = -0.5 * sin - 0.04;
    let swing = cos.max(0.0);
    let shin = 0.14 + 0.85 * swing * swing;
    let toe_off = libm::sinf(phase + 1.1).min(0.0);
    [thigh, shin, -(thigh + shin) * 0.85 + 0.35 * toe_off * toe_off - 0.1 * swing]
}

/// Height of the lowest point of a sole over the hips' joint, for a leg in the pose of [`leg`].
fn lowest(phase: f32) -> f32 {
    let [thigh, shin, foot] = leg(phase).map(Quat::from_rotation_x);
    let offset = |from: usize, to: usize| JOINTS[to].2 - JOINTS[from].2;
    let ankle = offset(0, 11) + thigh * (offset(11, 12) + shin * offset(12, 13));
    let height = |point: Vec3| (ankle + thigh * (shin * (foot * point))).y;
    height(SOLE[0]).min(height(SOLE[1]))
}

fn walk<'a>(nodes: &[usize], times: &'a [f32]) -> Vec<Track<'a>> {
    let half = TAU / 2.0;
    let heights = (0..=KEYS).map(|key| {
        let phase = TAU * (key % KEYS) as f32 / KEYS as f32;
        let lowest = lowest(phase).min(lowest(phase + half));
        Vec3::new(0.012 * libm::cosf(phase), -lowest, 0.0)
    });
    let values = flat3(&heights.collect::<Vec<_>>());
    let mut tracks =
        vec![Track { node: nodes[0], path: "translation", interpolation: "LINEAR", times, values }];
    for (joints, shift) in [([11, 12, 13], 0.0), ([14, 15, 16], half)] {
        for (index, joint) in joints.into_iter().enumerate() {
            tracks.push(rotation(nodes[joint], times, |phase| {
                Quat::from_rotation_x(leg(phase + shift)[index])
            }));
        }
    }
    for (joints, side) in [([5, 6], 1.0), ([8, 9], -1.0)] {
        let swing = move |phase: f32| side * libm::sinf(phase);
        tracks.push(rotation(nodes[joints[0]], times, |phase| {
            Quat::from_rotation_z(-0.28 * side) * Quat::from_rotation_x(0.55 * swing(phase))
        }));
        tracks.push(rotation(nodes[joints[1]], times, |phase| {
            Quat::from_rotation_x(-0.45 + 0.25 * swing(phase))
        }));
    }
    let yaw = |amount: f32| move |phase: f32| Quat::from_rotation_y(amount * libm::sinf(phase));
    tracks.push(rotation(nodes[1], times, yaw(0.08)));
    tracks.push(rotation(nodes[2], times, |phase| Quat::from_rotation_x(0.05) * yaw(0.16)(phase)));
    tracks.push(rotation(nodes[4], times, |phase| {
        Quat::from_rotation_x(-0.05 + 0.03 * libm::cosf(2.0 * phase)) * yaw(-0.2)(phase)
    }));
    for (joint, lag) in [(17, 0.0), (18, 0.9)] {
        tracks.push(rotation(nodes[joint], times, |phase| {
            Quat::from_rotation_x(0.12 + 0.14 * libm::cosf(2.0 * phase - lag))
                * Quat::from_rotation_z(0.1 * libm::sinf(phase - lag))
        }));
    }
    tracks
}

fn wave<'a>(nodes: &[usize], times: &'a [f32]) -> Vec<Track<'a>> {
    // The arm is up in the middle half of the clip.
    let raised = |phase: f32| {
        let share = ((1.0 - libm::cosf(phase)) * 0.9).min(1.0);
        share * share * (3.0 - 2.0 * share)
    };
    let angle = |radians: f32| Quat::from_rotation_z(radians);
    vec![
        rotation(nodes[8], times, |phase| angle(0.28 - 1.85 * raised(phase))),
        rotation(nodes[9], times, |phase| angle(raised(phase) * (-0.75 + 0.4 * libm::sinf(4.0 * phase)))),
        rotation(nodes[10], times, |phase| angle(raised(phase) * 0.25 * libm::sinf(4.0 * phase - 0.6))),
        rotation(nodes[5], times, |_| angle(-0.28)),
        rotation(nodes[4], times, |phase| {
            angle(-0.14 * raised(phase)) * Quat::from_rotation_y(-0.12 * raised(phase))
        }),
        rotation(nodes[2], times, |phase| angle(0.05 * raised(phase))),
    ]
}
