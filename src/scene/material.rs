//! The glTF metallic-roughness material and its extensions, as numbers and textures.

use glam::{Vec2, Vec3, Vec4};

use super::TextureIndex;

/// What a surface looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Linear base colour and alpha.
    pub base_color: Vec4,
    /// sRGB colour and linear alpha that multiply `base_color`.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// 0 mirror to 1 dull; the GGX α is its square.
    pub roughness: f32,
    /// Linear; roughness in G, metallic in B.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map.
    pub normal_texture: Option<NormalTexture>,
    /// Ambient occlusion, linear, in R.
    pub occlusion_texture: Option<OcclusionTexture>,
    /// Linear radiance, strength included (`KHR_materials_emissive_strength`).
    pub emissive: Vec3,
    /// Linear colour of which `emissive` is the product with the strength; clips move either.
    pub emissive_factor: Vec3,
    /// Multiplies `emissive_factor`.
    pub emissive_strength: f32,
    /// sRGB colour that multiplies `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// Whether the back face is visible.
    pub double_sided: bool,
    /// Emits its base colour and receives no light (`KHR_materials_unlit`).
    pub unlit: bool,
    /// Index of refraction (`KHR_materials_ior`); 0 means a Fresnel factor of one everywhere.
    pub ior: f32,
    /// Light that passes through (`KHR_materials_transmission`).
    pub transmission: Option<Transmission>,
    /// The inside of a closed surface (`KHR_materials_volume`); `None` is a thin wall.
    pub volume: Option<Volume>,
}

/// A texture with the coordinates it is looked up by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Which texture.
    pub texture: TextureIndex,
    /// Subscript of [`super::Primitive::uvs`].
    pub uv_set: u32,
    /// Applied to the coordinates before wrapping.
    pub transform: UvTransform,
}

/// `KHR_texture_transform`: translation · rotation · scale of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Added last.
    pub offset: Vec2,
    /// Counter-clockwise as seen in the picture, radians.
    pub rotation_radians: f32,
    /// Applied first.
    pub scale: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation_radians: 0.0, scale: Vec2::ONE }
    }
}

/// A tangent-space normal map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalTexture {
    /// Linear; RGB hold the normal as `2c − 1`.
    pub texture: TextureRef,
    /// Multiplies the normal's x and y.
    pub scale: f32,
}

/// Ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionTexture {
    /// Linear, in R.
    pub texture: TextureRef,
    /// 0 ignores the texture, 1 applies it fully.
    pub strength: f32,
}

/// How alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Not at all.
    #[default]
    Opaque,
    /// The surface is there where alpha reaches the cutoff.
    Mask {
        /// Lowest alpha that is there.
        cutoff: f32,
    },
    /// Alpha is coverage.
    Blend,
}

/// Light that passes through the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// Share of the light that is not reflected which passes through.
    pub factor: f32,
    /// Linear, in R; multiplies `factor`.
    pub texture: Option<TextureRef>,
}

/// A homogeneous, purely absorbing inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// World-space metres after which white light has become `attenuation_color`; may be infinite.
    pub attenuation_distance: f32,
    /// Linear colour at that distance.
    pub attenuation_color: Vec3,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: None,
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            emissive: Vec3::ZERO,
            emissive_factor: Vec3::ZERO,
            emissive_strength: 1.0,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            ior: 1.5,
            transmission: None,
            volume: None,
        }
    }
}
