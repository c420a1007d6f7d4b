//! Node hierarchy: parents, order, scenes and their total size, computed without recursion.
//!
//! Source: glTF 2.0 specification, section 3.5 (scenes and nodes).

use std::collections::BTreeSet;

use super::context::Context;
use super::document::Document;
use super::image_light;
use crate::error::Result;
use crate::scene::{Mesh, Node, NodeIndex, SceneRoots};

/// Estimated memory of a posed triangle, with its share of vertices and of the BVH, bytes. Used to refuse scenes whose
/// instances do not fit into memory.
const POSED_TRIANGLE_BYTES: u64 = 160;
/// Memory of one instance of a primitive in both frames, bytes.
const INSTANCE_BYTES: u64 = 256;

/// Node hierarchy and the scenes that select from it.
#[derive(Debug)]
pub(super) struct Hierarchy {
    pub(super) nodes: Vec<Node>,
    pub(super) node_order: Vec<NodeIndex>,
    pub(super) scenes: Vec<SceneRoots>,
    pub(super) default_scene: usize,
}

/// Sets the parent of every node. A second parent is an error.
pub(super) fn set_parents(context: &Context, nodes: &mut [Node]) -> Result<()> {
    let mut parents: Vec<Option<NodeIndex>> = vec![None; nodes.len()];
    for (i, node) in (0_u32..).zip(nodes.iter()) {
        for child in &node.children {
            let Some(slot) = parents.get_mut(child.index()) else {
                continue;
            };
            if let Some(NodeIndex(first)) = slot.replace(NodeIndex(i)) {
                let message = format!(
                    "node {} is already a child of node {first}; a node has one parent at most",
                    child.0
                );
                return Err(context.invalid(format!("/nodes/{i}/children"), message));
            }
        }
    }
    for (node, parent) in nodes.iter_mut().zip(parents) {
        node.parent = parent;
    }
    Ok(())
}

/// Lists all nodes, parents before children. Since every node has at most one parent, the nodes that no root reaches lie
/// on cycles or below them.
pub(super) fn sort_parents_first(context: &Context, nodes: &[Node]) -> Result<Vec<NodeIndex>> {
    let mut order: Vec<NodeIndex> =
        (0_u32..).zip(nodes).filter(|(_, node)| node.parent.is_none()).map(|(i, _)| NodeIndex(i)).collect();
    let mut visited = 0;
    while let Some(&next) = order.get(visited) {
        visited = visited.saturating_add(1);
        let children = nodes.get(next.index()).map(|node| &node.children);
        order.extend(children.into_iter().flatten());
    }
    if order.len() == nodes.len() {
        return Ok(order);
    }
    let reached: BTreeSet<NodeIndex> = order.into_iter().collect();
    let stray = (0_u32..).take(nodes.len()).find(|&i| !reached.contains(&NodeIndex(i)));
    Err(context.invalid(
        format!("/nodes/{}", stray.unwrap_or_default()),
        "is its own ancestor; nodes must form trees",
    ))
}

pub(super) fn import_scenes(
    context: &Context,
    document: &Document,
    nodes: &[Node],
    image_light_count: usize,
) -> Result<(Vec<SceneRoots>, usize)> {
    let json = &document.root.scenes;
    let mut scenes = Vec::new();
    for (i, scene) in json.iter().enumerate() {
        let mut roots = Vec::new();
        let mut seen = BTreeSet::new();
        for (j, root) in scene.nodes.iter().enumerate() {
            let pointer = format!("/scenes/{i}/nodes/{j}");
            let index = context.check_index(root.value(), nodes.len(), &pointer, "node")?;
            if nodes.get(index).is_some_and(|node| node.parent.is_some()) {
                let message = format!("node {index} has a parent, so it cannot be a root");
                return Err(context.invalid(pointer, message));
            }
            if !seen.insert(index) {
                return Err(context.invalid(pointer, format!("lists node {index} twice")));
            }
            roots.push(NodeIndex::of(index));
        }
        let image_light = match document.element("scenes", i) {
            Some(raw) => image_light::of_scene(context, &raw, image_light_count)?,
            None => None,
        };
        scenes.push(SceneRoots { name: scene.name.clone(), roots, image_light });
    }
    let default_scene = match document.root.scene {
        Some(scene) => context.check_index(scene.value(), json.len(), "/scene", "scene")?,
        None => 0,
    };
    if scenes.is_empty() {
        // The file is a library of nodes. Show all of them.
        let parentless = (0_u32..).zip(nodes).filter(|(_, node)| node.parent.is_none());
        let roots = parentless.map(|(i, _)| NodeIndex(i)).collect();
        scenes.push(SceneRoots { name: None, roots, image_light: None });
    }
    Ok((scenes, default_scene))
}

