//! Resolves a selection request against a scene.

use super::named_kind::{find, label};
use super::resolve_clips::{clips_together, disjoint_clips, find_clip};
use super::{
    CameraChanges, CameraIndex, CameraRequest, ClipSelection, NameOrIndex, NamedKind, NodeIndex, Scene,
    SceneRoots, SelectedCamera, Selection, SelectionRequest, VariantIndex, VariantRequest,
};
use crate::error::{Error, Result, Warning};

const SCENE: NamedKind = NamedKind { noun: "scene", setting: "scene_choice", pointer: "/scenes" };
const CAMERA: NamedKind = NamedKind { noun: "camera", setting: "camera", pointer: "/cameras" };
const VARIANT: NamedKind =
    NamedKind { noun: "variant", setting: "variant", pointer: "/extensions/KHR_materials_variants/variants" };

impl Selection {
    /// Resolves `request` against `scene`. If all clips are requested, clips that share a target with an earlier clip are left
    /// out with one warning. Of several things with a requested name the first is selected, with a warning.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for a name or index that does not exist, with the existing ones, and for a request that has several
    /// selections, which [`Selection::resolve_each`] resolves.
    pub fn resolve(request: &SelectionRequest, scene: &Scene) -> Result<(Self, Vec<Warning>)> {
        let mut warnings = Vec::new();
        let SceneRoots { roots, image_light, .. } =
            resolve_roots(request.scene.as_ref(), scene, &mut warnings)?;
        let clips = match &request.clips {
            ClipSelection::Each => return Err(one_of_each("animation", "clip")),
            ClipSelection::None => Vec::new(),
            ClipSelection::All => disjoint_clips(scene, &roots, &mut warnings),
            ClipSelection::One(selected) => vec![find_clip(selected, scene, &mut warnings)?],
            ClipSelection::Together(selected) => clips_together(selected, scene, &mut warnings)?,
        };
        let camera = resolve_camera(request.camera.as_ref(), scene, &roots, &mut warnings)?;
        let variant = resolve_variant(request.variant.as_ref(), scene, &mut warnings)?;
        let camera_changes = CameraChanges::default();
        let selection = Self { roots, clips, camera, camera_changes, image_light, variant };
        Ok((selection, warnings))
    }
}

/// The error of a request for several sequences where one is needed.
fn one_of_each(setting: &str, what: &str) -> Error {
    Error::setting(setting, format!("each makes several sequences, and here is one; name a {what}"))
}

fn resolve_roots(
    selected: Option<&NameOrIndex>,
    scene: &Scene,
    warnings: &mut Vec<Warning>,
) -> Result<SceneRoots> {
    let index = match selected {
        None => scene.default_scene,
        Some(selected) => {
            let names = scene.scenes.iter().map(|roots| roots.name.as_deref());
            find(&SCENE, selected, names, warnings)?
        }
    };
    Ok(scene.scenes.get(index).cloned().unwrap_or_default())
}

fn resolve_variant(
    request: Option<&VariantRequest>,
    scene: &Scene,
    warnings: &mut Vec<Warning>,
) -> Result<Option<VariantIndex>> {
    let names = scene.variants.iter().map(|variant| Some(variant.name.as_str()));
    let called_none = NameOrIndex::Name("none".to_owned());
    let selected = match request {
        Some(VariantRequest::Each) => return Err(one_of_each("variant", "variant")),
        // A variant of this name is selected by it, as by any other.
        Some(VariantRequest::None) if names.clone().any(|name| name == Some("none")) => &called_none,
        None | Some(VariantRequest::None) => return Ok(None),
        Some(VariantRequest::Variant(selected)) => selected,
    };
    let index = find(&VARIANT, selected, names, warnings)?;
    Ok(Some(VariantIndex::of(index)))
}

