//! Skins.
//!
//! Source: glTF 2.0 specification, section 3.7.3 (skins).

use std::collections::BTreeSet;

use glam::Mat4;
use gltf::json;

use super::accessor::Data;
use super::attributes::Reference;
use super::context::Context;
use super::formats;
use crate::error::Result;
use crate::scene::{NodeIndex, Skin};

/// Imports all skins.
pub(super) fn import(context: &mut Context, data: &Data) -> Result<Vec<Skin>> {
    let skins = data.document.root.skins.iter().enumerate();
    skins.map(|(i, skin)| import_skin(context, data, skin, &format!("/skins/{i}"))).collect()
}

fn import_skin(context: &mut Context, data: &Data, skin: &json::Skin, pointer: &str) -> Result<Skin> {
    let node_count = data.document.root.nodes.len();
    if skin.joints.is_empty() {
        return Err(context.invalid(format!("{pointer}/joints"), "must not be empty"));
    }
    let mut joints = Vec::new();
    let mut seen = BTreeSet::new();
    for (i, joint) in skin.joints.iter().enumerate() {
        let pointer = format!("{pointer}/joints/{i}");
        let index = context.check_index(joint.value(), node_count, &pointer, "node")?;
        if !seen.insert(index) {
            return Err(context.invalid(pointer, format!("lists node {index} twice")));
        }
        joints.push(NodeIndex(u32::try_from(index).unwrap_or(u32::MAX)));
    }
    if let Some(skeleton) = skin.skeleton {
        // The skeleton root does not affect the image. Only its existence is checked.
        context.check_index(skeleton.value(), node_count, &format!("{pointer}/skeleton"), "node")?;
    }
    Ok(Skin {
        name: skin.name.clone(),
        inverse_bind_matrices: bind_matrices(context, data, skin, pointer)?,
        joints,
    })
}

/// Reads one inverse bind matrix per joint; identity matrices if the file has none.
fn bind_matrices(context: &mut Context, data: &Data, skin: &json::Skin, pointer: &str) -> Result<Vec<Mat4>> {
    let Some(accessor) = skin.inverse_bind_matrices else {
        return Ok(vec![Mat4::IDENTITY; skin.joints.len()]);
    };
    let reference = Reference {
        name: "inverseBindMatrices".to_owned(),
        accessor: accessor.value(),
        pointer: format!("{pointer}/inverseBindMatrices"),
    };
    let columns: Vec<[f32; 16]> = data.floats_as(context, &reference, &formats::BIND_MATRICES)?;
    if columns.len() < skin.joints.len() {
        let message = format!("has {} matrices for {} joints", columns.len(), skin.joints.len());
        return Err(context.invalid(reference.pointer, message));
    }
    let matrices: Vec<Mat4> = columns.iter().take(skin.joints.len()).map(Mat4::from_cols_array).collect();
    match matrices.iter().position(|matrix| !is_affine(matrix)) {
        None => Ok(matrices),
        Some(i) => Err(context.invalid(
            format!("/accessors/{}", reference.accessor),
            format!("matrix {i} is not affine: its last row must be 0, 0, 0, 1"),
        )),
    }
}

/// Whether the last row is 0, 0, 0, 1, up to the single-precision error of a matrix inverse.
pub(super) fn is_affine(matrix: &Mat4) -> bool {
    const TOLERANCE: f32 = 1e-3;
    let last = matrix.row(3);
    last.truncate().abs().max_element() <= TOLERANCE && (last.w - 1.0).abs() <= TOLERANCE
}
