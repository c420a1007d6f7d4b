//! What is recorded of samples besides their values, where it is asked for: light by parts, and which surfaces were seen.
//!
//! Everything that is added to a sample is added to one of its parts, too, in the same order. The value itself is summed as
//! if there were no parts.

use glam::Vec3;

use super::surface_hits::SurfaceHit;
use crate::integrator::{LightPass, LightPasses, RayKind, RayState};
use crate::scene_view::SceneView;

/// What a tracer records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleAovFlags {
    /// Light by parts: [`super::Tracer::light_passes`].
    pub light: bool,
    /// Surfaces that camera rays see: [`super::Tracer::covers`].
    pub covers: bool,
}

/// A surface that a camera ray sees. Shadow catchers are not seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceCoverage {
    /// Subscript of the sample in its batch.
    pub sample: u32,
    /// Subscript of [`crate::frame::Frame::instances`].
    pub instance: u32,
    /// Share of the ray that see-through surfaces in front and the surface's own coverage leave.
    pub share: f32,
}

/// The records of a batch.
#[derive(Debug, Default)]
pub(super) struct Records {
    what: SampleAovFlags,
    /// By sample, or nothing.
    light: Vec<LightPasses>,
    covers: Vec<InstanceCoverage>,
}

impl Records {
    pub(super) fn new(what: SampleAovFlags) -> Self {
        Self { what, ..Self::default() }
    }

    /// Begins a batch of so many samples.
    pub(super) fn clear(&mut self, samples: usize) {
        self.light.clear();
        self.covers.clear();
        if self.what.light {
            self.light.resize(samples, LightPasses::default());
        }
    }

    /// Adds to a part of a sample.
    pub(super) fn add(&mut self, sample: u32, part: LightPass, radiance: Vec3) {
        if let Some(light) = self.light.get_mut(sample as usize) {
            let sum = &mut light[part.subscript()];
            sum.iter_mut().zip(radiance.to_array()).for_each(|(sum, channel)| *sum += channel);
        }
    }

    /// Notes what a camera ray sees.
    pub(super) fn cover(&mut self, view: SceneView<'_>, state: &RayState, surface_hit: &SurfaceHit) {
        if self.what.covers && state.kind == RayKind::Camera {
            let instance = view.frame.instance_of_triangle[surface_hit.hit.triangle as usize];
            self.covers.push(InstanceCoverage { sample: state.sample, instance, share: surface_hit.share });
        }
    }

    pub(super) fn light(&self) -> &[LightPasses] {
        &self.light
    }

    pub(super) fn covers(&self) -> &[InstanceCoverage] {
        &self.covers
    }
}
