//! How a run went: what is still to be said, and the exit code.

use crate::progress::{print_error, print_openjd_failure};
use rayframe::error::{Error, Result};
use rayframe::sequence::Summary;

use super::Ending;
use super::render_options::message;
use rayframe::settings::{ProgressStyle, SettingValues};

/// How a run went.
pub(super) struct Outcome {
    /// Of the frames.
    pub(super) summary: Summary,
    /// What went wrong with the files beside the frames, each for itself.
    pub(super) beside: Vec<Error>,
}

impl Outcome {
    /// Nothing, when all that was asked for is there; else what is to be said about the frames, or about the other files.
    pub(super) fn result(self) -> Result<()> {
        self.summary.outcome().and(self.beside.into_iter().next().map_or(Ok(()), Err))
    }
}

/// Names what went wrong and has not been named yet, and finds the exit code: frames decide before the files beside them, and a
/// `signal` that ended the work before everything. With `--keep-going` every frame's failure has been named already.
pub(super) fn finish(outcome: Outcome, signal: Option<i32>, args: &SettingValues) -> Ending {
    let Outcome { summary, beside } = outcome;
    let mut is_interrupted = summary.is_interrupted;
    let mut code = 0;
    if let Err(error) = summary.outcome() {
        code = error.exit_code();
        let is_told = args.keep_going || (is_interrupted && signal.is_some());
        if !is_told {
            print_error(&message(&error));
        }
    }
    for error in beside {
        if matches!(error, Error::Interrupted(_)) {
            is_interrupted = true;
        } else {
            tell_failure(&error, args);
        }
        code = if code == 0 { error.exit_code() } else { code };
    }
    match signal {
        Some(signal) if is_interrupted => Ending::Signal(signal),
        _ => Ending::Code(code),
    }
}

/// Names a failure that is not about a frame, also to a farm that listens.
pub(super) fn tell_failure(error: &Error, args: &SettingValues) {
    if args.progress == ProgressStyle::OpenJd {
        print_openjd_failure(&message(error));
    }
    print_error(&message(error));
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayframe::cancel::Cancelled;
    use rayframe::sequence::FailedFrame;

    fn code(failed: Option<Error>, beside: Vec<Error>, signal: Option<i32>) -> Ending {
        let args = rayframe::settings::Settings::default().values();
        let is_interrupted = matches!(failed, Some(Error::Interrupted(_)));
        let failed = failed.filter(|_| !is_interrupted).map(|error| FailedFrame { frame: 1, error });
        let failed = failed.into_iter().collect();
        let summary = Summary { failed, is_interrupted, ..Summary::default() };
        finish(Outcome { summary, beside }, signal, &args)
    }

    fn internal() -> Error {
        Error::Internal { message: "a bug".to_owned() }
    }

    fn full_disk() -> Error {
        Error::WriteFailed { path: "stats.json".into(), source: std::io::ErrorKind::StorageFull.into() }
    }

    #[test]
    fn files_beside_the_frames_hide_neither_failures_nor_signals() {
        let interrupted = || Error::Interrupted(Cancelled);
        assert_eq!(code(None, vec![], None), Ending::Code(0));
        assert_eq!(code(None, vec![full_disk()], None), Ending::Code(74));
        assert_eq!(code(Some(internal()), vec![full_disk()], None), Ending::Code(70));
        assert_eq!(code(Some(interrupted()), vec![full_disk()], Some(15)), Ending::Signal(15));
        assert_eq!(code(None, vec![full_disk(), interrupted()], Some(2)), Ending::Signal(2));
        // A signal that came when all was done changes nothing.
        assert_eq!(code(None, vec![], Some(2)), Ending::Code(0));
    }
}
