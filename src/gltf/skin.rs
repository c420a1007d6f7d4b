//! Skins.
//!
//! Source: glTF 2.0 specification, section 3.7.3 (skins).

use std::collections::{BTreeMap, BTreeSet};

use glam::Mat4;
use gltf::json;

use super::accessor::Data;
use super::attributes::Reference;
use super::context::Context;
use super::formats;
use crate::error::Result;
use crate::scene::{Node, NodeIndex, SceneRoots, Skin, SkinIndex};

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
        joints.push(NodeIndex::of(index));
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

/// Warns about skins whose joints have no common root, and about skinned meshes in scenes that lack a joint. `node_order` lists parents
/// before children.
pub(super) fn check_joints(
    context: &mut Context,
    nodes: &[Node],
    node_order: &[NodeIndex],
    scenes: &[SceneRoots],
    skins: &[Skin],
) {
    // The root above each node.
    let mut roots: Vec<NodeIndex> = (0_u32..).map(NodeIndex).take(nodes.len()).collect();
    for node in node_order {
        let parent = nodes.get(node.index()).and_then(|node| node.parent);
        let above = parent.and_then(|parent| roots.get(parent.index()).copied());
        if let (Some(above), Some(root)) = (above, roots.get_mut(node.index())) {
            *root = above;
        }
    }
    let root_of = |node: NodeIndex| roots.get(node.index()).copied();

    // Joints of several trees.
    for (i, skin) in skins.iter().enumerate() {
        let first = skin.joints.first().copied().and_then(root_of);
        if let Some(stray) = skin.joints.iter().find(|&&joint| root_of(joint) != first) {
            let message = format!(
                "the joints have no common root: node {} is in another tree than the first; each moves with its own tree",
                stray.0
            );
            context.warn(format!("/skins/{i}/joints"), message);
        }
    }

    warn_of_joints_elsewhere(context, nodes, &roots, scenes, skins);
}

/// Warns once a scene that a joint of a skinned mesh is not in it. `roots` has the root above each node.
fn warn_of_joints_elsewhere(
    context: &mut Context,
    nodes: &[Node],
    roots: &[NodeIndex],
    scenes: &[SceneRoots],
    skins: &[Skin],
) {
    let root_of = |node: NodeIndex| roots.get(node.index()).copied();
    // One joint of each tree that has joints of a skin. Most skins have one tree.
    let trees: Vec<BTreeMap<NodeIndex, NodeIndex>> = skins
        .iter()
        .map(|skin| skin.joints.iter().rev().filter_map(|&joint| Some((root_of(joint)?, joint))).collect())
        .collect();
    // For each root the skins of meshes below it that have joints in other trees, with the first node of each.
    let mut spread: BTreeMap<NodeIndex, BTreeMap<SkinIndex, NodeIndex>> = BTreeMap::new();
    for (node, skin) in (0_u32..).map(NodeIndex).zip(nodes).filter_map(|(i, node)| Some((i, node.skin?))) {
        let joints = trees.get(skin.index());
        if let Some(root) = root_of(node)
            && joints.is_some_and(|joints| joints.keys().any(|tree| *tree != root))
        {
            spread.entry(root).or_default().entry(skin).or_insert(node);
        }
    }
    for (i, scene) in scenes.iter().enumerate() {
        let shown: BTreeSet<NodeIndex> = scene.roots.iter().copied().collect();
        let stray_of = |(skin, node): (&SkinIndex, &NodeIndex)| {
            let stray = trees.get(skin.index())?.iter().find(|(tree, _)| !shown.contains(tree));
            stray.map(|(_, &joint)| (*node, joint))
        };
        let skins = shown.iter().filter_map(|root| spread.get(root)).flatten();
        if let Some((node, stray)) = skins.into_iter().find_map(stray_of) {
            let message = format!(
                "the joint node {} is not in scene {i}, which shows the skinned mesh; it moves the mesh nevertheless",
                stray.0
            );
            context.warn(format!("/nodes/{}/skin", node.0), message);
        }
    }
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
