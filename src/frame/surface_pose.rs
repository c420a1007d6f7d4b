//! What decides about the surfaces of a scene at one time.

use glam::Mat4;

use super::animation::ScenePose;
use crate::bvh::TriangleFlags;
use crate::scene::{MeshIndex, NodeIndex, Scene};

/// All that decides about the surfaces of a scene at one time.
#[derive(Clone, Debug, Default)]
pub(super) struct SurfacePose {
    pub(super) pose: ScenePose,
    /// World matrices, by [`NodeIndex`].
    pub(super) world: Vec<Mat4>,
    /// Traversal flags of materials, by [`crate::scene::MaterialIndex`].
    pub(super) material_flags: Vec<TriangleFlags>,
}

/// Morph target weights. The node's precede the mesh's, and animated ones precede those at rest.
pub(super) fn morph_weights<'a>(
    scene: &'a Scene,
    pose: &'a ScenePose,
    node: NodeIndex,
    mesh: MeshIndex,
) -> &'a [f32] {
    pose.weights[node.index()]
        .as_ref()
        .or(scene.nodes[node.index()].weights.as_ref())
        .or(pose.mesh_weights[mesh.index()].as_ref())
        .unwrap_or(&scene.meshes[mesh.index()].weights)
}
