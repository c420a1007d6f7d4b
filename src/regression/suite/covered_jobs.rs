//! The jobs of a shot: one for each view that the suite covers.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::coverage::Coverage;
use super::names::{ReferenceFile, image_name, numbered_shot, reference_files};
use super::views::{View, views_of};
use super::{Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::gltf::ImageLoading;
use crate::scene::{Scene, SelectedCamera, Selection};
use crate::sequence::SequenceJob;
use crate::settings::NamedFrame;
use crate::shot::{ShotJob, ShotRequest, ShotSettings, ViewSettings, shot_jobs, shot_outlines};

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
        let CoveredShot { jobs, lost, .. } = covered_shot(suite, shot, &[], (ImageLoading::Headers, 1))?;
        let mut rendered = Vec::new();
        for covered in &jobs {
            let frames = covered.job.sequence.frames.iter();
            rendered.extend(frames.map(|&frame| covered.image_name(&shot.name, frame)));
        }
        let lost = lost_images(suite, &shot.name, &lost)?.into_iter().map(|(name, _)| name).collect();
        Ok(Self { rendered, lost })
    }
}

/// The jobs of a shot file or a scene, with the settings that the suite has for all shots, below `overrides`. They share one scene, and
/// the memory with other shots, of which there are `shots_at_once`.
///
/// # Errors
/// Those of reading and resolving the shot.
pub(super) fn jobs_of(
    suite: &Suite,
    shot: &SuiteShot,
    overrides: &[String],
    shots_at_once: usize,
) -> Result<CoveredShot> {
    covered_shot(suite, shot, overrides, (ImageLoading::Texels, shots_at_once))
}

/// The views of a shot that the suite covers, found once its scene is loaded.
struct CoveredViews<'a> {
    shot: &'a SuiteShot,
    coverage: &'a Coverage,
    views: Vec<View>,
}

impl CoveredViews<'_> {
    /// Finds the views, and returns the settings of each.
    fn find(&mut self, settings: &ShotSettings, scene: &Scene) -> Result<Vec<ViewSettings>> {
        self.views = views_of(self.shot, self.coverage, settings, scene)?;
        Ok(self.views.iter().map(|view| view.level.clone()).collect())
    }
}

fn covered_shot(
    suite: &Suite,
    shot: &SuiteShot,
    overrides: &[String],
    loading: (ImageLoading, usize),
) -> Result<CoveredShot> {
    let coverage = suite.coverage_of(&shot.path)?;
    let request = ShotRequest { path: &shot.path, suite: Some(&suite.file), overrides };
    let mut views = CoveredViews { shot, coverage: &coverage, views: Vec::new() };
    let resolved = shot_jobs(&request, loading, |settings, scene| views.find(settings, scene))?;
    let (mut jobs, mut lost) = (Vec::new(), Vec::new());
    for (job, view) in resolved.into_iter().zip(views.views) {
        match job {
            Ok(job) => jobs.push(CoveredJob { label: view.label, job }),
            Err(error) => {
                let error = error_of_list(error, &coverage)?;
                lost.push(LostView { label: view.label, error });
            }
        }
    }
    refuse_shared_images(shot, &jobs)?;
    let warning = frames_beyond_clips(&coverage, &jobs);
    Ok(CoveredShot { jobs, lost, warning })
}

/// Refuses a view whose image has the name of one of another view, such as that of a camera `walk.0000` beside a clip `walk`.
fn refuse_shared_images(shot: &SuiteShot, jobs: &[CoveredJob]) -> Result<()> {
    let mut views = BTreeMap::new();
    for (view, covered) in jobs.iter().enumerate() {
        for &frame in &covered.job.sequence.frames {
            let name = covered.image_name(&shot.name, frame);
            // Some file systems ignore case.
            let first: usize = *views.entry(name.to_lowercase()).or_insert(view);
            if first != view {
                let labels = [first, view].map(|view| jobs[view].label.escape_debug());
                let [first, second] = labels;
                let message = format!(
                    "the views \"{first}\" and \"{second}\" would share the reference {name}.exr; rename a camera, clip or variant of one"
                );
                return Err(Error::invalid(&shot.path, "", message));
            }
        }
    }
    Ok(())
}

/// What the images of a shot are called and made from.
#[derive(Debug, Default)]
pub(super) struct ShotFiles {
    /// The names of its images.
    pub(super) images: Vec<String>,
    /// Its input files, of all its views.
    pub(super) inputs: BTreeSet<PathBuf>,
}

/// The images and the input files of a shot. Neither texels nor environments are loaded.
///
/// # Errors
/// Those of reading and resolving the shot, and of a view that is lost.
pub(super) fn files_of(suite: &Suite, shot: &SuiteShot) -> Result<ShotFiles> {
    let coverage = suite.coverage_of(&shot.path)?;
    let request = ShotRequest { path: &shot.path, suite: Some(&suite.file), overrides: &[] };
    let mut views = CoveredViews { shot, coverage: &coverage, views: Vec::new() };
    let outlines = shot_outlines(&request, |settings, scene| views.find(settings, scene))?;
    let mut files = ShotFiles::default();
    for (outline, view) in outlines.into_iter().zip(views.views) {
        let name = view_name(&shot.name, &view.label);
        for frames in outline.sequences.iter().map(|sequence| &sequence.frames) {
            files.images.extend(frames.iter().map(|&frame| image_name(&name, frame, frames.len())));
        }
        files.inputs.extend(outline.inputs);
    }
    Ok(files)
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

/// The last frame of the clips that play.
fn last_frame(job: &SequenceJob) -> i64 {
    job.rate.last_frame(job.selection.duration_seconds(&job.scene))
}
