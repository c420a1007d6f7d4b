//! What `rayframe test --json` prints. `schema` grows when a field goes away or changes what it means.

use std::path::Path;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::regression::suite::{ShotResult, Suite, SuiteResult};
use crate::regression::{Cause, Check, FrameStatus, Limits, Mismatch, PooledErrors, ReportedFrame};

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
    pictures: Vec<FrameReport<'a>>,
}

#[derive(Debug, Serialize)]
struct FrameReport<'a> {
    name: &'a str,
    frame: Option<i64>,
    status: FrameStatus,
    /// The lines that people read.
    messages: &'a [String],
    /// Of the rendered picture, unless it passes.
    hash: Option<&'a str>,
    identical: bool,
    #[serde(rename = "faults")]
    mismatches: &'a [Mismatch],
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
        dangling: result.orphaned.iter().map(|picture| picture.name.as_str()).collect(),
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
        pictures: shot.pictures.iter().map(frame_report).collect(),
    }
}

fn frame_report(picture: &ReportedFrame) -> FrameReport<'_> {
    let comparison = picture.comparison.as_ref();
    FrameReport {
        name: &picture.name,
        frame: picture.frame,
        status: picture.status,
        messages: &picture.messages,
        hash: picture.actual_hash.as_deref(),
        identical: comparison.is_some_and(|comparison| comparison.is_identical),
        mismatches: comparison.map_or(&[], |comparison| &comparison.mismatches),
        checks: comparison.map_or(&[], |comparison| &comparison.checks),
        cause: comparison.and_then(|comparison| comparison.cause.as_ref()),
        likely: comparison.and_then(|comparison| comparison.cause.as_ref()).map(ToString::to_string),
        flip: comparison.and_then(|comparison| comparison.flip),
    }
}
