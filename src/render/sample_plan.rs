//! The samples that the pixels of an image take.

use super::filter::PixelSample;
use super::pixel_offsets::{pixel_offsets, progressive_offsets};
use super::settings::RenderSettings;
use crate::integrator::Integrator;

/// Index of the first set of extra samples; the sets of base samples have lower ones.
const EXTRA_SET: u32 = 1 << 16;

/// One of several renders of a frame, at different times, whose mean is the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShutterSample {
    /// From 0.
    pub index: u32,
    /// Number of shutter samples of the frame.
    pub count: u32,
}

impl ShutterSample {
    /// The only shutter sample of a frame without motion blur.
    pub const ONLY: Self = Self { index: 0, count: 1 };
}

/// The samples of every pixel in one shutter sample.
#[derive(Clone, Debug)]
pub(super) struct SamplePlan {
    /// Samples of all pixels.
    pub(super) base: Vec<PixelSample>,
    /// Additional samples of pixels on edges.
    pub(super) extra: Vec<PixelSample>,
    /// See [`super::Adaptive::threshold`].
    pub(super) threshold: f32,
    /// Noise at which a pixel takes no more samples.
    pub(super) noise: Option<f32>,
    /// Index of the first sample among those of all shutter samples.
    pub(super) first_index: u32,
}

impl SamplePlan {
    /// Divides the samples of a frame among its shutter samples; each has at least one.
    pub(super) fn new(settings: &RenderSettings, shutter_sample: ShutterSample) -> Self {
        let share = |samples: u32| samples.div_ceil(shutter_sample.count);
        let base = share(settings.samples);
        let max = settings.adaptive.map_or(base, |adaptive| share(adaptive.max_samples));
        let set = |count: u32, family: u32| match count {
            0 => Vec::new(),
            count => {
                let index = shutter_sample.index + family * EXTRA_SET;
                let offsets = match settings.integrator {
                    Integrator::Path => progressive_offsets(count, index),
                    Integrator::Whitted => pixel_offsets(count, index),
                };
                settings.filter.samples(&offsets)
            }
        };
        Self {
            base: set(base, 0),
            extra: set(max.saturating_sub(base), 1),
            threshold: settings.adaptive.map_or(0.0, |adaptive| adaptive.threshold),
            noise: settings.path.noise,
            first_index: shutter_sample.index.wrapping_mul(base.max(max)),
        }
    }

    /// Whether pixels on edges take extra samples.
    pub(super) fn is_adaptive(&self) -> bool {
        !self.extra.is_empty()
    }
}
