//! The jobs of a shot: one for each view that the suite covers.

use std::collections::BTreeSet;
use std::ffi::OsStr;

use super::coverage::{Coverage, Covered, CoveredFrame};
use super::names::image_name;
use super::{Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::framing::{NamedView, is_interior};
use crate::scene::{CameraRequest, ClipSelection, NameOrIndex, Scene};
use crate::sequence::SequenceJob;
use crate::settings::{BackgroundSource, DEFINITIONS, Settings, file_name_part};
use crate::shot::{ShotJob, ShotRequest, is_shot, shot_jobs};

/// Frames of a clip that are tested by default.
const FRAMES_OF_CLIP: [CoveredFrame; 3] = [CoveredFrame::First, CoveredFrame::Middle, CoveredFrame::Last];
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
        let view = if self.label.is_empty() { shot.to_owned() } else { format!("{shot}@{}", self.label) };
        image_name(&view, frame, self.job.sequence.frames.len())
    }

    /// The number of a frame, in shots of several frames and a single view.
    pub(super) fn frame_number(&self, frame: i64) -> Option<i64> {
        (self.label.is_empty() && self.job.sequence.frames.len() > 1).then_some(frame)
    }
}

/// The jobs of a shot file or a scene, with the settings that the suite has for all shots. They share one scene.
///
/// # Errors
/// Those of reading and resolving the shot, and [`Error::Setting`] for a camera, clip or variant that the scene does not have.
pub(super) fn jobs_of(suite: &Suite, shot: &SuiteShot) -> Result<Vec<CoveredJob>> {
    let coverage = suite.coverage_of(&shot.path)?;
    let request = ShotRequest { path: &shot.path, suite: Some(&suite.file), overrides: &[] };
    let mut views = Vec::new();
    let jobs = shot_jobs(&request, |settings, scene| {
        let has_plate = matches!(settings.values.background, BackgroundSource::Plate(_));
        let is_default =
            coverage.is_empty() && !is_shot(&shot.path) && !has_plate && !chooses(&settings.settings);
        if !is_default {
            check_names(&coverage, scene)?;
        }
        views = if is_default { default_views(scene)? } else { combinations(&coverage, scene) };
        make_unique(&mut views);
        Ok(views.iter().map(|view| view.settings.clone()).collect())
    })?;
    jobs.into_iter().zip(views).map(|(job, view)| covered_job(job, view)).collect()
}

fn covered_job(mut job: ShotJob, view: View) -> Result<CoveredJob> {
    if let Some(frames) = &view.frames {
        if job.sequence.plates.is_some() {
            let why = "of [test] cannot be combined with plates behind the scene; set `frames` of the shot";
            return Err(Error::setting("frames", why));
        }
        job.sequence.frames = frame_numbers(&job.sequence, frames);
    }
    Ok(CoveredJob { label: view.label, job })
}

/// The numbers of frames, in increasing order.
fn frame_numbers(job: &SequenceJob, frames: &[CoveredFrame]) -> Vec<i64> {
    let last = job.rate.last_frame(job.selection.duration_seconds(&job.scene));
    let number = |frame: &CoveredFrame| match frame {
        CoveredFrame::First => 0,
        CoveredFrame::Middle => last / 2,
        CoveredFrame::Last => last,
        CoveredFrame::Number(number) => *number,
    };
    frames.iter().map(number).collect::<BTreeSet<_>>().into_iter().collect()
}

fn chooses(settings: &Settings) -> bool {
    let chosen = DEFINITIONS.iter().filter(|definition| CHOOSING.contains(&definition.name));
    chosen.into_iter().any(|definition| definition.origin(settings).is_some())
}

/// What is set for a view, on top of the shot.
#[derive(Clone, Debug, Default)]
struct View {
    label: String,
    settings: Settings,
    frames: Option<Vec<CoveredFrame>>,
}

