//! Signals: SIGINT and SIGTERM cancel the run, a second one ends the program at once. SIGXFSZ becomes a write error, and SIGABRT, which
//! failed allocations raise, an exit code.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use rayframe::cancel::CancelFlag;

/// Exit code of an allocation that fails, as of memory limits.
#[cfg(unix)]
const NO_MEMORY: i32 = 77;

/// Gives failed allocations an exit code. The standard library prints their size and aborts; nothing else here does, but a panic
/// during the unwinding of another and an overflow of the stack, which print what they are.
pub(super) fn end_failed_allocations() {
    #[cfg(unix)]
    {
        let always = Arc::new(AtomicBool::new(true));
        // Without the handler the program ends by the signal.
        let _ = flag::register_conditional_shutdown(signal_hook::consts::SIGABRT, NO_MEMORY, always);
    }
}

/// The signal that was caught, if any.
#[derive(Clone, Debug, Default)]
pub(super) struct CaughtSignal(Arc<AtomicUsize>);

impl CaughtSignal {
    /// The number of the signal.
    pub(super) fn number(&self) -> Option<i32> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            number => i32::try_from(number).ok(),
        }
    }
}

/// Makes signals raise `cancel` from now on.
///
/// # Errors
/// Errors of the system.
pub(super) fn watch(cancel: &CancelFlag) -> std::io::Result<CaughtSignal> {
    watch_unless(cancel, &Arc::default())
}

/// The same, except that a signal ends the program at once while `ends_at_once` is set.
///
/// # Errors
/// Errors of the system.
pub(super) fn watch_unless(
    cancel: &CancelFlag,
    ends_at_once: &Arc<AtomicBool>,
) -> std::io::Result<CaughtSignal> {
    let caught = CaughtSignal::default();
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_default(signal, Arc::clone(ends_at_once))?;
        // Handlers run in this order: once the flag is up, the first of them ends the program.
        flag::register_conditional_default(signal, cancel.as_atomic())?;
        flag::register_usize(signal, Arc::clone(&caught.0), signal as usize)?;
        flag::register(signal, cancel.as_atomic())?;
    }
    // A handler that does nothing makes writing past the size limit fail with EFBIG instead of ending the program.
    #[cfg(unix)]
    flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    Ok(caught)
}
