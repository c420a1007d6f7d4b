//! The specular lobe of a surface, for rays that follow it.

use glam::{Mat3, Vec3};

use crate::bsdf::{AlbedoTerms, Bsdf};

/// The specular lobe of a surface.
pub(super) struct ReflectedLobe<'b> {
    pub(super) bsdf: &'b Bsdf,
    pub(super) terms: AlbedoTerms,
    /// Columns are tangent, bitangent and normal.
    pub(super) world_from_local: Mat3,
    /// Local direction to the viewer.
    pub(super) wo: Vec3,
    /// Directional albedo.
    pub(super) albedo: Vec3,
}
