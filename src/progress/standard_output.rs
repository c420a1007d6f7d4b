//! Writing of requested data to the standard output, and whether all of it was delivered.

use std::io::{self, ErrorKind, Write as _};
use std::sync::{Mutex, PoisonError};

/// The first failure. The stream belongs to the process, and so does its state.
static FAILURE: Mutex<Option<io::Error>> = Mutex::new(None);

/// Writes whole lines. The first failure is kept for [`take_failure`]; a reader that closed the pipe has what it wanted.
pub(super) fn write_lines(lines: &str) {
    let mut stdout = io::stdout().lock();
    note_failure(writeln!(stdout, "{}", lines.trim_end_matches('\n')).and_then(|()| stdout.flush()));
}

/// Keeps the failure of a write to the standard output as [`write_lines`] does.
pub(crate) fn note_failure(written: io::Result<()>) {
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            FAILURE.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
        Ok(()) | Err(_) => {}
    }
}

/// Why data was not delivered.
pub(crate) fn take_failure() -> Option<io::Error> {
    FAILURE.lock().unwrap_or_else(PoisonError::into_inner).take()
}
