//! The glTF metallic-roughness material and its extensions, as numbers and textures.

use glam::{Vec2, Vec3, Vec4};

use super::{
    Anisotropy, ClearCoat, DiffuseTransmission, Glossiness, Iridescence, Sheen, Specular, TextureIndex,
};

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
    /// How far the index of refraction differs between colours, as 20 by Abbe's number; matters in volumes only
    /// (`KHR_materials_dispersion`).
    pub dispersion: f32,
    /// Reflection other than the index says.
    pub specular: Option<Specular>,
    /// Takes the place of `roughness` and of G of its texture.
    pub glossiness: Option<Glossiness>,
    /// A clear layer on top.
    pub clear_coat: Option<ClearCoat>,
    /// Fibres below the coat.
    pub sheen: Option<Sheen>,
    /// A thin film.
    pub iridescence: Option<Iridescence>,
    /// A stretched highlight.
    pub anisotropy: Option<Anisotropy>,
    /// Diffuse light that goes through.
    pub diffuse_transmission: Option<DiffuseTransmission>,
    /// Invisible but for the shadows on it; set on request only ([`super::mark_shadow_catchers`]).
    pub is_shadow_catcher: bool,
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
    /// Counter-clockwise as seen in the picture.
    pub rotation: UvRotation,
    /// Applied first.
    pub scale: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation: UvRotation::default(), scale: Vec2::ONE }
    }
}

impl UvTransform {
    /// Where coordinates go. v runs downwards, hence the signs.
    pub fn of_point(&self, uv: Vec2) -> Vec2 {
        if *self == Self::default() { uv } else { self.offset + self.of_vector(uv) }
    }

    /// Where the difference of two coordinates goes.
    pub fn of_vector(&self, step: Vec2) -> Vec2 {
        let UvRotation { sin, cos, .. } = self.rotation;
        let scaled = step * self.scale;
        Vec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x)
    }
}

/// An angle with its sine and cosine, which lookups need and are not to compute each time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvRotation {
    radians: f32,
    sin: f32,
    cos: f32,
}

impl UvRotation {
    /// A rotation by an angle.
    pub fn from_radians(radians: f32) -> Self {
        let (sin, cos) = libm::sincosf(radians);
        Self { radians, sin, cos }
    }

    /// The angle.
    pub fn radians(self) -> f32 {
        self.radians
    }
}

impl Default for UvRotation {
    fn default() -> Self {
        Self { radians: 0.0, sin: 0.0, cos: 1.0 }
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
    /// Where this is 0 the surface is a thin wall. Rays measure how thick a volume is themselves, so it says no more than that.
    pub thickness: f32,
    /// World-space metres after which white light has become `attenuation_color`; may be infinite.
    pub attenuation_distance: f32,
    /// Linear colour at that distance.
    pub attenuation_color: Vec3,
}

impl Volume {
    /// An inside that absorbs nothing.
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
        }
    }
}

impl Material {
    /// Every texture that is looked up, with its coordinates.
    pub fn texture_refs(&self) -> impl Iterator<Item = &TextureRef> {
        [
            self.base_color_texture.as_ref(),
            self.metallic_roughness_texture.as_ref(),
            self.normal_texture.as_ref().map(|map| &map.texture),
            self.occlusion_texture.as_ref().map(|map| &map.texture),
            self.emissive_texture.as_ref(),
            self.transmission.as_ref().and_then(|layer| layer.texture.as_ref()),
            self.specular.as_ref().and_then(|layer| layer.texture.as_ref()),
            self.specular.as_ref().and_then(|layer| layer.color_texture.as_ref()),
            self.glossiness.as_ref().and_then(|layer| layer.texture.as_ref()),
            self.clear_coat.as_ref().and_then(|layer| layer.texture.as_ref()),
            self.clear_coat.as_ref().and_then(|layer| layer.roughness_texture.as_ref()),
            self.clear_coat.as_ref().and_then(|layer| layer.normal_texture.as_ref()).map(|map| &map.texture),
            self.sheen.as_ref().and_then(|layer| layer.color_texture.as_ref()),
            self.sheen.as_ref().and_then(|layer| layer.roughness_texture.as_ref()),
            self.iridescence.as_ref().and_then(|layer| layer.texture.as_ref()),
            self.iridescence.as_ref().and_then(|layer| layer.thickness_texture.as_ref()),
            self.anisotropy.as_ref().and_then(|layer| layer.texture.as_ref()),
            self.diffuse_transmission.as_ref().and_then(|layer| layer.texture.as_ref()),
            self.diffuse_transmission.as_ref().and_then(|layer| layer.color_texture.as_ref()),
        ]
        .into_iter()
        .flatten()
    }

    /// The coordinate set that the tangents of a mesh should follow; `None` where tangents matter to nothing.
    pub fn tangent_uv_set(&self) -> Option<u32> {
        let normal = self.normal_texture.map(|map| map.texture);
        let coat = self.clear_coat.and_then(|coat| coat.normal_texture).map(|map| map.texture);
        let stretch = self.anisotropy.map(|anisotropy| anisotropy.texture.map_or(0, |map| map.uv_set));
        normal.or(coat).map(|texture| texture.uv_set).or(stretch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_moves_u_to_minus_v() {
        // Rotation by 90° counter-clockwise: (u, v) → (v, −u), as the extension's sample viewers do.
        let rotation = UvRotation::from_radians(std::f32::consts::FRAC_PI_2);
        let quarter = UvTransform { rotation, ..Default::default() };
        let turned = quarter.of_point(Vec2::new(0.25, 0.75));
        assert!(turned.abs_diff_eq(Vec2::new(0.75, -0.25), 1e-6), "{turned}");
        // Scale comes before the turn, the offset after it; differences know no offset.
        let all = UvTransform { offset: Vec2::new(1.0, 2.0), scale: Vec2::new(2.0, 4.0), ..quarter };
        assert!(all.of_point(Vec2::new(0.25, 0.75)).abs_diff_eq(Vec2::new(4.0, 1.5), 1e-5));
        assert!(all.of_vector(Vec2::new(0.25, 0.75)).abs_diff_eq(Vec2::new(3.0, -0.5), 1e-5));
    }
}
