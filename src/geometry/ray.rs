//! A half-open segment of a line.

use glam::Vec3;

/// A ray `origin + t · direction` for `t` in the open interval (`t_min`, `t_max`).
///
/// The direction need not have unit length; `t` is measured in lengths of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// World-space start, metres.
    pub origin: Vec3,
    /// World-space direction; finite and not zero.
    pub direction: Vec3,
    /// Hits at or before this parameter do not count, nor do those behind the origin.
    pub t_min: f32,
    /// Hits at or beyond this parameter do not count; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// A ray that starts at `origin` and never ends.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}
