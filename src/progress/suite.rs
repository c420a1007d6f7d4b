//! Progress line of a suite on a terminal.

use std::sync::atomic::{AtomicUsize, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::print::one_line;

/// Progress line of a suite, which is cleared at the end.
#[derive(Debug)]
pub(crate) struct SuiteProgress {
    line: ProgressBar,
    failed: AtomicUsize,
}

impl SuiteProgress {
    /// A line on the standard error stream, if that is a terminal and `is_wanted`.
    pub(crate) fn new(is_wanted: bool) -> Self {
        let target = if is_wanted { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let line = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{pos} {msg}") {
            line.set_style(style);
        }
        Self { line, failed: AtomicUsize::new(0) }
    }

    /// Counts a finished shot of `count`. May be called from any thread.
    pub(crate) fn tell(&self, count: usize, name: &str, passes: bool) {
        let failed = self.failed.fetch_add(usize::from(!passes), Ordering::Relaxed) + usize::from(!passes);
        self.line.inc(1);
        let failures = if failed > 0 { format!(", {failed} failed") } else { String::new() };
        self.line.set_message(format!("of {count} shots{failures}: {}", one_line(name)));
    }

    /// Number of finished shots.
    pub(crate) fn finished(&self) -> usize {
        self.line.position() as usize
    }
}

impl Drop for SuiteProgress {
    fn drop(&mut self) {
        self.line.finish_and_clear();
    }
}
