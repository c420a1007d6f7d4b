//! Nodes: transforms, and references to meshes, skins, cameras and lights.
//!
//! Source: glTF 2.0 specification, sections 3.5 (scenes and nodes) and 3.7.3.2 (joint hierarchy).

use glam::{Mat4, Quat, Vec3};
use gltf::json;

use super::accessor::Data;
use super::context::Context;
use super::document::Document;
use super::extension_names::VISIBILITY;
use super::hierarchy::{Hierarchy, import_scenes, set_parents, sort_parents_first};
use super::raw::{ANY, Raw, check_range};
use super::rotation::unit_rotation;
use super::skin::{check_joints, is_affine};
use super::{instancing, light, mesh};
use crate::error::Result;
use crate::scene::{CameraIndex, LocalTransform, Mesh, MeshIndex, Node, NodeIndex, Skin, SkinIndex};

/// Number of lights that nodes and scenes can refer to.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightCounts {
    pub(super) punctual: usize,
    pub(super) image_based: usize,
}

/// Imports all nodes and scenes.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    meshes: &[Mesh],
    skins: &[Skin],
    light_counts: LightCounts,
) -> Result<Hierarchy> {
    let document = data.document;
    // Many nodes may show one mesh.
    let joints_of_meshes: Vec<MeshJoints> = meshes.iter().map(MeshJoints::of).collect();
    let mut nodes = Vec::new();
    for (i, json) in document.root.nodes.iter().enumerate() {
        let mut node = import_node(context, document, i, json)?;
        if let Some(raw) = document.element("nodes", i) {
            node.light = light::of_node(context, &raw, light_counts.punctual)?;
            node.is_hidden = is_hidden(context, &raw)?;
            instancing::set_instances(context, data, &raw, &mut node)?;
        }
        check_mesh(context, &mut node, json, meshes, &format!("/nodes/{i}"))?;
        let joints = node.mesh.and_then(|mesh| joints_of_meshes.get(mesh.index()));
        check_skin(context, &node, skins, joints, &format!("/nodes/{i}"))?;
        nodes.push(node);
    }
    set_parents(context, &mut nodes)?;
    let node_order = sort_parents_first(context, &nodes)?;
    let (scenes, default_scene) = import_scenes(context, document, &nodes, light_counts.image_based)?;
    check_joints(context, &nodes, &node_order, &scenes, skins);
    Ok(Hierarchy { nodes, node_order, scenes, default_scene })
}

fn import_node(context: &mut Context, document: &Document, index: usize, json: &json::Node) -> Result<Node> {
    let root = &document.root;
    let pointer = format!("/nodes/{index}");
    let check = |index: Option<usize>, length: usize, key: &str, what: &str| -> Result<Option<u32>> {
        let Some(index) = index else { return Ok(None) };
        let index = context.check_index(index, length, &format!("{pointer}/{key}"), what)?;
        Ok(u32::try_from(index).ok())
    };
    let mesh = check(json.mesh.map(|i| i.value()), root.meshes.len(), "mesh", "mesh")?;
    let skin = check(json.skin.map(|i| i.value()), root.skins.len(), "skin", "skin")?;
    let camera = check(json.camera.map(|i| i.value()), root.cameras.len(), "camera", "camera")?;
    let mut children = Vec::new();
    for child in json.children.iter().flatten() {
        let child = check(Some(child.value()), root.nodes.len(), "children", "node")?;
        children.extend(child.map(NodeIndex));
    }
    Ok(Node {
        name: json.name.clone(),
        parent: None,
        children,
        local: local_transform(context, json, &pointer)?,
        mesh: mesh.map(MeshIndex),
        skin: skin.map(SkinIndex),
        weights: json.weights.clone(),
        camera: camera.map(CameraIndex),
        light: None,
        instances: None,
        instance_colors: Vec::new(),
        is_hidden: false,
    })
}

fn is_hidden(context: &Context, raw: &Raw) -> Result<bool> {
    let Some(extension) = raw.extension(VISIBILITY) else {
        return Ok(false);
    };
    extension.expect_object(context)?;
    match extension.field("visible") {
        None => Ok(false),
        Some(field) => match field.value.as_bool() {
            Some(visible) => Ok(!visible),
            None => Err(context.invalid(field.pointer, "must be true or false")),
        },
    }
}