fn resolve_camera(
    request: Option<&CameraRequest>,
    scene: &Scene,
    roots: &[NodeIndex],
    warnings: &mut Vec<Warning>,
) -> Result<SelectedCamera> {
    let cameras = selected_cameras(scene, roots);
    match request {
        Some(CameraRequest::Auto) => Ok(SelectedCamera::Auto),
        Some(CameraRequest::Each) => Err(one_of_each("camera", "camera")),
        None => Ok(cameras.first().map_or(SelectedCamera::Auto, |&(_, node)| SelectedCamera::Node(node))),
        Some(CameraRequest::Camera(selected)) => {
            // Authoring tools show a camera under the name of its object, so the node's name is accepted as well.
            if let NameOrIndex::Name(name) = selected {
                let camera_name = |camera: CameraIndex| scene.cameras[camera.index()].name.as_ref();
                let node_name = |node: NodeIndex| scene.nodes[node.index()].name.as_ref();
                let mut named = cameras.clone();
                named.retain(|(camera, _)| camera_name(*camera) == Some(name));
                if named.is_empty() {
                    named.extend(cameras.iter().filter(|(_, node)| node_name(*node) == Some(name)));
                }
                if let Some(&(_, node)) = named.first() {
                    // Several nodes may show one camera, and an index selects the first of them.
                    named.dedup_by_key(|(camera, _)| *camera);
                    warnings.extend(CAMERA.ambiguity(name, named.iter().map(|(camera, _)| camera.index())));
                    return Ok(SelectedCamera::Node(node));
                }
            }
            let names: Vec<_> =
                (0..scene.cameras.len()).map(|camera| camera_or_node_name(scene, &cameras, camera)).collect();
            let index = find(&CAMERA, selected, names.iter().copied(), warnings)?;
            let node = cameras.iter().find(|(camera, _)| camera.index() == index);
            match node {
                Some(&(_, node)) => Ok(SelectedCamera::Node(node)),
                None => Err(Error::setting(
                    "camera",
                    format!(
                        "{} has no node in the selected scene; select another with `camera` or `scene_choice`, or set `camera` to auto",
                        label(index, scene.cameras[index].name.as_deref())
                    ),
                )),
            }
        }
    }
}

/// The camera's own name, or that of the first node that refers to it.
fn camera_or_node_name<'a>(
    scene: &'a Scene,
    cameras: &[(CameraIndex, NodeIndex)],
    camera: usize,
) -> Option<&'a str> {
    let node = cameras.iter().find(|(other, _)| other.index() == camera);
    let node_name = || scene.nodes[node?.1.index()].name.as_deref();
    scene.cameras[camera].name.as_deref().or_else(node_name)
}

/// The cameras of nodes below `roots`, ordered by camera, then by node.
pub(super) fn selected_cameras(scene: &Scene, roots: &[NodeIndex]) -> Vec<(CameraIndex, NodeIndex)> {
    let nodes = scene.nodes_below(roots).into_iter();
    let mut cameras: Vec<_> =
        nodes.filter_map(|index| Some((scene.nodes[index.index()].camera?, index))).collect();
    cameras.sort_unstable();
    cameras
}

