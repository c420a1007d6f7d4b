//! One shot: rendered, compared, and kept where it differs.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use super::super::{
    Comparison, EncodedImage, FrameStatus, Image, ImageBudget, Limits, ReportedFrame, compare, pixel_hash,
};
use super::limits::PresetLimits;
use super::names::{image_name, reference_path};
use super::pending::{discard_image, discard_removal, store_image};
use super::render::render_shot;
use super::{ShotReader, ShotResult, Suite, SuiteShot};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};

/// What all shots of a run have in common.
#[derive(Clone, Copy)]
pub struct TestContext<'a> {
    /// The suite.
    pub suite: &'a Suite,
    /// Understands its shots.
    pub reader: &'a dyn ShotReader,
    /// Whether pictures without reference, and those that differ, are kept beside the references.
    pub keeps_pending: bool,
    /// For the pictures of failures, until the report is written.
    pub room: &'a ImageBudget,
    /// Shots that are tested at the same time, which share the memory.
    pub shots_at_once: usize,
    /// Raised to stop.
    pub cancel: &'a CancelFlag,
}

/// Renders and compares one shot.
///
/// # Errors
/// [`Error::Interrupted`] when cancelled; all else is in the result.
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
    if context.keeps_pending {
        not_kept.extend(tested.pictures.iter().filter_map(|picture| settle(context.suite, picture).err()));
    }
    Ok(ShotResult {
        name: shot.name.clone(),
        path: shot.path.clone(),
        preset: passing.name(),
        limits: passing.limits,
        pictures: tested.pictures.into_iter().map(|picture| picture.reported).collect(),
        warnings: tested.warnings,
        not_kept,
        seconds: start.elapsed().as_secs_f64(),
    })
}

struct TestedShot {
    pictures: Vec<TestedFrame>,
    warnings: Vec<String>,
}

/// A picture, and the file that may become its reference.
struct TestedFrame {
    reported: ReportedFrame,
    file: Option<Vec<u8>>,
}

fn unopened(shot: &SuiteShot, message: String) -> TestedShot {
    let reported = reported(shot.name.clone(), None, FrameStatus::Broken, message);
    TestedShot { pictures: vec![TestedFrame { reported, file: None }], warnings: Vec::new() }
}

/// A picture of which only this is known.
pub(super) fn reported(
    name: String,
    frame: Option<i64>,
    status: FrameStatus,
    message: String,
) -> ReportedFrame {
    ReportedFrame {
        name,
        frame,
        status,
        messages: vec![message],
        comparison: None,
        expected: None,
        actual: None,
        actual_hash: None,
    }
}

/// Keeps a picture that somebody has to look at, and forgets what earlier runs kept where it passes. What cannot be tested says
/// nothing about that.
fn settle(suite: &Suite, picture: &TestedFrame) -> Result<()> {
    let name = &picture.reported.name;
    match (picture.reported.status, &picture.file) {
        (FrameStatus::Passed, _) => discard_image(suite, name)?,
        (FrameStatus::Missing | FrameStatus::Different, Some(bytes)) => store_image(suite, name, bytes)?,
        _ => return Ok(()),
    }
    discard_removal(suite, name)
}

fn tested(context: &TestContext<'_>, shot: &SuiteShot, limits: PresetLimits) -> Result<TestedShot> {
    let (mut job, warnings) = context.reader.job(context.suite, &shot.path)?;
    job.max_memory_bytes /= context.shots_at_once.max(1) as u64;
    let rendered = render_shot(job, context.cancel)?;
    let count = rendered.frames.len();
    let pictures = rendered.frames.iter().map(|(frame, file)| {
        let name = image_name(&shot.name, *frame, count);
        let number = (count > 1).then_some(*frame);
        let mut picture = match file {
            Ok(file) => compared(context.suite, &limits.limits, (name, number), file)?,
            Err(error) => {
                let reported = reported(name, number, FrameStatus::Broken, error.to_string());
                TestedFrame { reported, file: None }
            }
        };
        context.room.admit(&mut picture.reported);
        Ok(picture)
    });
    Ok(TestedShot {
        pictures: pictures.collect::<Result<_>>()?,
        warnings: warnings.iter().map(ToString::to_string).collect(),
    })
}

/// Compares the picture in `file` with the reference of its name.
fn compared(
    suite: &Suite,
    limits: &Limits,
    (name, frame): (String, Option<i64>),
    file: &Path,
) -> Result<TestedFrame> {
    let reference = reference_path(&suite.references, &name);
    let bytes = std::fs::read(file).map_err(Error::missing(file))?;
    let actual = Image::decode(file, &bytes)?;
    let mut picture = if reference.exists() {
        match Image::read(&reference) {
            Ok(expected) => against_reference((name, frame), &actual, &expected, limits),
            Err(error) => reported(name, frame, FrameStatus::Different, error.to_string()),
        }
    } else {
        let message = format!("there is no reference {}", reference.display());
        reported(name, frame, FrameStatus::Missing, message)
    };
    let is_passed = picture.status == FrameStatus::Passed;
    let stored = if is_passed { size_of(&reference) } else { bytes.len() as u64 };
    if let Some(message) = suite.too_large(stored) {
        picture.status = FrameStatus::Broken;
        picture.messages.insert(0, message);
    }
    if picture.status != FrameStatus::Passed {
        let errors = picture.comparison.as_mut().and_then(|comparison| comparison.flip_map.take());
        picture.actual = EncodedImage::new(&actual).map(|packed| match &errors {
            Some(map) => packed.with_errors(map),
            None => packed,
        });
        picture.actual_hash = Some(pixel_hash(&actual));
    }
    Ok(TestedFrame { reported: picture, file: Some(bytes) })
}

fn against_reference(
    (name, frame): (String, Option<i64>),
    actual: &Image,
    expected: &Image,
    limits: &Limits,
) -> ReportedFrame {
    let mut comparison: Comparison = compare(actual, expected, limits);
    let passes = comparison.passes();
    let mut picture = reported(name, frame, FrameStatus::Passed, String::new());
    picture.messages = comparison.failures();
    if passes {
        comparison.flip_map = None;
    } else {
        picture.status = FrameStatus::Different;
        picture.expected = EncodedImage::new(expected);
    }
    picture.comparison = Some(comparison);
    picture
}

fn size_of(file: &Path) -> u64 {
    std::fs::metadata(file).map_or(0, |metadata| metadata.len())
}
