//! Animation clips.
//!
//! Source: glTF 2.0 specification, section 3.11 (animations).

use std::collections::BTreeSet;

use gltf::json;
use gltf::json::animation::{Interpolation as JsonInterpolation, Property};
use gltf::json::validation::Checked;

use super::accessor::Data;
use super::attributes::Reference;
use super::context::Context;
use super::document::NO_NODE;
use super::formats;
use super::raw::Raw;
use crate::error::Result;
use crate::scene::{
    Animation, AnimationTarget, Channel, Interpolation, Keyframes, LocalTransform, Mesh, Node, NodeIndex,
};

/// Imports all clips.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    nodes: &[Node],
    meshes: &[Mesh],
) -> Result<Vec<Animation>> {
    let mut animations = Vec::new();
    for (i, animation) in data.document.root.animations.iter().enumerate() {
        let pointer = format!("/animations/{i}");
        let mut channels = Vec::new();
        let mut targets = BTreeSet::new();
        for (j, channel) in animation.channels.iter().enumerate() {
            let pointer = format!("{pointer}/channels/{j}");
            let Some(target) = target(context, data, channel, nodes, &pointer)? else {
                continue;
            };
            if !targets.insert(target) {
                let message = "moves what another channel of this clip moves";
                return Err(context.invalid(format!("{pointer}/target"), message));
            }
            let width = width(context, target, nodes, meshes, &pointer)?;
            let sampler = context.subscript(
                channel.sampler.value(),
                animation.samplers.len(),
                &format!("{pointer}/sampler"),
                "sampler",
            )?;
            if let Some(json) = animation.samplers.get(sampler) {
                let pointer = format!("/animations/{i}/samplers/{sampler}");
                let keyframes = keyframes(context, data, json, target, width, &pointer)?;
                channels.push(Channel { target, keyframes });
            }
        }
        animations.push(Animation { name: animation.name.clone(), channels });
    }
    Ok(animations)
}

/// What a channel moves; `None` for what is not honoured, with a warning where nothing else told of it.
fn target(
    context: &mut Context,
    data: &Data,
    channel: &json::animation::Channel,
    nodes: &[Node],
    pointer: &str,
) -> Result<Option<AnimationTarget>> {
    let pointer = format!("{pointer}/target");
    let Checked::Valid(property) = channel.target.path else {
        if let Some(raw) = Raw::at(&data.document.value, &pointer) {
            let path = raw.string(context, "path")?.unwrap_or_default().to_owned();
            // Paths of extensions have been named with the extension.
            if raw.field("extensions").is_none() {
                let message =
                    format!("the animation path \"{}\" is not known; it stands still", path.escape_debug());
                context.warn(format!("{pointer}/path"), message);
            }
        }
        return Ok(None);
    };
    let index = channel.target.node.value();
    if index == NO_NODE {
        return Ok(None);
    }
    let index = context.subscript(index, nodes.len(), &format!("{pointer}/node"), "node")?;
    let is_matrix = nodes.get(index).is_some_and(|node| matches!(node.local, LocalTransform::Matrix(_)));
    if is_matrix && property != Property::MorphTargetWeights {
        let message =
            format!("node {index} has a matrix; animated nodes need translation, rotation and scale");
        return Err(context.invalid(format!("{pointer}/node"), message));
    }
    let node = NodeIndex(u32::try_from(index).unwrap_or(u32::MAX));
    Ok(Some(match property {
        Property::Translation => AnimationTarget::Translation(node),
        Property::Rotation => AnimationTarget::Rotation(node),
        Property::Scale => AnimationTarget::Scale(node),
        Property::MorphTargetWeights => AnimationTarget::Weights(node),
    }))
}

/// Components of one value of `target`.
fn width(
    context: &Context,
    target: AnimationTarget,
    nodes: &[Node],
    meshes: &[Mesh],
    pointer: &str,
) -> Result<usize> {
    match target {
        AnimationTarget::Translation(_) | AnimationTarget::Scale(_) => Ok(3),
        AnimationTarget::Rotation(_) => Ok(4),
        AnimationTarget::Weights(node) => {
            let mesh = nodes.get(node.index()).and_then(|node| node.mesh);
            let weights = mesh.and_then(|mesh| meshes.get(mesh.index())).map(|mesh| mesh.weights.len());
            match weights {
                Some(count) if count > 0 => Ok(count),
                _ => Err(context.invalid(
                    format!("{pointer}/target"),
                    format!("node {} has no morph targets to weigh", node.0),
                )),
            }
        }
    }
}

