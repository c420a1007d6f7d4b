//! Animations: channels, samplers and their keyframes.
//!
//! Source: glTF 2.0 specification, section 3.11 (animations); the text of `KHR_animation_pointer`.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use gltf::json;
use gltf::json::animation::{Interpolation as JsonInterpolation, Property as Path};
use gltf::json::validation::Checked;

use super::accessor::Data;
use super::animated_order::{ImportedChannels, compared_properties};
use super::attributes::Reference;
use super::context::Context;
use super::document::NO_NODE;
use super::extension_names::ANIMATION_POINTER;
use super::formats::{self, AllowedFormats};
use super::keyframe_checks::KeyValues;
use super::pointer::{self, Property};
use super::raw::{ANY, Raw, without_rounding_below};
use crate::error::Result;
use crate::scene::{
    Animation, AnimationTarget, Camera, Channel, Interpolation, Keyframes, Light, Mesh, Node, NodeIndex,
};

/// Imported objects that channels can target, and whose values limit those of keyframes.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnimationTargets<'a> {
    nodes: &'a [Node],
    meshes: &'a [Mesh],
    lights: &'a [Light],
    cameras: &'a [Camera],
}

impl<'a> AnimationTargets<'a> {
    pub(super) fn new(
        nodes: &'a [Node],
        meshes: &'a [Mesh],
        lights: &'a [Light],
        cameras: &'a [Camera],
    ) -> Self {
        Self { nodes, meshes, lights, cameras }
    }
}

/// Target of a channel, and the values that its keyframes may have.
#[derive(Debug)]
struct ChannelTarget {
    property: AnimationTarget,
    /// Components of one value.
    components: usize,
    keys: &'static AllowedFormats,
    range: RangeInclusive<f32>,
    /// Whether the property is a boolean, which cannot be interpolated.
    is_boolean: bool,
    /// Whether a pointer names the property. Keys of a wrong format then exclude the channel, not the file.
    has_pointer: bool,
}

impl ChannelTarget {
    /// Whether the property is a colour without alpha.
    fn is_rgb(&self) -> bool {
        let can_be_color =
            matches!(self.property, AnimationTarget::Material(..) | AnimationTarget::Light(..));
        can_be_color && self.components == 3
    }
}

/// Imports all animations, and the number of ignored channels of each.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    targets: &AnimationTargets,
) -> Result<(Vec<Animation>, Vec<usize>)> {
    let (mut animations, mut all_outputs) = (Vec::new(), Vec::new());
    let mut ignored = Vec::new();
    for (i, animation) in data.document.root.animations.iter().enumerate() {
        let pointer = format!("/animations/{i}");
        let (mut channels, mut outputs) = (Vec::new(), Vec::new());
        let mut properties = BTreeSet::new();
        for (j, channel) in animation.channels.iter().enumerate() {
            let pointer = format!("{pointer}/channels/{j}");
            let Some(target) = channel_target(context, data, channel, targets, &pointer)? else {
                continue;
            };
            if target.property.clashes(&properties) {
                let message = "animates a property that another channel of this animation animates";
                return Err(context.invalid(format!("{pointer}/target"), message));
            }
            let sampler = context.check_index(
                channel.sampler.value(),
                animation.samplers.len(),
                &format!("{pointer}/sampler"),
                "sampler",
            )?;
            let pointer = format!("/animations/{i}/samplers/{sampler}");
            if let Some(json) = animation.samplers.get(sampler)
                && let Some(keyframes) = keyframes(context, data, json, &target, &pointer)?
            {
                properties.insert(target.property);
                channels.push(Channel { target: target.property, keyframes });
                outputs.push(format!("{pointer}/output"));
            }
        }
        ignored.push(animation.channels.len().saturating_sub(channels.len()));
        animations.push(Animation { name: animation.name.clone(), channels });
        all_outputs.push(outputs);
    }
    let animated = compared_properties(&animations);
    for (animation, outputs) in animations.iter().zip(&all_outputs) {
        let imported = ImportedChannels { animation, animated: &animated, outputs };
        imported.check_order(context, targets.lights, targets.cameras)?;
    }
    Ok((animations, ignored))
}

