//! The samples that the pixels of an image take.
//!
//! [`SamplePlan`] is that of Whitted's tree, [`path_samples`] gives those of paths.

use std::ops::Range;

use super::adaptive::EdgeThreshold;
use super::filter::PixelSample;
use super::pixel_offsets::{pixel_offsets, progressive_offsets};
use super::settings::RenderSettings;
use super::shutter_sample::ShutterSample;
use crate::color::exposure_scale;

/// Index of the set of extra samples in [`pixel_offsets`]; that of base samples is 0.
const EXTRA_SET: u32 = 1 << 16;

/// Some of the samples of every pixel that paths have in one shutter sample. The first of any number fill the pixel evenly.
pub(super) fn path_samples(
    settings: &RenderSettings,
    shutter_sample: ShutterSample,
    indices: Range<u32>,
) -> Vec<PixelSample> {
    let count = shutter_sample.share_of(settings.samples);
    settings.filter.samples(&progressive_offsets(indices, count, shutter_sample))
}

/// The samples of every pixel that Whitted's tree has in one shutter sample.
#[derive(Clone, Debug)]
pub(super) struct SamplePlan {
    /// Samples of all pixels.
    pub(super) base: Vec<PixelSample>,
    /// Additional samples of pixels on edges.
    pub(super) extra: Vec<PixelSample>,
    /// Where pixels take the extra samples.
    pub(super) edges: EdgeThreshold,
    /// Index of the first sample among those of all shutter samples.
    pub(super) first_index: u32,
    /// Whether pixels stay sums of weighted samples, which those of other shutter samples are added to. Where weights are negative, a mean
    /// of few samples is not defined.
    pub(super) leaves_sums: bool,
}

impl SamplePlan {
    /// Divides the samples of a frame among its shutter samples; each has at least one.
    pub(super) fn new(settings: &RenderSettings, shutter_sample: ShutterSample) -> Self {
        let base = shutter_sample.share_of(settings.samples);
        let max = settings.adaptive.map_or(base, |adaptive| shutter_sample.share_of(adaptive.max_samples));
        let max = max.max(base);
        let [base_offsets, extra_offsets] = if shutter_sample.count > 1 {
            // Most pixels have the base positions alone: their mean is the centre, too.
            [
                progressive_offsets(0..base, base, shutter_sample),
                progressive_offsets(base..max, max, shutter_sample),
            ]
        } else {
            [(base, 0), (max - base, EXTRA_SET)].map(|(count, set)| pixel_offsets(count, set))
        };
        Self {
            base: settings.filter.samples(&base_offsets),
            extra: settings.filter.samples(&extra_offsets),
            edges: EdgeThreshold {
                difference: settings.adaptive.map_or(0.0, |adaptive| adaptive.threshold),
                exposure_scale: exposure_scale(settings.exposure_ev),
            },
            first_index: shutter_sample.index.wrapping_mul(max),
            leaves_sums: shutter_sample.count > 1 && settings.filter.has_negative_lobes(),
        }
    }

    /// Most samples of a pixel.
    pub(super) fn most_samples(&self) -> u32 {
        (self.base.len() + self.extra.len()) as u32
    }

    /// Whether pixels on edges take extra samples.
    pub(super) fn is_adaptive(&self) -> bool {
        !self.extra.is_empty()
    }
}
