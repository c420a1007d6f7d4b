//! Resolves a selection request that may name each clip and each camera: one selection for each sequence.

use super::resolve_selection::selected_cameras;
use super::{
    AnimationIndex, CameraIndex, CameraRequest, ClipSelection, NameOrIndex, NodeIndex, Scene, SelectedCamera,
    Selection, SelectionRequest, make_unique_for_files,
};
use crate::error::{Result, Warning};

/// The selection of one sequence, and the names of its clip and camera.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSelection {
    /// The selection.
    pub selection: Selection,
    /// Name of the clip, `clip0` without one; `walk+camera` of several; `all` or `none` where these are requested. Where each is
    /// requested, the second clip of a name is `walk (2)`; case does not count.
    pub clip: String,
    /// Name of the camera, or of its node; `camera0` without either, `auto` for the automatic one. Where each is requested, the
    /// second camera of a name is `left (2)`; case does not count.
    pub camera: String,
}

impl Selection {
    /// Resolves `request` against `scene`: one selection for each requested clip and camera, cameras within clips. A scene
    /// without clips has one selection that plays none; a scene without cameras one with the automatic camera.
    ///
    /// # Errors
    /// Those of [`Selection::resolve`].
    pub fn resolve_each(
        request: &SelectionRequest,
        scene: &Scene,
    ) -> Result<(Vec<NamedSelection>, Vec<Warning>)> {
        let mut all_warnings = Vec::new();
        let is_each_camera = request.camera == Some(CameraRequest::Each);
        let camera = request.camera.clone().filter(|_| !is_each_camera);
        let (mut of_clips, mut clip_names) = (Vec::new(), Vec::new());
        for clips in clips_of_sequences(request, scene) {
            let of_sequence =
                SelectionRequest { clips: clips.clone(), camera: camera.clone(), ..request.clone() };
            let (selection, warnings) = Self::resolve(&of_sequence, scene)?;
            // Each clip resolves the other names again.
            for warning in warnings {
                if !all_warnings.contains(&warning) {
                    all_warnings.push(warning);
                }
            }
            clip_names.push(clip_name(&clips, &selection, scene));
            of_clips.push(selection);
        }
        make_unique_for_files(&mut clip_names);
        let mut selections = Vec::new();
        for (of_clip, clip) in of_clips.into_iter().zip(clip_names) {
            let (cameras, names) = cameras_of_sequences(&of_clip, is_each_camera, scene);
            selections.extend(cameras.into_iter().zip(names).map(|(camera, name)| NamedSelection {
                selection: Self { camera, ..of_clip.clone() },
                clip: clip.clone(),
                camera: name,
            }));
        }
        Ok((selections, all_warnings))
    }

    /// The clips that each selection of `request` plays alone; empty unless each is requested.
    pub(crate) fn clips_of_each(request: &SelectionRequest, scene: &Scene) -> Vec<AnimationIndex> {
        match request.clips {
            ClipSelection::Each => (0..scene.animations.len()).map(AnimationIndex::of).collect(),
            _ => Vec::new(),
        }
    }
}

/// The clips of each sequence.
fn clips_of_sequences(request: &SelectionRequest, scene: &Scene) -> Vec<ClipSelection> {
    match &request.clips {
        ClipSelection::Each if scene.animations.is_empty() => vec![ClipSelection::None],
        ClipSelection::Each => {
            (0..scene.animations.len()).map(|clip| ClipSelection::One(NameOrIndex::Index(clip))).collect()
        }
        clips => vec![clips.clone()],
    }
}

/// The cameras of the sequences of a clip, with their names: each of the scene, or the selected one.
fn cameras_of_sequences(
    selection: &Selection,
    is_each: bool,
    scene: &Scene,
) -> (Vec<SelectedCamera>, Vec<String>) {
    let nodes = if is_each { selected_cameras(scene, &selection.roots) } else { Vec::new() };
    if nodes.is_empty() {
        return (vec![selection.camera.clone()], vec![camera_name(scene, &selection.camera, false)]);
    }
    let name = |&(camera, node): &(CameraIndex, NodeIndex)| {
        let is_shared = nodes.iter().filter(|(other, _)| *other == camera).count() > 1;
        camera_name(scene, &SelectedCamera::Node(node), is_shared)
    };
    let mut names: Vec<_> = nodes.iter().map(name).collect();
    make_unique_for_files(&mut names);
    (nodes.iter().map(|&(_, node)| SelectedCamera::Node(node)).collect(), names)
}

/// The name of the clip, those of several joined by `+`, or how they are selected.
fn clip_name(requested: &ClipSelection, selection: &Selection, scene: &Scene) -> String {
    match (requested, selection.clips.as_slice()) {
        (ClipSelection::One(_) | ClipSelection::Together(_), clips) => {
            let name = |clip: &AnimationIndex| {
                let name = scene.animations.get(clip.index()).and_then(|clip| clip.name.clone());
                named(name, "clip", clip.index())
            };
            clips.iter().map(name).collect::<Vec<_>>().join("+")
        }
        (ClipSelection::All, _) => "all".to_owned(),
        _ => "none".to_owned(),
    }
}

