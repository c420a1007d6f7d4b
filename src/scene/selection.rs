//! Selected scene, clips, camera and variant, resolved against one scene.

use super::{
    AnimationIndex, AnimationTarget, CameraChanges, CameraIndex, ImageLightIndex, NodeIndex, Scene,
    SelectedCamera, VariantIndex,
};

/// Selected part of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Root nodes.
    pub roots: Vec<NodeIndex>,
    /// Clips that play together. Their targets are disjoint.
    pub clips: Vec<AnimationIndex>,
    /// The camera.
    pub camera: SelectedCamera,
    /// Changes to it, where it is a node's.
    pub camera_changes: CameraChanges,
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
