//! Sets of lights.

/// A set of lights, by their indices. Those from the 64th on are in it together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LightSet(u64);

impl LightSet {
    fn bit(index: usize) -> u64 {
        1 << index.min(63)
    }

    /// Adds a light.
    pub(super) fn insert(&mut self, index: usize) {
        self.0 |= Self::bit(index);
    }

    /// Whether a light is in the set.
    pub(super) fn contains(self, index: usize) -> bool {
        self.0 & Self::bit(index) != 0
    }

    /// The lights that are in either set.
    pub(super) fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
