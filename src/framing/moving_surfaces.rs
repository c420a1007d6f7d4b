//! Which clips move surfaces.

use crate::scene::{AnimationTarget, NodeIndex, Scene, Selection};

/// Whether a clip of `selection` may move surfaces or show them: it animates morph weights, or a node with a mesh, a joint or an ancestor of either.
pub(super) fn moves_surfaces(scene: &Scene, selection: &Selection) -> bool {
    let clips = selection.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
    let moving = clips.flat_map(|clip| &clip.channels).filter(|channel| !channel.keyframes.are_constant());
    let mut targets = moving.map(|channel| channel.target).peekable();
    if targets.peek().is_none() {
        return false;
    }
    let poses = posing_nodes(scene, selection);
    targets.any(|target| match target.node() {
        Some(node) => poses.get(node.index()).is_some_and(|poses| *poses),
        None => may_move(target),
    })
}

/// Whether an animation of the target may move surfaces or show them.
pub(super) fn may_move(target: AnimationTarget) -> bool {
    target.node().is_some()
        || matches!(target, AnimationTarget::MeshWeights(_) | AnimationTarget::MeshWeight(..))
}

/// For each node, whether a surface follows it.
fn posing_nodes(scene: &Scene, selection: &Selection) -> Vec<bool> {
    let mut poses = vec![false; scene.nodes.len()];
    let mut skins = vec![false; scene.skins.len()];
    let mut mark = |mut node: Option<NodeIndex>| {
        // Where a node is marked, so are its ancestors.
        while let Some(index) = node.filter(|index| poses.get(index.index()) == Some(&false)) {
            poses[index.index()] = true;
            node = scene.nodes[index.index()].parent;
        }
    };
    for index in scene.nodes_below(&selection.roots) {
        let node = &scene.nodes[index.index()];
        if node.mesh.is_none() {
            continue;
        }
        mark(Some(index));
        let Some(skin) = node.skin.filter(|skin| skins.get(skin.index()) == Some(&false)) else { continue };
        skins[skin.index()] = true;
        scene.skins[skin.index()].joints.iter().for_each(|joint| mark(Some(*joint)));
    }
    poses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        Animation, AnimationIndex, CameraChanges, Channel, Interpolation, Keyframes, MeshIndex, Node,
        SelectedCamera, Skin, SkinIndex,
    };

    #[test]
    fn clips_move_what_surfaces_follow() {
        // 0 holds 1, which holds a mesh in 2; 3 is an empty node; 4 holds the joint 5 of a skin; 6 shows that skin.
        let node = |parent: Option<u32>| Node { parent: parent.map(NodeIndex), ..Node::default() };
        let mut nodes =
            vec![node(None), node(Some(0)), node(Some(1)), node(None), node(None), node(Some(4)), node(None)];
        nodes[0].children = vec![NodeIndex(1)];
        nodes[1].children = vec![NodeIndex(2)];
        nodes[4].children = vec![NodeIndex(5)];
        (nodes[2].mesh, nodes[6].mesh) = (Some(MeshIndex(0)), Some(MeshIndex(1)));
        nodes[6].skin = Some(SkinIndex(0));
        let skins = vec![Skin { joints: vec![NodeIndex(5)], ..Skin::default() }];
        let mut scene = Scene { nodes, skins, ..Scene::default() };
        let moves = |scene: &mut Scene, target, last: f32| {
            let keyframes = Keyframes {
                times_seconds: vec![0.0, 1.0],
                values: vec![0.0, last],
                width: 1,
                interpolation: Interpolation::Linear,
            };
            let channels = vec![Channel { target, keyframes }];
            scene.animations = vec![Animation { name: None, channels }];
            let selection = Selection {
                roots: [0, 3, 6].map(NodeIndex).to_vec(),
                clips: vec![AnimationIndex(0)],
                camera: SelectedCamera::Auto,
                camera_changes: CameraChanges::default(),
                image_light: None,
                variant: None,
            };
            moves_surfaces(scene, &selection)
        };
        let node = |node: u32| AnimationTarget::Translation(NodeIndex(node));
        let moved: Vec<_> = (0..7).filter(|&index| moves(&mut scene, node(index), 1.0)).collect();
        assert_eq!(moved, [0, 1, 2, 4, 5, 6]);
        assert!(moves(&mut scene, AnimationTarget::MeshWeights(MeshIndex(0)), 1.0));
        assert!(!moves(&mut scene, node(0), 0.0));
    }
}
