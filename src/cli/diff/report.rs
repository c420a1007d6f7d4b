//! The JSON that `rayframe diff --json` prints (`schema/diff.schema.json`). The schema number grows when a field is removed or changes
//! its meaning.

use std::path::PathBuf;

use serde::Serialize;

use super::args::{DiffArgs, shown};
use rayframe::asset_diff::{AssetFacts, Change};
use rayframe::error::{Error, Result};
use rayframe::regression::{
    Comparison, FilePair, Limits, PairedFiles, PooledErrors, Preset, Verdict, VerdictCounts,
};

const SCHEMA: u32 = 1;

/// The result of all frames.
#[derive(Debug, Serialize)]
pub(super) struct Report<'a> {
    schema: u32,
    preset: Preset,
    /// The preset's name, with a suffix where single limits are changed.
    #[serde(skip)]
    pub(super) preset_name: String,
    /// Infinite limits are `null`.
    pub(super) limits: Limits,
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
    /// The contents of two scenes; absent for images.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) asset: Option<AssetReport<'a>>,
}

/// What changed between two scenes.
#[derive(Debug, Serialize)]
pub(super) struct AssetReport<'a> {
    /// Content that is lost, one line each, where that fails.
    pub(super) losses: Vec<String>,
    pub(super) changes: &'a [Change],
    pub(super) actual: &'a AssetFacts,
    pub(super) reference: &'a AssetFacts,
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
    /// The view of an asset; absent for images.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) view: Option<String>,
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
            view: None,
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

impl Report<'_> {
    pub(super) fn new(args: &DiffArgs, frames: Vec<FrameReport>, paired: &PairedFiles) -> Self {
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
            preset: args.preset,
            preset_name: args.limits.preset_name(args.preset),
            limits: args.limits.limits(args.preset),
            same: verdict != Verdict::Failed,
            verdict,
            missing_in_actual,
            missing_in_reference,
            series,
            frames,
            asset: None,
        }
    }

    /// The text of the JSON.
    pub(super) fn json(&self) -> Result<String> {
        serde_json::to_string_pretty(self).map_err(|error| Error::Internal { message: error.to_string() })
    }
}

/// Files without a counterpart: references without an actual file, then actual files without a reference.
fn missing(paired: &PairedFiles) -> (Vec<String>, Vec<String>) {
    let list = |files: &[PathBuf]| files.iter().map(|file| shown(file)).collect();
    (list(&paired.only_in_reference), list(&paired.only_in_actual))
}
