//! The requested view of a shot, and its frames.

use crate::error::{Error, Result, Warning};
use crate::framing::NamedView;
use crate::scene::{
    AnimationIndex, CameraRequest, LensRequest, NameOrIndex, NamedKind, NodeIndex, Scene, SelectedCamera,
    Selection, Target, TurntableRequest, ViewRequest,
};
use crate::settings::{FocusRequest, FrameRate, FrameSpec, LookAt, SettingValues, field_of_view_of, suggest};

/// The view that the settings ask for.
pub(super) fn view_request(
    args: &SettingValues,
    scene: &Scene,
    measured_clips: Vec<AnimationIndex>,
) -> Result<ViewRequest> {
    let field_of_view = args.fov.or_else(|| args.focal_length.map(field_of_view_of));
    let node = |setting, name| named_node(scene, setting, name, "'#0' for the first node, or a name");
    Ok(ViewRequest {
        orbit: args.orbit.or_else(|| args.view.map(NamedView::orbit)),
        position: args.camera_position,
        target: match &args.look_at {
            None => None,
            Some(LookAt::Point(point)) if args.camera_position == Some(*point) => {
                let why = "is the position of the camera, which gives no direction; move one of the two";
                return Err(Error::setting("look_at", why));
            }
            Some(LookAt::Point(point)) => Some(Target::Point(*point)),
            Some(LookAt::Node(name)) => Some(Target::Node(node("look_at", name)?)),
        },
        up: args.up,
        roll_degrees: args.roll,
        lens: match field_of_view {
            _ if args.ortho => Some(LensRequest::Orthographic),
            degrees => degrees.map(LensRequest::FieldOfView),
        },
        node: args.frame_node.as_ref().map(|name| node("frame_node", name)).transpose()?,
        measured_clips,
        turntable: args.turntable.map(|frames| TurntableRequest {
            elevation_degrees: Some(args.elevation),
            turn_seconds: args.fps.time_seconds(i64::from(frames)),
        }),
        keeps_camera: matches!(args.camera, Some(CameraRequest::Camera(_) | CameraRequest::Each)),
    })
}

/// The frames of a shot whose animation has the last frame `last`: those of one turn on a turntable.
pub(super) fn resolve_frames(
    args: &SettingValues,
    frames: &FrameSpec,
    last: i64,
) -> std::result::Result<Vec<i64>, String> {
    frames.resolve(args.turntable.map_or(last, |frames| i64::from(frames) - 1))
}

/// The last frame of clips and camera path. A loop of the camera ends before its first frame comes again.
pub(super) fn last_frame(rate: FrameRate, scene: &Scene, selection: &Selection) -> i64 {
    let of_clips = rate.last_frame(selection.clip_seconds(scene));
    let SelectedCamera::Path(path) = &selection.camera else {
        return of_clips;
    };
    let seconds = path.duration_seconds;
    let of_path = rate.last_frame(seconds as f32);
    // A thousandth of a frame is rounding.
    let repeats =
        path.is_loop && of_path > 0 && rate.time_seconds(of_path) > seconds - rate.time_seconds(1) * 1e-3;
    of_clips.max(of_path - i64::from(repeats))
}

/// The node that a setting names; `forms` says what else may be written.
pub(super) fn named_node(
    scene: &Scene,
    setting: &'static str,
    name: &NameOrIndex,
    forms: &str,
) -> Result<NodeIndex> {
    let text = match name {
        NameOrIndex::Name(name) => name.clone(),
        NameOrIndex::Index(index) => format!("#{index}"),
    };
    scene.node(name).ok_or_else(|| {
        let names = suggest(&text, scene.nodes.iter().filter_map(|node| node.name.as_deref()));
        let text = text.escape_debug();
        Error::setting(setting, format!("the scene has no node \"{text}\"; write {forms}: {names}"))
    })
}

/// A warning for each setting whose name several nodes have. The first of them is used.
pub(super) fn ambiguous_nodes(args: &SettingValues, scene: &Scene) -> Vec<Warning> {
    let target = match &args.look_at {
        Some(LookAt::Node(node)) => Some(node),
        _ => None,
    };
    let focus = match &args.focus {
        FocusRequest::Node(node) => Some(node),
        _ => None,
    };
    let selected = [("look_at", target), ("frame_node", args.frame_node.as_ref()), ("focus", focus)];
    let warning = |(setting, selected): (_, Option<&NameOrIndex>)| {
        let NameOrIndex::Name(name) = selected? else { return None };
        let nodes = scene.nodes.iter().enumerate().filter(|(_, node)| node.name.as_ref() == Some(name));
        let kind = NamedKind { noun: "node", setting, pointer: "/nodes" };
        kind.ambiguity(name, nodes.map(|(i, _)| i))
    };
    selected.into_iter().filter_map(warning).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Node;
    use crate::settings::Settings;

    #[test]
    fn names_of_several_nodes_are_told() {
        let name = |name: &str| NameOrIndex::Name(name.to_owned());
        let node = |name: &str| Node { name: Some(name.to_owned()), ..Node::default() };
        let nodes = ["arm", "eye", "eye", "arm", "hand"].map(node).to_vec();
        let scene = Scene { nodes, ..Scene::default() };
        let args = SettingValues {
            look_at: Some(LookAt::Node(name("arm"))),
            frame_node: Some(name("eye")),
            focus: FocusRequest::Node(name("arm")),
            ..Settings::default().values()
        };
        let messages: Vec<_> = ambiguous_nodes(&args, &scene).iter().map(ToString::to_string).collect();
        let told = |first, name, setting, second| {
            format!(
                "/nodes/{first}: 2 nodes are called \"{name}\", and the first one is used; `{setting}` '#{second}' selects the next one"
            )
        };
        let expected =
            [told(0, "arm", "look_at", 3), told(1, "eye", "frame_node", 2), told(0, "arm", "focus", 3)];
        assert_eq!(messages, expected);
        let args = SettingValues {
            look_at: Some(LookAt::Node(name("hand"))),
            frame_node: Some(NameOrIndex::Index(1)),
            ..Settings::default().values()
        };
        assert!(ambiguous_nodes(&args, &scene).is_empty());
        assert!(ambiguous_nodes(&Settings::default().values(), &scene).is_empty());
    }
}
