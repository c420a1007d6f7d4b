//! Amount of output.

/// Amount of output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Verbosity {
    /// Print warnings and errors only.
    pub(crate) is_quiet: bool,
    /// Print the phases of each frame and kept frames, too.
    pub(crate) is_verbose: bool,
    /// Print each failed frame at once, because the run continues after it.
    pub(crate) names_failures: bool,
}
