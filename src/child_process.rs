//! Processes of other programs.

use std::io;
use std::process::{Child, ExitStatus};
use std::thread;
use std::time::Duration;

/// Time between two looks at a running process.
const NAP: Duration = Duration::from_millis(5);

/// A process that is ended when this is dropped.
#[derive(Debug)]
pub(crate) struct OwnedChild(pub(crate) Child);

impl OwnedChild {
    /// Waits for the end of the process; `None` once `gives_up` says so.
    ///
    /// # Errors
    /// Errors of the system.
    pub(crate) fn wait_unless(&mut self, gives_up: impl Fn() -> bool) -> io::Result<Option<ExitStatus>> {
        loop {
            if let Some(status) = self.0.try_wait()? {
                return Ok(Some(status));
            }
            if gives_up() {
                return Ok(None);
            }
            thread::sleep(NAP);
        }
    }
}

impl Drop for OwnedChild {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
