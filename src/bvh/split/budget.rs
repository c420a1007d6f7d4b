//! Budget of references, shared by parallel tasks.
//!
//! Whether the limit is exceeded depends only on the sum, so it does not depend on the number of threads.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::cancel::CancelFlag;

/// References that a task creates between updates of the shared sum.
const POLL_EVERY: u64 = 256;

/// Limit of references and their number so far.
pub(crate) struct Budget<'a> {
    limit: u64,
    spent: AtomicU64,
    cancel: &'a CancelFlag,
}

/// Access of one task to a budget.
pub(crate) struct Share<'a> {
    budget: &'a Budget<'a>,
    pending: u64,
    exhausted: bool,
}

impl<'a> Budget<'a> {
    /// Unused budget of `limit` references; a raised `cancel` exhausts it.
    pub(crate) fn new(limit: u64, cancel: &'a CancelFlag) -> Self {
        Self { limit, spent: AtomicU64::new(0), cancel }
    }

    /// Access for a task.
    pub(crate) fn share(&'a self) -> Share<'a> {
        Share { budget: self, pending: 0, exhausted: self.is_exceeded() || self.cancel.is_raised() }
    }

    /// Whether the limit is exceeded; final once all shares are dropped.
    pub(crate) fn is_exceeded(&self) -> bool {
        self.spent() > self.limit
    }

    /// References counted so far; final once all shares are dropped.
    pub(crate) fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }
}

impl Share<'_> {
    /// Whether the task should stop.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// Counts one reference; false if the task should stop.
    pub(crate) fn spend(&mut self) -> bool {
        self.pending += 1;
        if self.pending == POLL_EVERY {
            self.flush();
            self.exhausted = self.budget.is_exceeded() || self.budget.cancel.is_raised();
        }
        !self.exhausted
    }

    fn flush(&mut self) {
        self.budget.spent.fetch_add(self.pending, Ordering::Relaxed);
        self.pending = 0;
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        self.flush();
    }
}
