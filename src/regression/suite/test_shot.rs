//! Renders one shot, compares its frames, and stores pending images.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::covered_jobs::{CoveredJob, CoveredShot, jobs_of, lost_images};
use super::large_scenes::is_large;
use super::limits::PresetLimits;
use super::names::reference_path;
use super::orphans::add_reference;
use super::pending::{discard_image, discard_removal, store_image};
use super::render::render_shot;
use super::rendered_images::{file_hash, store_rendered};
use super::stored_reference::read_stored;
use super::told_content::ToldContent;
use super::verdict_cache::{CachedShot, TestedInputs, VerdictCache};
use super::{Suite, SuiteShot};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image_file::is_pointer;
use crate::regression::compare::{are_identical_and_finite, compare};
use crate::regression::comparison::Comparison;
use crate::regression::encoded_image::EncodedImage;
use crate::regression::exact::value_hash;
use crate::regression::report_page::ImageBudget;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};
use crate::regression::{Image, Limits, Verdict, pixel_hash};
use crate::scene::Scene;
use crate::shot::ShotJob;

/// Settings shared by all shots of a run.
#[derive(Clone, Copy)]
pub(super) struct TestContext<'a> {
    /// The suite.
    pub(super) suite: &'a Suite,
    /// Settings over those of the shots, as `-D` has them.
    pub(super) overrides: &'a [String],
    /// Whether images that differ or have no reference are stored as pending images.
    pub(super) keeps_pending: bool,
    /// Folder of a report in which rendered images are stored.
    pub(super) images: Option<&'a Path>,
    /// Memory for the images of failures, until the report is written.
    pub(super) image_budget: &'a ImageBudget,
    /// Whether identical images are shown in the report, too.
    pub(super) reports_passing: bool,
    /// Verdicts of earlier runs, which replace rendering.
    pub(super) cache: Option<&'a VerdictCache<'a>>,
    /// Shots that are tested at the same time and share the memory.
    pub(super) shots_at_once: usize,
    /// Raised to stop.
    pub(super) cancel: &'a CancelFlag,
}

/// Renders and compares one shot. `None` where its share of the memory is too small or its scene is large, and it is to be tested alone.
///
/// # Errors
/// [`Error::Interrupted`] when cancelled. Other errors become part of the result.
pub(super) fn test_shot(context: &TestContext<'_>, shot: &SuiteShot) -> Result<Option<ShotResult>> {
    context.cancel.check()?;
    let start = Instant::now();
    let limits = context.suite.limits_of(&shot.path);
    let passing = limits.as_ref().map_or(context.suite.limits, |limits| *limits);
    let tested = catch_unwind(AssertUnwindSafe(|| tested(context, shot, limits?)));
    let tested = match tested {
        Ok(Ok(Some(tested))) => tested,
        Ok(Ok(None)) => return Ok(None),
        Ok(Err(Error::Refused { .. })) if context.shots_at_once > 1 => return Ok(None),
        Ok(Err(error @ Error::Interrupted(_))) => return Err(error),
        Ok(Err(error)) => unopened(shot, error.to_string()),
        Err(_) => {
            unopened(shot, "internal error: the program panicked; this is a bug worth reporting".to_owned())
        }
    };
    let mut not_kept = Vec::new();
    if let Some(report) = context.images {
        not_kept.extend(tested.frames.iter().filter_map(|frame| keep_rendered(report, frame).err()));
    }
    if context.keeps_pending {
        not_kept.extend(tested.frames.iter().filter_map(|frame| update_pending(context.suite, frame).err()));
    }
    let frames: Vec<_> = tested.frames.into_iter().map(|frame| frame.result).collect();
    if let (Some(cache), Some(files), false) = (context.cache, &tested.inputs, tested.is_cached) {
        cache.store(shot, TestedInputs { files, frames: &frames, warnings: &tested.warnings });
    }
    Ok(Some(ShotResult {
        name: shot.name.clone(),
        path: shot.path.clone(),
        preset: passing.name(),
        limits: passing.limits,
        frames,
        warnings: tested.warnings,
        not_kept,
        seconds: start.elapsed().as_secs_f64(),
        is_cached: tested.is_cached,
        is_unopened: tested.is_unopened,
    }))
}

#[derive(Default)]
struct TestedShot {
    frames: Vec<TestedFrame>,
    warnings: Vec<String>,
    /// `None` where the images depend on more than files.
    inputs: Option<Vec<PathBuf>>,
    is_cached: bool,
    is_unopened: bool,
}

impl TestedShot {
    fn cached(cached: CachedShot) -> Self {
        let frame = |(name, frame, reference)| {
            let result = FrameResult {
                reference_hash: Some(reference),
                comparison: Some(Comparison::identical()),
                ..FrameResult::new(name, frame, FrameStatus::Passed)
            };
            TestedFrame { result, file: None, was_rendered: true }
        };
        let frames = cached
            .images
            .into_iter()
            .map(|image| frame((image.name, image.frame, image.reference)))
            .collect();
        Self { frames, warnings: cached.warnings, is_cached: true, ..Self::default() }
    }
}

