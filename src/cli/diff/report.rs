//! The JSON that `rayframe diff --json` prints (`schema/diff.schema.json`). The schema number grows when a field is removed or changes
//! its meaning.

use std::path::PathBuf;

use serde::Serialize;

use super::args::shown;
use rayframe::regression::{
    Comparison, FilePair, Limits, PairedFiles, PooledErrors, Preset, Verdict, VerdictCounts,
};

const SCHEMA: u32 = 1;

/// The result of all frames.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    schema: u32,
    pub(super) preset: Preset,
    /// Infinite limits are `null`.
    limits: Limits,
    /// Whether everything passes and nothing is missing.
    pub(super) same: bool,
    /// The worst verdict; `failed` where a file has no counterpart.
    pub(super) verdict: Verdict,
    /// References without an actual file.
    pub(super) missing_in_actual: Vec<String>,
    /// Actual files without a reference.
    pub(super) missing_in_reference: Vec<String>,
    pub(super) series: Series,
    pub(super) frames: Vec<FrameReport>,
}

/// One number a frame, in the order of `frames`; `null` where there is none.
#[derive(Debug, Serialize)]
pub(super) struct Series {
    frame: Vec<Option<i64>>,
    pub(super) mean_flip: Vec<Option<f64>>,
    pub(super) tile_flip: Vec<Option<f64>>,
    rmse: Vec<Option<f64>>,
}

/// The comparison of two files.
#[derive(Debug, Serialize)]
pub(super) struct FrameReport {
    pub(super) frame: Option<i64>,
    pub(super) actual: String,
    pub(super) reference: String,
    pub(super) same: bool,
    pub(super) verdict: Verdict,
    actual_hash: String,
    reference_hash: String,
    /// Mismatches and failed checks, one line each.
    pub(super) failures: Vec<String>,
    #[serde(flatten)]
    pub(super) comparison: Comparison,
}

impl FrameReport {
    pub(super) fn new(
        pair: &FilePair,
        comparison: Comparison,
        [actual_hash, reference_hash]: [String; 2],
    ) -> Self {
        Self {
            frame: pair.frame,
            actual: shown(&pair.actual),
            reference: shown(&pair.reference),
            same: comparison.passes(),
            verdict: comparison.verdict(),
            actual_hash,
            reference_hash,
            failures: comparison.failures(),
            comparison,
        }
    }
}

impl Report {
    pub(super) fn new(preset: Preset, frames: Vec<FrameReport>, paired: &PairedFiles) -> Self {
        let (missing_in_actual, missing_in_reference) = missing(paired);
        let nothing_missing = missing_in_actual.is_empty() && missing_in_reference.is_empty();
        let flip = |value: fn(&PooledErrors) -> f64| {
            frames.iter().map(|frame| frame.comparison.flip.as_ref().map(value)).collect()
        };
        let series = Series {
            frame: frames.iter().map(|frame| frame.frame).collect(),
            mean_flip: flip(|flip| flip.mean),
            tile_flip: flip(|flip| flip.tile),
            rmse: frames
                .iter()
                .map(|frame| frame.comparison.root_mean_square.map(|found| found.error))
                .collect(),
        };
        let worst = frames.iter().map(|frame| frame.verdict).collect::<VerdictCounts>().worst();
        let verdict = if nothing_missing { worst } else { Verdict::Failed };
        Self {
            schema: SCHEMA,
            preset,
            limits: preset.limits(),
            same: verdict != Verdict::Failed,
            verdict,
            missing_in_actual,
            missing_in_reference,
            series,
            frames,
        }
    }
}

/// Files without a counterpart: references without an actual file, then actual files without a reference.
fn missing(paired: &PairedFiles) -> (Vec<String>, Vec<String>) {
    let list = |files: &[PathBuf]| files.iter().map(|file| shown(file)).collect();
    (list(&paired.only_in_reference), list(&paired.only_in_actual))
}
