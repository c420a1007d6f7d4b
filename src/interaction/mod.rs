//! What a hit means for shading: point, normals, texture coordinates, and the material's values there.
//!
//! [`SurfacePoint::new`] turns a hit of a frame into geometry on the viewer's side of the surface; [`material_at`] and
//! [`alpha_at`] look the material up. Nothing here knows about lights or about what is done with the values.

mod footprint;
mod material;
mod normal;
mod surface;
mod texture_lookup;

use glam::Vec3;

use crate::frame::Frame;
use crate::scene::Scene;

pub use footprint::Footprint;
pub use material::{alpha_at, catches_shadows, material_at};
pub use surface::SurfacePoint;

/// A frame with the scene that it poses: what texture lookups need besides the frame.
#[derive(Clone, Copy, Debug)]
pub struct PosedScene<'a> {
    /// Images, texture coordinates and vertex colours.
    pub scene: &'a Scene,
    /// The scene at one time.
    pub frame: &'a Frame,
}

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
    /// Index of refraction; 0 means a Fresnel factor of one everywhere.
    pub ior: f32,
    /// Share of the light that is not reflected which passes through.
    pub transmission: f32,
    /// A wall without inside: light passes straight through.
    pub thin: bool,
}