/// A frame, and the file that may become its reference.
pub(super) struct TestedFrame {
    pub(super) result: FrameResult,
    pub(super) file: Option<Vec<u8>>,
    /// Whether its shot rendered it or tried to, so that the image of an earlier run is outdated.
    pub(super) was_rendered: bool,
}

fn unopened(shot: &SuiteShot, message: String) -> TestedShot {
    let result = FrameResult::new(shot.name.clone(), None, FrameStatus::Broken).because(message);
    TestedShot {
        frames: vec![TestedFrame { result, file: None, was_rendered: false }],
        is_unopened: true,
        ..TestedShot::default()
    }
}

/// Stores a pending image for a frame that differs or has no reference. Discards those of identical frames, and those of broken ones, which
/// show an older scene. Where the shot cannot be opened, or does not have the frame any more, they stay.
fn update_pending(suite: &Suite, frame: &TestedFrame) -> Result<()> {
    let name = &frame.result.name;
    let verdict = frame.result.verdict();
    match (frame.result.status, &frame.file) {
        _ if verdict == Verdict::Identical => discard_image(suite, name)?,
        (FrameStatus::Broken, _) if frame.was_rendered => return discard_image(suite, name),
        (FrameStatus::Broken | FrameStatus::Orphaned, _) | (_, None) => return Ok(()),
        (_, Some(bytes)) => store_image(suite, &frame.result, bytes)?,
    }
    discard_removal(suite, name)
}

/// Stores a frame that changed or fails in the folder of a report, if it may become a reference.
pub(super) fn keep_rendered(report: &Path, frame: &TestedFrame) -> Result<()> {
    let TestedFrame { result, file, .. } = frame;
    match file {
        Some(bytes) if result.verdict() != Verdict::Identical && result.status != FrameStatus::Broken => {
            store_rendered(report, &result.name, bytes)
        }
        _ => Ok(()),
    }
}

/// `None` for a shot of a large scene beside others.
fn tested(context: &TestContext<'_>, shot: &SuiteShot, limits: PresetLimits) -> Result<Option<TestedShot>> {
    if let Some(cached) = context.cache.and_then(|cache| cache.find(shot)) {
        let mut shot = TestedShot::cached(cached);
        shot.frames.iter_mut().for_each(|frame| admit(context, &mut frame.result));
        return Ok(Some(shot));
    }
    if context.shots_at_once > 1 && is_large(&shot.scene) {
        return Ok(None);
    }
    let (mut frames, mut warnings, mut inputs) = (Vec::new(), BTreeSet::new(), Some(BTreeSet::new()));
    let CoveredShot { jobs, lost, warning } =
        jobs_of(context.suite, shot, context.overrides, context.shots_at_once)?;
    warnings.extend(warning);
    let mut told = ToldContent::default();
    for covered in jobs {
        tested_view(context, (shot, &covered), &limits.limits, (&mut frames, &mut told))?;
        let ShotJob { sequence, warnings: of_view, inputs: files } = covered.job;
        warnings.extend(of_view.iter().map(ToString::to_string));
        // The library of a denoiser is no input file.
        inputs = inputs.filter(|_| sequence.denoiser.is_none());
        if let Some(inputs) = &mut inputs {
            inputs.extend(files);
        }
    }
    let lost = lost_images(context.suite, &shot.name, &lost)?;
    frames.extend(lost.into_iter().map(|(name, view)| lost_frame(context, name, &view.error)));
    Ok(Some(TestedShot {
        frames,
        warnings: warnings.into_iter().collect(),
        inputs: inputs.map(|inputs| inputs.into_iter().collect()),
        ..TestedShot::default()
    }))
}

/// Keeps the images of a result for the report, as far as there is memory for them.
fn admit(context: &TestContext<'_>, result: &mut FrameResult) {
    if context.reports_passing && result.verdict() == Verdict::Identical {
        add_reference(context.suite, result);
    }
    context.image_budget.admit(result);
}

/// The failure of an image of something that the scene does not have. Its reference stays.
fn lost_frame(context: &TestContext<'_>, name: String, error: &Error) -> TestedFrame {
    let mut result = FrameResult::new(name, None, FrameStatus::Broken).because(error.to_string());
    add_reference(context.suite, &mut result);
    if result.reference_hash.is_some() {
        let reference = reference_path(&context.suite.references, &result.name);
        let reference = reference.display();
        let lost = format!("lost: what {reference} shows; it is orphaned once the list does not name it");
        result.messages.insert(0, lost);
    }
    context.image_budget.admit(&mut result);
    TestedFrame { result, file: None, was_rendered: false }
}

