//! Which of a file's scenes, clips and cameras are shown.

use std::collections::BTreeSet;

use glam::Mat4;

use super::{
    AnimationIndex, AnimationTarget, CameraIndex, ImageLightIndex, NodeIndex, Projection, Scene, SceneRoots,
    VariantIndex,
};
use crate::error::{Error, Result, Warning};

/// One of several things in a file, as a user names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NameOrIndex {
    /// By name.
    Name(String),
    /// By position in the file, from 0.
    Index(usize),
}

/// Which clips play, as a user asks for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ClipSelection {
    /// All whose targets no earlier clip holds.
    #[default]
    All,
    /// None: the scene stands still.
    None,
    /// One.
    One(NameOrIndex),
}

/// What a user asks to see.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SelectionRequest {
    /// Which set of roots; `None` is the file's default.
    pub scene: Option<NameOrIndex>,
    /// Which clips.
    pub clips: ClipSelection,
    /// Which camera; `None` is the first that the scene places, else automatic framing.
    pub camera: Option<CameraRequest>,
    /// Which set of materials; `None` is what primitives have without one.
    pub variant: Option<NameOrIndex>,
}

/// Which camera a user asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraRequest {
    /// Frame the whole scene.
    Auto,
    /// One of the file's.
    Placed(NameOrIndex),
}

/// Which camera looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SelectedCamera {
    /// One that frames the whole scene over the selected clips.
    Auto,
    /// The camera of this node.
    Node(NodeIndex),
    /// One that stands still, such as an automatic one that was resolved.
    Fixed {
        /// Rotation and translation; columns are right, up, backward, position.
        world_from_camera: Mat4,
        /// Its projection.
        projection: Projection,
    },
}

/// What is shown, resolved against one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Roots that are drawn.
    pub roots: Vec<NodeIndex>,
    /// Clips that play together; their targets are disjoint.
    pub clips: Vec<AnimationIndex>,
    /// The camera.
    pub camera: SelectedCamera,
    /// The surroundings that the chosen set of roots asks for.
    pub image_light: Option<ImageLightIndex>,
    /// The set of materials.
    pub variant: Option<VariantIndex>,
}

impl Selection {
    /// Whether a clip moves the image-based light that is shown.
    pub fn moves_image_light(&self, scene: &Scene) -> bool {
        let moves = |target| matches!(target, AnimationTarget::ImageLight(light, _) if Some(light) == self.image_light);
        let clips = self.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
        clips.flat_map(|clip| &clip.channels).any(|channel| moves(channel.target))
    }

    /// Finds in `scene` what `request` asks for. A clip that `request` asks for only by asking for all, and one of
    /// whose targets an earlier clip moves, is left out with a warning.
    ///
    /// # Errors
    ///
    /// [`Error::Usage`] when a name or position does not exist; the message lists what does.
    pub fn resolve(request: &SelectionRequest, scene: &Scene) -> Result<(Self, Vec<Warning>)> {
        let SceneRoots { roots, image_light, .. } = resolve_roots(request.scene.as_ref(), scene)?;
        let (clips, warnings) = match &request.clips {
            ClipSelection::None => (Vec::new(), Vec::new()),
            ClipSelection::All => disjoint_clips(scene),
            ClipSelection::One(choice) => {
                let names = scene.animations.iter().map(|clip| clip.name.as_deref());
                let clip = find("animation", "--animation", choice, names)?;
                (vec![AnimationIndex(subscript(clip))], Vec::new())
            }
        };
        let camera = resolve_camera(request.camera.as_ref(), scene, &roots)?;
        let variant = resolve_variant(request.variant.as_ref(), scene)?;
        let selection = Self { roots, clips, camera, image_light, variant };
        Ok((selection, warnings))
    }

    /// The camera for messages: `camera "name"`, `camera #2` where it has no name, or `camera auto`.
    pub fn camera_label(&self, scene: &Scene) -> String {
        let SelectedCamera::Node(node) = self.camera else {
            return "camera auto".to_owned();
        };
        let node = scene.nodes.get(node.index());
        let index = node.and_then(|node| node.camera).map_or(0, CameraIndex::index);
        let camera_name = scene.cameras.get(index).and_then(|camera| camera.name.as_deref());
        match camera_name.or_else(|| node.and_then(|node| node.name.as_deref())) {
            Some(name) => format!("camera \"{name}\""),
            None => format!("camera #{index}"),
        }
    }
}

fn resolve_roots(choice: Option<&NameOrIndex>, scene: &Scene) -> Result<SceneRoots> {
    let index = match choice {
        None => scene.default_scene,
        Some(choice) => {
            let names = scene.scenes.iter().map(|roots| roots.name.as_deref());
            find("scene", "--scene", choice, names)?
        }
    };
    Ok(scene.scenes.get(index).cloned().unwrap_or_default())
}

