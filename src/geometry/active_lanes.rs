//! Lanes of a block that hold something.

use super::LANES;

/// A set of lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ActiveLanes(u16);

impl ActiveLanes {
    /// The first lanes, at most all of them.
    pub(crate) fn first(count: usize) -> Self {
        Self(if count < LANES { (1 << count) - 1 } else { u16::MAX })
    }

    /// Those of which `is_active` is true.
    #[inline(always)]
    pub(crate) fn filtered(self, is_active: impl Fn(usize) -> bool) -> Self {
        let active = self.into_iter().filter(|&lane| is_active(lane));
        Self(active.fold(0, |bits, lane| bits | 1 << lane))
    }

    /// The same and one more.
    pub(crate) fn with(self, lane: usize) -> Self {
        Self(self.0 | 1 << lane)
    }

    /// Whether a lane is one of them.
    pub(crate) fn contains(self, lane: usize) -> bool {
        self.0 >> lane & 1 == 1
    }

    /// Whether there are none.
    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl IntoIterator for ActiveLanes {
    type Item = usize;
    type IntoIter = ActiveLanesIter;

    #[inline(always)]
    fn into_iter(self) -> ActiveLanesIter {
        ActiveLanesIter(self.0)
    }
}

/// The lanes of [`ActiveLanes`], in order.
#[derive(Debug)]
pub(crate) struct ActiveLanesIter(u16);

impl Iterator for ActiveLanesIter {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(lane % LANES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_come_in_order() {
        let lanes = |active: ActiveLanes| active.into_iter().collect::<Vec<_>>();
        assert_eq!(lanes(ActiveLanes::first(3)), [0, 1, 2]);
        assert_eq!(lanes(ActiveLanes::first(LANES)), (0..LANES).collect::<Vec<_>>());
        assert!(ActiveLanes::first(0).is_empty());
        assert_eq!(lanes(ActiveLanes::first(LANES).filtered(|lane| lane % 5 == 0)), [0, 5, 10, 15]);
    }
}
