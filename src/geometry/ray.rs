//! Rays.

use glam::Vec3;

/// Ray `origin + t · direction` for `t` in the open interval (`t_min`, `t_max`).
///
/// The direction need not have unit length. `t` is measured in multiples of its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// World-space start, metres.
    pub origin: Vec3,
    /// World-space direction; finite and not zero.
    pub direction: Vec3,
    /// Hits at or before this parameter are ignored, as are those behind the origin.
    pub t_min: f32,
    /// Hits at or beyond this parameter are ignored; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// An infinite ray from `origin`.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// Whether a hit at `t` counts; subnormal distances are zero.
    #[inline(always)]
    pub(crate) fn contains(&self, t: f32) -> bool {
        is_within(t, self.t_min, self.t_max)
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Whether a hit at `t` counts; subnormal distances are zero.
#[inline(always)]
pub(super) fn is_within(t: f32, t_min: f32, t_max: f32) -> bool {
    t > t_min && t < t_max && t >= f32::MIN_POSITIVE
}
