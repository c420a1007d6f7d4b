//! The names of what a scene holds, for the attribute `sceneContent` of references.

use std::collections::{BTreeMap, BTreeSet};

use crate::image::{ContentNames, SceneContent};
use crate::scene::{Animation, AnimationIndex, Scene};

use super::clip_checksum;

/// Names of the nodes with a mesh and of their morph targets, of the cameras and named lights that stand in a scene of the file, of its
/// clips and which of these move, and of its variants. `playing` are the clips of the image.
pub(super) fn scene_content(scene: &Scene, playing: &[AnimationIndex]) -> SceneContent {
    let standing = scene.nodes_of_scenes();
    let nodes: Vec<_> = standing.iter().filter_map(|node| scene.nodes.get(node.index())).collect();
    let with_mesh: Vec<_> = nodes.iter().filter(|node| node.mesh.is_some()).collect();
    // Names of meshes change with exporters; those of nodes are what animations and engines refer to.
    let targets = with_mesh.iter().filter_map(|node| {
        let mesh = scene.meshes.get(node.mesh?.index())?;
        Some((node.name.clone()?, mesh.morph_target_count()))
    });
    let morph_targets = SceneContent::listed_morph_targets(targets);
    let clip_label = |index: usize| scene.clip_label(AnimationIndex(index as u32));
    let clips = (0..scene.animations.len()).map(clip_label);
    let moving = scene.animations.iter().enumerate().filter(|(_, clip)| clip.moves());
    let moving_clips = moving.map(|(index, _)| clip_label(index)).collect();
    let cameras: BTreeSet<_> = nodes.iter().filter_map(|node| node.camera).collect();
    let cameras = cameras.into_iter().map(|camera| scene.camera_label(camera));
    let lights: BTreeSet<_> = nodes.iter().filter_map(|node| node.light).collect();
    // Numbers change with the order, as those of nodes do.
    let lights = lights.into_iter().filter_map(|light| scene.light_name(light).map(str::to_owned)).collect();
    let variants = scene.variants.iter().map(|variant| variant.name.clone());
    SceneContent {
        nodes: ContentNames::new(with_mesh.iter().filter_map(|node| node.name.clone()).collect()),
        clips: ContentNames::new(clips.collect()),
        cameras: ContentNames::new(cameras.collect()),
        variants: ContentNames::new(variants.collect()),
        morph_targets,
        moving_clips: Some(ContentNames::new(moving_clips)),
        lights: Some(ContentNames::new(lights)),
        motions: by_clip(scene, playing, |clip| clip_checksum(scene, clip)),
        durations_ms: by_clip(scene, playing, duration_ms),
    }
}

/// Values of the clips that play, or of all where none does: other clips have images of their own.
fn by_clip<T>(
    scene: &Scene,
    playing: &[AnimationIndex],
    value: impl Fn(&Animation) -> T,
) -> Option<BTreeMap<String, T>> {
    let all = scene.animations.iter().enumerate().map(|(index, clip)| (AnimationIndex(index as u32), clip));
    let clips = all.filter(|(index, _)| playing.is_empty() || playing.contains(index));
    SceneContent::listed_by_clip(clips.map(|(index, clip)| (scene.clip_label(index), value(clip))))
}

/// Milliseconds, rounded: exporters round times.
fn duration_ms(clip: &Animation) -> u64 {
    libm::round(f64::from(clip.duration_seconds()) * 1000.0) as u64
}
