//! A flag that a signal handler raises and that building and tracing poll, so that a frame ends within a second.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A shared flag; clones see the same state.
#[derive(Clone, Debug, Default)]
pub struct CancelFlag {
    own: Arc<AtomicBool>,
    /// A flag that counts as this one's as well.
    outer: Option<Arc<AtomicBool>>,
}

/// The work was given up because the [`CancelFlag`] was raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the end")]
pub struct Cancelled;

impl CancelFlag {
    /// A flag that is not raised.
    pub fn new() -> Self {
        Self::default()
    }

    /// A flag for part of the work: raised by itself or with this one, which it never raises.
    #[must_use]
    pub fn inner(&self) -> Self {
        debug_assert!(self.outer.is_none(), "flags nest once");
        Self { own: Arc::default(), outer: Some(Arc::clone(&self.own)) }
    }

    /// Asks the work that polls this flag to stop.
    pub fn raise(&self) {
        self.own.store(true, Ordering::Relaxed);
    }

    /// Whether the work should stop.
    pub fn is_raised(&self) -> bool {
        let is_up = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        is_up(&self.own) || self.outer.as_ref().is_some_and(is_up)
    }

    /// `Err(Cancelled)` once the flag is raised, for use with `?`.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_raised() { Err(Cancelled) } else { Ok(()) }
    }

    /// The flag as the plain atomic that signal handlers store into.
    pub fn as_atomic(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inner_flag_follows_the_outer_one_and_not_the_other_way_round() {
        let outer = CancelFlag::new();
        let (first, second) = (outer.inner(), outer.inner());
        first.raise();
        assert_eq!((outer.is_raised(), first.is_raised(), second.is_raised()), (false, true, false));
        outer.raise();
        assert_eq!((outer.is_raised(), second.is_raised()), (true, true));
    }
}
