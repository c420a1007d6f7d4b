//! How light passes glass along shadow rays.

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
    /// Whether a shadow ray ends at the surface that it is for: those of lamps that rays cannot hit do. Other rays start there.
    pub(super) fn ends_at_surface(self, ray: &Ray) -> bool {
        self == Self::Straight && ray.t_max < f32::INFINITY
    }
}
