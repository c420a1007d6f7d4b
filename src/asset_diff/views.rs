//! The views in which two assets are rendered: which camera, clip, variant and frames.

use std::collections::BTreeSet;

use super::difference::AssetDifference;
use super::facts::AssetFacts;
use super::group_kind::GroupKind;
use crate::scene::{Animation, CameraIndex, Scene};
use crate::settings::{FrameRate, number_duplicates};

/// One camera at some times, for both assets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    /// Its name, unique among the views of two assets: `front`, `camera "close-up"`, `clip "walk"`.
    pub name: String,
    /// Frame numbers at 24 frames a second; frame 0 alone for a still.
    pub frames: Vec<i64>,
    /// The camera.
    pub(super) camera: ViewCamera,
    /// The clip that plays alone.
    pub(super) clip: Option<PairedIndex>,
    /// The material variant.
    pub(super) variant: Option<PairedIndex>,
}

/// The camera of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ViewCamera {
    /// A camera that both files have.
    OfFile(PairedIndex),
    /// The automatic camera of the reference.
    Front,
    /// The same from the other side.
    Back,
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

impl View {
    fn still(name: impl Into<String>, camera: ViewCamera) -> Self {
        Self { name: name.into(), frames: vec![0], camera, clip: None, variant: None }
    }
}

/// The views of two assets: stills without animation by every camera that both scenes have, or else from the front and, unless the
/// reference `is_interior`, from the back; then by the first of these cameras the first, the middle and the last frame of every clip
/// of the reference, and a still of every variant.
pub(super) fn views(sides: &Sides<'_>, is_interior: bool) -> Vec<View> {
    let [actual, reference] = sides.scenes;
    let standing = [actual, reference].map(Scene::cameras_of_default_scene);
    let stands = |side: usize, camera: usize| standing[side].contains(&CameraIndex(camera as u32));
    let cameras = paired(sides, GroupKind::Cameras).into_iter();
    let cameras = cameras
        .filter(|(pair, _)| stands(0, pair.actual) && stands(1, pair.reference))
        .map(|(pair, name)| View::still(format!("camera \"{name}\""), ViewCamera::OfFile(pair)));
    let mut views: Vec<_> = cameras.collect();
    if views.is_empty() {
        views.push(View::still("front", ViewCamera::Front));
        if !is_interior {
            views.push(View::still("back", ViewCamera::Back));
        }
    }
    let camera = views[0].camera;
    for (pair, name) in paired(sides, GroupKind::Clips) {
        let frames = reference.animations.get(pair.reference).map_or(vec![0], clip_frames);
        let clip = View { frames, clip: Some(pair), ..View::still(format!("clip \"{name}\""), camera) };
        views.push(clip);
    }
    for (pair, name) in paired(sides, GroupKind::Variants) {
        views.push(View { variant: Some(pair), ..View::still(format!("variant \"{name}\""), camera) });
    }
    number_duplicates(views.iter_mut().map(|view| &mut view.name));
    views
}

/// Things that both files have, with their names in the reference.
fn paired(sides: &Sides<'_>, group: GroupKind) -> Vec<(PairedIndex, String)> {
    let items = sides.reference.items(group);
    let pairs = sides.difference.matchings.get(&group).map_or(&[][..], |matching| &matching.pairs);
    let named = pairs
        .iter()
        .map(|&(actual, reference)| (PairedIndex { actual, reference }, items[reference].name.clone()));
    named.collect()
}

/// The first, the middle and the last frame.
fn clip_frames(clip: &Animation) -> Vec<i64> {
    let last = FrameRate::FILM.last_frame(clip.duration_seconds());
    BTreeSet::from([0, last / 2, last]).into_iter().collect()
}
