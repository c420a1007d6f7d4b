//! The jobs of a shot: one for each view that the suite covers.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::PathBuf;

use super::coverage::{Coverage, Covered};
use super::names::{ReferenceFile, image_name, numbered_shot, reference_files};
use super::{Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::framing::{NamedView, is_interior};
use crate::gltf::ImageLoading;
use crate::scene::{
    AnimationIndex, CameraRequest, ClipSelection, NameOrIndex, Scene, SelectedCamera, Selection,
    make_unique_for_files,
};
use crate::sequence::SequenceJob;
use crate::settings::{
    BackgroundSource, DEFINITIONS, FrameSpec, Named as _, NamedFrame, Settings, file_name_part,
};
use crate::shot::default_views::{DefaultCamera, DefaultView, Elements, default_views};
use crate::shot::{ShotJob, ShotRequest, ShotSettings, is_shot, shot_jobs, shot_outlines};

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

/// A job of a shot.
#[derive(Debug)]
pub(super) struct CoveredJob {
    /// The view's part of the names of its images; empty for a shot of a single view.
    label: String,
    pub(super) job: ShotJob,
}

impl CoveredJob {
    /// The name of the image of a frame.
    pub(super) fn image_name(&self, shot: &str, frame: i64) -> String {
        image_name(&view_name(shot, &self.label), frame, self.job.sequence.frames.len())
    }

    /// The number of a frame, in shots of several frames and a single view.
    pub(super) fn frame_number(&self, frame: i64) -> Option<i64> {
        (self.label.is_empty() && self.job.sequence.frames.len() > 1).then_some(frame)
    }
}

/// The name of a view of a shot: that of its image, where it has one frame.
fn view_name(shot: &str, label: &str) -> String {
    if label.is_empty() { shot.to_owned() } else { format!("{shot}@{label}") }
}

/// A view of a shot with a camera, clip or variant that a list of `[test]` names and the scene does not have.
#[derive(Debug)]
pub(super) struct LostView {
    label: String,
    /// The error about the list.
    pub(super) error: Error,
}

impl LostView {
    /// The names of its images among the `references` of the suite, or its own where there is none.
    fn image_names(&self, references: &[ReferenceFile], shot: &str) -> Vec<String> {
        let view = view_name(shot, &self.label);
        let references = references.iter().filter(|file| matches!(file, ReferenceFile::Reference(_)));
        let names = references.map(ReferenceFile::name);
        let names = names.filter(|name| *name == view || numbered_shot(name) == Some(&view));
        let names: Vec<_> = names.map(str::to_owned).collect();
        if names.is_empty() { vec![view] } else { names }
    }
}

/// What is rendered of a shot.
#[derive(Debug)]
pub(super) struct CoveredShot {
    pub(super) jobs: Vec<CoveredJob>,
    pub(super) lost: Vec<LostView>,
    /// About frames that no clip has.
    pub(super) warning: Option<String>,
}

/// The names of the images of lost views, each with its view.
///
/// # Errors
/// Those of reading the references.
pub(super) fn lost_images<'a>(
    suite: &Suite,
    shot: &str,
    lost: &'a [LostView],
) -> Result<Vec<(String, &'a LostView)>> {
    if lost.is_empty() {
        return Ok(Vec::new());
    }
    let references = reference_files(suite)?;
    let images =
        |view: &'a LostView| view.image_names(&references, shot).into_iter().map(move |name| (name, view));
    Ok(lost.iter().flat_map(images).collect())
}

/// The names of all images of a shot. Renders nothing.
///
/// # Errors
/// Those of reading and resolving the shot, and of reading the references.
pub fn image_names(suite: &Suite, shot: &SuiteShot) -> Result<Vec<String>> {
    let ShotImages { rendered, lost } = ShotImages::of(suite, shot)?;
    Ok(rendered.into_iter().chain(lost).collect())
}

/// The names of the images of a shot.
#[derive(Debug)]
pub(super) struct ShotImages {
    pub(super) rendered: Vec<String>,
    /// Those of lost views.
    pub(super) lost: Vec<String>,
}