/// The camera's own name, or that of its node, which comes first where several nodes share the camera.
fn camera_name(scene: &Scene, camera: &SelectedCamera, is_shared: bool) -> String {
    let SelectedCamera::Node(NodeIndex(node)) = camera else { return "auto".to_owned() };
    let node = scene.nodes.get(*node as usize);
    let of_node = node.and_then(|node| node.name.clone());
    let index = node.and_then(|node| node.camera).map_or(0, CameraIndex::index);
    let own = scene.cameras.get(index).and_then(|camera| camera.name.clone());
    let name = if is_shared { of_node.or(own) } else { own.or(of_node) };
    named(name, "camera", index)
}

/// The name, or `clip2` without one.
fn named(name: Option<String>, what: &str, index: usize) -> String {
    name.filter(|name| !name.is_empty()).unwrap_or_else(|| format!("{what}{index}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Animation, Camera, Node, Projection, SceneRoots};

    fn scene() -> Scene {
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect_ratio: None, z_near: 0.1, z_far: None };
        let camera = |name: Option<&str>| Camera { name: name.map(str::to_owned), projection };
        let node = |name: &str, camera| Node {
            name: Some(name.to_owned()).filter(|name| !name.is_empty()),
            camera: Some(CameraIndex(camera)),
            ..Node::default()
        };
        let clip = |name: Option<&str>| Animation { name: name.map(str::to_owned), channels: Vec::new() };
        Scene {
            nodes: vec![node("left", 0), node("right", 0), node("", 1)],
            scenes: vec![SceneRoots {
                roots: vec![NodeIndex(0), NodeIndex(1), NodeIndex(2)],
                ..SceneRoots::default()
            }],
            cameras: vec![camera(Some("stereo")), camera(None)],
            animations: vec![clip(Some("walk")), clip(None)],
            ..Scene::default()
        }
    }

    fn names(request: &SelectionRequest, scene: &Scene) -> Vec<(String, String)> {
        let (selections, _) = Selection::resolve_each(request, scene).unwrap();
        selections.into_iter().map(|named| (named.clip, named.camera)).collect()
    }

    fn pair(clip: &str, camera: &str) -> (String, String) {
        (clip.to_owned(), camera.to_owned())
    }

    #[test]
    fn each_clip_and_each_camera_has_a_sequence() {
        let each = SelectionRequest {
            clips: ClipSelection::Each,
            camera: Some(CameraRequest::Each),
            ..SelectionRequest::default()
        };
        let expected = ["walk", "clip1"]
            .iter()
            .flat_map(|clip| ["left", "right", "camera1"].map(|camera| pair(clip, camera)))
            .collect::<Vec<_>>();
        assert_eq!(names(&each, &scene()), expected);
        assert_eq!(Selection::resolve(&each, &scene()).unwrap_err().exit_code(), 2);
        // What a scene does not have is one sequence without it.
        let bare = Scene { scenes: vec![SceneRoots::default()], ..Scene::default() };
        assert_eq!(names(&each, &bare), [pair("none", "auto")]);
    }

    #[test]
    fn equal_names_are_numbered() {
        let mut scene = scene();
        let clip = |name: &str| Animation { name: Some(name.to_owned()), channels: Vec::new() };
        scene.animations = ["walk", "Walk", "walk (2)", "walk"].map(clip).to_vec();
        scene.cameras[1].name = Some("left".to_owned());
        let each = |clips, camera| SelectionRequest { clips, camera, ..SelectionRequest::default() };
        let clips = ["walk", "Walk (3)", "walk (2)", "walk (4)"].map(|clip| pair(clip, "stereo"));
        assert_eq!(names(&each(ClipSelection::Each, None), &scene), clips);
        // The nodes of the shared camera come first.
        let cameras = ["left", "right", "left (2)"].map(|camera| pair("none", camera));
        assert_eq!(names(&each(ClipSelection::None, Some(CameraRequest::Each)), &scene), cameras);
        // A clip that is requested alone keeps its name.
        let second = ClipSelection::One(NameOrIndex::Index(1));
        assert_eq!(names(&each(second, None), &scene), [pair("Walk", "stereo")]);
    }

    #[test]
    fn single_selections_have_names_as_well() {
        let request = |clips| SelectionRequest { clips, ..SelectionRequest::default() };
        assert_eq!(names(&request(ClipSelection::All), &scene()), [pair("all", "stereo")]);
        assert_eq!(names(&request(ClipSelection::None), &scene()), [pair("none", "stereo")]);
        let second = ClipSelection::One(NameOrIndex::Index(1));
        assert_eq!(names(&request(second), &scene()), [pair("clip1", "stereo")]);
        let both = ClipSelection::Together("#1, walk".to_owned());
        assert_eq!(names(&request(both), &scene()), [pair("clip1+walk", "stereo")]);
    }
}
