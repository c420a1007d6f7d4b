//! The direction with which a path goes on: sampled from the lobes of its surface, or towards where photons came from.

use glam::{Vec2, Vec3};

use super::guiding::Guidance;
use super::shaded_point::ShadedPoint;
use crate::bsdf::{ScatterLobe, ScatterSample};

/// A sampled direction.
pub(super) struct SampledDirection {
    pub(super) sample: ScatterSample,
    /// In world space.
    pub(super) direction: Vec3,
    /// The weight by the lobes alone over that of `sample`.
    pub(super) unguided_ratio: f32,
}

impl ShadedPoint<'_, '_> {
    /// Samples a direction; `None` where the path ends. `u_lobe` and `u` are uniform in the unit interval and square.
    pub(super) fn sample_direction(&self, u_lobe: f32, u: Vec2) -> Option<SampledDirection> {
        let Some(guidance) = &self.guidance else {
            let sample = self.scattering.sample(u_lobe, u)?;
            let direction = self.world_direction(&sample)?;
            return Some(SampledDirection { sample, direction, unguided_ratio: 1.0 });
        };
        let lobe_share = 1.0 - guidance.share;
        if u_lobe < guidance.share {
            return self.sample_guided(guidance, u);
        }
        let u_lobe = ((u_lobe - guidance.share) / lobe_share).min(1.0 - f32::EPSILON / 2.0);
        let mut sample = self.scattering.sample(u_lobe, u)?;
        let direction = self.world_direction(&sample)?;
        // Smooth lobes have no density, and no photons follow them.
        let unguided_ratio = if sample.is_smooth {
            lobe_share
        } else {
            let pdf = guidance.mixed_pdf(direction, sample.pdf);
            let ratio = pdf / sample.pdf;
            sample.pdf = pdf;
            ratio
        };
        sample.weight /= unguided_ratio;
        Some(SampledDirection { sample, direction, unguided_ratio })
    }

    fn sample_guided(&self, guidance: &Guidance<'_>, u: Vec2) -> Option<SampledDirection> {
        let (direction, density) = guidance.sample(u);
        let wi = self.local(direction).filter(|wi| wi.z > 0.0)?;
        let (value, lobe_pdf) = self.scattering.eval_and_pdf(wi);
        if lobe_pdf <= 0.0 || value == Vec3::ZERO {
            return None;
        }
        let pdf = guidance.share * density + (1.0 - guidance.share) * lobe_pdf;
        let sample = ScatterSample {
            wi,
            weight: value / pdf,
            pdf,
            lobe: ScatterLobe::Diffuse,
            is_smooth: false,
            is_unbent: false,
        };
        Some(SampledDirection { sample, direction, unguided_ratio: pdf / lobe_pdf })
    }

    /// The density with which [`ShadedPoint::sample_direction`] samples a world-space direction that the lobes sample with `lobe_pdf`.
    pub(super) fn direction_pdf(&self, direction: Vec3, lobe_pdf: f32) -> f32 {
        self.guidance.as_ref().map_or(lobe_pdf, |guidance| guidance.mixed_pdf(direction, lobe_pdf))
    }

    /// The world-space direction of a sample; `None` where the normals disagree about its side.
    fn world_direction(&self, sample: &ScatterSample) -> Option<Vec3> {
        if sample.is_unbent {
            return Some(-self.point.wo);
        }
        let direction = (self.world_from_local * sample.wi).normalize();
        (direction.dot(self.point.geometric_normal) * sample.wi.z > 0.0).then_some(direction)
    }
}
