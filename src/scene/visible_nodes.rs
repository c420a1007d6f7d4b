//! The nodes that a selection ever shows.

use std::collections::BTreeMap;

use super::{AnimationTarget, NodeIndex, Scene, Selection};

/// The nodes below the roots of a selection but those that are hidden at all times, for themselves or with a parent.
pub fn visible_nodes(scene: &Scene, selection: &Selection) -> Vec<NodeIndex> {
    let animated = animated_visibility(scene, selection);
    let mut visible = Vec::new();
    let mut pending = selection.roots.clone();
    while let Some(index) = pending.pop() {
        let Some(node) = scene.nodes.get(index.index()) else { continue };
        if animated.get(&index).copied().unwrap_or(!node.is_hidden) {
            pending.extend_from_slice(&node.children);
            visible.push(index);
        }
    }
    visible
}

/// The nodes whose visibility the selected clips animate, each with whether any keyframe shows it.
fn animated_visibility(scene: &Scene, selection: &Selection) -> BTreeMap<NodeIndex, bool> {
    let mut is_shown = BTreeMap::new();
    let clips = selection.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
    for channel in clips.flat_map(|clip| &clip.channels) {
        if let AnimationTarget::Visibility(node) = channel.target {
            *is_shown.entry(node).or_insert(false) |=
                channel.keyframes.values.iter().any(|value| *value != 0.0);
        }
    }
    is_shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        Animation, AnimationIndex, CameraChanges, Channel, Interpolation, Keyframes, Node, SelectedCamera,
    };

    #[test]
    fn selected_clips_decide_about_the_nodes_that_they_animate() {
        // Node 0 holds 1 to 4. A clip shows 2 and hides 3; the file hides 1 and 2.
        let channel = |node, values: [f32; 2]| Channel {
            target: AnimationTarget::Visibility(NodeIndex(node)),
            keyframes: Keyframes {
                times_seconds: vec![0.0, 1.0],
                values: values.to_vec(),
                width: 1,
                interpolation: Interpolation::Step,
            },
        };
        let clip = Animation { name: None, channels: vec![channel(2, [0.0, 1.0]), channel(3, [0.0, 0.0])] };
        let root = Node { children: (1..5).map(NodeIndex).collect(), ..Node::default() };
        let leaves = [true, true, false, false].map(|is_hidden| Node { is_hidden, ..Node::default() });
        let mut scene = Scene {
            nodes: std::iter::once(root).chain(leaves).collect(),
            animations: vec![clip],
            ..Scene::default()
        };
        let mut selection = Selection {
            roots: vec![NodeIndex(0)],
            clips: vec![AnimationIndex(0)],
            camera: SelectedCamera::Auto,
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant: None,
        };
        let visible = |scene: &Scene, selection: &Selection| {
            let mut nodes: Vec<u32> = visible_nodes(scene, selection).iter().map(|node| node.0).collect();
            nodes.sort_unstable();
            nodes
        };
        assert_eq!(visible(&scene, &selection), [0, 2, 4]);
        // A clip that does not play decides nothing.
        selection.clips.clear();
        assert_eq!(visible(&scene, &selection), [0, 3, 4]);
        // What is below a hidden node is hidden with it.
        scene.nodes[0].is_hidden = true;
        assert_eq!(visible(&scene, &selection), [0; 0]);
    }
}
