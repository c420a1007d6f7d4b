//! Where an instance is over all times at which a scene is measured.

use crate::geometry::Aabb;

/// Longest path that is framed, as a factor on the size of what moves.
const LONGEST_PATH: f32 = 100.0;
/// Smallest share of a path that is a jump between two measured times.
const SHARE_OF_JUMP: f32 = 0.5;
/// A path is long beside its instance where it exceeds it by this factor.
const LONG_PATH: f32 = 3.0;

/// Where an instance is, and how large.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Bounds over all times.
    pub(super) path: Aabb,
    /// Diagonal of the largest of its boxes at single times, metres.
    pub(super) diagonal: f32,
    /// Whether its box is not the same at all times at which it is visible.
    pub(super) moves: bool,
    /// The box at the last measured time at which it is visible.
    last: Aabb,
    /// Largest distance between the middles of boxes that follow each other, metres.
    largest_step: f32,
}

impl Extent {
    /// That of an instance that is visible at no time.
    pub(super) const NOWHERE: Self =
        Self { path: Aabb::EMPTY, diagonal: 0.0, moves: false, last: Aabb::EMPTY, largest_step: 0.0 };

    /// Adds the box at the next time, empty where the instance is not visible.
    pub(super) fn add(&mut self, bounds: Aabb) {
        if bounds.is_empty() {
            return;
        }
        if !self.last.is_empty() {
            let step = bounds.center().distance(self.last.center());
            self.largest_step = self.largest_step.max(step);
        }
        self.last = bounds;
        self.moves |= !self.path.is_empty() && bounds != self.path;
        self.diagonal = self.diagonal.max(bounds.extent().length());
        self.path = self.path.union(bounds);
    }

    /// Whether most of its path shows nothing of it: things that are parked far away and jump into view, and projectiles.
    pub(super) fn is_stray(&self) -> bool {
        let path = self.path.extent().length();
        let jumps = path > LONG_PATH * self.diagonal && self.largest_step > SHARE_OF_JUMP * path;
        self.moves && (jumps || path > LONGEST_PATH * self.diagonal)
    }
}
