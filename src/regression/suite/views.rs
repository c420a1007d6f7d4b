//! The views of a shot that the suite covers: combinations of cameras, named views, clips and variants.

use std::ffi::OsStr;

use super::SuiteShot;
use super::coverage::{Coverage, Covered};
use crate::error::Result;
use crate::framing::{NamedView, is_interior};
use crate::scene::{
    AnimationIndex, CameraRequest, ClipSelection, NameOrIndex, Scene, VariantRequest, make_unique_for_files,
};
use crate::settings::{
    BackgroundSource, DEFINITIONS, FrameSpec, Named as _, NamedFrame, Settings, file_name_part,
};
use crate::shot::default_views::{DefaultCamera, DefaultView, Elements, default_views};
use crate::shot::{ShotSettings, ViewSettings, is_shot};

/// Frames of a clip that are tested by default.
const FRAMES_OF_CLIP: [NamedFrame; 3] = [NamedFrame::First, NamedFrame::Middle, NamedFrame::Last];
/// Bytes of a name of the file in the name of an image.
const MAX_LABEL_BYTES: usize = 60;
/// Settings that choose what of a scene is seen. A scene without a shot file is covered unless the suite has one of them.
const CHOOSING: [&str; 17] = [
    "frames",
    "all",
    "start",
    "end",
    "step",
    "camera",
    "orbit",
    "view",
    "camera_position",
    "look_at",
    "frame_node",
    "camera_path",
    "turntable",
    "elevation",
    "animation",
    "scene_choice",
    "variant",
];
/// Settings that make another view of a camera of the file.
const OTHER_VIEWS: &[&str] = &["orbit", "view", "camera_position", "look_at", "frame_node"];
/// Those on a turntable, which begins where the camera is: the others say what it turns about.
const OTHER_VIEWS_OF_TURNTABLE: &[&str] = &["orbit", "view", "camera_position"];
/// The setting by which a view has the lens of a camera of the file.
const CAMERA_OF_FILE: &[&str] = &["camera"];

/// The views of a shot that the suite covers, with distinct labels.
pub(super) fn views_of(
    shot: &SuiteShot,
    coverage: &Coverage,
    settings: &ShotSettings,
    scene: &Scene,
) -> Result<Vec<View>> {
    let is_default = coverage.is_empty()
        && !is_shot(&shot.path)
        && !has_image_sequence(settings)
        && !chooses(&settings.settings);
    let mut views = if is_default { whole_scene(scene)? } else { combinations(coverage, settings, scene) };
    make_unique_for_files(views.iter_mut().map(|view| &mut view.label));
    Ok(views)
}

/// Whether an image for each frame lies behind the scene, of which those of all clips' frames may not be there.
fn has_image_sequence(shot: &ShotSettings) -> bool {
    matches!(&shot.values.background, BackgroundSource::Plate(plate) if plate.is_numbered())
}

fn chooses(settings: &Settings) -> bool {
    DEFINITIONS
        .iter()
        .any(|definition| CHOOSING.contains(&definition.name) && definition.origin(settings).is_some())
}

/// What is set for a view, on top of the shot.
#[derive(Clone, Debug, Default)]
pub(super) struct View {
    /// Its part of the names of its images.
    pub(super) label: String,
    pub(super) level: ViewSettings,
}

impl View {
    /// The whole shot, at `frames`.
    fn whole(frames: Option<&[NamedFrame]>) -> Self {
        let frames = frames.map(|frames| FrameSpec::Named(frames.to_vec()).into());
        let settings = Settings { frames, ..Settings::default() };
        Self { label: String::new(), level: ViewSettings { settings, without: &[] } }
    }

    /// The view with another setting, and its name.
    fn and(&self, name: &str, set: impl FnOnce(&mut Settings)) -> Self {
        let mut name = file_name_part(OsStr::new(name)).to_string_lossy().into_owned();
        let fits = |end: &usize| name.is_char_boundary(*end);
        name.truncate((0..=name.len().min(MAX_LABEL_BYTES)).rfind(fits).unwrap_or(0));
        let label = if self.label.is_empty() { name } else { format!("{}@{name}", self.label) };
        let mut view = Self { label, ..self.clone() };
        set(&mut view.level.settings);
        view
    }

    /// The view without these settings of the shot.
    fn without(mut self, names: &'static [&'static str]) -> Self {
        self.level.without = names;
        self
    }
}

