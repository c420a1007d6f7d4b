//! The results of a run: suite → shot → frame → comparison.
//!
//! The command line's JSON, JUnit's XML and the HTML page are all written from this tree. Its JSON form is that of
//! `schema/test.schema.json`.

use std::path::PathBuf;

use serde::ser::SerializeStruct as _;
use serde::{Deserialize, Serialize, Serializer};

use super::comparison::Comparison;
use super::encoded_image::EncodedImage;
use super::presets::Limits;
use super::verdict::{FailOn, Verdict, VerdictCounts};
use crate::error::Error;

/// The result of a suite.
#[derive(Debug, Default, Serialize)]
pub struct SuiteResult {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Tested shots, sorted by name.
    pub shots: Vec<ShotResult>,
    /// References that no shot renders.
    #[serde(rename = "dangling", serialize_with = "names")]
    pub orphaned: Vec<FrameResult>,
    /// Errors of updating pending images after the last shot.
    #[serde(skip)]
    pub not_kept: Vec<Error>,
    /// Files `.toml` that have no setting of a shot, and are skipped.
    #[serde(skip)]
    pub stray: Vec<PathBuf>,
    /// Names of the selected shots of which no file changed since the revision that the options name.
    pub not_tested: Vec<String>,
    /// The first error of keeping verdicts for the next run.
    #[serde(skip)]
    pub not_cached: Option<Error>,
}

/// The result of one shot.
#[derive(Debug)]
pub struct ShotResult {
    /// The shot's name, such as `light/point`.
    pub name: String,
    /// The shot file or scene.
    pub path: PathBuf,
    /// The preset's name, with a suffix where single limits were changed.
    pub preset: String,
    /// The limits.
    pub limits: Limits,
    /// All frames in order. A shot that cannot be opened has a single broken frame.
    pub frames: Vec<FrameResult>,
    /// Features of the scene that are not honoured.
    pub warnings: Vec<String>,
    /// Errors of storing pending images beside the references.
    pub not_kept: Vec<Error>,
    /// Seconds spent rendering and comparing.
    pub seconds: f64,
    /// Whether it was not rendered, because nothing changed since an earlier run in which all of its images were identical.
    pub is_cached: bool,
    /// Whether it could not be opened, so that its frames are unknown. False in merged reports, which do not tell.
    pub is_unopened: bool,
}

/// The result of one frame.
#[derive(Clone, Debug)]
pub struct FrameResult {
    /// The name of the reference without extension: `light/point`, `light/point.0012`.
    pub name: String,
    /// The frame number, for shots of several frames.
    pub frame: Option<i64>,
    /// The outcome.
    pub status: FrameStatus,
    /// Failures, one line each; the largest measure of an image that changed within the limits.
    pub messages: Vec<String>,
    /// Hash of the rendered pixels ([`super::pixel_hash`]), which approvals name. `None` for identical frames.
    pub actual_hash: Option<String>,
    /// Hash of the values of a rendered image that has no reference, without its scene. `None` in merged reports.
    pub value_hash: Option<String>,
    /// SHA-256 of the file of the reference. `None` where there is none.
    pub reference_hash: Option<String>,
    /// The comparison with the reference. `None` where there was nothing to compare.
    pub comparison: Option<Comparison>,
    /// The reference, for frames that changed or fail.
    pub expected: Option<EncodedImage>,
    /// The rendered image, for frames that changed or fail.
    pub actual: Option<EncodedImage>,
}

/// The outcome of one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameStatus {
    /// The image is within the limits of its reference.
    Passed,
    /// The image differs from its reference.
    Different,
    /// There is no reference yet.
    Missing,
    /// A reference that no shot renders. An approval removes it.
    Orphaned,
    /// The frame could not be rendered, or its image cannot become a reference.
    Broken,
}

impl FrameStatus {
    /// The name in JSON, JUnit and the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Different => "different",
            Self::Missing => "missing",
            Self::Orphaned => "orphaned",
            Self::Broken => "broken",
        }
    }
}

impl FrameResult {
    /// A result without messages and images.
    pub fn new(name: String, frame: Option<i64>, status: FrameStatus) -> Self {
        Self {
            name,
            frame,
            status,
            messages: Vec::new(),
            comparison: None,
            expected: None,
            actual: None,
            actual_hash: None,
            value_hash: None,
            reference_hash: None,
        }
    }

    /// The same result with one more message.
    #[must_use]
    pub fn because(mut self, message: impl Into<String>) -> Self {
        self.messages.push(message.into());
        self
    }

