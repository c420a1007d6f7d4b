//! Sampled directions with their densities.

use glam::Vec3;

/// A direction that was sampled, with its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DirectionSample {
    /// Unit vector.
    pub(crate) direction: Vec3,
    /// Probability density of the direction, by solid angle (1/sr).
    pub(crate) pdf: f32,
}
