//! Exit status of the program.

use crate::progress::print_error;
use rayframe::error::Result;

use super::render_options::message;

/// Exit status of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExitStatus {
    /// An exit code.
    Code(u8),
    /// A signal, as if it had not been caught.
    Signal(i32),
}

/// Prints the error of a command and returns its exit status.
pub(super) fn exit_status(result: Result<()>) -> ExitStatus {
    match result {
        Ok(()) => ExitStatus::Code(0),
        Err(error) => {
            print_error(&message(&error));
            ExitStatus::Code(error.exit_code())
        }
    }
}
