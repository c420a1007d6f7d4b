//! The glTF metallic-roughness material with its extensions.

use glam::{Vec3, Vec4};

use super::{
    Anisotropy, ClearCoat, DiffuseTransmission, Glossiness, Iridescence, MaterialIndex, NormalTexture,
    OcclusionTexture, Sheen, Specular, TextureRef,
};

/// Material of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Linear base colour and alpha.
    pub base_color: Vec4,
    /// sRGB colour and linear alpha that multiply `base_color`.
    pub base_color_texture: Option<TextureRef>,
    /// 0 (dielectric) to 1 (metal).
    pub metallic: f32,
    /// 0 (mirror) to 1 (rough); the GGX α is its square.
    pub roughness: f32,
    /// Linear; roughness in G, metallic in B.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map.
    pub normal_texture: Option<NormalTexture>,
    /// Ambient occlusion, linear, in R.
    pub occlusion_texture: Option<OcclusionTexture>,
    /// Linear radiance, strength included (`KHR_materials_emissive_strength`).
    pub emissive: Vec3,
    /// Linear emissive colour. `emissive` is its product with the strength; clips animate either.
    pub emissive_factor: Vec3,
    /// Factor on `emissive_factor`.
    pub emissive_strength: f32,
    /// sRGB colour that multiplies `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// Alpha mode.
    pub alpha_mode: AlphaMode,
    /// Whether the back face is visible.
    pub double_sided: bool,
    /// Emits its base colour and receives no light (`KHR_materials_unlit`).
    pub unlit: bool,
    /// Index of refraction (`KHR_materials_ior`); 0 means a Fresnel factor of one everywhere.
    pub ior: f32,
    /// Specular transmission (`KHR_materials_transmission`).
    pub transmission: Option<Transmission>,
    /// Interior of a closed surface (`KHR_materials_volume`); `None` is a thin wall.
    pub volume: Option<Volume>,
    /// Dispersion as 20 divided by the Abbe number; affects volumes only (`KHR_materials_dispersion`).
    pub dispersion: f32,
    /// Strength and colour of the specular reflection.
    pub specular: Option<Specular>,
    /// Replaces `roughness` and channel G of its texture.
    pub glossiness: Option<Glossiness>,
    /// Clear coat on top of the other lobes.
    pub clear_coat: Option<ClearCoat>,
    /// Sheen below the clear coat.
    pub sheen: Option<Sheen>,
    /// Thin-film iridescence.
    pub iridescence: Option<Iridescence>,
    /// Anisotropy of the highlight.
    pub anisotropy: Option<Anisotropy>,
    /// Diffuse transmission.
    pub diffuse_transmission: Option<DiffuseTransmission>,
    /// Whether only the shadows on the surface are visible. Set by [`super::mark_shadow_catchers`], never by importers.
    pub is_shadow_catcher: bool,
    /// The material of the file of which this is a copy, for a node that catches shadows.
    pub copy_of: Option<MaterialIndex>,
}

/// Alpha mode of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// The surface is opaque where alpha reaches the cutoff, and absent elsewhere.
    Mask {
        /// Lowest opaque alpha.
        cutoff: f32,
    },
    /// Alpha is coverage.
    Blend,
}

/// Specular transmission of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// Fraction of the light that is not reflected which is transmitted.
    pub factor: f32,
    /// Linear, in R; multiplies `factor`.
    pub texture: Option<TextureRef>,
}

/// Homogeneous, purely absorbing medium inside a closed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// 0 makes the surface a thin wall. Other values are equivalent, because rays measure the thickness themselves.
    pub thickness: f32,
    /// World-space metres over which white light is attenuated to `attenuation_color`; may be infinite.
    pub attenuation_distance: f32,
    /// Linear colour at that distance.
    pub attenuation_color: Vec3,
}

impl Volume {
    /// A medium without absorption.
    pub const CLEAR: Self =
        Self { thickness: 1.0, attenuation_distance: f32::INFINITY, attenuation_color: Vec3::ONE };
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
            dispersion: 0.0,
            specular: None,
            glossiness: None,
            clear_coat: None,
            sheen: None,
            iridescence: None,
            anisotropy: None,
            diffuse_transmission: None,
            is_shadow_catcher: false,
            copy_of: None,
        }
    }
}

impl Material {
    /// All texture references of the material.
    pub fn texture_refs(&self) -> impl Iterator<Item = &TextureRef> {
        [
            self.base_color_texture.as_ref(),
            self.metallic_roughness_texture.as_ref(),
            self.normal_texture.as_ref().map(|map| &map.texture),
            self.occlusion_texture.as_ref().map(|map| &map.texture),
            self.emissive_texture.as_ref(),
            self.transmission.as_ref().and_then(|extension| extension.texture.as_ref()),
            self.specular.as_ref().and_then(|extension| extension.texture.as_ref()),
            self.specular.as_ref().and_then(|extension| extension.color_texture.as_ref()),
            self.glossiness.as_ref().and_then(|extension| extension.texture.as_ref()),
            self.clear_coat.as_ref().and_then(|extension| extension.texture.as_ref()),
            self.clear_coat.as_ref().and_then(|extension| extension.roughness_texture.as_ref()),
            self.clear_coat
                .as_ref()
                .and_then(|extension| extension.normal_texture.as_ref())
                .map(|map| &map.texture),
            self.sheen.as_ref().and_then(|extension| extension.color_texture.as_ref()),
            self.sheen.as_ref().and_then(|extension| extension.roughness_texture.as_ref()),
            self.iridescence.as_ref().and_then(|extension| extension.texture.as_ref()),
            self.iridescence.as_ref().and_then(|extension| extension.thickness_texture.as_ref()),
            self.anisotropy.as_ref().and_then(|extension| extension.texture.as_ref()),
            self.diffuse_transmission.as_ref().and_then(|extension| extension.texture.as_ref()),
            self.diffuse_transmission.as_ref().and_then(|extension| extension.color_texture.as_ref()),
        ]
        .into_iter()
        .flatten()
    }

    /// Whether the surface transmits light as glass does. Diffuse transmission does not count.
    pub fn transmits(&self) -> bool {
        self.transmission.is_some_and(|transmission| transmission.factor > 0.0) && !self.unlit
    }

    /// Whether the surface bounds a closed volume that light enters and leaves, as through glass or by diffuse transmission.
    pub fn is_volume(&self) -> bool {
        let diffuse = self.diffuse_transmission.map_or(0.0, |transmission| transmission.factor);
        let lets_light_in = self.transmits() || (diffuse > 0.0 && !self.unlit);
        self.volume.is_some_and(|volume| volume.thickness > 0.0) && lets_light_in
    }

    /// Whether the surface bounds a volume whose index bends light.
    pub fn is_glass_volume(&self) -> bool {
        self.is_volume() && self.transmits()
    }

    /// Set of texture coordinates for the tangents of a mesh; `None` if nothing uses tangents.
    pub fn tangent_uv_set(&self) -> Option<u32> {
        let normal = self.normal_texture.map(|map| map.texture);
        let coat = self.clear_coat.and_then(|coat| coat.normal_texture).map(|map| map.texture);
        let anisotropy = self.anisotropy.map(|anisotropy| anisotropy.texture.map_or(0, |map| map.uv_set));
        normal.or(coat).map(|texture| texture.uv_set).or(anisotropy)
    }
}
