//! AOVs of the samples of a batch: light passes and instance coverage.
//!
//! Everything that is added to a sample is also added to one of its light passes, in the same order. The value itself is
//! summed as if there were no passes.

use glam::Vec3;

use super::surface_hit::SurfaceHit;
use super::{GuideSample, LightPass, LightPasses, RayKind, RayState};
use crate::frame::Frame;

/// The AOVs that a tracer records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleAovFlags {
    /// Light passes: [`super::tracing::Tracer::light_passes`].
    pub light: bool,
    /// Instances that camera rays see: [`super::tracing::Tracer::coverage`].
    pub coverage: bool,
    /// Guides of denoising, of paths alone: [`super::tracing::Tracer::guides`].
    pub guides: bool,
}

/// The share of a camera ray that a mesh instance covers. Shadow catchers cover nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceCoverage {
    /// Index of the sample in its batch.
    pub sample: u32,
    /// Index into [`crate::frame::Frame::instances`].
    pub instance: u32,
    /// Share of the ray: what transparent surfaces in front leave, times the coverage of the surface itself.
    pub share: f32,
}

/// The recorded AOVs of a batch.
#[derive(Debug, Default)]
pub(super) struct SampleAovs {
    flags: SampleAovFlags,
    /// One entry for each sample, or none.
    light: Vec<LightPasses>,
    coverage: Vec<InstanceCoverage>,
    /// One entry for each sample, or none.
    guides: Vec<GuideSample>,
}

impl SampleAovs {
    pub(super) fn new(flags: SampleAovFlags) -> Self {
        Self { flags, ..Self::default() }
    }

    /// Starts a batch of `samples` samples.
    pub(super) fn clear(&mut self, samples: usize) {
        self.light.clear();
        self.coverage.clear();
        self.guides.clear();
        if self.flags.light {
            self.light.resize(samples, LightPasses::default());
        }
        if self.flags.guides {
            self.guides.resize(samples, GuideSample::default());
        }
    }

    /// Whether light passes are recorded.
    pub(super) fn records_light(&self) -> bool {
        self.flags.light
    }

    /// Adds radiance to a light pass of a sample.
    pub(super) fn add(&mut self, sample: u32, light_pass: LightPass, radiance: Vec3) {
        if let Some(light) = self.light.get_mut(sample as usize) {
            let sum = &mut light[light_pass.index()];
            sum.iter_mut().zip(radiance.to_array()).for_each(|(sum, channel)| *sum += channel);
        }
    }

    /// Adds a surface that scatters light to the guide of a sample.
    pub(super) fn add_guide(&mut self, sample: u32, share: f32, guide: GuideSample) {
        if let Some(sum) = self.guides.get_mut(sample as usize) {
            sum.albedo += guide.albedo * share;
            sum.normal += guide.normal * share;
        }
    }

    /// Whether guides are recorded.
    pub(super) fn has_guides(&self) -> bool {
        self.flags.guides
    }

    pub(super) fn guides(&self) -> &[GuideSample] {
        &self.guides
    }

    /// Adds the instance that a ray sees, if it is a camera ray.
    pub(super) fn add_coverage(&mut self, frame: &Frame, state: &RayState, surface_hit: &SurfaceHit) {
        if self.flags.coverage && state.kind == RayKind::Camera {
            let instance = frame.instance_of_triangle[surface_hit.hit.triangle as usize];
            self.coverage.push(InstanceCoverage { sample: state.sample, instance, share: surface_hit.share });
        }
    }

    pub(super) fn light(&self) -> &[LightPasses] {
        &self.light
    }

    pub(super) fn coverage(&self) -> &[InstanceCoverage] {
        &self.coverage
    }
}