/// Resolves the target of a channel. `None` if it is not supported; a warning is recorded unless one already names the cause.
fn channel_target(
    context: &mut Context,
    data: &Data,
    channel: &json::animation::Channel,
    targets: &AnimationTargets,
    pointer: &str,
) -> Result<Option<ChannelTarget>> {
    let target_pointer = format!("{pointer}/target");
    let target = match channel.target.path {
        Checked::Valid(path) => {
            let index = channel.target.node.value();
            if index == NO_NODE {
                return Ok(None);
            }
            let index =
                context.check_index(index, targets.nodes.len(), &format!("{target_pointer}/node"), "node")?;
            let node = NodeIndex::of(index);
            let (property, keys) = match path {
                Path::Translation => (AnimationTarget::Translation(node), &formats::VECTOR_KEYS),
                Path::Rotation => (AnimationTarget::Rotation(node), &formats::ROTATION_KEYS),
                Path::Scale => (AnimationTarget::Scale(node), &formats::VECTOR_KEYS),
                Path::MorphTargetWeights => (AnimationTarget::Weights(node), &formats::WEIGHT_KEYS),
            };
            ChannelTarget { property, components: 0, keys, range: ANY, is_boolean: false, has_pointer: false }
        }
        Checked::Invalid => match pointer_target(context, data, &target_pointer)? {
            Some(target) => target,
            None => return Ok(None),
        },
    };
    let components = components(context, &target, targets, pointer)?;
    Ok(components.map(|components| ChannelTarget { components, ..target }))
}

/// Resolves the target of a channel that has an extension or an unknown path.
fn pointer_target(context: &mut Context, data: &Data, pointer: &str) -> Result<Option<ChannelTarget>> {
    let Some(raw) = Raw::at(&data.document.value, pointer) else {
        return Ok(None);
    };
    let path = raw.string(context, "path")?.unwrap_or_default().to_owned();
    let Some(extension) = raw.extension(ANIMATION_POINTER).filter(|_| path == "pointer") else {
        // The warning about an unsupported extension covers its paths.
        if raw.field("extensions").is_none() {
            let message = format!("the animation path \"{}\" is unknown; it is ignored", path.escape_debug());
            context.warn(format!("{pointer}/path"), message);
        }
        return Ok(None);
    };
    extension.expect_object(context)?;
    let pointer = format!("{}/pointer", extension.pointer);
    let Some(property_pointer) = extension.string(context, "pointer")? else {
        return Err(context.invalid(pointer, "is missing"));
    };
    let Some(property) = pointer::resolve(data.document, property_pointer) else {
        let message = format!(
            "the animated property {} is missing or not supported; it is not animated",
            property_pointer.escape_debug()
        );
        context.warn(pointer, message);
        return Ok(None);
    };
    let keys = match property.components {
        _ if property.is_boolean => &formats::BOOLEAN_KEYS,
        components => {
            formats::PROPERTY_KEYS.get(components.saturating_sub(1)).unwrap_or(&formats::WEIGHT_KEYS)
        }
    };
    let Property { target: property, components, range, is_boolean } = property;
    Ok(Some(ChannelTarget { property, components, keys, range, is_boolean, has_pointer: true }))
}

/// Number of components of one value of the target; `None` for weights of a mesh that is not rendered or has no morph targets, which a
/// warning names.
fn components(
    context: &mut Context,
    target: &ChannelTarget,
    targets: &AnimationTargets,
    pointer: &str,
) -> Result<Option<usize>> {
    let AnimationTargets { nodes, meshes, .. } = targets;
    let (mesh, index) = match target.property {
        AnimationTarget::Translation(_) | AnimationTarget::Scale(_) => return Ok(Some(3)),
        AnimationTarget::Rotation(_) => return Ok(Some(4)),
        AnimationTarget::Weights(node) => (nodes.get(node.index()).and_then(|node| node.mesh), None),
        AnimationTarget::Weight(node, index) => {
            (nodes.get(node.index()).and_then(|node| node.mesh), Some(index))
        }
        AnimationTarget::MeshWeights(mesh) => (Some(mesh), None),
        AnimationTarget::MeshWeight(mesh, index) => (Some(mesh), Some(index)),
        AnimationTarget::Visibility(_)
        | AnimationTarget::Material(..)
        | AnimationTarget::Light(..)
        | AnimationTarget::Camera(..)
        | AnimationTarget::ImageLight(..) => return Ok(Some(target.components)),
    };
    let mesh = mesh.and_then(|mesh| meshes.get(mesh.index()));
    if mesh.is_some_and(|mesh| mesh.primitives.is_empty()) {
        return Ok(None);
    }
    let count = mesh.map_or(0, |mesh| mesh.weights.len());
    match index {
        _ if count == 0 => {
            context.warn(format!("{pointer}/target"), "weights without morph targets are not animated");
            Ok(None)
        }
        Some(index) if count <= index as usize => {
            let message = format!("there is no morph target {index}, the mesh has {count}");
            Err(context.invalid(format!("{pointer}/target"), message))
        }
        Some(_) => Ok(Some(1)),
        None => Ok(Some(count)),
    }
}

