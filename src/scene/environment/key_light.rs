//! The directional lights that belong to an environment.

use glam::Vec3;

/// Directional light of an environment that casts shadows. Lookups do not contain that of [`super::Environment::key_light`];
/// [`super::Environment::peaks`] says which of them contain those of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyLight {
    /// Unit vector towards the light.
    pub direction_to_light: Vec3,
    /// Irradiance of a surface that faces the light.
    pub irradiance: Vec3,
}
