//! Checksum of the keyframes of a clip, from which a comparison tells that the motion between tested frames changed.

use crc32fast::Hasher as Checksum;

use crate::scene::{Animation, AnimationTarget, Channel, NodeIndex, Scene};

/// The checksum, 8 hexadecimal digits. The order of channels and of nodes does not count.
pub(crate) fn clip_checksum(scene: &Scene, clip: &Animation) -> String {
    let mut channels: Vec<u32> =
        clip.channels.iter().map(|channel| checksum_of_channel(scene, channel)).collect();
    channels.sort_unstable();
    let mut checksum = Checksum::new();
    for channel in channels {
        checksum.update(&channel.to_le_bytes());
    }
    format!("{:08x}", checksum.finalize())
}

fn checksum_of_channel(scene: &Scene, Channel { target, keyframes }: &Channel) -> u32 {
    let mut checksum = Checksum::new();
    checksum.update(target_text(scene, *target).as_bytes());
    checksum.update(format!(" {:?} {}", keyframes.interpolation, keyframes.width).as_bytes());
    for numbers in [&keyframes.times_seconds, &keyframes.values] {
        for number in numbers {
            checksum.update(&number.to_bits().to_le_bytes());
        }
    }
    checksum.finalize()
}

/// What a channel moves, by names: exporters change the order of nodes and materials.
fn target_text(scene: &Scene, target: AnimationTarget) -> String {
    let of_node = |node: NodeIndex, what: &str| {
        let name = scene.nodes.get(node.index()).and_then(|node| node.name.as_deref());
        format!("{what} of {}", name.unwrap_or_default())
    };
    match target {
        AnimationTarget::Translation(node) => of_node(node, "translation"),
        AnimationTarget::Rotation(node) => of_node(node, "rotation"),
        AnimationTarget::Scale(node) => of_node(node, "scale"),
        AnimationTarget::Weights(node) => of_node(node, "weights"),
        AnimationTarget::Visibility(node) => of_node(node, "visibility"),
        AnimationTarget::Weight(node, target) => of_node(node, &format!("weight {target}")),
        AnimationTarget::MeshWeights(_) => "weights of a mesh".to_owned(),
        AnimationTarget::MeshWeight(_, target) => format!("weight {target} of a mesh"),
        AnimationTarget::Material(index, property) => {
            let name = scene.materials.get(index.index()).and_then(|material| material.name.as_deref());
            format!("{property:?} of {}", name.unwrap_or_default())
        }
        AnimationTarget::Light(index, property) => {
            format!("{property:?} of {}", scene.light_name(index).unwrap_or_default())
        }
        AnimationTarget::Camera(index, property) => {
            format!("{property:?} of {}", scene.camera_name(index).unwrap_or_default())
        }
        AnimationTarget::ImageLight(_, property) => format!("{property:?} of an image-based light"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Interpolation, Keyframes, Node};

    /// References hold checksums, which later versions compare. Where this one changes, raise `PartHashes::RULES`.
    #[test]
    fn checksums_are_those_of_earlier_versions() {
        let door = Node { name: Some("door".to_owned()), ..Node::default() };
        let scene = Scene { nodes: vec![Node::default(), door], ..Scene::default() };
        let channel = |target, interpolation, times: &[f32], values: &[f32]| Channel {
            target,
            keyframes: Keyframes {
                times_seconds: times.to_vec(),
                values: values.to_vec(),
                width: values.len() / times.len(),
                interpolation,
            },
        };
        let opens = channel(
            AnimationTarget::Translation(NodeIndex(1)),
            Interpolation::Linear,
            &[0.0, 0.5],
            &[0.0, 0.0, 0.0, 1.0, 2.0, -3.0],
        );
        let turns = channel(
            AnimationTarget::Rotation(NodeIndex(0)),
            Interpolation::Step,
            &[0.25],
            &[0.0, 0.0, 0.0, 1.0],
        );
        for channels in [vec![opens.clone(), turns.clone()], vec![turns, opens]] {
            // By the CRC-32 of Python's zlib
            assert_eq!(clip_checksum(&scene, &Animation { name: None, channels }), "4c9b8bc8");
        }
    }
}
