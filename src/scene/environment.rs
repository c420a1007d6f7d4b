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

impl EnvironmentMap {
    /// A map from row-major linear pixels, top row first.
    pub fn new(
        width: u32,
        height: u32,
        pixels: Vec<[f32; 3]>,
        rotation_degrees: f32,
    ) -> Result<Self, String> {
        let _ = (width, height, pixels, rotation_degrees);
        Ok(Self {})
    }
}
