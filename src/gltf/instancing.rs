//! Instances of a node's mesh.
//!
//! Source: the text of `EXT_mesh_gpu_instancing` (Khronos Group). It leaves names that begin with `_` to applications: three.js and Babylon.js write and
//! read `_COLOR_0`, the colour of each instance.

use glam::{Mat4, Quat, Vec3};

use super::accessor::Data;
use super::attributes::{Attributes, Reference};
use super::context::Context;
use super::extension_names::INSTANCING;
use super::formats;
use super::primitive::read_colors;
use super::raw::Raw;
use super::rotation::unit_rotation;
use crate::error::Result;
use crate::scene::Node;

/// Sets the mesh instances of the node `raw`, if it has any. Only what the node keeps of them stays charged.
pub(super) fn set_instances(context: &mut Context, data: &Data, raw: &Raw, node: &mut Node) -> Result<()> {
    let Some(extension) = raw.extension_object(context, INSTANCING)? else {
        return Ok(());
    };
    let used_before = context.used_bytes();
    read_extension(context, data, &extension, node)?;
    let instances = node.instances.as_deref().map_or(0, size_of_val);
    let kept = instances.saturating_add(size_of_val(node.instance_colors.as_slice()));
    context.release_temporaries(used_before, kept as u64);
    Ok(())
}

fn read_extension(context: &mut Context, data: &Data, extension: &Raw, node: &mut Node) -> Result<()> {
    let Some(raw_attributes) = extension.field("attributes") else {
        return Err(context.invalid(format!("{}/attributes", extension.pointer), "is missing"));
    };
    let attributes = Attributes::new(context, data, &raw_attributes)?;
    let Some(first) = attributes.first() else {
        return Err(context.invalid(raw_attributes.pointer, "must not be empty"));
    };
    let count = data.accessor(context, first.accessor, &first.pointer)?.count.0;
    attributes.check_counts_against(context, data, count, &first.name)?;
    for reference in attributes.iter() {
        let known = matches!(reference.name.as_str(), "TRANSLATION" | "ROTATION" | "SCALE");
        if !(known || reference.name.starts_with('_')) {
            let message =
                format!("the attribute {} of instances is not supported; it is ignored", reference.name);
            context.warn(&reference.pointer, message);
        }
    }
    let instances = read(context, data, &attributes, count, &extension.pointer)?;
    if node.mesh.is_none() {
        context.warn(&extension.pointer, "instances on a node without mesh have no effect");
        return Ok(());
    }
    if node.skin.is_some() {
        // All instances would lie at the same position.
        let message = "only the joints position a skinned mesh, so its instances are rendered once";
        context.warn(&extension.pointer, message);
        return Ok(());
    }
    node.instances = Some(instances);
    if let Some(reference) = attributes.find("_COLOR_0") {
        let accessor = data.accessor(context, reference.accessor, &reference.pointer)?;
        match formats::mismatch(accessor, &formats::COLOR, false) {
            None => {
                let colors = read_colors(context, data, &attributes, "_COLOR_0")?;
                node.instance_colors = colors.unwrap_or_default();
            }
            // What applications store under such a name is theirs.
            Some(why) => context.warn(&reference.pointer, format!("{why}; the instances have no colours")),
        }
    }
    Ok(())
}

fn read(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    count: u64,
    pointer: &str,
) -> Result<Vec<Mat4>> {
    let translations = vectors(context, data, attributes.find("TRANSLATION"), &formats::INSTANCE_VECTORS)?;
    let scales = vectors(context, data, attributes.find("SCALE"), &formats::INSTANCE_VECTORS)?;
    let rotations: Vec<[f32; 4]> = match attributes.find("ROTATION") {
        Some(reference) => data.floats_as(context, reference, &formats::INSTANCE_ROTATIONS)?,
        None => Vec::new(),
    };
    let mut instances = context.allocate(count, pointer)?;
    for i in 0..usize::try_from(count).unwrap_or(usize::MAX) {
        let translation = translations.get(i).copied().unwrap_or(Vec3::ZERO);
        let scale = scales.get(i).copied().unwrap_or(Vec3::ONE);
        let rotation = match rotations.get(i) {
            Some(rotation) => unit_rotation(*rotation).map(|(unit, _)| unit),
            None => Some(Quat::IDENTITY),
        };
        let Some(rotation) = rotation else {
            let message = format!("the rotation of instance {i} has length zero, which is not a rotation");
            return Err(context.invalid(format!("{pointer}/attributes/ROTATION"), message));
        };
        instances.push(Mat4::from_scale_rotation_translation(scale, rotation, translation));
    }
    Ok(instances)
}

fn vectors(
    context: &mut Context,
    data: &Data,
    reference: Option<&Reference>,
    allowed: &formats::AllowedFormats,
) -> Result<Vec<Vec3>> {
    let Some(reference) = reference else {
        return Ok(Vec::new());
    };
    let values: Vec<[f32; 3]> = data.floats_as(context, reference, allowed)?;
    Ok(values.into_iter().map(Vec3::from_array).collect())
}
