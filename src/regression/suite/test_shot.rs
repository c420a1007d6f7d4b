//! One shot: rendered, compared, and kept where it differs.

use std::path::Path;
use std::time::Instant;

use super::super::{
    EncodedPicture, FrameStatus, Judgement, LayeredPicture, Limits, ReportedFrame, judge, pixel_hash,
};
use super::limits::PresetLimits;
use super::names::{picture_name, reference_path};
use super::pending::keep;
use super::render::render_shot;
use super::result::is_passed;
use super::{ShotReader, ShotResult, Suite, SuiteShot};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};

/// Renders and compares one shot.
///
/// # Errors
/// [`Error::Interrupted`] when cancelled, and what writing beside the references meets; all else is in the result.
pub fn test_shot(
    suite: &Suite,
    reader: &dyn ShotReader,
    shot: &SuiteShot,
    keeps_pending: bool,
    cancel: &CancelFlag,
) -> Result<ShotResult> {
    cancel.check()?;
    let start = Instant::now();
    let limits = suite.limits_of(&shot.path);
    let passing = limits.as_ref().map_or(suite.limits, |limits| *limits);
    let tested = match limits.and_then(|limits| tested(suite, reader, shot, limits, cancel)) {
        Ok(tested) => tested,
        Err(error @ Error::Interrupted(_)) => return Err(error),
        Err(error) => unopened(shot, &error),
    };
    if keeps_pending {
        for picture in &tested.pictures {
            keep(suite, &picture.reported.name, picture.pending.as_deref())?;
        }
    }
    Ok(ShotResult {
        name: shot.name.clone(),
        path: shot.path.clone(),
        preset: passing.name(),
        limits: passing.limits,
        pictures: tested.pictures.into_iter().map(|picture| picture.reported).collect(),
        warnings: tested.warnings,
        seconds: start.elapsed().as_secs_f64(),
    })
}

struct TestedShot {
    pictures: Vec<TestedPicture>,
    warnings: Vec<String>,
}

/// A picture, and the file that may become its reference.
struct TestedPicture {
    reported: ReportedFrame,
    pending: Option<Vec<u8>>,
}

fn unopened(shot: &SuiteShot, error: &Error) -> TestedShot {
    let reported = broken(shot.name.clone(), None, error.to_string());
    TestedShot { pictures: vec![TestedPicture { reported, pending: None }], warnings: Vec::new() }
}

pub(super) fn broken(name: String, frame: Option<i64>, message: String) -> ReportedFrame {
    ReportedFrame {
        name,
        frame,
        status: FrameStatus::Broken,
        messages: vec![message],
        judgement: None,
        expected: None,
        actual: None,
        actual_hash: None,
    }
}

fn tested(
    suite: &Suite,
    reader: &dyn ShotReader,
    shot: &SuiteShot,
    limits: PresetLimits,
    cancel: &CancelFlag,
) -> Result<TestedShot> {
    let (job, warnings) = reader.job(suite, &shot.path)?;
    let rendered = render_shot(job, cancel)?;
    let count = rendered.frames.len();
    let pictures = rendered.frames.iter().map(|(frame, file)| {
        let name = picture_name(&shot.name, *frame, count);
        let number = (count > 1).then_some(*frame);
        match file {
            Ok(file) => compared(suite, &limits.limits, name, number, file),
            Err(error) => {
                Ok(TestedPicture { reported: broken(name, number, error.to_string()), pending: None })
            }
        }
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
    name: String,
    frame: Option<i64>,
    file: &Path,
) -> Result<TestedPicture> {
    let reference = reference_path(&suite.references, &name);
    let actual = LayeredPicture::read(file)?;
    let bytes = std::fs::read(file).map_err(Error::missing(file))?;
    let mut reported = broken(name, frame, String::new());
    reported.messages.clear();
    if reference.exists() {
        match LayeredPicture::read(&reference) {
            Ok(expected) => settle(&mut reported, &actual, &expected, limits),
            Err(error) => {
                reported.status = FrameStatus::Different;
                reported.messages.push(error.to_string());
            }
        }
    } else {
        reported.status = FrameStatus::Missing;
        reported.messages.push(format!("there is no reference {}", reference.display()));
    }
    let stored = if is_passed(&reported) { size_of(&reference) } else { bytes.len() as u64 };
    if stored > suite.max_reference_bytes {
        reported.status = FrameStatus::Broken;
        reported.messages.push(format!(
            "the file has {} KiB and a reference at most {}; ask for fewer pixels or layers, or raise max_reference_kib",
            stored.div_ceil(1024),
            suite.max_reference_bytes / 1024
        ));
    }
    if !is_passed(&reported) {
        reported.actual = EncodedPicture::new(&actual);
        reported.actual_hash = Some(pixel_hash(&actual));
    }
    let waits = matches!(reported.status, FrameStatus::Missing | FrameStatus::Different);
    Ok(TestedPicture { reported, pending: waits.then_some(bytes) })
}

fn settle(reported: &mut ReportedFrame, actual: &LayeredPicture, expected: &LayeredPicture, limits: &Limits) {
    let mut judgement: Judgement = judge(actual, expected, limits);
    if judgement.passes() {
        reported.status = FrameStatus::Passed;
        judgement.flip_map = None;
    } else {
        reported.status = FrameStatus::Different;
        reported.messages = judgement.failures();
        reported.expected = EncodedPicture::new(expected);
    }
    reported.judgement = Some(judgement);
}

fn size_of(file: &Path) -> u64 {
    std::fs::metadata(file).map_or(0, |metadata| metadata.len())
}
