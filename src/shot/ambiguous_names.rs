//! Names of the settings that several things of a scene have.

use std::iter::once;

use crate::error::Warning;
use crate::scene::{CameraRequest, ClipSelection, NameOrIndex, Scene};
use crate::settings::{FocusRequest, LookAt, SettingValues};

/// A warning for each name of the settings that several things of its kind have. The first of them is used.
pub(super) fn ambiguous_names(args: &SettingValues, scene: &Scene) -> Vec<Warning> {
    let clip = match &args.animation {
        ClipSelection::One(clip) => Some(clip),
        _ => None,
    };
    let target = match &args.look_at {
        Some(LookAt::Node(node)) => Some(node),
        _ => None,
    };
    let focus = match &args.focus {
        FocusRequest::Node(node) => Some(node),
        _ => None,
    };
    let scenes = scene.scenes.iter().map(|roots| roots.name.as_deref());
    let clips = scene.animations.iter().map(|clip| clip.name.as_deref());
    let variants = scene.variants.iter().map(|variant| Some(variant.name.as_str()));
    let nodes = || scene.nodes.iter().map(|node| node.name.as_deref());
    let scenes = warning(("scene_choice", "scenes", "/scenes"), args.scene_choice.as_ref(), scenes);
    let clips = warning(("animation", "animations", "/animations"), clip, clips);
    let variants = warning(
        ("variant", "variants", "/extensions/KHR_materials_variants/variants"),
        args.variant.as_ref(),
        variants,
    );
    let camera = once(camera_warning(args, scene));
    let named_nodes = [("look_at", target), ("frame_node", args.frame_node.as_ref()), ("focus", focus)];
    let named_nodes = named_nodes.map(|(setting, name)| warning((setting, "nodes", "/nodes"), name, nodes()));
    [scenes, clips, variants].into_iter().chain(camera).chain(named_nodes).flatten().collect()
}

/// The warning about a name among `names`, all of one kind in the order of their indices.
fn warning<'a>(
    (setting, kind, pointer): (&str, &str, &str),
    selected: Option<&NameOrIndex>,
    names: impl Iterator<Item = Option<&'a str>>,
) -> Option<Warning> {
    let Some(NameOrIndex::Name(name)) = selected else { return None };
    let mut indices = names.enumerate().filter(|(_, other)| *other == Some(name)).map(|(index, _)| index);
    let (first, second) = (indices.next()?, indices.next()?);
    let count = 2 + indices.count();
    let name = name.escape_debug();
    Some(Warning {
        pointer: format!("{pointer}/{first}"),
        message: format!(
            "{count} {kind} are called \"{name}\", and the first one is used; `{setting}` '#{second}' selects the next one"
        ),
    })
}

/// The same for cameras: a camera's own name goes before those of its nodes.
fn camera_warning(args: &SettingValues, scene: &Scene) -> Option<Warning> {
    let Some(CameraRequest::Camera(selected)) = &args.camera else { return None };
    let about = ("camera", "cameras", "/cameras");
    let own = scene.cameras.iter().map(|camera| camera.name.as_deref());
    let NameOrIndex::Name(name) = selected else { return None };
    if own.clone().any(|own| own == Some(name)) {
        return warning(about, Some(selected), own);
    }
    let of_node = |camera: usize| {
        let mut nodes =
            scene.nodes.iter().filter(|node| node.camera.is_some_and(|own| own.index() == camera));
        nodes.find(|node| node.name.as_ref() == Some(name))?.name.as_deref()
    };
    warning(about, Some(selected), (0..scene.cameras.len()).map(of_node))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Animation, Camera, CameraIndex, Node, Projection};
    use crate::settings::Settings;

    fn clip(name: &str) -> Animation {
        Animation { name: Some(name.to_owned()), channels: Vec::new() }
    }

    fn scene() -> Scene {
        let projection = Projection::Orthographic { x_mag: 1.0, y_mag: 1.0, z_near: 0.0, z_far: 1.0 };
        let camera = |name: Option<&str>| Camera { name: name.map(str::to_owned), projection };
        let node = |name: &str, camera: Option<u32>| Node {
            name: Some(name.to_owned()),
            camera: camera.map(CameraIndex),
            ..Node::default()
        };
        Scene {
            animations: vec![clip("walk"), clip("run"), clip("walk"), clip("walk")],
            cameras: vec![camera(Some("left")), camera(None), camera(None), camera(Some("left"))],
            nodes: vec![
                node("arm", Some(0)),
                node("eye", Some(1)),
                node("eye", Some(2)),
                node("arm", Some(3)),
                node("hand", None),
            ],
            ..Scene::default()
        }
    }

    fn messages(args: &SettingValues) -> Vec<String> {
        ambiguous_names(args, &scene()).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn names_of_several_things_are_told() {
        let name = |name: &str| NameOrIndex::Name(name.to_owned());
        let args = SettingValues {
            animation: ClipSelection::One(name("walk")),
            camera: Some(CameraRequest::Camera(name("left"))),
            look_at: Some(LookAt::Node(name("arm"))),
            frame_node: Some(name("eye")),
            focus: FocusRequest::Node(name("arm")),
            ..Settings::default().values()
        };
        let messages = messages(&args);
        assert_eq!(messages.len(), 5, "{messages:?}");
        assert_eq!(
            messages[0],
            "/animations/0: 3 animations are called \"walk\", and the first one is used; `animation` '#2' selects the next one"
        );
        for (message, begin) in messages[1..].iter().zip([
            "/cameras/0: 2 cameras are called \"left\"",
            "/nodes/0: 2 nodes are called \"arm\"",
            "/nodes/1: 2 nodes are called \"eye\"",
            "/nodes/0: 2 nodes are called \"arm\"",
        ]) {
            assert!(message.starts_with(begin), "{message}");
        }
        // Cameras without names go by those of their nodes.
        let args = SettingValues {
            camera: Some(CameraRequest::Camera(name("eye"))),
            ..Settings::default().values()
        };
        assert!(self::messages(&args)[0].contains("'#2' selects"), "{:?}", self::messages(&args));
    }

    #[test]
    fn indices_and_unique_names_are_not() {
        let args = SettingValues {
            animation: ClipSelection::One(NameOrIndex::Name("run".to_owned())),
            camera: Some(CameraRequest::Camera(NameOrIndex::Index(0))),
            look_at: Some(LookAt::Node(NameOrIndex::Name("hand".to_owned()))),
            frame_node: Some(NameOrIndex::Index(1)),
            ..Settings::default().values()
        };
        assert!(messages(&args).is_empty());
        assert!(messages(&Settings::default().values()).is_empty());
    }
}
