//! The clear coat of a surface as one of its lobes, for path tracing.

use glam::{Mat3, Vec3};

use super::smooth_lobes::SmoothLobes;
use super::{Coat, bounded_reflection, ggx};
use crate::geometry::normalized_or;

/// A coat with its directions.
#[derive(Clone, Copy, Debug)]
pub struct OrientedCoat {
    /// The coat.
    pub coat: Coat,
    /// Takes directions of the shading frame to that of the coat.
    pub coat_from_local: Mat3,
    /// Geometric normal on the side of the view, in the shading frame: the coat reflects light from its side alone, also from directions that are
    /// below the lobes because their normal leans away.
    pub geometric_normal: Vec3,
}

/// The coat towards the view.
#[derive(Clone, Copy, Debug)]
pub(super) struct CoatLobe {
    pub(super) coat: Coat,
    pub(super) coat_from_local: Mat3,
    geometric_normal: Vec3,
    /// In the frame of the coat.
    pub(super) wo: Vec3,
    pub(super) albedo: f32,
    /// Factor of the lobe, for this view.
    scale: f32,
}

impl CoatLobe {
    /// The lobe towards `wo`, in the shading frame.
    pub(super) fn new(coat: OrientedCoat, wo: Vec3) -> Self {
        let OrientedCoat { coat, coat_from_local, geometric_normal } = coat;
        let wo = coat_from_local * wo;
        let (albedo, scale) = (coat.albedo(wo.z), coat.lobe_scale(wo.z));
        Self { coat, coat_from_local, geometric_normal, wo, albedo, scale }
    }

    /// Whether a direction of the shading frame is above the geometric surface. A coat's own normal may lean so far that it faces light from below.
    pub(super) fn is_above(&self, wi: Vec3) -> bool {
        self.geometric_normal.dot(wi) > 0.0
    }

    /// f · cos θ_i for light from a direction of the shading frame, and the density of that direction.
    pub(super) fn eval_and_pdf(&self, wi: Vec3, smooth: SmoothLobes) -> (f32, f32) {
        let Self { coat, coat_from_local, wo, scale, .. } = self;
        let is_smooth = coat.is_smooth();
        let is_above = self.is_above(wi);
        let wi = *coat_from_local * wi;
        let is_hidden = is_smooth && smooth == SmoothLobes::Without;
        if !is_above || wo.z <= 0.0 || wi.z <= 0.0 || is_hidden {
            return (0.0, 0.0);
        }
        let half = normalized_or(*wo + wi, Vec3::Z);
        let lobe = ggx::distribution(half, coat.alpha) * ggx::visibility(wo.z, wi.z, coat.alpha);
        let pdf = if is_smooth { 0.0 } else { self.reflected_pdf(half) };
        (scale * lobe * wi.z, pdf)
    }

    /// The density over solid angle of directions that the coat reflects, by their half vector.
    fn reflected_pdf(&self, half: Vec3) -> f32 {
        let (cosine, alpha) = (self.wo.z, self.coat.alpha);
        let towards = (ggx::distribution(half, alpha), ggx::masking_root(cosine, alpha));
        bounded_reflection::pdf(towards, cosine, alpha)
    }
}
