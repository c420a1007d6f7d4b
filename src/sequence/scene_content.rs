//! The names of what a scene holds, for the attribute `sceneContent` of references.

use std::collections::BTreeSet;

use crate::image::{ContentNames, SceneContent};
use crate::scene::{CameraIndex, Node, Scene};

/// Names of the nodes with a mesh and the cameras that stand in a scene of the file, of its clips and of its variants.
pub(super) fn scene_content(scene: &Scene) -> SceneContent {
    let or_number = |name: Option<&str>, what: &str, index: usize| {
        name.map_or_else(|| format!("{what}{index}"), str::to_owned)
    };
    let nodes = nodes_of_scenes(scene);
    let with_mesh = nodes.iter().filter(|node| node.mesh.is_some());
    let clips = scene.animations.iter().enumerate();
    let cameras: BTreeSet<usize> =
        nodes.iter().filter_map(|node| node.camera).map(CameraIndex::index).collect();
    let camera = |index: usize| or_number(scene.camera_name(CameraIndex(index as u32)), "camera", index);
    SceneContent {
        nodes: ContentNames::new(with_mesh.filter_map(|node| node.name.clone()).collect()),
        clips: ContentNames::new(
            clips.map(|(index, clip)| or_number(clip.name.as_deref(), "clip", index)).collect(),
        ),
        cameras: ContentNames::new(cameras.into_iter().map(camera).collect()),
        variants: ContentNames::new(scene.variants.iter().map(|variant| variant.name.clone()).collect()),
    }
}

/// The nodes of all scenes of the file, each once.
fn nodes_of_scenes(scene: &Scene) -> Vec<&Node> {
    let mut pending: Vec<_> = scene.scenes.iter().flat_map(|scene| scene.roots.iter().copied()).collect();
    let (mut seen, mut nodes) = (BTreeSet::new(), Vec::new());
    while let Some(index) = pending.pop() {
        let Some(node) = scene.nodes.get(index.index()).filter(|_| seen.insert(index.index())) else {
            continue;
        };
        pending.extend_from_slice(&node.children);
        nodes.push(node);
    }
    nodes
}
