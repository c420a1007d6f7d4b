//! The names of what a scene holds, for the attribute `sceneContent` of references.

use crate::image::{ContentNames, SceneContent};
use crate::scene::{CameraIndex, Scene};

/// Names of the file's nodes with a mesh, its clips, cameras and variants.
pub(super) fn scene_content(scene: &Scene) -> SceneContent {
    let or_number = |name: Option<&str>, what: &str, index: usize| {
        name.map_or_else(|| format!("{what}{index}"), str::to_owned)
    };
    let with_mesh = scene.nodes.iter().filter(|node| node.mesh.is_some());
    let clips = scene.animations.iter().enumerate();
    let cameras = 0..scene.cameras.len();
    let camera = |index: usize| or_number(scene.camera_name(CameraIndex(index as u32)), "camera", index);
    SceneContent {
        nodes: ContentNames::new(with_mesh.filter_map(|node| node.name.clone()).collect()),
        clips: ContentNames::new(
            clips.map(|(index, clip)| or_number(clip.name.as_deref(), "clip", index)).collect(),
        ),
        cameras: ContentNames::new(cameras.map(camera).collect()),
        variants: ContentNames::new(scene.variants.iter().map(|variant| variant.name.clone()).collect()),
    }
}
