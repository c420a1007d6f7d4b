//! Clock of traces: processor time of threads that pull chunks of work.
//!
//! The time is summed over threads and divided by their number, so that other load on the machine does not count. The Embree
//! program is measured the same way.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Items per chunk.
const CHUNK: usize = 8192;
/// Seconds of a run after which no further ones follow.
const LONG_SECONDS: f64 = 0.5;

/// Least of up to `runs` measurements; the series ends after a long one.
pub fn best_seconds(runs: usize, mut run: impl FnMut() -> f64) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        best = best.min(run());
        if best > LONG_SECONDS {
            break;
        }
    }
    best
}

/// Runs `work` over chunks of `items` on `threads` new threads; processor seconds summed over threads, over their number.
pub fn processor_seconds(threads: usize, items: usize, work: impl Fn(Range<usize>) + Sync) -> f64 {
    let next = AtomicUsize::new(0);
    let pull = || {
        let start = thread_seconds();
        loop {
            let first = next.fetch_add(CHUNK, Ordering::Relaxed);
            if first >= items {
                return thread_seconds() - start;
            }
            work(first..items.min(first + CHUNK));
        }
    };
    let sum: f64 = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(pull)).collect();
        running.into_iter().filter_map(|thread| thread.join().ok()).sum()
    });
    sum / threads as f64
}

/// Processor time of this thread so far.
#[cfg(unix)]
fn thread_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Wall-clock time, on systems without a clock of threads.
#[cfg(not(unix))]
fn thread_seconds() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}
