//! The views in which two assets are rendered: which camera, clip, variant and frames.

use std::collections::BTreeSet;

use super::difference::AssetDifference;
use super::facts::AssetFacts;
use super::group_kind::GroupKind;
use crate::scene::{Animation, CameraIndex, Scene, make_unique_for_files};
use crate::settings::{FrameRate, first_middle_last};
use crate::shot::default_views::{DefaultCamera, DefaultView, Elements, default_views};

/// One camera at some times, for both assets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    /// Its name, unique among the views of two assets: `three-quarter`, `camera "close-up"`, `clip "walk"`.
    pub name: String,
    /// Frame numbers at 24 frames a second; frame 0 alone for a still.
    pub frames: Vec<i64>,
    /// The camera.
    pub(super) camera: DefaultCamera<PairedIndex>,
    /// The clip that plays alone.
    pub(super) clip: Option<PairedIndex>,
    /// The material variant.
    pub(super) variant: Option<PairedIndex>,
}

/// Indices of one thing in both files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PairedIndex {
    pub(super) actual: usize,
    pub(super) reference: usize,
}

/// The two assets that are viewed.
pub(super) struct Sides<'a> {
    pub(super) scenes: [&'a Scene; 2],
    pub(super) reference: &'a AssetFacts,
    pub(super) difference: &'a AssetDifference,
}

/// The views of two assets: the default views of what both have, by the cameras that stand in both scenes.
pub(super) fn views(sides: &Sides<'_>, is_interior: bool) -> Vec<View> {
    let standing = sides.scenes.map(Scene::cameras_of_default_scene);
    let stands = |side: usize, camera: usize| standing[side].contains(&CameraIndex(camera as u32));
    let mut cameras = paired(sides, GroupKind::Cameras);
    cameras.retain(|(_, pair)| stands(0, pair.actual) && stands(1, pair.reference));
    let elements = Elements {
        cameras,
        clips: paired(sides, GroupKind::Clips),
        variants: paired(sides, GroupKind::Variants),
    };
    let mut views: Vec<_> =
        default_views(elements, is_interior).into_iter().map(|view| of_default(sides, view)).collect();
    make_unique_for_files(views.iter_mut().map(|view| &mut view.name));
    views
}

fn of_default(sides: &Sides<'_>, view: DefaultView<PairedIndex>) -> View {
    let DefaultView { name, camera, clip, variant } = view;
    let [_, reference] = sides.scenes;
    let frames = clip.and_then(|clip| reference.animations.get(clip.reference)).map_or(vec![0], clip_frames);
    let name = match (clip, variant, camera) {
        (Some(_), _, _) => format!("clip \"{name}\""),
        (_, Some(_), _) => format!("variant \"{name}\""),
        (_, _, DefaultCamera::OfFile(_)) => format!("camera \"{name}\""),
        _ => name,
    };
    View { name, frames, camera, clip, variant }
}

/// Things that both files have, with their names in the reference.
fn paired(sides: &Sides<'_>, group: GroupKind) -> Vec<(String, PairedIndex)> {
    let items = sides.reference.items(group);
    let pairs = sides.difference.matchings.get(&group).map_or(&[][..], |matching| &matching.pairs);
    let named = pairs
        .iter()
        .map(|&(actual, reference)| (items[reference].name.clone(), PairedIndex { actual, reference }));
    named.collect()
}

/// The first, the middle and the last frame.
fn clip_frames(clip: &Animation) -> Vec<i64> {
    let last = FrameRate::FILM.last_frame(clip.duration_seconds());
    BTreeSet::from(first_middle_last(last)).into_iter().collect()
}
