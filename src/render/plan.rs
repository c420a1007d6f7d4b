//! Which samples the pixels of a picture take.

use super::RenderSettings;
use super::filter::PixelSample;
use super::sampling::pixel_offsets;

/// Number of the set of extra samples in the first pass, beyond all base sets.
const EXTRA: u32 = 1 << 16;

/// One of several renders of a frame, at different times, whose mean is the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShutterSample {
    /// From 0.
    pub index: u32,
    /// How many there are.
    pub count: u32,
}

impl ShutterSample {
    /// The only one.
    pub const ONLY: Self = Self { index: 0, count: 1 };
}

/// The samples of every pixel in one pass.
#[derive(Clone, Debug)]
pub(super) struct SamplePlan {
    /// Those that all pixels take.
    pub(super) base: Vec<PixelSample>,
    /// Those that pixels on edges take, too.
    pub(super) extra: Vec<PixelSample>,
    /// See [`super::Adaptive::threshold`].
    pub(super) threshold: f32,
    /// Number of the first sample among those of all passes.
    pub(super) first_index: u32,
}

impl SamplePlan {
    /// Deals the samples of a frame to a pass; each has at least one.
    pub(super) fn new(settings: &RenderSettings, pass: ShutterSample) -> Self {
        let share = |samples: u32| samples.div_ceil(pass.count);
        let base = share(settings.samples);
        let most = settings.adaptive.map_or(base, |adaptive| share(adaptive.most_samples));
        let set = |count: u32, family: u32| match count {
            0 => Vec::new(),
            count => settings.filter.samples(&pixel_offsets(count, pass.index + family * EXTRA)),
        };
        Self {
            base: set(base, 0),
            extra: set(most.saturating_sub(base), 1),
            threshold: settings.adaptive.map_or(0.0, |adaptive| adaptive.threshold),
            first_index: pass.index.wrapping_mul(base.max(most)),
        }
    }

    /// Whether some pixels take more than others.
    pub(super) fn looks_for_edges(&self) -> bool {
        !self.extra.is_empty()
    }
}
