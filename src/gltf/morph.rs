//! Morph targets: displacements of positions, normals, tangents, texture coordinates and colours.
//!
//! Source: glTF 2.0 specification, section 3.7.2.2 (morph targets).

use glam::{Vec2, Vec3, Vec4};

use super::accessor::Data;
use super::attributes::{Attributes, Reference};
use super::context::Context;
use super::formats;
use super::raw::Raw;
use crate::error::{Error, Result};
use crate::scene::MorphTarget;

/// Reads the morph targets of the primitive `raw`; `base` holds the primitive's own attributes, `uv_sets` the number of its sets of texture coordinates.
pub(super) fn read(
    context: &mut Context,
    data: &Data,
    raw: &Raw,
    (base, uv_sets): (&Attributes, usize),
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
        morphs.push(read_target(context, data, &attributes, (base, uv_sets))?);
    }
    Ok(morphs)
}

fn read_target(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    (base, uv_sets): (&Attributes, usize),
) -> Result<MorphTarget> {
    for name in ["POSITION", "COLOR_0"] {
        if let (Some(reference), None) = (attributes.find(name), base.find(name)) {
            return Err(no_base(context, reference));
        }
    }
    for name in ["NORMAL", "TANGENT"] {
        if let (Some(reference), None) = (attributes.find(name), base.find(name)) {
            context
                .warn(&reference.pointer, format!("the primitive has no {name}, the target's are ignored"));
        }
    }
    let has_normals = base.find("NORMAL").is_some();
    let has_tangents = has_normals && base.find("TANGENT").is_some();
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
        tangents: tangents.filter(|_| has_tangents),
        uvs: read_uvs(context, data, attributes, (base, uv_sets))?,
        colors,
    })
}

fn read_uvs(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    (base, uv_sets): (&Attributes, usize),
) -> Result<Vec<(usize, Vec<Vec2>)>> {
    let mut uvs = Vec::new();
    for (set, reference) in attributes.sets_from("TEXCOORD_", 0) {
        if base.find(&reference.name).is_none() {
            return Err(no_base(context, reference));
        }
        if set >= uv_sets {
            continue;
        }
        let values: Vec<[f32; 2]> = data.floats_or_zeros_as(context, reference, &formats::MORPH_TEXCOORD)?;
        uvs.push((set, values.into_iter().map(Vec2::from_array).collect()));
    }
    Ok(uvs)
}

/// The error of a target that displaces an attribute that the primitive does not have.
fn no_base(context: &Context, reference: &Reference) -> Error {
    context.invalid(&reference.pointer, format!("the primitive has no {} to displace", reference.name))
}
