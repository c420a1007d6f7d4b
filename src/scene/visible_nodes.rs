//! The nodes that a selection ever shows.

use super::{AnimationTarget, NodeIndex, Scene, Selection};

/// The nodes below the roots of a selection but those that are hidden at all times, for themselves or with a parent.
pub fn visible_nodes(scene: &Scene, selection: &Selection) -> Vec<NodeIndex> {
    let mut visible = Vec::new();
    let mut pending = selection.roots.clone();
    while let Some(index) = pending.pop() {
        let Some(node) = scene.nodes.get(index.index()) else { continue };
        if !is_always_hidden(scene, selection, index) {
            pending.extend_from_slice(&node.children);
            visible.push(index);
        }
    }
    visible
}

/// Whether a node is hidden for itself at all times.
fn is_always_hidden(scene: &Scene, selection: &Selection, node: NodeIndex) -> bool {
    let clips = selection.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
    let channels = clips.flat_map(|clip| &clip.channels);
    let mut of_node =
        channels.filter(|channel| channel.target == AnimationTarget::Visibility(node)).peekable();
    match of_node.peek() {
        Some(_) => of_node.all(|channel| channel.keyframes.values.iter().all(|&value| value == 0.0)),
        None => scene.nodes[node.index()].is_hidden,
    }
}