fn local_transform(context: &mut Context, json: &json::Node, pointer: &str) -> Result<LocalTransform> {
    if let Some(matrix) = &json.matrix {
        if json.translation.is_some() || json.rotation.is_some() || json.scale.is_some() {
            let message = "has both a matrix and translation, rotation or scale; only one form is allowed";
            return Err(context.invalid(pointer, message));
        }
        let pointer = format!("{pointer}/matrix");
        check_all(context, matrix, &pointer)?;
        let matrix = Mat4::from_cols_array(matrix);
        if !is_affine(&matrix) {
            return Err(context.invalid(pointer, "is not affine: its last row must be 0, 0, 0, 1"));
        }
        return Ok(LocalTransform::Matrix(matrix));
    }
    let translation = json.translation.unwrap_or([0.0; 3]);
    check_all(context, &translation, &format!("{pointer}/translation"))?;
    let scale = json.scale.unwrap_or([1.0; 3]);
    check_all(context, &scale, &format!("{pointer}/scale"))?;
    let rotation = match &json.rotation {
        Some(stored) => rotation(context, stored.0, &format!("{pointer}/rotation"))?,
        None => Quat::IDENTITY,
    };
    Ok(LocalTransform::Trs {
        translation: Vec3::from_array(translation),
        rotation,
        scale: Vec3::from_array(scale),
    })
}

fn check_all(context: &Context, values: &[f32], pointer: &str) -> Result<()> {
    values.iter().try_for_each(|&value| check_range(context, value, &ANY, pointer).map(|_| ()))
}

fn rotation(context: &mut Context, rotation: [f32; 4], pointer: &str) -> Result<Quat> {
    const TOLERANCE: f64 = 1e-2;
    check_all(context, &rotation, pointer)?;
    let Some((unit, length)) = unit_rotation(rotation) else {
        let message = "is a quaternion of length zero, which is not a rotation";
        return Err(context.invalid(pointer, message));
    };
    if (length - 1.0).abs() > TOLERANCE {
        context.warn(pointer, "some rotations are not unit quaternions; they are normalized");
    }
    Ok(unit)
}

/// Checks the morph weights of a node, which have no effect without a mesh.
fn check_mesh(
    context: &mut Context,
    node: &mut Node,
    json: &json::Node,
    meshes: &[Mesh],
    pointer: &str,
) -> Result<()> {
    let Some(weights) = &json.weights else {
        return Ok(());
    };
    let Some(mesh) = node.mesh.and_then(|mesh| meshes.get(mesh.index())) else {
        let message = "morph weights on a node without mesh have no effect";
        context.warn(format!("{pointer}/weights"), message);
        node.weights = None;
        return Ok(());
    };
    let weights = mesh::check_weights(context, weights, mesh.weights.len(), &mesh.primitives, pointer)?;
    node.weights = Some(weights);
    Ok(())
}

/// What the vertices of a mesh need of a skin.
struct MeshJoints {
    /// Highest joint index. `None` if no primitive has joints.
    highest: Option<u32>,
    /// Whether a primitive has no joints.
    is_partial: bool,
}

impl MeshJoints {
    fn of(mesh: &Mesh) -> Self {
        let influences = || mesh.primitives.iter().map(|primitive| primitive.influences.as_ref());
        let highest = |joints: &[u32]| joints.iter().copied().max().unwrap_or(0);
        Self {
            highest: influences().flatten().map(|influences| highest(&influences.joints)).max(),
            is_partial: influences().any(|influences| influences.is_none()),
        }
    }
}

/// Checks the skin of a node against the joints of its mesh; `None` without a mesh.
fn check_skin(
    context: &mut Context,
    node: &Node,
    skins: &[Skin],
    joints: Option<&MeshJoints>,
    pointer: &str,
) -> Result<()> {
    let Some(skin) = node.skin.and_then(|skin| skins.get(skin.index())) else {
        if joints.is_some_and(|joints| joints.highest.is_some()) {
            context.warn(
                format!("{pointer}/mesh"),
                "some meshes have joints but their nodes have no skin; they are not deformed",
            );
        }
        return Ok(());
    };
    let pointer = format!("{pointer}/skin");
    let Some(joints) = joints else {
        context.warn(pointer, "a skin on a node without mesh has no effect");
        return Ok(());
    };
    if joints.is_partial {
        let message = "the mesh of this node has primitives without JOINTS_0 and WEIGHTS_0";
        return Err(context.invalid(pointer, message));
    }
    match joints.highest {
        Some(highest) if highest as usize >= skin.joints.len() => Err(context.invalid(
            pointer,
            format!("the mesh uses joint {highest}, but the skin has only {} joints", skin.joints.len()),
        )),
        _ => Ok(()),
    }
}
