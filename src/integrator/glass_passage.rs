//! How light passes glass along shadow rays.

/// What light passes glass along a straight shadow ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum GlassPassage {
    /// That of lights that rays cannot hit, as far as [`super::GlassShadows`] allows.
    #[default]
    Straight,
    /// That of lights that rays can hit: clear thin walls alone. Sampled rays bring the light that other glass bends or scatters.
    ThinWalls,
}