impl View {
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

/// Refuses names of clips and variants that the scene does not have. Cameras are selected by more names, those of nodes.
fn check_names(coverage: &Coverage, scene: &Scene) -> Result<()> {
    let clips: Vec<_> = (0..scene.animations.len()).map(|index| clip_label(scene, index)).collect();
    let variants: Vec<_> = scene.variants.iter().map(|variant| variant.name.clone()).collect();
    for (key, covered, names) in
        [("clips", &coverage.clips, clips), ("variants", &coverage.variants, variants)]
    {
        let Some(Covered::Named(asked)) = covered else { continue };
        let is_missing = |asked: &&NameOrIndex| match asked {
            NameOrIndex::Name(name) => !names.contains(name),
            NameOrIndex::Index(index) => *index >= names.len(),
        };
        if let Some(missing) = asked.iter().find(is_missing) {
            let missing = match missing {
                NameOrIndex::Name(name) => format!("\"{}\"", name.escape_debug()),
                NameOrIndex::Index(index) => format!("#{index}"),
            };
            let known: Vec<_> = names.iter().map(|name| format!("\"{}\"", name.escape_debug())).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            let why = format!(
                "of [test]: the scene has no {missing}, there is {known}; restore it, or take it off the list"
            );
            return Err(Error::setting(key, why));
        }
    }
    Ok(())
}

/// All combinations of what the coverage names.
fn combinations(coverage: &Coverage, scene: &Scene) -> Vec<View> {
    let Coverage { frames, cameras, views, clips, variants } = coverage;
    let whole = View { frames: frames.clone(), ..View::default() };
    let cameras = cameras
        .as_ref()
        .map(|cameras| chosen(cameras, scene.cameras_of_default_scene(), |index| camera_label(scene, index)));
    let mut from = Vec::new();
    for (name, camera) in cameras.into_iter().flatten() {
        from.push(whole.and(&name, |settings| settings.camera = Some(CameraRequest::Camera(camera).into())));
    }
    for &view in views.iter().flatten() {
        from.push(
            whole
                .and(crate::settings::Named::choice_name(view), |settings| settings.view = Some(view.into())),
        );
    }
    if from.is_empty() {
        from.push(whole);
    }
    let clips = clips
        .as_ref()
        .map(|clips| chosen(clips, (0..scene.animations.len()).collect(), |index| clip_label(scene, index)));
    let with_clips =
        crossed(from, clips, |settings, clip| settings.animation = Some(ClipSelection::One(clip).into()));
    let variants = variants.as_ref().map(|variants| {
        chosen(variants, (0..scene.variants.len()).collect(), |index| scene.variants[index].name.clone())
    });
    crossed(with_clips, variants, |settings, variant| settings.variant = Some(variant.into()))
}

/// Every view with every element; the views alone where there is none.
fn crossed(
    views: Vec<View>,
    elements: Option<Vec<(String, NameOrIndex)>>,
    set: impl Fn(&mut Settings, NameOrIndex),
) -> Vec<View> {
    match elements {
        Some(elements) if !elements.is_empty() => {
            let with = |view: &View| {
                let of = |(name, element): &(String, NameOrIndex)| {
                    view.and(name, |settings| set(settings, element.clone()))
                };
                elements.iter().map(of).collect::<Vec<_>>()
            };
            views.iter().flat_map(with).collect()
        }
        _ => views,
    }
}

/// The elements with their labels.
fn chosen(
    covered: &Covered,
    all: BTreeSet<usize>,
    label: impl Fn(usize) -> String,
) -> Vec<(String, NameOrIndex)> {
    match covered {
        Covered::Each => all.into_iter().map(|index| (label(index), NameOrIndex::Index(index))).collect(),
        Covered::Named(names) => {
            let text = |name: &NameOrIndex| match name {
                NameOrIndex::Name(name) => name.clone(),
                NameOrIndex::Index(index) => index.to_string(),
            };
            names.iter().map(|name| (text(name), name.clone())).collect()
        }
    }
}

fn camera_label(scene: &Scene, index: usize) -> String {
    let name = scene.camera_name(crate::scene::CameraIndex(index as u32));
    name.map_or_else(|| format!("camera{index}"), str::to_owned)
}

fn clip_label(scene: &Scene, index: usize) -> String {
    let name = scene.animations.get(index).and_then(|clip| clip.name.clone());
    name.unwrap_or_else(|| format!("clip{index}"))
}

/// The views of a scene without a shot file: stills without animation by every camera, or else by the automatic one and, unless it is
/// inside, from the other side; then by the first of these the first, middle and last frame of every clip, and a still of every variant.
fn default_views(scene: &Scene) -> Result<Vec<View>> {
    let still = View { frames: Some(vec![CoveredFrame::First]), ..View::default() };
    let stopped = |settings: &mut Settings| settings.animation = Some(ClipSelection::None.into());
    let cameras =
        chosen(&Covered::Each, scene.cameras_of_default_scene(), |index| camera_label(scene, index));
    let by_camera = |camera: &NameOrIndex| Some(CameraRequest::Camera(camera.clone()).into());
    let mut views: Vec<View> = cameras
        .iter()
        .map(|(name, camera)| {
            still.and(name, |settings| {
                stopped(settings);
                settings.camera = by_camera(camera);
            })
        })
        .collect();
    if views.is_empty() {
        views.push(still.and("auto", stopped));
        if !is_interior(scene)? {
            views.push(still.and("three-quarter-back", |settings| {
                stopped(settings);
                settings.view = Some(NamedView::ThreeQuarterBack.into());
            }));
        }
    }
    let first = View {
        settings: Settings {
            camera: cameras.first().and_then(|(_, camera)| by_camera(camera)),
            ..Settings::default()
        },
        ..View::default()
    };
    for (index, name) in (0..scene.animations.len()).map(|index| (index, clip_label(scene, index))) {
        let clip = ClipSelection::One(NameOrIndex::Index(index));
        let view = first.and(&name, |settings| settings.animation = Some(clip.into()));
        views.push(View { frames: Some(FRAMES_OF_CLIP.to_vec()), ..view });
    }
    for (index, variant) in scene.variants.iter().enumerate() {
        let view = View { frames: still.frames.clone(), ..first.clone() };
        views.push(view.and(&variant.name, |settings| {
            stopped(settings);
            settings.variant = Some(NameOrIndex::Index(index).into());
        }));
    }
    Ok(views)
}

/// Adds numbers to labels that several views have, also on file systems that ignore case.
fn make_unique(views: &mut [View]) {
    let mut labels = BTreeSet::new();
    for view in views {
        let label = view.label.clone();
        let mut number = 2;
        while !labels.insert(view.label.to_lowercase()) {
            view.label = format!("{label} {number}");
            number += 1;
        }
    }
}
