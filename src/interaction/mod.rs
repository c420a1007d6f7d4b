//! What a hit means for shading: point, normals, texture coordinates, and the material's values there.
//!
//! [`SurfacePoint::new`] turns a hit of a frame into geometry on the viewer's side of the surface; [`surface_at`] looks the
//! material up, too, and [`alpha_at`] its coverage alone. Nothing here knows about lights or about what is done with the values.

mod material;
mod material_extensions;
mod normal;
mod ray_differential;
mod surface;
mod texture_lookup;

use glam::Vec3;

pub use material::{alpha_at, catches_shadows, surface_at};
pub use ray_differential::RayDifferential;
pub use surface::SurfacePoint;

/// A material's values at one point, textures applied; coverage is asked of [`alpha_at`] alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialSample {
    /// Linear base colour.
    pub base_color: Vec3,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// 0 mirror to 1 dull; the GGX α is its square.
    pub roughness: f32,
    /// Share of the environment's light that reaches the point, from the occlusion map.
    pub occlusion: f32,
    /// Emitted radiance.
    pub emission: Vec3,
    /// Emits its base colour and receives no light.
    pub unlit: bool,
    /// Index of refraction; 0 leaves the reflection to its colour.
    pub ior: f32,
    /// Multiplies a dielectric's reflection at every angle.
    pub specular: f32,
    /// Multiplies a dielectric's reflection along the normal.
    pub specular_color: Vec3,
    /// Share of the light that is not reflected which passes through.
    pub transmission: f32,
    /// A wall without inside: light passes straight through.
    pub thin: bool,
    /// Share of the diffuse light that goes through.
    pub diffuse_transmission: f32,
    /// Colour of the diffuse light that goes through.
    pub diffuse_transmission_color: Vec3,
    /// A stretched highlight.
    pub anisotropy: Option<AnisotropySample>,
    /// A thin film.
    pub iridescence: Option<IridescenceSample>,
    /// Fibres below the coat.
    pub sheen: Option<SheenSample>,
    /// A clear layer on top.
    pub clear_coat: Option<ClearCoatSample>,
}

/// A stretched highlight at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnisotropySample {
    /// 0 round to 1 fully stretched.
    pub strength: f32,
    /// World-space unit vector along which it is stretched; not necessarily at a right angle to the shading normal.
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

/// Fibres at one point.
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
    /// 0 mirror to 1 dull; the GGX α is its square.
    pub roughness: f32,
    /// World-space unit normal of the coat, on the viewer's side; its mirror ray leaves the surface.
    pub normal: Vec3,
}

impl Default for MaterialSample {
    /// A white, dull dielectric.
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
