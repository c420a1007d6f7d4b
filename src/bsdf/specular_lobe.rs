//! A GGX lobe, isotropic or anisotropic, without its Fresnel factor.

use glam::{Vec2, Vec3};

use super::bounded_reflection;
use super::ggx::{self, MIN_ALPHA};
use super::ggx_anisotropic::AnisotropicGgx;

/// Whether isotropic lobes of this roughness are those of mirrors and clear glass; an anisotropic one is wider.
pub(crate) fn is_smooth_roughness(roughness: f32) -> bool {
    SpecularLobe::new(roughness.clamp(0.0, 1.0), None).is_smooth()
}

/// A GGX lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpecularLobe {
    pub(super) roughness: f32,
    pub(super) alpha: f32,
    pub(super) anisotropic: Option<AnisotropicGgx>,
}

impl SpecularLobe {
    /// A lobe of the given roughness; with a strength of anisotropy it is wider along X.
    #[inline(always)]
    pub(super) fn new(roughness: f32, anisotropy_strength: Option<f32>) -> Self {
        let alpha = roughness * roughness;
        let alpha = if alpha > MIN_ALPHA { alpha } else { MIN_ALPHA };
        let anisotropic = anisotropy_strength.map(|strength| AnisotropicGgx::new(alpha, strength));
        Self { roughness, alpha, anisotropic }
    }

    /// The lobe of facets that tilt light by `scale` times less; as sharp as a mirror's where both its α are.
    #[inline(always)]
    pub(super) fn narrowed(&self, scale: f32) -> Self {
        let narrowed = self.anisotropic.map(|ggx| ggx.narrowed(scale * scale));
        let anisotropic = narrowed.filter(|ggx| ggx.alpha.x > MIN_ALPHA);
        Self { anisotropic, ..Self::new(self.roughness * scale, None) }
    }

    /// Whether the lobe is a mirror's.
    #[inline(always)]
    pub(super) fn is_smooth(&self) -> bool {
        self.anisotropic.is_none() && self.alpha <= MIN_ALPHA
    }

    /// Roughness along the direction in which the lobe is widest.
    pub(super) fn widest_roughness(&self) -> f32 {
        self.anisotropic.map_or(self.roughness, |ggx| libm::sqrtf(ggx.alpha.x))
    }

    /// D V of the lobe.
    #[inline(always)]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3, half: Vec3) -> f32 {
        match &self.anisotropic {
            Some(anisotropic) => anisotropic.distribution(half) * anisotropic.visibility(wo, wi),
            None => ggx::distribution(half, self.alpha) * ggx::visibility(wo.z, wi.z, self.alpha),
        }
    }

    /// G1 of a direction on either side.
    pub(super) fn masking(&self, direction: Vec3) -> f32 {
        let cosine = direction.z.abs();
        let root = match &self.anisotropic {
            Some(anisotropic) => anisotropic.masking_root(direction),
            None => ggx::masking_root(cosine, self.alpha),
        };
        2.0 * cosine / (cosine + root)
    }

    /// The density over solid angle of normals from [`SpecularLobe::visible_normal`].
    pub(super) fn visible_normal_pdf(&self, wo: Vec3, half: Vec3) -> f32 {
        // A mirror spreads normals by 4 o·h.
        self.reflection_pdf(wo, half) * (4.0 * wo.dot(half))
    }

    /// Samples a microfacet normal that `wo` sees; `disk` is a point of the unit disk.
    pub(super) fn visible_normal(&self, wo: Vec3, disk: Vec2) -> Vec3 {
        match &self.anisotropic {
            Some(anisotropic) => anisotropic.visible_normal(wo, disk),
            None => ggx::visible_normal(wo, self.alpha, disk),
        }
    }

    /// Samples a direction that the lobe reflects; `None` below the surface. `disk` is a point of the unit disk.
    pub(super) fn reflected(&self, wo: Vec3, disk: Vec2) -> Option<Vec3> {
        let alpha = self.anisotropic.map_or(Vec2::splat(self.alpha), |anisotropic| anisotropic.alpha);
        bounded_reflection::reflected(wo, alpha, disk)
    }

    /// The density of these directions, with respect to solid angle.
    #[inline(always)]
    pub(super) fn reflected_pdf(&self, wo: Vec3, half: Vec3) -> f32 {
        let (towards, least_alpha) = match &self.anisotropic {
            Some(ggx) => ((ggx.distribution(half), ggx.masking_root(wo)), ggx.alpha.min_element()),
            None => ((ggx::distribution(half, self.alpha), ggx::masking_root(wo.z, self.alpha)), self.alpha),
        };
        bounded_reflection::pdf(towards, wo.z, least_alpha)
    }

    /// The density of directions reflected at normals from [`SpecularLobe::visible_normal`], with respect to solid angle.
    #[inline(always)]
    pub(super) fn reflection_pdf(&self, wo: Vec3, half: Vec3) -> f32 {
        match &self.anisotropic {
            Some(anisotropic) => anisotropic.reflection_pdf(wo, half),
            None => ggx::reflection_pdf(wo.z, half, self.alpha),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrowed_lobes_have_the_narrowed_roughness_along_both_axes() {
        // Without strength a lobe is as wide in both directions, and narrows as the isotropic one: to a roughness of 0.6 · 0.5, α = 0.09.
        for strength in [None, Some(0.0)] {
            let lobe = SpecularLobe::new(0.6, strength).narrowed(0.5);
            let alpha = lobe.anisotropic.map_or(Vec2::splat(lobe.alpha), |ggx| ggx.alpha);
            assert!((alpha - 0.09).abs().max_element() < 1e-6, "{alpha}");
        }
        // mix(0.36, 1, 0.25) = 0.52 along the wider axis; a quarter of both.
        let brushed = SpecularLobe::new(0.6, Some(0.5)).narrowed(0.5).anisotropic.unwrap();
        assert!((brushed.alpha - Vec2::new(0.13, 0.09)).abs().max_element() < 1e-6, "{}", brushed.alpha);
        let clear = SpecularLobe::new(0.6, Some(0.5)).narrowed(0.0);
        assert!(clear.is_smooth());
    }
}
