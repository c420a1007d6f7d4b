//! The last surface of a path that scattered light.

use glam::Vec3;

use super::path::VisibleEntry;

/// The surface that sampled a ray, as far as the weight of a light at the ray's end depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LastScatter {
    /// Density of the ray's direction with respect to solid angle; infinite where no shadow rays look for lights in that direction.
    pub(super) pdf: f32,
    pub(super) position: Vec3,
    /// Number of reflections and refractions before the surface.
    pub(super) depth: u32,
    /// Normal of a surface that scatters light of its own side alone.
    pub(super) normal: Option<Vec3>,
    /// What it sees of the environment.
    pub(super) visible: Option<VisibleEntry>,
}
