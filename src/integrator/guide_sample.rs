//! Guides of denoising.

use glam::Vec3;

/// What guides the denoising of a pixel or a sample: the first surface that scatters light, behind mirrors and clear glass. 0 without one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuideSample {
    /// Linear base colour, at least the emission; 0 to 1.
    pub albedo: Vec3,
    /// World-space shading normal; of a mean, not of unit length.
    pub normal: Vec3,
}
