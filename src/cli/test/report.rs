//! What `rayframe test --json` prints. `schema` grows when a field goes away or changes what it means.

use std::path::Path;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::regression::suite::{ShotResult, Suite, SuiteResult};
use crate::regression::{Cause, Check, Fault, FrameStatus, Limits, PooledErrors, ReportedFrame};

const SCHEMA: u32 = 1;

#[derive(Debug, Serialize)]
struct SuiteReport<'a> {
    schema: u32,
    suite: String,
    report: String,
    passes: bool,
    passed: usize,
    failed: usize,
    seconds: f64,
    shots: Vec<ShotReport<'a>>,
    /// References that no shot asks for.
    dangling: Vec<&'a str>,
}

#[derive(Debug, Serialize)]
struct ShotReport<'a> {
    name: &'a str,
    file: String,
    passes: bool,
    preset: &'a str,
    /// Infinite ones are `null`.
    limits: Limits,
    seconds: f64,
    warnings: &'a [String],
    pictures: Vec<PictureReport<'a>>,
}

#[derive(Debug, Serialize)]
struct PictureReport<'a> {
    name: &'a str,
    frame: Option<i64>,
    status: FrameStatus,
    /// The lines that people read.
    messages: &'a [String],
    /// Of the rendered picture, unless it passes.
    hash: Option<&'a str>,
    identical: bool,
    faults: &'a [Fault],
    checks: &'a [Check],
    cause: Option<&'a Cause>,
    likely: Option<String>,
    flip: Option<PooledErrors>,
}

/// The result as JSON.
pub(super) fn json(suite: &Suite, result: &SuiteResult, page: &Path) -> Result<String> {
    let (passed, failed) = result.counts();
    let report = SuiteReport {
        schema: SCHEMA,
        suite: suite.file.display().to_string(),
        report: page.display().to_string(),
        passes: result.passes(),
        passed,
        failed,
        seconds: result.seconds,
        shots: result.shots.iter().map(shot_report).collect(),
        dangling: result.dangling.iter().map(|picture| picture.name.as_str()).collect(),
    };
    serde_json::to_string_pretty(&report).map_err(|error| Error::Internal { message: error.to_string() })
}

fn shot_report(shot: &ShotResult) -> ShotReport<'_> {
    ShotReport {
        name: &shot.name,
        file: shot.path.display().to_string(),
        passes: shot.passes(),
        preset: &shot.preset,
        limits: shot.limits,
        seconds: shot.seconds,
        warnings: &shot.warnings,
        pictures: shot.pictures.iter().map(picture_report).collect(),
    }
}

fn picture_report(picture: &ReportedFrame) -> PictureReport<'_> {
    let judgement = picture.judgement.as_ref();
    PictureReport {
        name: &picture.name,
        frame: picture.frame,
        status: picture.status,
        messages: &picture.messages,
        hash: picture.actual_hash.as_deref(),
        identical: judgement.is_some_and(|judgement| judgement.is_identical),
        faults: judgement.map_or(&[], |judgement| &judgement.faults),
        checks: judgement.map_or(&[], |judgement| &judgement.checks),
        cause: judgement.and_then(|judgement| judgement.cause.as_ref()),
        likely: judgement.and_then(|judgement| judgement.cause.as_ref()).map(ToString::to_string),
        flip: judgement.and_then(|judgement| judgement.flip),
    }
}
