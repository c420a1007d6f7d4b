//! Light that comes from all around.

use glam::Vec3;

/// What surrounds the scene.
#[derive(Clone, Debug, Default)]
pub enum Environment {
    /// Nothing.
    #[default]
    None,
    /// The same radiance from everywhere.
    Constant(Vec3),
    /// A soft gradient with one key light, for scenes without any light.
    Studio,
    /// An equirectangular picture.
    Map(EnvironmentMap),
}

/// An equirectangular picture of the surroundings.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {}

impl Environment {
    /// stub
    pub fn radiance(&self, _: Vec3) -> Vec3 {
        Vec3::ZERO
    }
    /// stub
    pub fn irradiance(&self, _: Vec3) -> Vec3 {
        Vec3::ZERO
    }
    /// stub
    pub fn prefiltered(&self, _: Vec3, _: f32) -> Vec3 {
        Vec3::ZERO
    }
    /// stub
    pub fn key_light(&self) -> Option<(Vec3, Vec3)> {
        None
    }
}
