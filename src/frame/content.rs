//! What a scene shows at one time, without its vertices in world space.

use std::sync::Arc;

use glam::Mat4;

use crate::scene::{ImageLightPose, Material, MeshIndex, NodeIndex, Scene, Selection, SkinIndex};

use super::Frame;
use super::animation::ScenePose;
use super::posed_nodes::{PosedLight, posed_light};
use super::surface_pose::morph_weights;
use super::surfaces::joint_matrices;
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
    /// The node's world matrix, then the matrices of its GPU instances in its own space.
    pub matrices: Vec<Mat4>,
    /// The joint matrices of its skin, which many meshes may share; empty without a skin.
    pub joint_matrices: Arc<[Mat4]>,
    /// Morph weights.
    pub weights: Vec<f32>,
}

impl Frame {
    /// What `scene` shows at `time_seconds`.
    pub fn content_at(scene: &Scene, selection: &Selection, time_seconds: f64) -> PosedContent {
        let mut content = PosedContent::default();
        let (mut pose, mut world) = (ScenePose::default(), Vec::new());
        pose.play(scene, selection, time_seconds, &mut content.materials);
        transform::inherit_hidden(scene, &mut pose.hidden);
        scene.world_matrices(&pose.local, &mut world);
        content.image_light = selection.image_light.map(|light| pose.image_lights[light.index()]);
        let no_joints: Arc<[Mat4]> = Arc::default();
        let mut palettes: Vec<Option<Arc<[Mat4]>>> = vec![None; scene.skins.len()];
        let nodes = transform::selected_nodes(scene, selection);
        for index in nodes.into_iter().filter(|node| !pose.hidden[node.index()]) {
            content.lights.extend(posed_light(scene, &pose, index, &world));
            let node = &scene.nodes[index.index()];
            let Some(mesh) = node.mesh else { continue };
            let mut matrices = vec![world[index.index()]];
            matrices.extend(node.instances.iter().flatten());
            let of_skin = |skin: SkinIndex| {
                let skin = skin.index();
                let joints = || joint_matrices(&scene.skins[skin], &world).collect();
                Arc::clone(palettes[skin].get_or_insert_with(joints))
            };
            let joint_matrices = node.skin.map_or_else(|| Arc::clone(&no_joints), of_skin);
            let weights = morph_weights(scene, &pose, index, mesh).to_vec();
            content.meshes.push(PosedMesh { mesh, node: index, matrices, joint_matrices, weights });
        }
        content
    }
}