impl ShotImages {
    /// Opens the shot and renders nothing.
    ///
    /// # Errors
    /// Those of reading and resolving the shot.
    pub(super) fn of(suite: &Suite, shot: &SuiteShot) -> Result<Self> {
        let CoveredShot { jobs, lost, .. } = covered(suite, shot, &[], ImageLoading::Headers)?;
        let mut rendered = Vec::new();
        for covered in &jobs {
            let frames = covered.job.sequence.frames.iter();
            rendered.extend(frames.map(|&frame| covered.image_name(&shot.name, frame)));
        }
        let lost = lost_images(suite, &shot.name, &lost)?.into_iter().map(|(name, _)| name).collect();
        Ok(Self { rendered, lost })
    }
}

/// The jobs of a shot file or a scene, with the settings that the suite has for all shots, below `overrides`. They share one scene.
///
/// # Errors
/// Those of reading and resolving the shot.
pub(super) fn jobs_of(suite: &Suite, shot: &SuiteShot, overrides: &[String]) -> Result<CoveredShot> {
    covered(suite, shot, overrides, ImageLoading::Texels)
}

fn covered(
    suite: &Suite,
    shot: &SuiteShot,
    overrides: &[String],
    images: ImageLoading,
) -> Result<CoveredShot> {
    let coverage = suite.coverage_of(&shot.path)?;
    let request = ShotRequest { path: &shot.path, suite: Some(&suite.file), overrides };
    let mut views = Vec::new();
    let resolved = shot_jobs(&request, images, |settings, scene| {
        views = views_of(shot, &coverage, settings, scene)?;
        Ok(views.iter().map(|view| view.settings.clone()).collect())
    })?;
    let (mut jobs, mut lost) = (Vec::new(), Vec::new());
    for (job, view) in resolved.into_iter().zip(views) {
        match job {
            Ok(job) => jobs.push(CoveredJob { label: view.label, job }),
            Err(error) => {
                let error = error_of_list(error, &coverage)?;
                lost.push(LostView { label: view.label, error });
            }
        }
    }
    let warning = frames_beyond_clips(&coverage, &jobs);
    Ok(CoveredShot { jobs, lost, warning })
}

/// The views of a shot that the suite covers, with distinct labels.
fn views_of(
    shot: &SuiteShot,
    coverage: &Coverage,
    settings: &ShotSettings,
    scene: &Scene,
) -> Result<Vec<View>> {
    let is_default =
        coverage.is_empty() && !is_shot(&shot.path) && !has_plate(settings) && !chooses(&settings.settings);
    let mut views = if is_default { whole_scene(scene)? } else { combinations(coverage, scene) };
    make_unique_for_files(views.iter_mut().map(|view| &mut view.label));
    Ok(views)
}

/// What the images of a shot are called and made from.
#[derive(Debug, Default)]
pub(super) struct OutlinedShot {
    /// The names of its images.
    pub(super) images: Vec<String>,
    /// Its input files, of all its views.
    pub(super) inputs: BTreeSet<PathBuf>,
}

/// The images and the input files of a shot. Neither texels nor environments are loaded.
///
/// # Errors
/// Those of reading and resolving the shot, and of a view that is lost.
pub(super) fn outlined(suite: &Suite, shot: &SuiteShot) -> Result<OutlinedShot> {
    let coverage = suite.coverage_of(&shot.path)?;
    let request = ShotRequest { path: &shot.path, suite: Some(&suite.file), overrides: &[] };
    let mut views = Vec::new();
    let outlines = shot_outlines(&request, |settings, scene| {
        views = views_of(shot, &coverage, settings, scene)?;
        Ok(views.iter().map(|view| view.settings.clone()).collect())
    })?;
    let mut outlined = OutlinedShot::default();
    for (outline, view) in outlines.into_iter().zip(views) {
        let name = view_name(&shot.name, &view.label);
        for frames in outline.sequences.iter().map(|sequence| &sequence.frames) {
            outlined.images.extend(frames.iter().map(|&frame| image_name(&name, frame, frames.len())));
        }
        outlined.inputs.extend(outline.inputs);
    }
    Ok(outlined)
}

/// An error about a camera, clip or variant as one about the list that names it.
///
/// # Errors
/// Every other error.
fn error_of_list(error: Error, coverage: &Coverage) -> Result<Error> {
    let Error::Setting(mut error) = error else { return Err(error) };
    let Coverage { cameras, clips, variants, .. } = coverage;
    let lists =
        [("camera", "cameras", cameras), ("animation", "clips", clips), ("variant", "variants", variants)];
    match lists.iter().find(|(setting, _, list)| *setting == error.setting && list.is_some()) {
        Some((_, key, _)) => {
            error.setting = format!("{key} of [test]");
            Ok(Error::Setting(error))
        }
        None => Err(Error::Setting(error)),
    }
}