/// Renders and compares the frames of one view, and adds them to those of the shot.
fn tested_view(
    context: &TestContext<'_>,
    (shot, covered): (&SuiteShot, &CoveredJob),
    limits: &Limits,
    (tested, told): (&mut Vec<TestedFrame>, &mut ToldContent),
) -> Result<()> {
    let mut rendered = render_shot(covered.job.sequence.clone(), context.cancel)?;
    let is_refused = |(_, file): &(i64, Result<PathBuf>)| matches!(file, Err(Error::Refused { .. }));
    if let Some(refused) = rendered.frames.iter().position(is_refused).filter(|_| context.shots_at_once > 1) {
        rendered.frames.swap_remove(refused).1?;
    }
    for (frame, file) in &rendered.frames {
        let id = FrameId {
            name: covered.image_name(&shot.name, *frame),
            frame: covered.frame_number(*frame),
            scene: Some(&covered.job.sequence.scene),
        };
        let mut frame = match file {
            Ok(file) => test_frame(context.suite, limits, id, file, told)?,
            Err(error) => {
                let result = id.result(FrameStatus::Broken).because(error.to_string());
                TestedFrame { result, file: None, was_rendered: true }
            }
        };
        admit(context, &mut frame.result);
        tested.push(frame);
    }
    Ok(())
}

/// The name of a frame's reference, and the frame number in shots of several frames.
pub(super) struct FrameId<'a> {
    pub(super) name: String,
    pub(super) frame: Option<i64>,
    /// The rendered scene, where it is at hand, for names of its materials.
    pub(super) scene: Option<&'a Scene>,
}

impl FrameId<'_> {
    fn result(self, status: FrameStatus) -> FrameResult {
        FrameResult::new(self.name, self.frame, status)
    }
}

/// Compares the image in `file` with its reference. What `told` has of the shot's content is not told again.
pub(super) fn test_frame(
    suite: &Suite,
    limits: &Limits,
    id: FrameId<'_>,
    file: &Path,
    told: &mut ToldContent,
) -> Result<TestedFrame> {
    let reference = reference_path(&suite.references, &id.name);
    let bytes = std::fs::read(file).map_err(Error::missing(file))?;
    let actual = Image::decode(file, &bytes)?;
    let stored = read_stored(&reference);
    let mut result = match &stored {
        Ok(Some(stored)) => match Image::decode(&reference, stored) {
            Ok(expected) => compare_frame(id, [&actual, &expected], limits, told),
            // The image cannot replace what was not fetched.
            Err(error) if is_pointer(stored) => id.result(FrameStatus::Broken).because(error.to_string()),
            Err(error) => id.result(FrameStatus::Different).because(error.to_string()),
        },
        Ok(None) => {
            id.result(FrameStatus::Missing).because(format!("there is no reference {}", reference.display()))
        }
        // Nor what cannot be read.
        Err(error) => id.result(FrameStatus::Broken).because(error.to_string()),
    };
    let stored = stored.ok().flatten();
    result.reference_hash = stored.as_deref().map(file_hash);
    let size = stored.filter(|_| result.passes()).map_or(bytes.len(), |stored| stored.len());
    if let Some(message) = suite.too_large(size as u64) {
        result.status = FrameStatus::Broken;
        result.messages.insert(0, message);
    }
    if result.verdict() != Verdict::Identical {
        let errors = result.comparison.as_mut().and_then(|comparison| comparison.flip_map.take());
        result.actual = EncodedImage::new(&actual).map(|packed| match &errors {
            Some(map) => packed.with_errors(map),
            None => packed,
        });
        result.actual_hash = Some(pixel_hash(&actual));
        result.value_hash = (result.status == FrameStatus::Missing).then(|| value_hash(&actual));
    }
    Ok(TestedFrame { result, file: Some(bytes), was_rendered: true })
}

fn compare_frame(
    id: FrameId<'_>,
    [actual, expected]: [&Image; 2],
    limits: &Limits,
    told: &mut ToldContent,
) -> FrameResult {
    let mut comparison = if are_identical_and_finite(actual, expected) {
        Comparison::identical()
    } else {
        compare(actual, expected, limits)
    };
    if let Some(scene) = id.scene {
        comparison.name_materials(actual, expected, &|id| scene.material_of_id(id));
    }
    let mut result = id.result(FrameStatus::Passed);
    match comparison.verdict() {
        Verdict::Identical => comparison.flip_map = None,
        Verdict::Changed => {}
        Verdict::Failed => result.status = FrameStatus::Different,
    }
    result.messages = told.messages(&result.name, &comparison);
    if comparison.verdict() != Verdict::Identical {
        result.expected = EncodedImage::new(expected);
    }
    result.comparison = Some(comparison);
    result
}
