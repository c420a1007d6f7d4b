//! Backdrop of a built-in light.

use glam::Vec3;

use crate::geometry::smoothstep;

/// Radiance that depends on the height of a direction alone.
#[derive(Debug)]
pub(super) struct Gradient {
    pub(super) floor: Vec3,
    pub(super) horizon: Vec3,
    pub(super) ceiling: Vec3,
    /// Sine of the elevation from which down the floor has its radiance.
    pub(super) floor_height: f32,
}

impl Gradient {
    #[inline(always)]
    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        let height = direction.y;
        let is_below = height < 0.0;
        let rise = |height: f32| smoothstep([0.0, 1.0], height);
        let (below, above) = (rise(height / self.floor_height), rise(height));
        let share = if is_below { below } else { above };
        let end = if is_below { self.floor } else { self.ceiling };
        self.horizon + (end - self.horizon) * share
    }
}
