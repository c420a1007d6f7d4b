//! What the material extensions of glTF add to a surface, as numbers and textures.

use glam::Vec3;

use super::{NormalTexture, TextureRef};

/// Strength and colour of a dielectric's reflection (`KHR_materials_specular`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    /// Multiplies the reflection at every angle.
    pub factor: f32,
    /// Linear, in A; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// Linear colour that multiplies the reflection along the normal; may exceed one.
    pub color: Vec3,
    /// sRGB colour that multiplies `color`.
    pub color_texture: Option<TextureRef>,
}

/// Smoothness of the specular-glossiness model, in place of a roughness (`KHR_materials_pbrSpecularGlossiness`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glossiness {
    /// 1 less the roughness.
    pub factor: f32,
    /// Linear, in A; multiplies `factor`.
    pub texture: Option<TextureRef>,
}

/// A clear layer on top of everything else (`KHR_materials_clearcoat`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearCoat {
    /// Share of the surface that is coated.
    pub factor: f32,
    /// Linear, in R; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// 0 mirror to 1 dull; the GGX α is its square.
    pub roughness: f32,
    /// Linear, in G; multiplies `roughness`.
    pub roughness_texture: Option<TextureRef>,
    /// Normals of the coat alone; without it the coat is as smooth as the mesh.
    pub normal_texture: Option<NormalTexture>,
}

/// Fibres that stand on the surface, such as those of velvet (`KHR_materials_sheen`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheen {
    /// Linear colour; black is none.
    pub color: Vec3,
    /// sRGB colour that multiplies `color`.
    pub color_texture: Option<TextureRef>,
    /// How much the fibres stray from the normal: 0 not to 1 very; α is its square.
    pub roughness: f32,
    /// Linear, in A; multiplies `roughness`.
    pub roughness_texture: Option<TextureRef>,
}

/// A film as thin as the wavelengths of light (`KHR_materials_iridescence`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iridescence {
    /// Share of the surface that the film covers.
    pub factor: f32,
    /// Linear, in R; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// Index of refraction of the film.
    pub ior: f32,
    /// Thickness where the texture is 0, nanometres.
    pub thickness_minimum_nm: f32,
    /// Thickness where the texture is 1, or without one, nanometres.
    pub thickness_maximum_nm: f32,
    /// Linear, in G; where between minimum and maximum.
    pub thickness_texture: Option<TextureRef>,
}

/// A highlight that is stretched along one direction of the surface (`KHR_materials_anisotropy`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anisotropy {
    /// 0 round to 1 fully stretched.
    pub strength: f32,
    /// Counter-clockwise from the tangent, radians.
    pub rotation_radians: f32,
    /// Linear; the direction in tangent space as `2c − 1` in R and G, and what multiplies `strength` in B.
    pub texture: Option<TextureRef>,
}

/// Light that is scattered evenly to the other side (`KHR_materials_diffuse_transmission`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// Share of the diffuse light that goes through.
    pub factor: f32,
    /// Linear, in A; multiplies `factor`.
    pub texture: Option<TextureRef>,
    /// Linear colour of what goes through.
    pub color: Vec3,
    /// sRGB colour that multiplies `color`.
    pub color_texture: Option<TextureRef>,
}
