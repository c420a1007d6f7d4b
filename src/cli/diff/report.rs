//! What `rayframe diff --json` prints. `schema` grows when a field goes away or changes what it means.

use serde::Serialize;

use super::{missing, shown};
use crate::regression::{
    Cause, Check, Comparison, ExposureRange, FilePair, LayerDifference, Limits, Mismatch, PairedFiles,
    PooledErrors, Preset, RootMeanSquare,
};

const SCHEMA: u32 = 1;

/// All frames.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    schema: u32,
    pub(super) preset: Preset,
    /// Infinite ones are `null`.
    limits: Limits,
    /// Whether everything passes and nothing is missing.
    pub(super) same: bool,
    /// Files of the reference without a frame of what is judged.
    pub(super) missing_in_actual: Vec<String>,
    /// Files of what is judged without a reference.
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

/// Two files.
#[derive(Debug, Serialize)]
pub(super) struct FrameReport {
    pub(super) frame: Option<i64>,
    pub(super) actual: String,
    pub(super) reference: String,
    pub(super) same: bool,
    pub(super) identical: bool,
    actual_hash: String,
    reference_hash: String,
    #[serde(rename = "faults")]
    pub(super) mismatches: Vec<Mismatch>,
    /// The lines that people read.
    pub(super) failures: Vec<String>,
    pub(super) checks: Vec<Check>,
    pub(super) cause: Option<Cause>,
    likely: Option<String>,
    pub(super) flip: Option<PooledErrors>,
    exposures: Option<Exposures>,
    pub(super) root_mean_square: Option<RootMeanSquare>,
    layers: Vec<LayerDifference>,
}

/// The exposures of FLIP of light, in stops.
#[derive(Debug, Serialize)]
struct Exposures {
    start: f32,
    stop: f32,
    count: u32,
}

impl FrameReport {
    pub(super) fn new(
        pair: &FilePair,
        comparison: Comparison,
        exposures: Option<ExposureRange>,
        (actual_hash, reference_hash): (String, String),
    ) -> Self {
        Self {
            frame: pair.frame,
            actual: shown(&pair.actual),
            reference: shown(&pair.reference),
            same: comparison.passes(),
            identical: comparison.is_identical,
            actual_hash,
            reference_hash,
            failures: comparison.failures(),
            likely: comparison.cause.as_ref().map(ToString::to_string),
            mismatches: comparison.mismatches,
            checks: comparison.checks,
            cause: comparison.cause,
            flip: comparison.flip,
            exposures: exposures.map(|ExposureRange { start, stop, count }| Exposures { start, stop, count }),
            root_mean_square: comparison.root_mean_square,
            layers: comparison.layers,
        }
    }
}

impl Report {
    pub(super) fn new(preset: Preset, frames: Vec<FrameReport>, paired: &PairedFiles) -> Self {
        let (missing_in_actual, missing_in_reference) = missing(paired);
        let nothing_missing = missing_in_actual.is_empty() && missing_in_reference.is_empty();
        let flip = |value: fn(&PooledErrors) -> f64| {
            frames.iter().map(|frame| frame.flip.as_ref().map(value)).collect()
        };
        let series = Series {
            frame: frames.iter().map(|frame| frame.frame).collect(),
            mean_flip: flip(|flip| flip.mean),
            tile_flip: flip(|flip| flip.tile),
            rmse: frames.iter().map(|frame| frame.root_mean_square.map(|found| found.error)).collect(),
        };
        Self {
            schema: SCHEMA,
            preset,
            limits: preset.limits(),
            same: nothing_missing && frames.iter().all(|frame| frame.same),
            missing_in_actual,
            missing_in_reference,
            series,
            frames,
        }
    }
}
