//! Cancellation flag. Building and tracing poll it, so that a frame ends within a second.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Shared cancellation flag. Clones share its state.
#[derive(Clone, Debug, Default)]
pub struct CancelFlag {
    own: Arc<AtomicBool>,
    /// An outer flag, which cancels this one as well.
    outer: Option<Arc<AtomicBool>>,
}

/// Error of work that a [`CancelFlag`] cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the end")]
pub struct Cancelled;

impl CancelFlag {
    /// A flag that is not raised.
    pub fn new() -> Self {
        Self::default()
    }

    /// A flag for part of the work. Raising `self` raises the inner flag as well, but not the other way round.
    #[must_use]
    pub fn inner(&self) -> Self {
        debug_assert!(self.outer.is_none(), "flags nest once");
        Self { own: Arc::default(), outer: Some(Arc::clone(&self.own)) }
    }

    /// Requests cancellation.
    pub fn raise(&self) {
        self.own.store(true, Ordering::Relaxed);
    }

    /// Whether cancellation is requested.
    pub fn is_raised(&self) -> bool {
        let is_set = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        is_set(&self.own) || self.outer.as_ref().is_some_and(is_set)
    }

    /// `Err(Cancelled)` once the flag is raised, for use with `?`.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_raised() { Err(Cancelled) } else { Ok(()) }
    }

    /// The flag as an atomic, for signal handlers.
    pub fn as_atomic(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raising_an_outer_flag_raises_inner_ones_but_not_the_other_way_round() {
        let outer = CancelFlag::new();
        let (first, second) = (outer.inner(), outer.inner());
        first.raise();
        assert_eq!((outer.is_raised(), first.is_raised(), second.is_raised()), (false, true, false));
        outer.raise();
        assert_eq!((outer.is_raised(), second.is_raised()), (true, true));
    }
}
