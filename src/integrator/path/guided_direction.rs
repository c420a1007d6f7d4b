//! The direction with which a path goes on: sampled from the lobes of its surface, or towards where photons came from.

use glam::{Vec2, Vec3};

use super::path_block::PathBlock;
use super::shaded_point::ShadedPoint;
use crate::bsdf::{LobeDirection, ScatterLobe, ScatterSample};
use crate::geometry::DirectionSample;

/// A direction in which a surface sends a ray of a path.
pub(super) struct ScatteredDirection {
    pub(super) sample: ScatterSample,
    /// In world space.
    pub(super) direction: Vec3,
    /// The weight by the lobes alone over that of `sample`.
    pub(super) unguided_ratio: f32,
}

/// A direction before what the lobes scatter from there is known.
#[derive(Clone, Copy)]
pub(super) enum ProposedDirection {
    /// Sampled by the lobes.
    ByLobes { direction: Vec3, sampled: LobeDirection },
    /// Sampled by the guide; `wi` is the same in the local shading frame.
    ByGuide { guided: DirectionSample, wi: Vec3 },
}

impl ProposedDirection {
    /// The local direction, unless a smooth lobe sampled it.
    pub(super) fn rough(&self) -> Option<Vec3> {
        match *self {
            Self::ByLobes { sampled: LobeDirection::Rough { wi, .. }, .. } | Self::ByGuide { wi, .. } => {
                Some(wi)
            }
            Self::ByLobes { sampled: LobeDirection::Smooth(_), .. } => None,
        }
    }
}

impl ShadedPoint<'_, '_> {
    /// Samples a direction; `None` where the path ends. `u_lobe` and `u` are uniform in the unit interval and square.
    pub(super) fn propose_direction(
        &self,
        block: &PathBlock,
        u_lobe: f32,
        u: Vec2,
    ) -> Option<ProposedDirection> {
        let u_lobe = match &self.guidance {
            None => u_lobe,
            Some(guidance) if u_lobe < guidance.share => {
                let guided = guidance.sample(u);
                let wi = self.local(guided.direction).filter(|_| self.is_outside(guided.direction))?;
                return Some(ProposedDirection::ByGuide { guided, wi });
            }
            Some(guidance) => {
                ((u_lobe - guidance.share) / (1.0 - guidance.share)).min(1.0 - f32::EPSILON / 2.0)
            }
        };
        let sampled = block.sample_direction(self.lane, u_lobe, u)?;
        let direction = match sampled {
            LobeDirection::Smooth(sample) if sample.is_unbent => -self.point.wo,
            LobeDirection::Smooth(ScatterSample { wi, lobe, .. }) | LobeDirection::Rough { wi, lobe } => {
                self.world_direction(wi, lobe)?
            }
        };
        Some(ProposedDirection::ByLobes { direction, sampled })
    }

    /// The sample in a proposed direction from where the lobes scatter `value` and which they sample with `lobe_pdf`; `None` where the path ends.
    pub(super) fn sample_in(
        &self,
        proposed: ProposedDirection,
        (value, lobe_pdf): (Vec3, f32),
    ) -> Option<ScatteredDirection> {
        let share = self.guidance.as_ref().map_or(0.0, |guidance| guidance.share);
        match proposed {
            ProposedDirection::ByGuide { guided: DirectionSample { direction, pdf: guided_pdf }, wi } => {
                let pdf = share * guided_pdf + (1.0 - share) * lobe_pdf;
                let sample = ScatterSample::of_rough(wi, ScatterLobe::Diffuse, (value, lobe_pdf))?;
                let sample = ScatterSample { weight: value / pdf, pdf, ..sample };
                Some(ScatteredDirection { sample, direction, unguided_ratio: pdf / lobe_pdf })
            }
            // Smooth lobes have no density, and no photons follow them.
            ProposedDirection::ByLobes { direction, sampled: LobeDirection::Smooth(mut sample) } => {
                let unguided_ratio = 1.0 - share;
                sample.weight /= unguided_ratio;
                Some(ScatteredDirection { sample, direction, unguided_ratio })
            }
            ProposedDirection::ByLobes { direction, sampled: LobeDirection::Rough { wi, lobe } } => {
                let mut sample = ScatterSample::of_rough(wi, lobe, (value, lobe_pdf))?;
                sample.pdf = self.direction_pdf(direction, lobe_pdf);
                let unguided_ratio = sample.pdf / lobe_pdf;
                sample.weight /= unguided_ratio;
                Some(ScatteredDirection { sample, direction, unguided_ratio })
            }
        }
    }

    /// The density with which [`ShadedPoint::propose_direction`] samples a world-space direction that the lobes sample with `lobe_pdf`.
    pub(super) fn direction_pdf(&self, direction: Vec3, lobe_pdf: f32) -> f32 {
        self.guidance.as_ref().map_or(lobe_pdf, |guidance| guidance.mixed_pdf(direction, lobe_pdf))
    }

    /// The world-space direction of a sampled one; `None` where it is not on the side to which the lobe sends light.
    fn world_direction(&self, wi: Vec3, lobe: ScatterLobe) -> Option<Vec3> {
        let direction = (self.world_from_local * wi).normalize();
        let side = if lobe.is_reflective() { 1.0 } else { -1.0 };
        (direction.dot(self.point.geometric_normal) * side > 0.0).then_some(direction)
    }
}
