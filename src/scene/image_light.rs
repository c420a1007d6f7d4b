//! Image-based lights of a scene file (`EXT_lights_image_based`).

use glam::{Quat, Vec3};

/// Image-based light: a cube map with its irradiance and its prefiltered levels.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageLight {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Factor on all radiance and irradiance.
    pub intensity: f32,
    /// Rotation of the light in world space.
    pub rotation: Quat,
    /// Irradiance as real spherical harmonics: Y₀₀, Y₁₋₁, Y₁₀, Y₁₁, Y₂₋₂, Y₂₋₁, Y₂₀, Y₂₁, Y₂₂.
    pub irradiance: [Vec3; 9],
    /// Radiance at roughness 0, then prefiltered levels that evenly cover roughness up to 1; at least one.
    pub levels: Vec<CubeLevel>,
}

impl ImageLight {
    /// The pose without animation.
    pub fn pose(&self) -> ImageLightPose {
        ImageLightPose { intensity: self.intensity, rotation: self.rotation }
    }
}

impl ImageLightPose {
    /// Intensity one, no rotation.
    pub const IDENTITY: Self = Self { intensity: 1.0, rotation: Quat::IDENTITY };
}

/// The animatable properties of an [`ImageLight`] at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageLightPose {
    /// See [`ImageLight::intensity`].
    pub intensity: f32,
    /// See [`ImageLight::rotation`].
    pub rotation: Quat,
}

/// One level of a cube map: radiance on six faces.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeLevel {
    /// Texels along an edge.
    pub size: u32,
    /// +X, −X, +Y, −Y, +Z, −Z; each row-major from the top, seen from inside.
    pub faces: [Vec<[f32; 3]>; 6],
}
