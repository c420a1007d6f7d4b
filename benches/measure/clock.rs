//! The clocks that benchmarks share.
//!
//! Builds are measured by the wall: what counts is when the structure is ready. Traces are measured by processor time, summed
//! over threads and divided by their number, so that other load on the machine does not count; Embree's program is measured
//! the same way.

use std::time::Instant;

/// After a run this long no further ones are tried.
const LONG_SECONDS: f64 = 0.5;

/// What `work` returns and how long it took by the wall.
pub(crate) fn wall_seconds<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// The least of up to `runs` measurements; a single one where it is long.
pub(crate) fn best_seconds(runs: usize, mut run: impl FnMut() -> f64) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        best = best.min(run());
        if best > LONG_SECONDS {
            break;
        }
    }
    best
}
