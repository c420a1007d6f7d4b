//! The nodes of a scene at one time, without surfaces, lights and cameras.

use glam::Mat4;

use super::animation::ScenePose;
use super::surface_pose::morph_weights;
use super::transform;
use crate::scene::{MeshIndex, NodeIndex, Scene, Selection};

/// World matrices, visibility and morph weights of all nodes.
#[derive(Debug)]
pub(crate) struct NodePose {
    pose: ScenePose,
    world: Vec<Mat4>,
}

impl NodePose {
    /// The nodes of `scene` at `time_seconds`.
    pub(crate) fn at(scene: &Scene, selection: &Selection, time_seconds: f64) -> Self {
        let (mut pose, mut world) = (ScenePose::default(), Vec::new());
        pose.play(scene, selection, time_seconds, &mut Vec::new());
        transform::inherit_hidden(scene, &mut pose.hidden);
        scene.world_matrices(&pose.local, &mut world);
        Self { pose, world }
    }

    /// The world matrix of a node.
    pub(crate) fn world(&self, node: NodeIndex) -> Mat4 {
        self.world[node.index()]
    }

    /// Whether the node or one above it is hidden.
    pub(crate) fn is_hidden(&self, node: NodeIndex) -> bool {
        self.pose.hidden[node.index()]
    }

    /// Morph weights of a mesh under a node.
    pub(crate) fn weights<'a>(&'a self, scene: &'a Scene, node: NodeIndex, mesh: MeshIndex) -> &'a [f32] {
        morph_weights(scene, &self.pose, node, mesh)
    }
}
