//! The shape of a GGX lobe, round or stretched, whatever it reflects.

use glam::{Vec2, Vec3};

use super::SHARPEST_ALPHA;
use super::ggx;
use super::ggx_anisotropic::AnisotropicGgx;

/// The facets of a rough surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpecularLobe {
    pub(super) roughness: f32,
    alpha: f32,
    pub(super) stretch: Option<AnisotropicGgx>,
}

impl SpecularLobe {
    /// The facets of a roughness; with a strength they are stretched along X.
    pub(super) fn new(roughness: f32, stretch_strength: Option<f32>) -> Self {
        let alpha = roughness * roughness;
        let alpha = if alpha > SHARPEST_ALPHA { alpha } else { SHARPEST_ALPHA };
        Self {
            roughness,
            alpha,
            stretch: stretch_strength.map(|strength| AnisotropicGgx::new(alpha, strength)),
        }
    }

    /// Whether it cannot be told from a mirror's.
    pub(super) fn is_smooth(&self) -> bool {
        self.stretch.is_none() && self.alpha <= SHARPEST_ALPHA
    }

    /// The roughness along the direction in which it is widest.
    pub(super) fn widest_roughness(&self) -> f32 {
        self.stretch.map_or(self.roughness, |stretch| libm::sqrtf(stretch.alpha.x))
    }

    /// D V.
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3, half: Vec3) -> f32 {
        match &self.stretch {
            Some(stretch) => stretch.distribution(half) * stretch.visibility(wo, wi),
            None => ggx::distribution(half, self.alpha) * ggx::visibility(wo.z, wi.z, self.alpha),
        }
    }

    /// A normal of the facets that `wo` sees; `disk` is a point of the unit disk.
    pub(super) fn visible_normal(&self, wo: Vec3, disk: Vec2) -> Vec3 {
        match &self.stretch {
            Some(stretch) => stretch.visible_normal(wo, disk),
            None => ggx::visible_normal(wo, self.alpha, disk),
        }
    }

    /// The density, with respect to the solid angle of what they reflect, of these normals.
    pub(super) fn reflection_pdf(&self, wo: Vec3, half: Vec3) -> f32 {
        match &self.stretch {
            Some(stretch) => stretch.reflection_pdf(wo, half),
            None => ggx::reflection_pdf(wo.z, half, self.alpha),
        }
    }
}