fn resolve_variant(choice: Option<&NameOrIndex>, scene: &Scene) -> Result<Option<VariantIndex>> {
    let Some(choice) = choice else {
        return Ok(None);
    };
    let names = scene.variants.iter().map(|variant| Some(variant.name.as_str()));
    let index = find("variant", "--variant", choice, names)?;
    Ok(Some(VariantIndex(subscript(index))))
}

/// All clips but those one of whose targets an earlier chosen clip moves.
fn disjoint_clips(scene: &Scene) -> (Vec<AnimationIndex>, Vec<Warning>) {
    let mut clips = Vec::new();
    let mut warnings = Vec::new();
    let mut held: BTreeSet<AnimationTarget> = BTreeSet::new();
    for (i, clip) in scene.animations.iter().enumerate() {
        if clip.channels.iter().any(|channel| channel.target.clashes(&held)) {
            warnings.push(Warning {
                pointer: format!("/animations/{i}"),
                message: format!(
                    "the clip {} moves what an earlier one moves and is left out; show it with --animation '#{i}'",
                    label(i, clip.name.as_deref())
                ),
            });
            continue;
        }
        held.extend(clip.channels.iter().map(|channel| channel.target));
        clips.push(AnimationIndex(subscript(i)));
    }
    (clips, warnings)
}

fn resolve_camera(
    request: Option<&CameraRequest>,
    scene: &Scene,
    roots: &[NodeIndex],
) -> Result<SelectedCamera> {
    let placed = placed_cameras(scene, roots);
    match request {
        Some(CameraRequest::Auto) => Ok(SelectedCamera::Auto),
        None => Ok(placed.first().map_or(SelectedCamera::Auto, |&(_, node)| SelectedCamera::Node(node))),
        Some(CameraRequest::Placed(choice)) => {
            // Artists know cameras by the name of the object that holds them, so that counts too.
            if let NameOrIndex::Name(name) = choice {
                let camera_name = |camera: CameraIndex| scene.cameras[camera.index()].name.as_ref();
                let node_name = |node: NodeIndex| scene.nodes[node.index()].name.as_ref();
                let by_camera = placed.iter().find(|(camera, _)| camera_name(*camera) == Some(name));
                let by_node = placed.iter().find(|(_, node)| node_name(*node) == Some(name));
                if let Some(&(_, node)) = by_camera.or(by_node) {
                    return Ok(SelectedCamera::Node(node));
                }
            }
            let names: Vec<_> =
                (0..scene.cameras.len()).map(|camera| camera_or_node_name(scene, &placed, camera)).collect();
            let index = find("camera", "--camera", choice, names.iter().copied())?;
            let node = placed.iter().find(|(camera, _)| camera.index() == index);
            match node {
                Some(&(_, node)) => Ok(SelectedCamera::Node(node)),
                None => Err(Error::usage(format!(
                    "camera {} is not placed in the chosen scene; choose another with --camera or --scene, or --camera auto",
                    label(index, scene.cameras[index].name.as_deref())
                ))),
            }
        }
    }
}

/// The camera's own name, else that of the first node that holds it.
fn camera_or_node_name<'a>(
    scene: &'a Scene,
    placed: &[(CameraIndex, NodeIndex)],
    camera: usize,
) -> Option<&'a str> {
    let node = placed.iter().find(|(placed, _)| placed.index() == camera);
    let node_name = || scene.nodes[node?.1.index()].name.as_deref();
    scene.cameras[camera].name.as_deref().or_else(node_name)
}

/// The cameras on nodes that `roots` reach, by camera, then by node.
fn placed_cameras(scene: &Scene, roots: &[NodeIndex]) -> Vec<(CameraIndex, NodeIndex)> {
    let mut placed = Vec::new();
    let mut pending = roots.to_vec();
    while let Some(index) = pending.pop() {
        let node = &scene.nodes[index.index()];
        placed.extend(node.camera.map(|camera| (camera, index)));
        pending.extend(&node.children);
    }
    placed.sort_unstable();
    placed
}

/// The position of what `choice` names among `names`.
fn find<'a>(
    what: &str,
    option: &str,
    choice: &NameOrIndex,
    names: impl ExactSizeIterator<Item = Option<&'a str>> + Clone,
) -> Result<usize> {
    let (found, asked) = match choice {
        NameOrIndex::Name(name) => {
            // A number that nobody is called is a position: shells take # for a comment.
            let as_position = || name.parse().ok().filter(|&i: &usize| i < names.len());
            let found = names.clone().position(|other| other == Some(name)).or_else(as_position);
            (found, format!("\"{name}\""))
        }
        NameOrIndex::Index(index) => (Some(*index).filter(|&i| i < names.len()), format!("#{index}")),
    };
    found.ok_or_else(|| {
        let choices: Vec<String> = names.enumerate().map(|(i, name)| label(i, name)).collect();
        let choices = if choices.is_empty() {
            "the file has none".to_owned()
        } else {
            format!("choose one of: {}", choices.join(", "))
        };
        Error::usage(format!("{option}: there is no {what} {asked}; {choices}"))
    })
}

