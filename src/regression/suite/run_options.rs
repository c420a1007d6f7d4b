//! Options of a run of a suite.

use std::path::PathBuf;

use super::Shard;

/// Options of a run.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// Selects shots: the shot or image of exactly this name, or else all whose names contain it. Empty selects all.
    pub filter: String,
    /// Of those, only the shots of this part of the suite.
    pub shard: Option<Shard>,
    /// Of those, only shots with files that changed since this revision of the git repository.
    pub changed_since: Option<String>,
    /// Whether shots are not rendered whose images were identical in an earlier run and of which nothing changed since. Verdicts are kept
    /// in [`super::Suite::cache`].
    pub uses_cache: bool,
    /// Whether images that differ or have no reference are stored as pending images, for [`super::Acceptance`].
    pub keeps_pending: bool,
    /// Folder of a report in which rendered images are stored, for [`super::RenderedChecks`]. On build servers, which store no pending
    /// images, this keeps them.
    pub images: Option<PathBuf>,
    /// Whether the results of images that are identical to their references have the images, too, for the report.
    pub reports_passing: bool,
    /// Number of threads; 0 for one a core.
    pub threads: usize,
    /// Memory limit of all shots that are tested at a time, bytes, over the one in their files.
    pub max_memory_bytes: Option<u64>,
}