/// A warning about numbers in `frames` that are beyond the end of every clip, where clips play.
fn frames_beyond_clips(coverage: &Coverage, jobs: &[CoveredJob]) -> Option<String> {
    let moves_camera = |selection: &Selection| {
        matches!(selection.camera, SelectedCamera::Turntable(_) | SelectedCamera::Path(_))
    };
    let playing = jobs.iter().map(|covered| &covered.job.sequence);
    let playing = playing.filter(|job| !job.selection.clips.is_empty());
    // A camera may move after the end.
    let last =
        playing.map(|job| if moves_camera(&job.selection) { i64::MAX } else { last_frame(job) }).max()?;
    let beyond = coverage.frames.iter().flatten().filter_map(|frame| match frame {
        NamedFrame::Number(number) if *number > last => Some(number.to_string()),
        _ => None,
    });
    let beyond: Vec<_> = beyond.collect();
    (!beyond.is_empty()).then(|| {
        let numbers = beyond.join(", ");
        format!("frames of [test]: {numbers}: beyond the end of every clip, whose last frame is {last}; its pose is repeated")
    })
}

/// Whether a plate lies behind the scene, whose file may depend on the frame.
fn has_plate(shot: &ShotSettings) -> bool {
    matches!(shot.values.background, BackgroundSource::Plate(_))
}

/// The last frame of the clips that play.
fn last_frame(job: &SequenceJob) -> i64 {
    job.rate.last_frame(job.selection.duration_seconds(&job.scene))
}

fn chooses(settings: &Settings) -> bool {
    DEFINITIONS
        .iter()
        .any(|definition| CHOOSING.contains(&definition.name) && definition.origin(settings).is_some())
}

/// What is set for a view, on top of the shot.
#[derive(Clone, Debug, Default)]
struct View {
    label: String,
    settings: Settings,
}

impl View {
    /// The whole shot, at `frames`.
    fn whole(frames: Option<&[NamedFrame]>) -> Self {
        let frames = frames.map(|frames| FrameSpec::Named(frames.to_vec()).into());
        Self { label: String::new(), settings: Settings { frames, ..Settings::default() } }
    }

    /// The view with another setting, and its name.
    fn and(&self, name: &str, set: impl FnOnce(&mut Settings)) -> Self {
        let mut name = file_name_part(OsStr::new(name)).to_string_lossy().into_owned();
        let fits = |end: &usize| name.is_char_boundary(*end);
        name.truncate((0..=name.len().min(MAX_LABEL_BYTES)).rfind(fits).unwrap_or(0));
        let label = if self.label.is_empty() { name } else { format!("{}@{name}", self.label) };
        let mut view = Self { label, ..self.clone() };
        set(&mut view.settings);
        view
    }
}

/// All combinations of what the coverage names.
fn combinations(coverage: &Coverage, scene: &Scene) -> Vec<View> {
    let whole = View::whole(coverage.frames.as_deref());
    let chosen = |covered: &Option<Covered>, all: fn(&Scene) -> Vec<(String, NameOrIndex)>| {
        covered.as_ref().map(|covered| chosen(covered, all(scene))).unwrap_or_default()
    };
    let mut from = Vec::new();
    for (name, camera) in chosen(&coverage.cameras, cameras) {
        from.push(whole.and(&name, |settings| settings.camera = Some(CameraRequest::Camera(camera).into())));
    }
    for &view in coverage.views.iter().flatten() {
        from.push(whole.and(view.choice_name(), |settings| settings.view = Some(view.into())));
    }
    if from.is_empty() {
        from.push(whole);
    }
    let with_clips = crossed(from, &chosen(&coverage.clips, clips), |settings, clip| {
        settings.animation = Some(ClipSelection::One(clip).into());
    });
    crossed(with_clips, &chosen(&coverage.variants, variants), |settings, variant| {
        settings.variant = Some(variant.into());
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
            settings.variant = variant.map(Into::into);
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
    fn choosing_names_are_settings() {
        for name in CHOOSING {
            assert!(DEFINITIONS.iter().any(|definition| definition.name == name), "{name}");
        }
    }
}
