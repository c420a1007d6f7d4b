//! Clock of builds: wall-clock time.

use std::time::Instant;

/// Result of `work` and its seconds.
pub fn wall_seconds<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}
