//! What a scene shows at one time, without its vertices in world space.

use glam::Mat4;

use crate::scene::{ImageLightPose, Material, MeshIndex, NodeIndex, Scene, Selection};

use super::Frame;
use super::posed_nodes::{PosedLight, posed_light};
use super::surfaces::{Scratch, fill_joint_matrices, morph_weights};
use super::transform;

/// The meshes, materials and lights of a scene at one time.
#[derive(Clone, Debug, Default)]
pub struct PosedContent {
    /// The visible meshes of the selected nodes, in the order of the hierarchy.
    pub meshes: Vec<PosedMesh>,
    /// Materials, by [`crate::scene::MaterialIndex`].
    pub materials: Vec<Material>,
    /// Visible lights.
    pub lights: Vec<PosedLight>,
    /// The image-based light, if the selected scene has one.
    pub image_light: Option<ImageLightPose>,
}

/// A mesh under a node.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedMesh {
    /// The mesh.
    pub mesh: MeshIndex,
    /// The node.
    pub node: NodeIndex,
    /// The node's world matrix, those of its GPU instances, then the joint matrices of its skin.
    pub matrices: Vec<Mat4>,
    /// Morph weights.
    pub weights: Vec<f32>,
}

impl Frame {
    /// What `scene` shows at `time_seconds`.
    pub fn content_at(scene: &Scene, selection: &Selection, time_seconds: f64) -> PosedContent {
        let mut content = PosedContent::default();
        let Scratch { mut pose, mut world, mut joint_matrices } = Scratch::default();
        pose.play(scene, selection, time_seconds, &mut content.materials);
        transform::inherit_hidden(scene, &mut pose.hidden);
        transform::world_matrices(scene, &pose.local, &mut world);
        content.image_light = selection.image_light.map(|light| pose.image_lights[light.index()]);
        let nodes = transform::selected_nodes(scene, selection);
        for index in nodes.into_iter().filter(|node| !pose.hidden[node.index()]) {
            content.lights.extend(posed_light(scene, &pose, index, &world));
            let node = &scene.nodes[index.index()];
            let Some(mesh) = node.mesh else { continue };
            let mut matrices = vec![world[index.index()]];
            matrices.extend(node.instances.iter().flatten());
            if let Some(skin) = node.skin {
                fill_joint_matrices(&scene.skins[skin.index()], &world, &mut joint_matrices);
                matrices.extend(&joint_matrices);
            }
            let weights = morph_weights(scene, &pose, index, mesh).to_vec();
            content.meshes.push(PosedMesh { mesh, node: index, matrices, weights });
        }
        content
    }
}
