//! Renders one shot, compares its frames, and stores pending images.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use super::job::job_of;
use super::limits::PresetLimits;
use super::names::{image_name, reference_path};
use super::pending::{discard_image, discard_removal, store_image};
use super::render::render_shot;
use super::rendered_images::store_rendered;
use super::{Suite, SuiteShot};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::regression::compare::compare;
use crate::regression::encoded_image::EncodedImage;
use crate::regression::report_page::ImageBudget;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};
use crate::regression::{Image, Limits, Verdict, pixel_hash};
use crate::shot::ShotJob;

/// Settings shared by all shots of a run.
#[derive(Clone, Copy)]
pub struct TestContext<'a> {
    /// The suite.
    pub suite: &'a Suite,
    /// Whether images that differ or have no reference are stored as pending images.
    pub keeps_pending: bool,
    /// Folder of a report in which rendered images are stored.
    pub images: Option<&'a Path>,
    /// Memory for the images of failures, until the report is written.
    pub image_budget: &'a ImageBudget,
    /// Shots that are tested at the same time and share the memory.
    pub shots_at_once: usize,
    /// Raised to stop.
    pub cancel: &'a CancelFlag,
}

/// Renders and compares one shot.
///
/// # Errors
/// [`Error::Interrupted`] when cancelled. Other errors become part of the result.
pub fn test_shot(context: &TestContext<'_>, shot: &SuiteShot) -> Result<ShotResult> {
    context.cancel.check()?;
    let start = Instant::now();
    let limits = context.suite.limits_of(&shot.path);
    let passing = limits.as_ref().map_or(context.suite.limits, |limits| *limits);
    let tested = catch_unwind(AssertUnwindSafe(|| tested(context, shot, limits?)));
    let tested = match tested {
        Ok(Ok(tested)) => tested,
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
    Ok(ShotResult {
        name: shot.name.clone(),
        path: shot.path.clone(),
        preset: passing.name(),
        limits: passing.limits,
        frames: tested.frames.into_iter().map(|frame| frame.result).collect(),
        warnings: tested.warnings,
        not_kept,
        seconds: start.elapsed().as_secs_f64(),
    })
}

struct TestedShot {
    frames: Vec<TestedFrame>,
    warnings: Vec<String>,
}

/// A frame, and the file that may become its reference.
struct TestedFrame {
    result: FrameResult,
    file: Option<Vec<u8>>,
}

fn unopened(shot: &SuiteShot, message: String) -> TestedShot {
    let result = FrameResult::new(shot.name.clone(), None, FrameStatus::Broken, message);
    TestedShot { frames: vec![TestedFrame { result, file: None }], warnings: Vec::new() }
}

/// Stores a pending image for a frame that differs or has no reference, and discards pending images of identical frames. Broken
/// frames leave pending images as they are.
fn update_pending(suite: &Suite, frame: &TestedFrame) -> Result<()> {
    let name = &frame.result.name;
    let verdict = frame.result.verdict();
    match (frame.result.status, &frame.file) {
        _ if verdict == Verdict::Identical => discard_image(suite, name)?,
        (FrameStatus::Broken | FrameStatus::Orphaned, _) | (_, None) => return Ok(()),
        (_, Some(bytes)) => store_image(suite, name, verdict, bytes)?,
    }
    discard_removal(suite, name)
}

/// Stores a frame that changed or fails in the folder of a report, if it may become a reference.
fn keep_rendered(report: &Path, frame: &TestedFrame) -> Result<()> {
    let TestedFrame { result, file } = frame;
    match file {
        Some(bytes) if result.verdict() != Verdict::Identical && result.status != FrameStatus::Broken => {
            store_rendered(report, &result.name, bytes)
        }
        _ => Ok(()),
    }
}

fn tested(context: &TestContext<'_>, shot: &SuiteShot, limits: PresetLimits) -> Result<TestedShot> {
    let ShotJob { sequence: mut job, warnings } = job_of(context.suite, &shot.path)?;
    job.max_memory_bytes /= context.shots_at_once.max(1) as u64;
    let rendered = render_shot(job, context.cancel)?;
    let count = rendered.frames.len();
    let frames = rendered.frames.iter().map(|(frame, file)| {
        let id =
            FrameId { name: image_name(&shot.name, *frame, count), frame: (count > 1).then_some(*frame) };
        let mut tested = match file {
            Ok(file) => test_frame(context.suite, &limits.limits, id, file)?,
            Err(error) => {
                TestedFrame { result: id.result(FrameStatus::Broken, error.to_string()), file: None }
            }
        };
        context.image_budget.admit(&mut tested.result);
        Ok(tested)
    });
    Ok(TestedShot {
        frames: frames.collect::<Result<_>>()?,
        warnings: warnings.iter().map(ToString::to_string).collect(),
    })
}

/// The name of a frame's reference, and the frame number in shots of several frames.
struct FrameId {
    name: String,
    frame: Option<i64>,
}

impl FrameId {
    fn result(self, status: FrameStatus, message: String) -> FrameResult {
        FrameResult::new(self.name, self.frame, status, message)
    }
}

/// Compares the image in `file` with its reference.
fn test_frame(suite: &Suite, limits: &Limits, id: FrameId, file: &Path) -> Result<TestedFrame> {
    let reference = reference_path(&suite.references, &id.name);
    let bytes = std::fs::read(file).map_err(Error::missing(file))?;
    let actual = Image::decode(file, &bytes)?;
    let mut result = if reference.exists() {
        match Image::read(&reference) {
            Ok(expected) => compare_frame(id, &actual, &expected, limits),
            Err(error) => id.result(FrameStatus::Different, error.to_string()),
        }
    } else {
        id.result(FrameStatus::Missing, format!("there is no reference {}", reference.display()))
    };
    let stored = if result.passes() { size_of(&reference) } else { bytes.len() as u64 };
    if let Some(message) = suite.too_large(stored) {
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
    }
    Ok(TestedFrame { result, file: Some(bytes) })
}

fn compare_frame(id: FrameId, actual: &Image, expected: &Image, limits: &Limits) -> FrameResult {
    let mut comparison = compare(actual, expected, limits);
    let mut result = id.result(FrameStatus::Passed, String::new());
    result.messages.clear();
    match comparison.verdict() {
        Verdict::Identical => comparison.flip_map = None,
        Verdict::Changed => result.messages = comparison.largest_measure().into_iter().collect(),
        Verdict::Failed => {
            result.status = FrameStatus::Different;
            result.messages = comparison.failures();
        }
    }
    if comparison.verdict() != Verdict::Identical {
        result.expected = EncodedImage::new(expected);
    }
    result.comparison = Some(comparison);
    result
}

fn size_of(file: &Path) -> u64 {
    std::fs::metadata(file).map_or(0, |metadata| metadata.len())
}