impl Scene {
    /// The node of a name or index. Of several nodes with one name it is the first.
    pub fn node(&self, selected: &NameOrIndex) -> Option<NodeIndex> {
        let index = match selected {
            NameOrIndex::Name(name) => self.nodes.iter().position(|node| node.name.as_ref() == Some(name)),
            NameOrIndex::Index(index) => (*index < self.nodes.len()).then_some(*index),
        };
        index.map(|index| NodeIndex(index as u32))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::{
        Animation, AnimationIndex, AnimationTarget, Camera, Channel, Interpolation, Keyframes, Node,
        Projection, Variant,
    };

    pub(in crate::scene) fn clip(name: &str, targets: &[AnimationTarget]) -> Animation {
        let channel = |&target: &AnimationTarget| Channel {
            target,
            keyframes: Keyframes {
                times_seconds: vec![0.0],
                values: vec![0.0; 3],
                width: 3,
                interpolation: Interpolation::Step,
            },
        };
        Animation { name: Some(name.to_owned()), channels: targets.iter().map(channel).collect() }
    }

    fn camera(name: &str) -> Camera {
        let projection = Projection::Orthographic { x_mag: 1.0, y_mag: 1.0, z_near: 0.0, z_far: 1.0 };
        Camera { name: Some(name.to_owned()), projection }
    }

    /// Scene "empty" has no nodes; scene "main" has node 1 with camera 1 below node 0. Node 2 with camera 0 is in no scene.
    pub(in crate::scene) fn scene() -> Scene {
        let moves = |i| AnimationTarget::Translation(NodeIndex(i));
        let rotates = |i| AnimationTarget::Rotation(NodeIndex(i));
        let node = |camera: Option<u32>, children: &[u32]| Node {
            name: camera.map(|i| format!("object {i}")),
            camera: camera.map(CameraIndex),
            children: children.iter().copied().map(NodeIndex).collect(),
            ..Node::default()
        };
        let roots = |name: &str, roots: &[u32]| SceneRoots {
            name: Some(name.to_owned()),
            roots: roots.iter().copied().map(NodeIndex).collect(),
            image_light: None,
        };
        Scene {
            nodes: vec![node(None, &[1]), node(Some(1), &[]), node(Some(0), &[])],
            scenes: vec![roots("empty", &[]), roots("main", &[0])],
            default_scene: 1,
            cameras: vec![camera("loose"), camera("used")],
            variants: ["green", "red"].map(|name| Variant { name: name.to_owned() }).to_vec(),
            animations: vec![
                clip("a", &[moves(0)]),
                clip("b", &[moves(0), rotates(1)]),
                clip("c", &[rotates(1)]),
            ],
            ..Scene::default()
        }
    }

    #[test]
    fn defaults_are_the_first_camera_of_the_scene_and_disjoint_clips() {
        let (selection, warnings) = Selection::resolve(&SelectionRequest::default(), &scene()).unwrap();
        assert_eq!(selection.roots, [NodeIndex(0)]);
        assert_eq!(selection.camera, SelectedCamera::Node(NodeIndex(1)));
        // "b" is left out because of "a"; "c" stays, because "b" does not play.
        assert_eq!(selection.clips, [AnimationIndex(0), AnimationIndex(2)]);
        assert_eq!(warnings.len(), 1);
        assert_eq!(warnings[0].pointer, "/animations/1");
    }

    #[test]
    fn names_and_indices_are_found() {
        let request = SelectionRequest {
            scene: Some(NameOrIndex::Name("main".to_owned())),
            clips: ClipSelection::One(NameOrIndex::Index(1)),
            camera: Some(CameraRequest::Camera(NameOrIndex::Name("object 1".to_owned()))),
            variant: Some(VariantRequest::Variant(NameOrIndex::Name("red".to_owned()))),
        };
        let (selection, warnings) = Selection::resolve(&request, &scene()).unwrap();
        assert_eq!(selection.clips, [AnimationIndex(1)]);
        assert_eq!(selection.camera, SelectedCamera::Node(NodeIndex(1)));
        assert_eq!(selection.variant, Some(VariantIndex(1)));
        assert!(warnings.is_empty());
    }

    /// The warnings about a camera and a clip of these names.
    fn ambiguities(scene: &Scene, camera: &str, clip: &str) -> Vec<String> {
        let request = SelectionRequest {
            clips: ClipSelection::One(NameOrIndex::Name(clip.to_owned())),
            camera: Some(CameraRequest::Camera(NameOrIndex::Name(camera.to_owned()))),
            ..SelectionRequest::default()
        };
        let (_, warnings) = Selection::resolve(&request, scene).unwrap();
        warnings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn names_of_several_things_are_told() {
        let mut scene = scene();
        scene.animations = ["walk", "run", "walk", "walk"].map(|name| clip(name, &[])).to_vec();
        let clips = "/animations/0: 3 animations are called \"walk\", and the first one is used; `animation` '#2' selects the next one";
        assert_eq!(ambiguities(&scene, "used", "walk"), [clips]);
        assert!(ambiguities(&scene, "used", "run").is_empty());
        // A namesake outside the selected scene cannot be selected.
        scene.cameras[0].name = Some("used".to_owned());
        assert!(ambiguities(&scene, "used", "run").is_empty());
        scene.nodes[0].children.push(NodeIndex(2));
        let message = ambiguities(&scene, "used", "run").remove(0);
        assert!(message.starts_with("/cameras/0: 2 cameras are called \"used\""), "{message}");
        assert!(message.contains("`camera` '#1' selects"), "{message}");
        // Cameras without names go by those of their nodes.
        for i in 0..2 {
            scene.cameras[i].name = None;
            scene.nodes[i + 1].name = Some("eye".to_owned());
        }
        assert!(ambiguities(&scene, "eye", "run")[0].contains("2 cameras are called \"eye\""));
        // Two nodes with one camera are one.
        scene.nodes[2].camera = Some(CameraIndex(1));
        assert!(ambiguities(&scene, "eye", "run").is_empty());
    }

    #[test]
    fn none_is_no_variant_unless_one_is_called_so() {
        let request = SelectionRequest { variant: Some(VariantRequest::None), ..SelectionRequest::default() };
        let resolved = |names: &[&str]| {
            let variants = names.iter().map(|name| Variant { name: (*name).to_owned() }).collect();
            Selection::resolve(&request, &Scene { variants, ..scene() }).unwrap().0.variant
        };
        assert_eq!([resolved(&[]), resolved(&["red", "None"])], [None; 2]);
        assert_eq!(resolved(&["red", "none"]), Some(VariantIndex(1)));
    }

    #[test]
    fn numbers_that_are_no_names_are_indices() {
        let camera = Some(CameraRequest::Camera(NameOrIndex::Name("1".to_owned())));
        let clips = ClipSelection::One(NameOrIndex::Name("2".to_owned()));
        let request = SelectionRequest { clips, camera, ..SelectionRequest::default() };
        let (selection, _) = Selection::resolve(&request, &scene()).unwrap();
        assert_eq!(selection.camera, SelectedCamera::Node(NodeIndex(1)));
        assert_eq!(selection.clips, [AnimationIndex(2)]);
        let mut named = scene();
        named.animations[1].name = Some("2".to_owned());
        assert_eq!(Selection::resolve(&request, &named).unwrap().0.clips, [AnimationIndex(1)]);
    }

    #[test]
    fn a_scene_without_cameras_gets_an_automatic_one() {
        let request = SelectionRequest { scene: Some(NameOrIndex::Index(0)), ..SelectionRequest::default() };
        let (selection, _) = Selection::resolve(&request, &scene()).unwrap();
        assert_eq!(selection.camera, SelectedCamera::Auto);
        assert!(selection.roots.is_empty());
    }

    #[test]
    fn unknown_names_list_the_existing_ones() {
        let ask = |request: SelectionRequest| {
            let error = Selection::resolve(&request, &scene()).unwrap_err();
            assert_eq!(error.exit_code(), 2);
            error.to_string()
        };
        let camera = |selected| SelectionRequest {
            camera: Some(CameraRequest::Camera(selected)),
            ..SelectionRequest::default()
        };
        let message = ask(camera(NameOrIndex::Name("nobody".to_owned())));
        assert!(message.contains("#0 \"loose\", #1 \"used\""), "{message}");
        assert!(ask(camera(NameOrIndex::Name("loose".to_owned()))).contains("no node in the selected scene"));
        // A camera without a name is listed under the name of its node.
        let mut unnamed = scene();
        unnamed.cameras[1].name = None;
        let request = camera(NameOrIndex::Name("nobody".to_owned()));
        let message = Selection::resolve(&request, &unnamed).unwrap_err().to_string();
        assert!(message.contains("#1 \"object 1\""), "{message}");
        assert!(ask(camera(NameOrIndex::Index(2))).contains("no camera #2"));
        let clips = ClipSelection::One(NameOrIndex::Name("z".to_owned()));
        let message = ask(SelectionRequest { clips, ..SelectionRequest::default() });
        assert!(message.contains("#2 \"c\""), "{message}");
        let variant = Some(VariantRequest::Variant(NameOrIndex::Name("blue".to_owned())));
        let message = ask(SelectionRequest { variant, ..SelectionRequest::default() });
        assert!(message.contains("variant: ") && message.contains("#0 \"green\", #1 \"red\""), "{message}");
    }
}
