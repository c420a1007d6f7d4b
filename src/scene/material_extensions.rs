//! Lobes and modifiers of the glTF material extensions.

use glam::Vec3;

use super::texture_ref::{NormalTexture, TextureRef};

/// Strength and colour of the dielectric reflection (`KHR_materials_specular`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    /// Factor on the reflection at every angle.
    pub factor: f32,
    /// Linear, in A; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// Linear colour factor on the reflection at normal incidence; may exceed one.
    pub color: Vec3,
    /// sRGB colour that multiplies `color`.
    pub color_texture: Option<TextureRef>,
}

/// Glossiness of the specular-glossiness model, which replaces the roughness (`KHR_materials_pbrSpecularGlossiness`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glossiness {
    /// One minus the roughness.
    pub factor: f32,
    /// Linear, in A; multiplies `factor`.
    pub texture: Option<TextureRef>,
}

/// Clear coat on top of all other lobes (`KHR_materials_clearcoat`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearCoat {
    /// Coated fraction of the surface.
    pub factor: f32,
    /// Linear, in R; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// 0 (mirror) to 1 (rough); the GGX α is its square.
    pub roughness: f32,
    /// Linear, in G; multiplies `roughness`.
    pub roughness_texture: Option<TextureRef>,
    /// Normal map of the coat alone; without one the coat has the normals of the mesh.
    pub normal_texture: Option<NormalTexture>,
}

/// Sheen of fibres such as velvet (`KHR_materials_sheen`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheen {
    /// Linear colour; black disables the sheen.
    pub color: Vec3,
    /// sRGB colour that multiplies `color`.
    pub color_texture: Option<TextureRef>,
    /// Spread of the fibres about the normal, 0 to 1; α is its square.
    pub roughness: f32,
    /// Linear, in A; multiplies `roughness`.
    pub roughness_texture: Option<TextureRef>,
}

/// Iridescent thin film (`KHR_materials_iridescence`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iridescence {
    /// Fraction of the surface that the film covers.
    pub factor: f32,
    /// Linear, in R; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// Index of refraction of the film.
    pub ior: f32,
    /// Thickness at texture value 0, nanometres.
    pub thickness_minimum_nm: f32,
    /// Thickness at texture value 1 or without a texture, nanometres.
    pub thickness_maximum_nm: f32,
    /// Linear, in G; interpolates between minimum and maximum.
    pub thickness_texture: Option<TextureRef>,
}

/// Anisotropic highlight, elongated along one direction of the surface (`KHR_materials_anisotropy`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anisotropy {
    /// 0 (isotropic) to 1 (fully anisotropic).
    pub strength: f32,
    /// Counter-clockwise from the tangent, radians.
    pub rotation_radians: f32,
    /// Linear; the direction in tangent space as `2c − 1` in R and G, and a factor on `strength` in B.
    pub texture: Option<TextureRef>,
}

/// Lambertian transmission to the other side (`KHR_materials_diffuse_transmission`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// Fraction of the diffuse light that is transmitted.
    pub factor: f32,
    /// Linear, in A; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// Linear colour of the transmitted light.
    pub color: Vec3,
    /// sRGB colour that multiplies `color`.
    pub color_texture: Option<TextureRef>,
}
