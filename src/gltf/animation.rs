//! Animation clips.
//!
//! Source: glTF 2.0 specification, section 3.11 (animations); the text of `KHR_animation_pointer`.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use gltf::json;
use gltf::json::animation::{Interpolation as JsonInterpolation, Property as Path};
use gltf::json::validation::Checked;

use super::accessor::Data;
use super::attributes::Reference;
use super::context::Context;
use super::document::NO_NODE;
use super::extensions::ANIMATION_POINTER;
use super::formats::{self, Allowed};
use super::pointer::{self, Property};
use super::raw::{ANY, Raw, check_range};
use crate::error::Result;
use crate::scene::{
    Animation, AnimationTarget, Channel, ImageLightProperty, Interpolation, Keyframes, LocalTransform, Mesh,
    Node, NodeIndex,
};

/// What a channel moves, and what its keys may be.
#[derive(Debug)]
struct Moved {
    target: AnimationTarget,
    /// Components of one value.
    width: usize,
    keys: &'static Allowed,
    range: RangeInclusive<f32>,
    /// Whether values are either true or false, so that there is nothing between keys.
    is_switch: bool,
}

/// Imports all clips, and how many channels of each are left out.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    nodes: &[Node],
    meshes: &[Mesh],
) -> Result<(Vec<Animation>, Vec<usize>)> {
    let mut animations = Vec::new();
    let mut ignored = Vec::new();
    for (i, animation) in data.document.root.animations.iter().enumerate() {
        let pointer = format!("/animations/{i}");
        let mut channels = Vec::new();
        let mut targets = BTreeSet::new();
        for (j, channel) in animation.channels.iter().enumerate() {
            let pointer = format!("{pointer}/channels/{j}");
            let Some(moved) = moved(context, data, channel, (nodes, meshes), &pointer)? else {
                continue;
            };
            if moved.target.clashes(&targets) {
                let message = "moves what another channel of this clip moves";
                return Err(context.invalid(format!("{pointer}/target"), message));
            }
            targets.insert(moved.target);
            let sampler = context.subscript(
                channel.sampler.value(),
                animation.samplers.len(),
                &format!("{pointer}/sampler"),
                "sampler",
            )?;
            if let Some(json) = animation.samplers.get(sampler) {
                let pointer = format!("/animations/{i}/samplers/{sampler}");
                let keyframes = keyframes(context, data, json, &moved, &pointer)?;
                channels.push(Channel { target: moved.target, keyframes });
            }
        }
        ignored.push(animation.channels.len().saturating_sub(channels.len()));
        animations.push(Animation { name: animation.name.clone(), channels });
    }
    Ok((animations, ignored))
}

/// What a channel moves; `None` for what is not honoured, with a warning where nothing else told of it.
fn moved(
    context: &mut Context,
    data: &Data,
    channel: &json::animation::Channel,
    (nodes, meshes): (&[Node], &[Mesh]),
    pointer: &str,
) -> Result<Option<Moved>> {
    let target_pointer = format!("{pointer}/target");
    let property = match channel.target.path {
        Checked::Valid(path) => {
            let index = channel.target.node.value();
            if index == NO_NODE {
                return Ok(None);
            }
            let index = context.subscript(index, nodes.len(), &format!("{target_pointer}/node"), "node")?;
            let node = NodeIndex(u32::try_from(index).unwrap_or(u32::MAX));
            let (target, keys) = match path {
                Path::Translation => (AnimationTarget::Translation(node), &formats::VECTOR_KEYS),
                Path::Rotation => (AnimationTarget::Rotation(node), &formats::ROTATION_KEYS),
                Path::Scale => (AnimationTarget::Scale(node), &formats::VECTOR_KEYS),
                Path::MorphTargetWeights => (AnimationTarget::Weights(node), &formats::WEIGHT_KEYS),
            };
            Moved { target, width: 0, keys, range: ANY, is_switch: false }
        }
        Checked::Invalid => match pointed(context, data, &target_pointer)? {
            Some(moved) => moved,
            None => return Ok(None),
        },
    };
    check_matrix(context, property.target, nodes, &target_pointer)?;
    let width = width(context, &property, nodes, meshes, pointer)?;
    Ok(Some(Moved { width, ..property }))
}

/// What a channel with an extension or an unknown path moves.
fn pointed(context: &mut Context, data: &Data, pointer: &str) -> Result<Option<Moved>> {
    let Some(raw) = Raw::at(&data.document.value, pointer) else {
        return Ok(None);
    };
    let path = raw.string(context, "path")?.unwrap_or_default().to_owned();
    let Some(extension) = raw.extension(ANIMATION_POINTER).filter(|_| path == "pointer") else {
        // Paths of other extensions have been named with the extension.
        if raw.field("extensions").is_none() {
            let message =
                format!("the animation path \"{}\" is not known; it stands still", path.escape_debug());
            context.warn(format!("{pointer}/path"), message);
        }
        return Ok(None);
    };
    extension.expect_object(context)?;
    let place = format!("{}/pointer", extension.pointer);
    let Some(named) = extension.string(context, "pointer")? else {
        return Err(context.invalid(place, "is missing"));
    };
    let Some(property) = pointer::property(data.document, named) else {
        let message = format!(
            "the animated property {} is not in the file or not supported; it stands still",
            named.escape_debug()
        );
        context.warn(place, message);
        return Ok(None);
    };
    let keys = match property.width {
        _ if property.is_switch => &formats::SWITCH_KEYS,
        width => formats::PROPERTY_KEYS.get(width.saturating_sub(1)).unwrap_or(&formats::WEIGHT_KEYS),
    };
    let Property { target, width, range, is_switch } = property;
    Ok(Some(Moved { target, width, keys, range, is_switch }))
}

