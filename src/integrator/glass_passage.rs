//! How light passes glass along shadow rays.

use glam::Vec3;

use super::{ColorChannels, MediaStack};
use crate::geometry::Ray;

/// What light passes glass along a straight shadow ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum GlassPassage {
    /// That of lights that rays cannot hit, as far as [`super::GlassShadows`] allows.
    #[default]
    Straight,
    /// That of lights that rays can hit: clear thin walls alone. Sampled rays bring the light that other glass bends or scatters.
    ThinWalls,
}

impl GlassPassage {
    /// Index of refraction in front of a surface that a ray in `media` hits. Light that passes volumes straight is that of a ray from vacuum.
    pub(super) fn ior_outside(self, media: &MediaStack) -> f32 {
        match self {
            Self::Straight => 1.0,
            Self::ThinWalls => media.ior(ColorChannels::White),
        }
    }

    /// Transmittance of the last stretch of a ray: from its start, or from the last hit, given by its `t` with the length of the direction. Distant
    /// lights that rays cannot hit are taken to be outside of all volumes that the ray does not leave.
    pub(super) fn last_stretch(self, media: &MediaStack, ray: &Ray, hit: Option<(f32, f32)>) -> Vec3 {
        let is_outside = self == Self::Straight && ray.t_max == f32::INFINITY;
        if is_outside || media.is_empty() {
            return Vec3::ONE;
        }
        let from_start = || (ray.t_min, libm::sqrtf(ray.direction.dot(ray.direction)));
        let (t, length) = hit.unwrap_or_else(from_start);
        media.transmittance((ray.t_max - t) * length)
    }
}