/// All combinations of what the coverage names.
fn combinations(coverage: &Coverage, shot: &ShotSettings, scene: &Scene) -> Vec<View> {
    let whole = View::whole(coverage.frames.as_deref());
    let chosen = |covered: &Option<Covered>, all: fn(&Scene) -> Vec<(String, NameOrIndex)>| {
        covered.as_ref().map(|covered| chosen(covered, all(scene))).unwrap_or_default()
    };
    let mut from = Vec::new();
    for (name, camera) in chosen(&coverage.cameras, cameras) {
        let view = whole.and(&name, |settings| settings.camera = Some(CameraRequest::Camera(camera).into()));
        let is_turned = shot.values.turntable.is_some();
        from.push(view.without(if is_turned { OTHER_VIEWS_OF_TURNTABLE } else { OTHER_VIEWS }));
    }
    for &view in coverage.views.iter().flatten() {
        let view = whole.and(view.choice_name(), |settings| settings.view = Some(view.into()));
        from.push(view.without(CAMERA_OF_FILE));
    }
    if from.is_empty() {
        from.push(whole);
    }
    let with_clips = crossed(from, &chosen(&coverage.clips, clips), |settings, clip| {
        settings.animation = Some(ClipSelection::One(clip).into());
    });
    crossed(with_clips, &chosen(&coverage.variants, variants), |settings, variant| {
        settings.variant = Some(VariantRequest::Variant(variant).into());
    })
}

/// Every view with every element; the views alone where there is none.
fn crossed(
    views: Vec<View>,
    elements: &[(String, NameOrIndex)],
    set: impl Fn(&mut Settings, NameOrIndex),
) -> Vec<View> {
    if elements.is_empty() {
        return views;
    }
    let with_each = |view: &View| {
        let with = |(name, element): &(String, NameOrIndex)| {
            view.and(name, |settings| set(settings, element.clone()))
        };
        elements.iter().map(with).collect::<Vec<_>>()
    };
    views.iter().flat_map(with_each).collect()
}

/// The elements with their labels: `all`, or those that are named.
fn chosen(covered: &Covered, all: Vec<(String, NameOrIndex)>) -> Vec<(String, NameOrIndex)> {
    let Covered::Named(names) = covered else { return all };
    let label = |name: &NameOrIndex| match name {
        NameOrIndex::Name(name) => name.clone(),
        NameOrIndex::Index(index) => index.to_string(),
    };
    names.iter().map(|name| (label(name), name.clone())).collect()
}

/// The cameras of the default scene.
fn cameras(scene: &Scene) -> Vec<(String, NameOrIndex)> {
    let cameras = scene.cameras_of_default_scene().into_iter();
    cameras.map(|camera| (scene.camera_label(camera), NameOrIndex::Index(camera.index()))).collect()
}

fn clips(scene: &Scene) -> Vec<(String, NameOrIndex)> {
    let label = |index: usize| scene.clip_label(AnimationIndex(index as u32));
    (0..scene.animations.len()).map(|index| (label(index), NameOrIndex::Index(index))).collect()
}

fn variants(scene: &Scene) -> Vec<(String, NameOrIndex)> {
    let variants = scene.variants.iter().enumerate();
    variants.map(|(index, variant)| (variant.name.clone(), NameOrIndex::Index(index))).collect()
}

/// The views of a scene without a shot file.
fn whole_scene(scene: &Scene) -> Result<Vec<View>> {
    let elements = Elements { cameras: cameras(scene), clips: clips(scene), variants: variants(scene) };
    Ok(default_views(elements, is_interior(scene)?).into_iter().map(View::from).collect())
}

impl From<DefaultView<NameOrIndex>> for View {
    fn from(DefaultView { name, camera, clip, variant }: DefaultView<NameOrIndex>) -> Self {
        let frames = if clip.is_some() { &FRAMES_OF_CLIP[..] } else { &[NamedFrame::First] };
        Self::whole(Some(frames)).and(&name, |settings| {
            settings.animation = Some(clip.map_or(ClipSelection::None, ClipSelection::One).into());
            settings.variant = variant.map(|variant| VariantRequest::Variant(variant).into());
            match camera {
                DefaultCamera::OfFile(camera) => {
                    settings.camera = Some(CameraRequest::Camera(camera).into());
                }
                DefaultCamera::Automatic => {}
                DefaultCamera::OtherSide => settings.view = Some(NamedView::ThreeQuarterBack.into()),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_settings() {
        for name in CHOOSING.iter().chain(OTHER_VIEWS).chain(OTHER_VIEWS_OF_TURNTABLE).chain(CAMERA_OF_FILE) {
            assert!(DEFINITIONS.iter().any(|definition| definition.name == *name), "{name}");
        }
    }
}
