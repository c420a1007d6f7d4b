//! What is a find: a panic in rayframe's own code, an internal error, or more memory than the input justifies.

use std::panic::PanicHookInfo;
use std::sync::{Mutex, Once, PoisonError};

use rayframe::Error;

/// Exit code of an internal error, which is always a bug.
const INTERNAL: u8 = 70;

/// Memory limit that targets pass to the library, bytes.
pub(crate) const LIBRARY_LIMIT: u64 = 32 << 20;

/// Memory that an input of this many bytes may take: 64 MiB, and 20 times itself.
pub const fn memory_limit(input_bytes: usize) -> usize {
    (64 << 20) + 20 * input_bytes
}

/// The value, or `None` for an error as users may get one. An internal error is a find.
pub(crate) fn accepted<T>(result: rayframe::Result<T>) -> Option<T> {
    match result {
        Ok(value) => Some(value),
        Err(error) => {
            check(&error);
            None
        }
    }
}

fn check(error: &Error) {
    let text = error.to_string();
    assert!(error.exit_code() != INTERNAL && !text.contains("please report"), "internal error: {text}");
}

/// The value of what cannot fail unless the machine does.
#[expect(clippy::panic, reason = "a target ends by a panic, and a full disk is no verdict")]
pub(crate) fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("the target cannot run: {error}"))
}

/// Watches for panics in rayframe's own code. Decoders of other projects may panic where the library isolates them; a panic of its
/// own is a find even where something catches it.
#[derive(Clone, Copy, Debug)]
pub struct PanicWatch;

static OWN_PANIC: Mutex<Option<String>> = Mutex::new(None);
/// The last panic elsewhere, which is a find if nothing isolates it.
static FOREIGN_PANIC: Mutex<Option<String>> = Mutex::new(None);
/// Held during a run: what is recorded belongs to one.
static RUNNING: Mutex<()> = Mutex::new(());
static CHAINED: Once = Once::new();

impl PanicWatch {
    /// Watches in place of the hook before, and prints nothing.
    pub fn quiet() -> Self {
        std::panic::set_hook(Box::new(record));
        Self
    }

    /// Watches beside the hook before.
    pub fn chained() -> Self {
        CHAINED.call_once(|| {
            let before = std::panic::take_hook();
            std::panic::set_hook(Box::new(move |info| {
                record(info);
                before(info);
            }));
        });
        Self
    }

    /// Runs `target` on `input`. A description of the panic in rayframe's own code or in the target, whether caught or not.
    pub fn run(self, target: fn(&[u8]), input: &[u8]) -> Option<String> {
        let _running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        *OWN_PANIC.lock().unwrap_or_else(PoisonError::into_inner) = None;
        let escaped = std::panic::catch_unwind(|| target(input)).is_err();
        let own = OWN_PANIC.lock().unwrap_or_else(PoisonError::into_inner).take();
        let foreign = FOREIGN_PANIC.lock().unwrap_or_else(PoisonError::into_inner).take();
        own.or_else(|| foreign.filter(|_| escaped))
    }
}

fn record(info: &PanicHookInfo<'_>) {
    let Some(location) = info.location() else { return };
    // Paths of workspace members are relative; those of dependencies are not.
    let is_own =
        ["src", "tests/fuzz"].iter().any(|folder| std::path::Path::new(location.file()).starts_with(folder));
    if is_own {
        let mut own = OWN_PANIC.lock().unwrap_or_else(PoisonError::into_inner);
        own.get_or_insert_with(|| info.to_string());
    } else {
        FOREIGN_PANIC.lock().unwrap_or_else(PoisonError::into_inner).replace(info.to_string());
    }
}
