//! Resolves a selection request that may name each clip, camera and variant: one selection for each sequence.

use super::resolve_selection::selected_cameras;
use super::{
    AnimationIndex, CameraIndex, CameraRequest, ClipSelection, NameOrIndex, NodeIndex, Scene, SelectedCamera,
    Selection, SelectionRequest, VariantIndex, VariantRequest, make_unique_for_files,
};
use crate::error::{Result, Warning};

/// The selection of one sequence, and the names of its clip, camera and variant.
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
    /// Name of the variant; `none` without one. Where each is requested, the second variant of a name is `red (2)`; case does not
    /// count.
    pub variant: String,
}

impl Selection {
    /// Resolves `request` against `scene`: one selection for each requested clip, camera and variant, cameras within clips and
    /// variants within cameras. A scene without clips has one selection that plays none, a scene without cameras one with the
    /// automatic camera, and a scene without variants one with the primitives' own materials.
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
        let is_each_variant = request.variant == Some(VariantRequest::Each);
        let variant = request.variant.clone().filter(|_| !is_each_variant);
        let (mut of_clips, mut clip_names) = (Vec::new(), Vec::new());
        for clips in clips_of_sequences(request, scene) {
            let of_sequence = SelectionRequest {
                clips: clips.clone(),
                camera: camera.clone(),
                variant: variant.clone(),
                ..request.clone()
            };
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
            let (cameras, camera_names) = cameras_of_sequences(&of_clip, is_each_camera, scene);
            let (variants, variant_names) = variants_of_sequences(&of_clip, is_each_variant, scene);
            for (camera, camera_name) in cameras.iter().zip(&camera_names) {
                let of_camera = Self { camera: camera.clone(), ..of_clip.clone() };
                selections.extend(variants.iter().zip(&variant_names).map(|(&variant, name)| {
                    NamedSelection {
                        selection: Self { variant, ..of_camera.clone() },
                        clip: clip.clone(),
                        camera: camera_name.clone(),
                        variant: name.clone(),
                    }
                }));
            }
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

/// The variants of the sequences of a camera, with their names: each of the file, or the selected one.
fn variants_of_sequences(
    selection: &Selection,
    is_each: bool,
    scene: &Scene,
) -> (Vec<Option<VariantIndex>>, Vec<String>) {
    if !is_each || scene.variants.is_empty() {
        return (vec![selection.variant], vec![variant_name(scene, selection.variant)]);
    }
    let variants: Vec<_> = (0..scene.variants.len()).map(|variant| Some(VariantIndex::of(variant))).collect();
    let mut names: Vec<_> = variants.iter().map(|&variant| variant_name(scene, variant)).collect();
    make_unique_for_files(&mut names);
    (variants, names)
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

/// The variant's name, or `none` where primitives keep their own materials.
fn variant_name(scene: &Scene, variant: Option<VariantIndex>) -> String {
    let Some(variant) = variant else { return "none".to_owned() };
    let name = scene.variants.get(variant.index()).map(|variant| variant.name.clone());
    named(name, "variant", variant.index())
}

/// The name, or `clip2` without one.
fn named(name: Option<String>, what: &str, index: usize) -> String {
    name.filter(|name| !name.is_empty()).unwrap_or_else(|| format!("{what}{index}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Animation, Camera, Node, Projection, SceneRoots, Variant};

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
            variants: variants(&["day", "night"]),
            ..Scene::default()
        }
    }

    fn variants(names: &[&str]) -> Vec<Variant> {
        names.iter().map(|&name| Variant { name: name.to_owned() }).collect()
    }

    fn variant_names(request: &SelectionRequest, scene: &Scene) -> Vec<(Option<VariantIndex>, String)> {
        let (selections, _) = Selection::resolve_each(request, scene).unwrap();
        selections.into_iter().map(|named| (named.selection.variant, named.variant)).collect()
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
    fn each_variant_of_each_clip_and_camera_has_a_sequence() {
        let variant = Some(VariantRequest::Each);
        let each = SelectionRequest {
            clips: ClipSelection::Each,
            camera: Some(CameraRequest::Each),
            variant: variant.clone(),
            ..SelectionRequest::default()
        };
        // Variants within cameras within clips.
        let pairs = [("walk", "left"), ("walk", "right"), ("walk", "camera1"), ("clip1", "left")];
        let twice = |&(clip, camera): &(&str, &str)| [pair(clip, camera), pair(clip, camera)];
        let expected: Vec<_> = pairs.iter().flat_map(twice).collect();
        assert_eq!(names(&each, &scene())[..8], expected);
        let of_variants = variant_names(&each, &scene());
        assert_eq!(of_variants.len(), 12);
        let day_and_night =
            [(Some(VariantIndex(0)), "day".to_owned()), (Some(VariantIndex(1)), "night".to_owned())];
        assert!(of_variants.chunks(2).all(|chunk| chunk == day_and_night), "{of_variants:?}");
        // A single sequence needs a name.
        let each = SelectionRequest { variant, ..SelectionRequest::default() };
        let error = Selection::resolve(&each, &scene()).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("variant: each makes several sequences"), "{error}");
        // A scene without variants has its own materials.
        let bare = Scene { variants: Vec::new(), ..scene() };
        assert_eq!(variant_names(&each, &bare), [(None, "none".to_owned())]);
    }

    #[test]
    fn variants_of_one_name_are_numbered() {
        let each = SelectionRequest { variant: Some(VariantRequest::Each), ..SelectionRequest::default() };
        let scene = Scene { variants: variants(&["red", "Red", "", "red (2)"]), ..scene() };
        let named = |request: &SelectionRequest| {
            variant_names(request, &scene).into_iter().map(|(_, name)| name).collect::<Vec<_>>()
        };
        assert_eq!(named(&each), ["red", "Red (3)", "variant2", "red (2)"]);
        // A variant that is requested alone keeps its name.
        let second = Some(VariantRequest::Variant(NameOrIndex::Index(1)));
        assert_eq!(named(&SelectionRequest { variant: second, ..SelectionRequest::default() }), ["Red"]);
        assert_eq!(named(&SelectionRequest::default()), ["none"]);
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
