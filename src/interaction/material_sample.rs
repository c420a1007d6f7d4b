//! Material values at one point.

use glam::Vec3;

/// The values of a material at one point, textures applied. Coverage is computed by [`super::alpha_at`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialSample {
    /// Linear base colour.
    pub base_color: Vec3,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// 0 mirror to 1 fully rough; the GGX α is its square.
    pub roughness: f32,
    /// Share of the environment's light that reaches the point, from the occlusion map; for where no shadow rays decide about it.
    pub occlusion: f32,
    /// Emitted radiance.
    pub emission: Vec3,
    /// Whether the surface emits its base colour and receives no light.
    pub unlit: bool,
    /// Index of refraction; 0 leaves the reflectance to the specular colour.
    pub ior: f32,
    /// Whether the material has the two below, of `KHR_materials_specular`, whatever they are here.
    pub is_tinted: bool,
    /// Multiplies a dielectric's reflectance at every angle.
    pub specular: f32,
    /// Multiplies a dielectric's reflectance along the normal.
    pub specular_color: Vec3,
    /// Share of the light that is transmitted, of what is not reflected.
    pub transmission: f32,
    /// Whether the surface is a thin wall: light passes unbent.
    pub thin: bool,
    /// Share of the diffuse light that is transmitted.
    pub diffuse_transmission: f32,
    /// Colour of diffusely transmitted light.
    pub diffuse_transmission_color: Vec3,
    /// Anisotropy of the specular lobe.
    pub anisotropy: Option<AnisotropySample>,
    /// Thin film.
    pub iridescence: Option<IridescenceSample>,
    /// Sheen below the coat.
    pub sheen: Option<SheenSample>,
    /// Clear coat on top.
    pub clear_coat: Option<ClearCoatSample>,
}

impl MaterialSample {
    /// The same with rougher lobes: a GGX α below 0.3 is doubled, to at least 0.1 (Pharr, Jakob and Humphreys, "Physically Based Rendering",
    /// 2023, section 14.4.3, path regularisation).
    pub(crate) fn regularized(&self) -> Self {
        let clear_coat =
            self.clear_coat.map(|coat| ClearCoatSample { roughness: regularized(coat.roughness), ..coat });
        Self { roughness: regularized(self.roughness), clear_coat, ..*self }
    }
}

fn regularized(roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    if alpha < 0.3 { (2.0 * alpha).clamp(0.1, 0.3).sqrt() } else { roughness }
}

/// Anisotropy at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnisotropySample {
    /// 0 isotropic to 1 fully anisotropic.
    pub strength: f32,
    /// World-space unit vector of the larger roughness; not necessarily perpendicular to the shading normal.
    pub direction: Vec3,
}

/// A thin film at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IridescenceSample {
    /// Share of the surface that the film covers.
    pub factor: f32,
    /// Index of refraction of the film.
    pub ior: f32,
    /// Nanometres.
    pub thickness_nm: f32,
}

/// Sheen at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheenSample {
    /// Linear colour.
    pub color: Vec3,
    /// The distribution's α is its square.
    pub roughness: f32,
}

/// A clear coat at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearCoatSample {
    /// Share of the surface that is coated.
    pub factor: f32,
    /// 0 mirror to 1 fully rough; the GGX α is its square.
    pub roughness: f32,
    /// World-space unit normal of the coat, on the viewer's side; its mirror ray leaves the surface.
    pub normal: Vec3,
}

impl Default for MaterialSample {
    /// A white, rough dielectric.
    fn default() -> Self {
        Self {
            base_color: Vec3::ONE,
            metallic: 0.0,
            roughness: 1.0,
            occlusion: 1.0,
            emission: Vec3::ZERO,
            unlit: false,
            ior: 1.5,
            specular: 1.0,
            is_tinted: false,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            thin: true,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Vec3::ONE,
            anisotropy: None,
            iridescence: None,
            sheen: None,
            clear_coat: None,
        }
    }
}
