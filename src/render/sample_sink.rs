//! Where traced samples are summed: in floats, in the order of a pixel's samples, or exactly, in any order.

use super::adaptive::SampleRange;
use super::filter::PixelSample;
use super::tile_aovs::TileAovs;
use super::tile_pixels::PixelSum;
use crate::film::{ExactSum, GuideSample, LightPasses, SampleSums, add_exact_share};
use crate::integrator::InstanceCoverage;
use crate::integrator::tracing::SampleValue;

/// Receiver of traced samples.
pub(super) trait SampleSink {
    /// Whether a sample counts. AOVs of others are not added.
    fn accepts(&self, value: &SampleValue) -> bool;

    /// Adds some samples of the pixel at `position`, number `index` of the list of pixels.
    fn add(&mut self, index: usize, position: (u32, u32), values: &[SampleValue], set: &[PixelSample]);

    /// Adds the light passes of one sample.
    fn add_light(&mut self, position: (u32, u32), weight: f32, light: &LightPasses);

    /// Adds the guides of one sample.
    fn add_guide(&mut self, position: (u32, u32), weight: f32, guide: &GuideSample);

    /// Adds an instance that a sample sees.
    fn add_coverage(&mut self, position: (u32, u32), weight: f32, seen: &InstanceCoverage);
}

/// Sums of Whitted's tree.
pub(super) struct FloatSink<'t> {
    pub(super) pixels: &'t mut [PixelSum],
    /// Ranges of the samples of each pixel.
    pub(super) ranges: Option<&'t mut [SampleRange]>,
    pub(super) aovs: &'t mut TileAovs,
}

impl SampleSink for FloatSink<'_> {
    fn accepts(&self, _: &SampleValue) -> bool {
        true
    }

    fn add(&mut self, index: usize, _: (u32, u32), values: &[SampleValue], set: &[PixelSample]) {
        self.pixels[index].add(values, set);
        if let Some(ranges) = &mut self.ranges {
            for value in values {
                ranges[index].add(value.to_array());
            }
        }
    }

    fn add_light(&mut self, position: (u32, u32), weight: f32, light: &LightPasses) {
        self.aovs.add_light(position, weight, light);
    }

    fn add_guide(&mut self, _: (u32, u32), _: f32, _: &GuideSample) {}

    fn add_coverage(&mut self, position: (u32, u32), weight: f32, seen: &InstanceCoverage) {
        self.aovs.add_coverage(position, weight, seen);
    }
}

/// Sums of paths.
pub(super) struct ExactSink<'t> {
    sums: &'t mut SampleSums,
    /// Samples that were infinite or not a number, and are left out.
    pub(super) non_finite_samples: u64,
}

impl<'t> ExactSink<'t> {
    pub(super) fn new(sums: &'t mut SampleSums) -> Self {
        Self { sums, non_finite_samples: 0 }
    }
}

impl SampleSink for ExactSink<'_> {
    fn accepts(&self, value: &SampleValue) -> bool {
        is_finite(value)
    }

    fn add(&mut self, _: usize, position: (u32, u32), values: &[SampleValue], set: &[PixelSample]) {
        let index = self.sums.index(position);
        let pixel = &mut self.sums.pixels[index];
        let mut moments = self.sums.moments.as_mut().map(|moments| &mut moments[index]);
        for (value, &PixelSample { weight, .. }) in values.iter().zip(set) {
            if !is_finite(value) {
                self.non_finite_samples += 1;
                continue;
            }
            for (channel, value) in value.to_array().into_iter().enumerate() {
                pixel.light[channel].add(value * weight);
                if let Some(moments) = &mut moments {
                    moments.sums[channel].add(value);
                    moments.squares[channel].add_square(value);
                }
            }
            pixel.weight += weight as i32;
            pixel.count += 1;
        }
    }

    fn add_light(&mut self, position: (u32, u32), weight: f32, light: &LightPasses) {
        let index = self.sums.index(position);
        let is_finite = light.as_flattened().iter().all(|channel| channel.is_finite());
        if let (Some(sums), true) = (&mut self.sums.light, is_finite) {
            let sums = sums[index].as_flattened_mut().iter_mut();
            sums.zip(light.as_flattened()).for_each(|(sum, channel)| sum.add(channel * weight));
        }
    }

    fn add_guide(&mut self, position: (u32, u32), weight: f32, guide: &GuideSample) {
        let index = self.sums.index(position);
        if let Some(sums) = &mut self.sums.guides {
            for (sums, guide) in sums[index].iter_mut().zip([guide.albedo, guide.normal]) {
                for (sum, value) in sums.iter_mut().zip(guide.to_array()) {
                    sum.add(value * weight);
                }
            }
        }
    }

    fn add_coverage(&mut self, position: (u32, u32), weight: f32, seen: &InstanceCoverage) {
        let index = self.sums.index(position);
        if let Some(coverage) = &mut self.sums.coverage {
            let mut share = ExactSum::default();
            share.add(seen.share * weight);
            add_exact_share(&mut coverage[index], seen.instance, share);
        }
    }
}

fn is_finite(value: &SampleValue) -> bool {
    value.to_array().iter().all(|channel| channel.is_finite())
}
