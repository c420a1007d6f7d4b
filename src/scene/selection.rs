//! Selected scene, clips, camera and variant, resolved against one scene.

use super::animation::first_key_seconds;
use super::{
    Animation, AnimationIndex, AnimationTarget, CameraChanges, CameraIndex, ImageLightIndex, Light,
    NodeIndex, Scene, SelectedCamera, VariantIndex,
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
    /// Changes to it, where it is a node's or a path's.
    pub camera_changes: CameraChanges,
    /// Image-based light of the selected scene.
    pub image_light: Option<ImageLightIndex>,
    /// Material variant.
    pub variant: Option<VariantIndex>,
}

impl Selection {
    /// Whether `other` differs at most in its camera.
    pub(crate) fn has_surfaces_of(&self, other: &Self) -> bool {
        let Self { roots, clips, camera: _, camera_changes: _, image_light, variant } = self;
        *roots == other.roots
            && *clips == other.clips
            && *image_light == other.image_light
            && *variant == other.variant
    }

    /// Time of the last keyframe of the selected clips and of the camera's path, seconds.
    pub fn duration_seconds(&self, scene: &Scene) -> f32 {
        let of_path = match &self.camera {
            SelectedCamera::Path(path) => path.duration_seconds as f32,
            _ => 0.0,
        };
        self.clip_seconds(scene).max(of_path)
    }

    /// Time of the first keyframe of the selected clips, seconds; 0 without clips.
    pub fn clip_start_seconds(&self, scene: &Scene) -> f32 {
        first_key_seconds(&scene.animations, &self.clips)
    }

    /// Time of the last keyframe of the selected clips, seconds.
    pub fn clip_seconds(&self, scene: &Scene) -> f32 {
        let clips = self.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
        clips.map(Animation::duration_seconds).fold(0.0, |a, b| if b > a { b } else { a })
    }

    /// Whether a selected clip animates the image-based light.
    pub fn moves_image_light(&self, scene: &Scene) -> bool {
        let is_light = |target| matches!(target, AnimationTarget::ImageLight(light, _) if Some(light) == self.image_light);
        let clips = self.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
        clips.flat_map(|clip| &clip.channels).any(|channel| is_light(channel.target))
    }

    /// Whether any node below the selected roots has a light.
    pub fn has_lights(&self, scene: &Scene) -> bool {
        !self.lights(scene).is_empty()
    }

    /// Every light below the selected roots, once for each node that has it.
    pub fn lights<'s>(&self, scene: &'s Scene) -> Vec<&'s Light> {
        let mut lights = Vec::new();
        let mut pending = self.roots.clone();
        while let Some(node) = pending.pop().and_then(|index| scene.nodes.get(index.index())) {
            lights.extend(node.light.and_then(|light| scene.lights.get(light.index())));
            pending.extend_from_slice(&node.children);
        }
        lights
    }

    /// Label of the camera for messages: `camera "name"`, `camera #2` without a name, or `camera auto`.
    pub fn camera_label(&self, scene: &Scene) -> String {
        let node = match &self.camera {
            SelectedCamera::Node(node) => *node,
            SelectedCamera::Path(path) => return format!("camera path {}", path.label),
            _ => return "camera auto".to_owned(),
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
