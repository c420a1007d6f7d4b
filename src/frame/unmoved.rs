//! What need not be posed again: instances that are as they were when their frame was posed before.

use super::mesh_instance::MeshInstance;
use super::surface_pose::{SurfacePose, morph_weights};
use crate::scene::{MeshIndex, NodeIndex, Scene, Skin};

/// The surfaces of a frame at the time before and now.
pub(super) struct Unmoved<'a> {
    scene: &'a Scene,
    before: &'a SurfacePose,
    now: &'a SurfacePose,
    /// Whether all joints of a skin are as before, by [`crate::scene::SkinIndex`]. Many instances may share one.
    keeps_skins: Vec<bool>,
}

impl<'a> Unmoved<'a> {
    /// Compares two poses of `scene`.
    pub(super) fn new(scene: &'a Scene, before: &'a SurfacePose, now: &'a SurfacePose) -> Self {
        let keeps_skin = |skin: &Skin| skin.joints.iter().all(|&joint| keeps_matrix(before, now, joint));
        Self { scene, before, now, keeps_skins: scene.skins.iter().map(keeps_skin).collect() }
    }

    /// Whether every vertex, triangle and flag of `instance` is the same to the bit.
    pub(super) fn holds(&self, instance: &MeshInstance) -> bool {
        let &MeshInstance { node, mesh, material, .. } = instance;
        let skin = self.scene.nodes[node.index()].skin;
        self.before.pose.hidden[node.index()] == self.now.pose.hidden[node.index()]
            && self.before.material_flags[material.index()] == self.now.material_flags[material.index()]
            && self.keeps_weights(node, mesh)
            && keeps_matrix(self.before, self.now, node)
            && skin.is_none_or(|skin| self.keeps_skins[skin.index()])
    }

    fn keeps_weights(&self, node: NodeIndex, mesh: MeshIndex) -> bool {
        let [before, now] = [self.before, self.now].map(|of| morph_weights(self.scene, &of.pose, node, mesh));
        before.iter().map(|weight| weight.to_bits()).eq(now.iter().map(|weight| weight.to_bits()))
    }
}

/// Whether the world matrix of a node is the same to the bit, since zeros of either sign give other bits.
fn keeps_matrix(before: &SurfacePose, now: &SurfacePose, node: NodeIndex) -> bool {
    let bits = |pose: &SurfacePose| pose.world[node.index()].to_cols_array().map(f32::to_bits);
    bits(before) == bits(now)
}
