//! How many references splitting may make, shared by tasks that run in parallel.
//!
//! Whether the limit is exceeded depends on the sum alone, so it is the same for any number of threads.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::cancel::CancelFlag;

/// References that a task makes before it adds them to the sum and looks whether to go on.
const POLL_EVERY: u64 = 256;

/// A limit, and how much of it is used.
pub(crate) struct Budget<'a> {
    limit: u64,
    spent: AtomicU64,
    cancel: &'a CancelFlag,
}

/// One task's access to a budget.
pub(crate) struct Share<'a> {
    budget: &'a Budget<'a>,
    pending: u64,
    exhausted: bool,
}

impl<'a> Budget<'a> {
    /// Nothing of `limit` is spent yet; a raised `cancel` exhausts it.
    pub(crate) fn new(limit: u64, cancel: &'a CancelFlag) -> Self {
        Self { limit, spent: AtomicU64::new(0), cancel }
    }

    /// Access for a task.
    pub(crate) fn share(&'a self) -> Share<'a> {
        Share { budget: self, pending: 0, exhausted: self.is_exceeded() || self.cancel.is_raised() }
    }

    /// Whether more was spent than the limit; final once all shares are dropped.
    pub(crate) fn is_exceeded(&self) -> bool {
        self.spent() > self.limit
    }

    /// What the shares that are dropped have spent.
    pub(crate) fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }
}

impl Share<'_> {
    /// Whether there is no use in going on.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// Counts one reference; false if there is no use in going on.
    pub(crate) fn spend(&mut self) -> bool {
        self.pending += 1;
        if self.pending == POLL_EVERY {
            self.settle();
            self.exhausted = self.budget.is_exceeded() || self.budget.cancel.is_raised();
        }
        !self.exhausted
    }

    fn settle(&mut self) {
        self.budget.spent.fetch_add(self.pending, Ordering::Relaxed);
        self.pending = 0;
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        self.settle();
    }
}
