//! Morph targets: displacements of positions, normals, tangents, texture coordinates and colours.
//!
//! Source: glTF 2.0 specification, section 3.7.2.2 (morph targets).

use glam::{Vec2, Vec3, Vec4};

use super::accessor::Data;
use super::attributes::Attributes;
use super::context::Context;
use super::formats;
use super::raw::Raw;
use crate::error::Result;
use crate::scene::MorphTarget;

/// Reads the morph targets of the primitive `raw`; `base` holds the primitive's own attributes.
pub(super) fn read(
    context: &mut Context,
    data: &Data,
    raw: &Raw,
    base: &Attributes,
    vertex_count: u64,
) -> Result<Vec<MorphTarget>> {
    let Some(targets) = raw.field("targets") else {
        return Ok(Vec::new());
    };
    let mut morphs = Vec::new();
    for target in targets.elements(context)? {
        let attributes = Attributes::new(context, data, &target)?;
        attributes.check_counts(context, data, vertex_count)?;
        attributes.warn_unused(context);
        morphs.push(read_target(context, data, &attributes, base)?);
    }
    Ok(morphs)
}

fn read_target(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    base: &Attributes,
) -> Result<MorphTarget> {
    for name in ["POSITION", "NORMAL", "TANGENT", "COLOR_0"] {
        check_base(context, attributes, base, name)?;
    }
    let has_normals = base.find("NORMAL").is_some();
    let mut vectors = |name: &str, allowed| -> Result<Option<Vec<Vec3>>> {
        let Some(reference) = attributes.find(name) else {
            return Ok(None);
        };
        let values: Vec<[f32; 3]> = match name {
            "POSITION" => data.floats_as(context, reference, allowed)?,
            _ => data.floats_or_zeros_as(context, reference, allowed)?,
        };
        Ok(Some(values.into_iter().map(Vec3::from_array).collect()))
    };
    let positions = vectors("POSITION", &formats::MORPH_POSITION)?;
    let normals = vectors("NORMAL", &formats::MORPH_NORMAL)?;
    let tangents = vectors("TANGENT", &formats::MORPH_TANGENT)?;
    let colors = match attributes.find("COLOR_0") {
        Some(reference) => {
            let values = data.colors_as(context, reference, &formats::MORPH_COLOR, 0.0)?;
            Some(values.into_iter().map(Vec4::from_array).collect())
        }
        None => None,
    };
    Ok(MorphTarget {
        positions,
        // A primitive without base normals is shaded flat, so the target's normals have no use.
        normals: normals.filter(|_| has_normals),
        tangents: tangents.filter(|_| has_normals),
        uvs: read_uvs(context, data, attributes, base)?,
        colors,
    })
}

fn read_uvs(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    base: &Attributes,
) -> Result<Vec<(usize, Vec<Vec2>)>> {
    let mut uvs = Vec::new();
    let base_sets = base.sets(context, "TEXCOORD_", 0)?;
    for (set, base_reference) in base_sets.iter().enumerate() {
        if let Some(reference) = attributes.find(&base_reference.name) {
            let values: Vec<[f32; 2]> =
                data.floats_or_zeros_as(context, reference, &formats::MORPH_TEXCOORD)?;
            uvs.push((set, values.into_iter().map(Vec2::from_array).collect()));
        }
    }
    for set in attributes.numbered("TEXCOORD_") {
        check_base(context, attributes, base, &set)?;
    }
    Ok(uvs)
}

/// Errors if the target displaces an attribute that the primitive does not have.
fn check_base(context: &Context, target: &Attributes, base: &Attributes, name: &str) -> Result<()> {
    match (target.find(name), base.find(name)) {
        (Some(reference), None) => {
            Err(context.invalid(&reference.pointer, format!("the primitive has no {name} to displace")))
        }
        _ => Ok(()),
    }
}
