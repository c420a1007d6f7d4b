//! The clock of builds: the wall, because what counts is when the structure is ready.

use std::time::Instant;

/// What `work` returns and how long it took.
pub(crate) fn wall_seconds<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}
