//! What is recorded of samples besides their values, where it is asked for: light by parts, and which surfaces were seen.
//!
//! Everything that is added to a sample is added to one of its parts, too, in the same order. The value itself is summed as
//! if there were no parts.

use glam::Vec3;

use super::sight::Sight;
use crate::integrator::{LightPass, LightPasses, Path, PathClass};
use crate::interaction::PosedScene;

/// What a tracer records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Recorded {
    /// Light by parts: [`super::Tracer::light_passes`].
    pub light: bool,
    /// Surfaces that camera rays see: [`super::Tracer::covers`].
    pub covers: bool,
}

/// A surface that a camera ray sees. Shadow catchers are not seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
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
    what: Recorded,
    /// By sample, or nothing.
    light: Vec<LightPasses>,
    covers: Vec<Cover>,
}

impl Records {
    pub(super) fn new(what: Recorded) -> Self {
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
    pub(super) fn cover(&mut self, posed: PosedScene<'_>, path: &Path, sight: &Sight) {
        if self.what.covers && path.class == PathClass::Camera {
            let instance = posed.frame.instance_of_triangle[sight.hit.primitive as usize];
            self.covers.push(Cover { sample: path.sample, instance, share: sight.share });
        }
    }

    pub(super) fn light(&self) -> &[LightPasses] {
        &self.light
    }

    pub(super) fn covers(&self) -> &[Cover] {
        &self.covers
    }
}