fn label(index: usize, name: Option<&str>) -> String {
    name.map_or_else(|| format!("#{index}"), |name| format!("#{index} \"{name}\""))
}

fn subscript(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

impl Scene {
    /// The node that is meant; of several with one name the first.
    pub fn node(&self, choice: &NameOrIndex) -> Option<NodeIndex> {
        let index = match choice {
            NameOrIndex::Name(name) => self.nodes.iter().position(|node| node.name.as_ref() == Some(name)),
            NameOrIndex::Index(index) => (*index < self.nodes.len()).then_some(*index),
        };
        index.map(|index| NodeIndex(index as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Animation, Camera, Channel, Interpolation, Keyframes, Node, Projection, Variant};

    fn clip(name: &str, targets: &[AnimationTarget]) -> Animation {
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

    /// Scene "empty" has nothing; scene "main" has node 1 with camera 1 below node 0. Node 2 with camera 0 is loose.
    fn scene() -> Scene {
        let moves = |i| AnimationTarget::Translation(NodeIndex(i));
        let turns = |i| AnimationTarget::Rotation(NodeIndex(i));
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
                clip("b", &[moves(0), turns(1)]),
                clip("c", &[turns(1)]),
            ],
            ..Scene::default()
        }
    }

    #[test]
    fn defaults_take_the_first_placed_camera_and_disjoint_clips() {
        let (selection, warnings) = Selection::resolve(&SelectionRequest::default(), &scene()).unwrap();
        assert_eq!(selection.roots, [NodeIndex(0)]);
        assert_eq!(selection.camera, SelectedCamera::Node(NodeIndex(1)));
        // "b" is left out because of "a"; "c" stays, because "b" does not play.
        assert_eq!(selection.clips, [AnimationIndex(0), AnimationIndex(2)]);
        assert_eq!(warnings.len(), 1);
        assert_eq!(warnings[0].pointer, "/animations/1");
    }

    #[test]
    fn names_and_positions_are_found() {
        let request = SelectionRequest {
            scene: Some(NameOrIndex::Name("main".to_owned())),
            clips: ClipSelection::One(NameOrIndex::Index(1)),
            camera: Some(CameraRequest::Placed(NameOrIndex::Name("object 1".to_owned()))),
            variant: Some(NameOrIndex::Name("red".to_owned())),
        };
        let (selection, warnings) = Selection::resolve(&request, &scene()).unwrap();
        assert_eq!(selection.clips, [AnimationIndex(1)]);
        assert_eq!(selection.camera, SelectedCamera::Node(NodeIndex(1)));
        assert_eq!(selection.variant, Some(VariantIndex(1)));
        assert!(warnings.is_empty());
    }

    #[test]
    fn numbers_that_are_no_names_are_positions() {
        let camera = Some(CameraRequest::Placed(NameOrIndex::Name("1".to_owned())));
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
    fn a_scene_without_cameras_is_framed() {
        let request = SelectionRequest { scene: Some(NameOrIndex::Index(0)), ..SelectionRequest::default() };
        let (selection, _) = Selection::resolve(&request, &scene()).unwrap();
        assert_eq!(selection.camera, SelectedCamera::Auto);
        assert!(selection.roots.is_empty());
    }

    #[test]
    fn what_does_not_exist_lists_the_choices() {
        let ask = |request: SelectionRequest| {
            let error = Selection::resolve(&request, &scene()).unwrap_err();
            assert_eq!(error.exit_code(), 2);
            error.to_string()
        };
        let camera = |choice| SelectionRequest {
            camera: Some(CameraRequest::Placed(choice)),
            ..SelectionRequest::default()
        };
        let message = ask(camera(NameOrIndex::Name("nobody".to_owned())));
        assert!(message.contains("#0 \"loose\", #1 \"used\""), "{message}");
        assert!(ask(camera(NameOrIndex::Name("loose".to_owned()))).contains("not placed"));
        // A camera without a name is listed under that of its node.
        let mut unnamed = scene();
        unnamed.cameras[1].name = None;
        let request = camera(NameOrIndex::Name("nobody".to_owned()));
        let message = Selection::resolve(&request, &unnamed).unwrap_err().to_string();
        assert!(message.contains("#1 \"object 1\""), "{message}");
        assert!(ask(camera(NameOrIndex::Index(2))).contains("no camera #2"));
        let clips = ClipSelection::One(NameOrIndex::Name("z".to_owned()));
        let message = ask(SelectionRequest { clips, ..SelectionRequest::default() });
        assert!(message.contains("#2 \"c\""), "{message}");
        let variant = Some(NameOrIndex::Name("blue".to_owned()));
        let message = ask(SelectionRequest { variant, ..SelectionRequest::default() });
        assert!(message.contains("--variant") && message.contains("#0 \"green\", #1 \"red\""), "{message}");
    }
}
