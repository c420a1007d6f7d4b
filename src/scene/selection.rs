//! Selected scene, clips, camera and variant, resolved against one scene.

use std::collections::BTreeSet;

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

    /// Whether any node below the selected roots has a light that is ever visible.
    pub fn has_lights(&self, scene: &Scene) -> bool {
        !self.lights(scene).is_empty()
    }

    /// Every light below the selected roots, once for each node that has it, but for those of nodes that are hidden at all times.
    pub fn lights<'s>(&self, scene: &'s Scene) -> Vec<&'s Light> {
        let mut lights = Vec::new();
        let mut pending = self.roots.clone();
        let appearing = self.appearing_nodes(scene);
        while let Some((index, node)) =
            pending.pop().and_then(|index| Some((index, scene.nodes.get(index.index())?)))
        {
            if node.is_hidden && !appearing.contains(&index) {
                continue;
            }
            lights.extend(node.light.and_then(|light| scene.lights.get(light.index())));
            pending.extend_from_slice(&node.children);
        }
        lights
    }

    /// Nodes whose visibility a selected clip animates.
    fn appearing_nodes(&self, scene: &Scene) -> BTreeSet<NodeIndex> {
        let clips = self.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
        let targets = clips.flat_map(|clip| &clip.channels).map(|channel| channel.target);
        let visibilities = targets.filter(|target| matches!(target, AnimationTarget::Visibility(_)));
        visibilities.filter_map(AnimationTarget::node).collect()
    }

    /// Label of the camera for messages: `camera "name"`, `camera #2` without a name, or `camera auto`.
    pub fn camera_label(&self, scene: &Scene) -> String {
        let node = match &self.camera {
            SelectedCamera::Node(node) => *node,
            SelectedCamera::Path(path) => return format!("camera path {}", path.label),
            _ => return "camera auto".to_owned(),
        };
        let camera = || scene.nodes.get(node.index())?.camera.map(CameraIndex::index);
        match self.camera_name(scene) {
            Some(name) => format!("camera \"{name}\""),
            None => format!("camera #{}", camera().unwrap_or(0)),
        }
    }

    /// The name of a camera of the scene, or else that of its node.
    pub fn camera_name<'s>(&self, scene: &'s Scene) -> Option<&'s str> {
        let SelectedCamera::Node(node) = &self.camera else { return None };
        let node = scene.nodes.get(node.index())?;
        let camera = node.camera.and_then(|camera| scene.cameras.get(camera.index()));
        camera.and_then(|camera| camera.name.as_deref()).or(node.name.as_deref())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::{Channel, Interpolation, Keyframes, LightIndex, LightKind, Node};

    fn selection(clips: Vec<AnimationIndex>) -> Selection {
        Selection {
            roots: vec![NodeIndex(0)],
            clips,
            camera: SelectedCamera::Node(NodeIndex(1)),
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant: None,
        }
    }

    #[test]
    fn lights_that_are_never_visible_do_not_count() {
        // Node 0 holds 1, which has the light.
        let root = Node { children: vec![NodeIndex(1)], ..Node::default() };
        let lamp = Node { parent: Some(NodeIndex(0)), light: Some(LightIndex(0)), ..Node::default() };
        let lamp_light =
            Light { name: None, color: Vec3::ONE, intensity: 1.0, range: None, kind: LightKind::Point };
        let mut scene = Scene { nodes: vec![root, lamp], lights: vec![lamp_light], ..Scene::default() };
        let clip = |node: u32| {
            let keyframes = Keyframes {
                times_seconds: vec![0.0, 1.0],
                values: vec![0.0, 1.0],
                width: 1,
                interpolation: Interpolation::Step,
            };
            let target = AnimationTarget::Visibility(NodeIndex(node));
            Animation { name: None, channels: vec![Channel { target, keyframes }] }
        };
        scene.animations = vec![clip(0), clip(1)];
        let (still, first) = (selection(Vec::new()), selection(vec![AnimationIndex(0)]));
        assert!(still.has_lights(&scene));
        for hidden in [0, 1] {
            scene.nodes[hidden].is_hidden = true;
            scene.nodes[1 - hidden].is_hidden = false;
            assert!(!still.has_lights(&scene), "{hidden}");
            // A clip may show what is hidden, but not what it does not animate.
            assert_eq!(first.has_lights(&scene), hidden == 0);
        }
        scene.nodes[0].is_hidden = true;
        assert!(!first.has_lights(&scene));
        assert!(selection(vec![AnimationIndex(0), AnimationIndex(1)]).has_lights(&scene));
    }

    #[test]
    fn cameras_are_called_by_their_names_or_those_of_their_nodes() {
        let node = Node { camera: Some(CameraIndex(0)), ..Node::default() };
        let mut scene = Scene { nodes: vec![Node::default(), node], ..Scene::default() };
        let selection = selection(Vec::new());
        assert_eq!(selection.camera_label(&scene), "camera #0");
        scene.nodes[1].name = Some("stand".to_owned());
        assert_eq!(selection.camera_label(&scene), "camera \"stand\"");
        assert_eq!(selection.camera_name(&scene), Some("stand"));
        let auto = Selection { camera: SelectedCamera::Auto, ..selection };
        assert_eq!((auto.camera_name(&scene), auto.camera_label(&scene)), (None, "camera auto".to_owned()));
    }
}
