//! Light from pictures that belong to the file (`EXT_lights_image_based`).

use glam::{Quat, Vec3};

/// Surroundings as six pictures, with what they do to matte and rough surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageLight {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Multiplies everything.
    pub intensity: f32,
    /// Turns the surroundings.
    pub rotation: Quat,
    /// Irradiance as real spherical harmonics: Y₀₀, Y₁₋₁, Y₁₀, Y₁₁, Y₂₋₂, Y₂₋₁, Y₂₀, Y₂₁, Y₂₂.
    pub irradiance: [Vec3; 9],
    /// What a mirror sees, then ever rougher surfaces up to roughness 1; at least one.
    pub levels: Vec<CubeLevel>,
}

impl ImageLight {
    /// While no clip moves it.
    pub fn pose(&self) -> ImageLightPose {
        ImageLightPose { intensity: self.intensity, rotation: self.rotation }
    }
}

impl ImageLightPose {
    /// As strong as the pictures are, and not turned.
    pub const PLAIN: Self = Self { intensity: 1.0, rotation: Quat::IDENTITY };
}

/// What clips may move of an [`ImageLight`], at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageLightPose {
    /// See [`ImageLight::intensity`].
    pub intensity: f32,
    /// See [`ImageLight::rotation`].
    pub rotation: Quat,
}

/// Radiance from all directions on the faces of a cube.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeLevel {
    /// Texels along an edge.
    pub size: u32,
    /// +X, −X, +Y, −Y, +Z, −Z; each row-major from the top, as one sees it from inside.
    pub faces: [Vec<[f32; 3]>; 6],
}