/// Refuses scenes with more triangles, instances included, than ids can number, or than memory can hold beside all that is imported.
pub(super) fn check_size(context: &Context, hierarchy: &Hierarchy, meshes: &[Mesh]) -> Result<()> {
    let Hierarchy { nodes, node_order, scenes, .. } = hierarchy;
    let largest = |of_mesh: fn(&Mesh) -> u64| -> (usize, u64) {
        let below = subtree_sums(nodes, node_order, &meshes.iter().map(of_mesh).collect::<Vec<_>>());
        let in_scene = |scene: &SceneRoots| -> u64 {
            let counts = scene.roots.iter().map(|root| below.get(root.index()).copied().unwrap_or(0));
            counts.fold(0, u64::saturating_add)
        };
        scenes.iter().map(in_scene).enumerate().max_by_key(|&(_, sum)| sum).unwrap_or_default()
    };
    let (scene, triangles) = largest(triangle_count);
    if triangles > u64::from(u32::MAX) {
        let message = format!("has {triangles} triangles, more than 32-bit ids can number; split the scene");
        return Err(context.refused(format!("/scenes/{scene}"), message));
    }
    // Posing follows the import, so its memory is none of the import's.
    let (scene, bytes) = largest(posed_bytes);
    if bytes > context.remaining_bytes() {
        return Err(
            context.too_large(context.used_bytes().saturating_add(bytes), &format!("/scenes/{scene}"))
        );
    }
    Ok(())
}

/// For every node the sum of `per_mesh` over its own mesh and the meshes below it, each instance counted.
fn subtree_sums(nodes: &[Node], node_order: &[NodeIndex], per_mesh: &[u64]) -> Vec<u64> {
    let mut below: Vec<u64> = nodes
        .iter()
        .map(|node| {
            let of_mesh = node.mesh.and_then(|mesh| per_mesh.get(mesh.index())).copied().unwrap_or(0);
            of_mesh.saturating_mul(node.instances.as_ref().map_or(1, |instances| instances.len() as u64))
        })
        .collect();
    // Children come before their parents.
    for node in node_order.iter().rev() {
        let own = below.get(node.index()).copied().unwrap_or(0);
        let parent = nodes.get(node.index()).and_then(|node| node.parent);
        if let Some(sum) = parent.and_then(|parent| below.get_mut(parent.index())) {
            *sum = sum.saturating_add(own);
        }
    }
    below
}

fn triangle_count(mesh: &Mesh) -> u64 {
    let counts = mesh.primitives.iter().map(|primitive| primitive.triangles.len() as u64);
    counts.fold(0, u64::saturating_add)
}

/// Memory of one instance of the mesh, bytes.
fn posed_bytes(mesh: &Mesh) -> u64 {
    let bytes = mesh.primitives.iter().map(|primitive| {
        let triangles = primitive.triangles.len() as u64;
        triangles.saturating_mul(POSED_TRIANGLE_BYTES).saturating_add(INSTANCE_BYTES)
    });
    bytes.fold(0, u64::saturating_add)
}
