//! Selected scene, clips, camera and variant, resolved against one scene.

use glam::Mat4;

use super::{
    AnimationIndex, AnimationTarget, CameraIndex, ImageLightIndex, NodeIndex, Projection, Scene, VariantIndex,
};

/// Selected camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SelectedCamera {
    /// Automatic camera that frames the whole scene over the selected clips.
    Auto,
    /// The camera of this node.
    Node(NodeIndex),
    /// Static camera, such as a resolved automatic one.
    Fixed {
        /// Rotation and translation; columns are right, up, backward, position.
        world_from_camera: Mat4,
        /// The projection.
        projection: Projection,
    },
}

/// Selected part of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Root nodes.
    pub roots: Vec<NodeIndex>,
    /// Clips that play together. Their targets are disjoint.
    pub clips: Vec<AnimationIndex>,
    /// The camera.
    pub camera: SelectedCamera,
    /// Image-based light of the selected scene.
    pub image_light: Option<ImageLightIndex>,
    /// Material variant.
    pub variant: Option<VariantIndex>,
}

impl Selection {
    /// Whether a selected clip animates the image-based light.
    pub fn moves_image_light(&self, scene: &Scene) -> bool {
        let is_light = |target| matches!(target, AnimationTarget::ImageLight(light, _) if Some(light) == self.image_light);
        let clips = self.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
        clips.flat_map(|clip| &clip.channels).any(|channel| is_light(channel.target))
    }

    /// Whether any node below the selected roots has a light.
    pub fn has_lights(&self, scene: &Scene) -> bool {
        let mut pending = self.roots.clone();
        while let Some(node) = pending.pop().and_then(|index| scene.nodes.get(index.index())) {
            if node.light.is_some() {
                return true;
            }
            pending.extend_from_slice(&node.children);
        }
        false
    }

    /// Label of the camera for messages: `camera "name"`, `camera #2` without a name, or `camera auto`.
    pub fn camera_label(&self, scene: &Scene) -> String {
        let SelectedCamera::Node(node) = self.camera else {
            return "camera auto".to_owned();
        };
        let node = scene.nodes.get(node.index());
        let index = node.and_then(|node| node.camera).map_or(0, CameraIndex::index);
        let camera_name = scene.cameras.get(index).and_then(|camera| camera.name.as_deref());
        match camera_name.or_else(|| node.and_then(|node| node.name.as_deref())) {
            Some(name) => format!("camera \"{name}\""),
            None => format!("camera #{index}"),
        }
    }
}