    /// Whether the frame is identical, changed within the limits, or failed.
    pub fn verdict(&self) -> Verdict {
        match (self.status, &self.comparison) {
            (FrameStatus::Passed, Some(comparison)) if comparison.verdict() == Verdict::Identical => {
                Verdict::Identical
            }
            (FrameStatus::Passed, _) => Verdict::Changed,
            _ => Verdict::Failed,
        }
    }

    /// The status in words, for lists: of frames that pass, the verdict.
    pub fn kind(&self) -> &'static str {
        match self.status {
            FrameStatus::Passed => self.verdict().name(),
            failed => failed.name(),
        }
    }

    /// Whether the frame passes.
    pub fn passes(&self) -> bool {
        self.status == FrameStatus::Passed
    }

    /// The likely cause as a sentence.
    pub fn likely_cause(&self) -> Option<String> {
        self.comparison.as_ref()?.cause.as_ref().map(ToString::to_string)
    }

    /// The folder of the reference; empty for the suite's own.
    pub fn folder(&self) -> &str {
        folder_of(&self.name)
    }
}

impl ShotResult {
    /// The worst verdict of its frames.
    pub fn verdict(&self) -> Verdict {
        self.frames.iter().map(FrameResult::verdict).collect::<VerdictCounts>().worst()
    }

    /// Whether every frame passes.
    pub fn passes(&self) -> bool {
        self.frames.iter().all(FrameResult::passes)
    }

    /// Failures, one line each, with the names of their frames.
    pub fn failures(&self) -> Vec<String> {
        failures_of(self.frames.iter())
    }

    /// The folder of the shot; empty for the suite's own.
    pub fn folder(&self) -> &str {
        folder_of(&self.name)
    }
}

impl SuiteResult {
    /// Whether every frame passes and no reference is orphaned.
    pub fn passes(&self) -> bool {
        self.orphaned.is_empty() && self.shots.iter().all(ShotResult::passes)
    }

    /// Errors of storing and discarding pending images.
    pub fn not_kept(&self) -> impl Iterator<Item = &Error> {
        self.shots.iter().flat_map(|shot| &shot.not_kept).chain(&self.not_kept)
    }

    /// All frames, then the orphaned references.
    pub fn frames(&self) -> impl Iterator<Item = &FrameResult> {
        self.shots.iter().flat_map(|shot| &shot.frames).chain(&self.orphaned)
    }

    /// Failures, one line each, with the names of their frames.
    pub fn failures(&self) -> Vec<String> {
        failures_of(self.frames())
    }

    /// Numbers of frames by verdict. Orphaned references fail.
    pub fn counts(&self) -> VerdictCounts {
        self.frames().map(FrameResult::verdict).collect()
    }

    /// Whether a verdict makes the run fail.
    pub fn fails(&self, fail_on: FailOn) -> bool {
        fail_on.fails(self.counts().worst())
    }
}

impl Serialize for ShotResult {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut shot = serializer.serialize_struct("ShotResult", 9)?;
        shot.serialize_field("name", &self.name)?;
        shot.serialize_field("file", &self.path.display().to_string())?;
        shot.serialize_field("passes", &self.passes())?;
        shot.serialize_field("preset", &self.preset)?;
        shot.serialize_field("limits", &self.limits)?;
        shot.serialize_field("seconds", &self.seconds)?;
        shot.serialize_field("cached", &self.is_cached)?;
        shot.serialize_field("warnings", &self.warnings)?;
        shot.serialize_field("pictures", &self.frames)?;
        shot.end()
    }
}

impl Serialize for FrameResult {
    /// Serialises the verdict, too. A frame without a comparison has the fields of an empty one.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Fields<'a> {
            name: &'a str,
            frame: Option<i64>,
            status: FrameStatus,
            verdict: Verdict,
            messages: &'a [String],
            hash: Option<&'a str>,
            reference: Option<&'a str>,
            #[serde(flatten)]
            comparison: &'a Comparison,
        }
        let none = Comparison::default();
        let fields = Fields {
            name: &self.name,
            frame: self.frame,
            status: self.status,
            verdict: self.verdict(),
            messages: &self.messages,
            hash: self.actual_hash.as_deref(),
            reference: self.reference_hash.as_deref(),
            comparison: self.comparison.as_ref().unwrap_or(&none),
        };
        fields.serialize(serializer)
    }
}

fn names<S: Serializer>(frames: &[FrameResult], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(frames.iter().map(|frame| &frame.name))
}

fn failures_of<'a>(frames: impl Iterator<Item = &'a FrameResult>) -> Vec<String> {
    let lines = frames
        .filter(|frame| !frame.passes())
        .flat_map(|frame| frame.messages.iter().map(|message| format!("{}: {message}", frame.name)));
    lines.collect()
}

/// The folder of a name; empty where there is none.
pub(super) fn folder_of(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(folder, _)| folder)
}