fn keyframes(
    context: &mut Context,
    data: &Data,
    sampler: &json::animation::Sampler,
    target: AnimationTarget,
    width: usize,
    pointer: &str,
) -> Result<Keyframes> {
    let Checked::Valid(interpolation) = sampler.interpolation else {
        let message = "must be LINEAR, STEP or CUBICSPLINE";
        return Err(context.invalid(format!("{pointer}/interpolation"), message));
    };
    let (interpolation, values_per_key) = match interpolation {
        JsonInterpolation::Step => (Interpolation::Step, 1_usize),
        JsonInterpolation::Linear => (Interpolation::Linear, 1),
        JsonInterpolation::CubicSpline => (Interpolation::CubicSpline, 3),
    };
    let times_seconds = times(context, data, sampler, pointer)?;
    let values = values(context, data, sampler, target, pointer)?;
    let expected = times_seconds.len().checked_mul(values_per_key).and_then(|count| count.checked_mul(width));
    if expected != Some(values.len()) {
        let message = format!(
            "has {} numbers for {} keys of {} values with {width} components",
            values.len(),
            times_seconds.len(),
            values_per_key
        );
        return Err(context.invalid(format!("{pointer}/output"), message));
    }
    if matches!(target, AnimationTarget::Rotation(_)) {
        check_rotations(context, &values, values_per_key, pointer)?;
    }
    Ok(Keyframes { times_seconds, values, width, interpolation })
}

fn times(
    context: &mut Context,
    data: &Data,
    sampler: &json::animation::Sampler,
    pointer: &str,
) -> Result<Vec<f32>> {
    let reference = Reference {
        name: "input".to_owned(),
        accessor: sampler.input.value(),
        pointer: format!("{pointer}/input"),
    };
    let times: Vec<[f32; 1]> = data.floats_as(context, &reference, &formats::TIMES)?;
    let times: Vec<f32> = times.into_iter().map(|[time]| time).collect();
    let pointer = format!("/accessors/{}", reference.accessor);
    if times.first().is_some_and(|&first| first < 0.0) {
        return Err(context.invalid(pointer, "has keyframes before time 0"));
    }
    match times.windows(2).position(|pair| matches!(pair, [a, b] if a >= b)) {
        None => Ok(times),
        Some(i) => Err(context
            .invalid(pointer, format!("keyframe times must increase, but key {i} is not before the next"))),
    }
}

fn values(
    context: &mut Context,
    data: &Data,
    sampler: &json::animation::Sampler,
    target: AnimationTarget,
    pointer: &str,
) -> Result<Vec<f32>> {
    let reference = Reference {
        name: "output".to_owned(),
        accessor: sampler.output.value(),
        pointer: format!("{pointer}/output"),
    };
    Ok(match target {
        AnimationTarget::Translation(_) | AnimationTarget::Scale(_) => {
            let values: Vec<[f32; 3]> = data.floats_as(context, &reference, &formats::VECTOR_KEYS)?;
            values.into_flattened()
        }
        AnimationTarget::Rotation(_) => {
            let values: Vec<[f32; 4]> = data.floats_as(context, &reference, &formats::ROTATION_KEYS)?;
            values.into_flattened()
        }
        AnimationTarget::Weights(_) => {
            let values: Vec<[f32; 1]> = data.floats_as(context, &reference, &formats::WEIGHT_KEYS)?;
            values.into_flattened()
        }
    })
}

/// A key of length zero turns nowhere and could not be normalized. Tangents of splines may be zero.
fn check_rotations(context: &Context, values: &[f32], values_per_key: usize, pointer: &str) -> Result<()> {
    let (quaternions, _) = values.as_chunks::<4>();
    let value_of_key = values_per_key / 2;
    let keys = quaternions.iter().skip(value_of_key).step_by(values_per_key.max(1));
    let zero = keys.into_iter().position(|q| q.iter().all(|component| component.abs() < 1e-12));
    match zero {
        None => Ok(()),
        Some(i) => Err(context.invalid(
            format!("{pointer}/output"),
            format!("key {i} is a quaternion of length zero, which turns nowhere"),
        )),
    }
}
