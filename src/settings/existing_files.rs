//! Policy for files that exist before a run.

/// Treatment of existing files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExistingFiles {
    /// Finished frames with the same hash are kept; any other file is an error.
    #[default]
    Protect,
    /// Finished frames with the same hash are kept, others are replaced.
    Resume,
    /// All are replaced.
    Overwrite,
}
