//! How an environment map lies in the world.

use glam::{Quat, Vec3};

/// The rotation of a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapRotation {
    pub(super) cos: f32,
    pub(super) sin: f32,
    /// Rotation of an image-based light that clips animate; `None` for any other map.
    pub(super) animated: Option<Quat>,
}

impl MapRotation {
    /// No rotation.
    pub(super) const NONE: Self = Self { cos: 1.0, sin: 0.0, animated: None };

    /// Rotates a direction of the map into the world.
    pub(super) fn world_from_map(&self, direction: Vec3) -> Vec3 {
        let Vec3 { x, y, z } = direction;
        let turned = Vec3::new(self.cos * x + self.sin * z, y, self.cos * z - self.sin * x);
        self.animated.map_or(turned, |rotation| rotation * turned)
    }

    /// Rotates a world direction into the map.
    #[inline(always)]
    pub(super) fn map_from_world(&self, direction: Vec3) -> Vec3 {
        let direction = self.animated.map_or(direction, |rotation| rotation.inverse() * direction);
        let Vec3 { x, y, z } = direction;
        Vec3::new(self.cos * x - self.sin * z, y, self.sin * x + self.cos * z)
    }
}
