//! Policy for files that exist before a run.

/// What becomes of files that are there already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExistingFiles {
    /// Whole frames made from the same things are kept; any other file is an error.
    #[default]
    Protect,
    /// Whole frames made from the same things are kept, others are replaced.
    Resume,
    /// All are replaced.
    Overwrite,
}