/// Reads keyframes. `None` for a property that a pointer names if their format does not fit, which a warning names.
fn keyframes(
    context: &mut Context,
    data: &Data,
    sampler: &json::animation::Sampler,
    target: &ChannelTarget,
    pointer: &str,
) -> Result<Option<Keyframes>> {
    let components = target.components;
    let Checked::Valid(interpolation) = sampler.interpolation else {
        let message = "must be LINEAR, STEP or CUBICSPLINE";
        return Err(context.invalid(format!("{pointer}/interpolation"), message));
    };
    let (interpolation, values_per_key) = match interpolation {
        JsonInterpolation::Step => (Interpolation::Step, 1_usize),
        JsonInterpolation::Linear => (Interpolation::Linear, 1),
        JsonInterpolation::CubicSpline => (Interpolation::CubicSpline, 3),
    };
    if target.is_boolean && interpolation != Interpolation::Step {
        let message = "must be STEP, because the property is a boolean";
        return Err(context.invalid(format!("{pointer}/interpolation"), message));
    }
    let times_seconds = times(context, data, sampler, pointer)?;
    let Some(mut values) = values(context, data, sampler, target, pointer)? else {
        return Ok(None);
    };
    let expected =
        times_seconds.len().checked_mul(values_per_key).and_then(|count| count.checked_mul(components));
    if expected != Some(values.len()) {
        let message = format!(
            "has {} numbers for {} keyframes of {} values with {components} components",
            values.len(),
            times_seconds.len(),
            values_per_key
        );
        return Err(context.invalid(format!("{pointer}/output"), message));
    }
    let pointer = format!("{pointer}/output");
    KeyValues { values: &mut values, components, values_per_key, pointer }.check(
        context,
        target.property,
        &target.range,
    )?;
    Ok(Some(Keyframes { times_seconds, values, width: components, interpolation }))
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
    let times: Vec<f32> = times.into_iter().map(|[time]| without_rounding_below(time, 0.0)).collect();
    // Blender writes them for actions that start before its frame 0, unless it samples them.
    if times.first().is_some_and(|&first| first < 0.0) {
        context.warn(&reference.pointer, "has keyframes before time 0; frames begin at time 0");
    }
    let pointer = format!("/accessors/{}", reference.accessor);
    // Keys without stored data are all at time 0, which is valid: an extension may supply them.
    let is_stored = data
        .accessor(context, reference.accessor, &reference.pointer)
        .is_ok_and(|accessor| accessor.buffer_view.is_some() || accessor.sparse.is_some());
    let not_before = times.windows(2).position(|pair| matches!(pair, [a, b] if a >= b));
    let Some(first) = not_before.filter(|_| is_stored) else { return Ok(times) };
    if let Some(i) = times.windows(2).position(|pair| matches!(pair, [a, b] if a > b)) {
        let message = format!("keyframe times must increase, but keyframe {i} is after the next");
        return Err(context.invalid(pointer, message));
    }
    // Exporters write sudden changes so. Other programs play them, though the specification does not allow it.
    context.warn(
        pointer,
        format!(
            "keyframe {first} has the time of the next; the value changes there at once to that of the next"
        ),
    );
    Ok(times)
}

/// Reads the values of all keyframes. `None` as for [`keyframes`].
fn values(
    context: &mut Context,
    data: &Data,
    sampler: &json::animation::Sampler,
    target: &ChannelTarget,
    pointer: &str,
) -> Result<Option<Vec<f32>>> {
    let reference = Reference {
        name: "output".to_owned(),
        accessor: sampler.output.value(),
        pointer: format!("{pointer}/output"),
    };
    let accessor = data.accessor(context, reference.accessor, &reference.pointer)?;
    let [.., rgba] = &formats::PROPERTY_KEYS;
    if target.is_rgb() && formats::mismatch(accessor, rgba, false).is_none() {
        // Blender writes specularColorFactor so.
        context.warn(&reference.pointer, "the colours of keyframes have alpha, which is ignored");
        let colors = data.floats_as::<4>(context, &reference, rgba)?;
        let colors: Vec<[f32; 3]> = colors.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        return Ok(Some(colors.into_flattened()));
    }
    if target.has_pointer
        && let Some(message) = formats::mismatch(accessor, target.keys, false)
    {
        context.warn(&reference.pointer, format!("{message}; the property is not animated"));
        return Ok(None);
    }
    let is_weights = matches!(target.property, AnimationTarget::Weights(_) | AnimationTarget::MeshWeights(_));
    Ok(Some(match if is_weights { 1 } else { target.components } {
        1 => data.floats_as::<1>(context, &reference, target.keys)?.into_flattened(),
        2 => data.floats_as::<2>(context, &reference, target.keys)?.into_flattened(),
        3 => data.floats_as::<3>(context, &reference, target.keys)?.into_flattened(),
        _ => data.floats_as::<4>(context, &reference, target.keys)?.into_flattened(),
    }))
}
