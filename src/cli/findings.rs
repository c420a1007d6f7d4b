//! The images of a result that are not identical to their references, worst first, as summaries and annotations list them.

use std::path::{Path, PathBuf};

use rayframe::regression::suite::Suite;
use rayframe::regression::{FailOn, FrameResult, Mismatch, SuiteResult, Verdict};

/// An image that changed or fails.
#[derive(Clone, Debug)]
pub(super) struct Finding<'a> {
    /// The result.
    pub(super) frame: &'a FrameResult,
    /// The shot file, the scene, the reference that no shot renders, or the compared file.
    file: PathBuf,
    /// Whether it makes the command fail.
    pub(super) fails: bool,
}

/// The findings of a suite, [sorted](findings).
pub(super) fn findings_of_suite<'a>(
    suite: &Suite,
    result: &'a SuiteResult,
    fail_on: FailOn,
) -> Vec<Finding<'a>> {
    let frames =
        result.shots.iter().flat_map(|shot| shot.frames.iter().map(|frame| (frame, shot.path.clone())));
    let reference = |frame: &FrameResult| suite.references.join(format!("{}.exr", frame.name));
    let orphaned = result.orphaned.iter().map(|frame| (frame, reference(frame)));
    findings(frames.chain(orphaned), fail_on)
}

/// All findings among images and their files: lost content first, failures without FLIP, such as missing references, then by FLIP of the
/// worst tile, and last changes within the limits.
pub(super) fn findings<'a>(
    frames: impl Iterator<Item = (&'a FrameResult, PathBuf)>,
    fail_on: FailOn,
) -> Vec<Finding<'a>> {
    let differing = frames.filter(|(frame, _)| frame.verdict() != Verdict::Identical);
    let mut findings: Vec<_> = differing
        .map(|(frame, file)| Finding { frame, file, fails: fail_on.fails(frame.verdict()) })
        .collect();
    let has_lost = |frame: &FrameResult| {
        let mismatches = frame.comparison.iter().flat_map(|comparison| &comparison.mismatches);
        mismatches.into_iter().any(|mismatch| matches!(mismatch, Mismatch::Lost { .. }))
    };
    let tile = |frame: &FrameResult| {
        let flip = frame.comparison.as_ref().and_then(|comparison| comparison.flip);
        flip.map_or(f64::INFINITY, |flip| flip.tile)
    };
    findings.sort_by(|a, b| {
        let (a, b) = (a.frame, b.frame);
        let by_loss = has_lost(b).cmp(&has_lost(a));
        let by_measure = tile(b).total_cmp(&tile(a)).then_with(|| a.name.cmp(&b.name));
        b.verdict().cmp(&a.verdict()).then(by_loss).then(by_measure)
    });
    findings
}

impl Finding<'_> {
    /// The verdict, and the kind of failure: `failed: missing`, `changed within limits`.
    pub(super) fn title(&self) -> String {
        match self.frame.verdict() {
            Verdict::Failed => format!("failed: {}", self.frame.kind()),
            passed => passed.words().to_owned(),
        }
    }

    /// The messages and the likely cause, one line each.
    pub(super) fn lines(&self) -> Vec<String> {
        let cause = self.frame.likely_cause().map(|cause| format!("likely {cause}"));
        self.frame.messages.iter().cloned().chain(cause).collect()
    }

    /// The path of the file below the folder of the repository, with `/` on every system; as it is outside of repositories.
    pub(super) fn repository_path(&self) -> String {
        let whole = self.file.canonicalize().unwrap_or_else(|_| self.file.clone());
        let is_repository = |folder: &&Path| folder.join(".git").exists();
        let below =
            whole.ancestors().skip(1).find(is_repository).and_then(|root| whole.strip_prefix(root).ok());
        below.unwrap_or(&self.file).display().to_string().replace('\\', "/")
    }
}
