//! The option `--fail-on`, common to `rayframe test` and `rayframe diff`.

use clap::{Args, ValueEnum};

use rayframe::regression::FailOn;

/// The option `--fail-on`.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct FailOnOption {
    /// What makes the exit code 1: failures, or changes within the limits as well
    #[arg(long, value_name = "VERDICT", default_value = "failed", value_enum)]
    fail_on: FailOnVerdict,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FailOnVerdict {
    Failed,
    Changed,
}

impl FailOnOption {
    /// The verdicts that make the command fail.
    pub(super) fn value(self) -> FailOn {
        match self.fail_on {
            FailOnVerdict::Failed => FailOn::Failed,
            FailOnVerdict::Changed => FailOn::Changed,
        }
    }

    /// `--fail-on changed` as words of a command; nothing for the default.
    pub(super) fn words(self) -> &'static [&'static str] {
        match self.fail_on {
            FailOnVerdict::Failed => &[],
            FailOnVerdict::Changed => &["--fail-on", "changed"],
        }
    }
}