/// Nodes with a matrix have no translation, rotation or scale to move.
fn check_matrix(context: &Context, target: AnimationTarget, nodes: &[Node], pointer: &str) -> Result<()> {
    let (AnimationTarget::Translation(node) | AnimationTarget::Rotation(node) | AnimationTarget::Scale(node)) =
        target
    else {
        return Ok(());
    };
    let node_is_matrix =
        nodes.get(node.index()).is_some_and(|node| matches!(node.local, LocalTransform::Matrix(_)));
    if !node_is_matrix {
        return Ok(());
    }
    let message =
        format!("node {} has a matrix; animated nodes need translation, rotation and scale", node.0);
    Err(context.invalid(format!("{pointer}/node"), message))
}

/// Components of one value of what is moved.
fn width(context: &Context, moved: &Moved, nodes: &[Node], meshes: &[Mesh], pointer: &str) -> Result<usize> {
    let (mesh, place) = match moved.target {
        AnimationTarget::Translation(_) | AnimationTarget::Scale(_) => return Ok(3),
        AnimationTarget::Rotation(_) => return Ok(4),
        AnimationTarget::Weights(node) => (nodes.get(node.index()).and_then(|node| node.mesh), None),
        AnimationTarget::Weight(node, place) => {
            (nodes.get(node.index()).and_then(|node| node.mesh), Some(place))
        }
        AnimationTarget::MeshWeights(mesh) => (Some(mesh), None),
        AnimationTarget::MeshWeight(mesh, place) => (Some(mesh), Some(place)),
        AnimationTarget::Visibility(_)
        | AnimationTarget::Material(..)
        | AnimationTarget::Light(..)
        | AnimationTarget::Camera(..)
        | AnimationTarget::ImageLight(..) => return Ok(moved.width),
    };
    let weights = mesh.and_then(|mesh| meshes.get(mesh.index())).map(|mesh| mesh.weights.len());
    match (weights, place) {
        (Some(count), Some(place)) if count > place as usize => Ok(1),
        (Some(count), Some(place)) => {
            let message = format!("there is no morph target {place}, the mesh has {count}");
            Err(context.invalid(format!("{pointer}/target"), message))
        }
        (Some(count), None) if count > 0 => Ok(count),
        _ => Err(context.invalid(format!("{pointer}/target"), "there are no morph targets to weigh")),
    }
}

fn keyframes(
    context: &mut Context,
    data: &Data,
    sampler: &json::animation::Sampler,
    moved: &Moved,
    pointer: &str,
) -> Result<Keyframes> {
    let width = moved.width;
    let Checked::Valid(interpolation) = sampler.interpolation else {
        let message = "must be LINEAR, STEP or CUBICSPLINE";
        return Err(context.invalid(format!("{pointer}/interpolation"), message));
    };
    let (interpolation, values_per_key) = match interpolation {
        JsonInterpolation::Step => (Interpolation::Step, 1_usize),
        JsonInterpolation::Linear => (Interpolation::Linear, 1),
        JsonInterpolation::CubicSpline => (Interpolation::CubicSpline, 3),
    };
    if moved.is_switch && interpolation != Interpolation::Step {
        let message = "must be STEP, because the property is either true or false";
        return Err(context.invalid(format!("{pointer}/interpolation"), message));
    }
    let times_seconds = times(context, data, sampler, pointer)?;
    let values = values(context, data, sampler, moved, pointer)?;
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
    check_values(context, &values, values_per_key, moved, pointer)?;
    if let AnimationTarget::Rotation(_) | AnimationTarget::ImageLight(_, ImageLightProperty::Rotation) =
        moved.target
    {
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
    moved: &Moved,
    pointer: &str,
) -> Result<Vec<f32>> {
    let reference = Reference {
        name: "output".to_owned(),
        accessor: sampler.output.value(),
        pointer: format!("{pointer}/output"),
    };
    let weighs = matches!(moved.target, AnimationTarget::Weights(_) | AnimationTarget::MeshWeights(_));
    Ok(match if weighs { 1 } else { moved.width } {
        1 => data.floats_as::<1>(context, &reference, moved.keys)?.into_flattened(),
        2 => data.floats_as::<2>(context, &reference, moved.keys)?.into_flattened(),
        3 => data.floats_as::<3>(context, &reference, moved.keys)?.into_flattened(),
        _ => data.floats_as::<4>(context, &reference, moved.keys)?.into_flattened(),
    })
}

/// Keys must be what the property may be; tangents of splines may be anything.
fn check_values(
    context: &Context,
    values: &[f32],
    values_per_key: usize,
    moved: &Moved,
    pointer: &str,
) -> Result<()> {
    let parts = values.chunks(moved.width.max(1)).skip(values_per_key / 2).step_by(values_per_key.max(1));
    let mut keys = parts.flatten();
    keys.try_for_each(|&key| {
        check_range(context, key, &moved.range, &format!("{pointer}/output")).map(|_| ())
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
