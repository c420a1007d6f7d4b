//! Work that threads pull in chunks, measured by their processor time.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Items that a thread takes at once.
pub(crate) const CHUNK: usize = 8192;

/// Runs `work` over chunks of `items` on `threads` new threads; processor seconds summed over threads, over their number.
pub(crate) fn processor_seconds(threads: usize, items: usize, work: impl Fn(Range<usize>) + Sync) -> f64 {
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

/// Where threads have no clock, the wall stands in.
#[cfg(not(unix))]
fn thread_seconds() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}
