//! Surface interactions: point, normals, texture coordinates and material values at a hit.
//!
//! [`SurfacePoint::new`] computes the geometry on the viewer's side of a surface, [`surface_at`] also the material values, and
//! [`alpha_at`] the coverage alone. Lights and the use of the values are not known here.

mod base_material_lanes;
mod blurred_material;
mod material;
mod material_extensions;
mod material_sample;
mod normal;
mod ray_differential;
mod surface;
mod surface_block;
mod surface_differentials;
mod surface_point;
mod texture_lookup;

pub(crate) use base_material_lanes::BaseMaterialLanes;
pub use blurred_material::BlurredMaterial;
pub use material::{
    alpha_at, catches_shadows, clear_coat_at, emission_at, is_constant, material_values, surface_at,
    untextured_color,
};
pub(crate) use material::{emission_around, emission_texels, is_opaque_at, transmits_at};
pub use material_sample::{
    AnisotropySample, ClearCoatSample, IridescenceSample, MaterialSample, SheenSample,
};
pub use ray_differential::RayDifferential;
pub use surface_block::{RayHit, SurfaceBlock};
pub use surface_point::SurfacePoint;
pub use texture_lookup::TextureProbes;
