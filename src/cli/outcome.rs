//! Outcome of a run: remaining messages and the exit code.

use crate::progress::{print_error, print_openjd_failure};
use rayframe::error::{Error, Result};
use rayframe::sequence::Summary;

use super::exit_status::ExitStatus;
use super::render_options::message;
use rayframe::settings::{ProgressStyle, SettingValues};

/// Outcome of a run.
pub(super) struct Outcome {
    /// Summary of the frames.
    pub(super) summary: Summary,
    /// Whether failures of frames were printed as they happened.
    pub(super) are_failures_told: bool,
    /// Errors of sidecar files: manifest, statistics, movie, contact sheet.
    pub(super) sidecar_errors: Vec<Error>,
}

impl Outcome {
    /// `Ok` if every file was written; else the error of the frames, or the first of the sidecar files.
    pub(super) fn result(self) -> Result<()> {
        self.summary.outcome().and(self.sidecar_errors.into_iter().next().map_or(Ok(()), Err))
    }
}

/// Prints the errors that were not printed yet, and returns the exit code: frames decide before sidecar files, and a
/// `signal` that ended the run before both.
pub(super) fn finish(outcome: Outcome, signal: Option<i32>, args: &SettingValues) -> ExitStatus {
    let Outcome { summary, are_failures_told, sidecar_errors } = outcome;
    let mut is_interrupted = summary.is_interrupted;
    let mut code = 0;
    if let Err(error) = summary.outcome() {
        code = error.exit_code();
        let is_printed = are_failures_told || (is_interrupted && signal.is_some());
        if !is_printed {
            print_error(&message(&error));
        }
    }
    for error in sidecar_errors {
        if matches!(error, Error::Interrupted(_)) {
            is_interrupted = true;
        } else {
            tell_failure(&error, args.progress);
        }
        code = if code == 0 { error.exit_code() } else { code };
    }
    match signal {
        Some(signal) if is_interrupted => ExitStatus::Signal(signal),
        _ => ExitStatus::Code(code),
    }
}

/// Prints an error that concerns no frame, also as a line of Open Job Description.
pub(super) fn tell_failure(error: &Error, progress: ProgressStyle) {
    tell_failure_text(&message(error), progress);
}

/// Prints the message of an error that concerns no frame, also as a line of Open Job Description.
pub(super) fn tell_failure_text(text: &str, progress: ProgressStyle) {
    if progress == ProgressStyle::OpenJd {
        print_openjd_failure(text);
    }
    print_error(text);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayframe::cancel::Cancelled;
    use rayframe::sequence::FailedFrame;

    fn code(failed: Option<Error>, sidecar_errors: Vec<Error>, signal: Option<i32>) -> ExitStatus {
        let args = rayframe::settings::Settings::default().values();
        let is_interrupted = matches!(failed, Some(Error::Interrupted(_)));
        let failed = failed.filter(|_| !is_interrupted).map(|error| FailedFrame { frame: 1, error });
        let failed = failed.into_iter().collect();
        let summary = Summary { failed, is_interrupted, ..Summary::default() };
        finish(Outcome { summary, are_failures_told: false, sidecar_errors }, signal, &args)
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
        assert_eq!(code(None, vec![], None), ExitStatus::Code(0));
        assert_eq!(code(None, vec![full_disk()], None), ExitStatus::Code(74));
        assert_eq!(code(Some(internal()), vec![full_disk()], None), ExitStatus::Code(70));
        assert_eq!(code(Some(interrupted()), vec![full_disk()], Some(15)), ExitStatus::Signal(15));
        assert_eq!(code(None, vec![full_disk(), interrupted()], Some(2)), ExitStatus::Signal(2));
        // A signal that came when all was done changes nothing.
        assert_eq!(code(None, vec![], Some(2)), ExitStatus::Code(0));
    }
}
