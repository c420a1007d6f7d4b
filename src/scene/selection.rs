//! Selected scene, clips, camera and variant, resolved against one scene.

use std::collections::BTreeSet;

use super::animation::first_key_seconds;
use super::{
    Animation, AnimationIndex, AnimationTarget, CameraChanges, CameraIndex, Channel, ImageLightIndex,
    ImageLightProperty, Light, Node, NodeIndex, Scene, SelectedCamera, VariantIndex,
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
        self.image_light_properties(scene).next().is_some()
    }

    /// Whether a selected clip animates the intensity of the image-based light.
    pub fn scales_image_light(&self, scene: &Scene) -> bool {
        self.image_light_properties(scene).any(|property| property == ImageLightProperty::Intensity)
    }

    /// Properties of the image-based light that selected clips animate.
    fn image_light_properties(&self, scene: &Scene) -> impl Iterator<Item = ImageLightProperty> {
        let clips = self.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
        clips.flat_map(|clip| &clip.channels).filter_map(|channel| match channel.target {
            AnimationTarget::ImageLight(light, property) if Some(light) == self.image_light => Some(property),
            _ => None,
        })
    }

    /// Whether any node below the selected roots has a light that the file ever shows.
    pub fn has_lights(&self, scene: &Scene) -> bool {
        !self.lights(scene).is_empty()
    }

    /// Every light below the selected roots that the file ever shows, once for each node that has it: neither it nor what it belongs to is hidden, or clips
    /// show that again, whether they are selected or not. So it is the same for all clips.
    pub fn lights<'s>(&self, scene: &'s Scene) -> Vec<&'s Light> {
        let shown: BTreeSet<NodeIndex> = shown_by_clips(scene).collect();
        self.lights_of(scene, |index, node| !node.is_hidden || shown.contains(&index))
    }

    /// Whether any light below the selected roots is one that the file never shows.
    pub(crate) fn leaves_out_lights(&self, scene: &Scene) -> bool {
        self.lights(scene).len() < self.lights_of(scene, |_, _| true).len()
    }

    /// The lights of nodes below the selected roots, as far as `is_shown` holds for them and all above.
    fn lights_of<'s>(&self, scene: &'s Scene, is_shown: impl Fn(NodeIndex, &Node) -> bool) -> Vec<&'s Light> {
        let mut lights = Vec::new();
        let mut pending = self.roots.clone();
        while let Some((index, node)) =
            pending.pop().and_then(|index| Some((index, scene.nodes.get(index.index())?)))
        {
            if is_shown(index, node) {
                lights.extend(node.light.and_then(|light| scene.lights.get(light.index())));
                pending.extend_from_slice(&node.children);
            }
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

/// Nodes that a clip of the scene shows at a time.
fn shown_by_clips(scene: &Scene) -> impl Iterator<Item = NodeIndex> {
    let channels = scene.animations.iter().flat_map(|clip| &clip.channels);
    let shows = |channel: &&Channel| channel.keyframes.values.iter().any(|value| *value != 0.0);
    channels.filter(shows).filter_map(|channel| match channel.target {
        AnimationTarget::Visibility(node) => Some(node),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::{Interpolation, Keyframes, LightIndex, LightKind};

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
        let clip = |node: u32, last: f32| {
            let keyframes = Keyframes {
                times_seconds: vec![0.0, 1.0],
                values: vec![0.0, last],
                width: 1,
                interpolation: Interpolation::Step,
            };
            let target = AnimationTarget::Visibility(NodeIndex(node));
            Animation { name: None, channels: vec![Channel { target, keyframes }] }
        };
        let still = selection(Vec::new());
        assert!(still.has_lights(&scene) && !still.leaves_out_lights(&scene));
        for hidden in [0, 1] {
            scene.animations.clear();
            scene.nodes[hidden].is_hidden = true;
            scene.nodes[1 - hidden].is_hidden = false;
            assert!(!still.has_lights(&scene) && still.leaves_out_lights(&scene), "{hidden}");
            // A clip may show what is hidden, selected or not, but not what it does not animate.
            scene.animations = vec![clip(1 - hidden as u32, 1.0), clip(hidden as u32, 0.0)];
            assert!(!still.has_lights(&scene));
            scene.animations.push(clip(hidden as u32, 1.0));
            for clips in [Vec::new(), vec![AnimationIndex(0)], vec![AnimationIndex(2)]] {
                let selection = selection(clips);
                assert!(selection.has_lights(&scene) && !selection.leaves_out_lights(&scene));
            }
        }
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
