//! Means of the sums over samples, written into a film.

use glam::Vec3;

use super::aovs::{CoverageSample, FilmAovs, GuideSample, LightPasses, NoiseSample, add_share, clamp_shares};
use super::exact_sum::ExactSum;
use super::sample_sums::{GuideSums, LightSums, PixelMoments, PixelSums, SampleSums};
use super::{Film, clamp_lobes};

impl SampleSums {
    /// Writes the means into the pixels of `film`, and into those of its AOVs that are recorded here. Both have the same window.
    /// Negative lobes of a filter leave neither negative colours nor a coverage outside 0 to 1.
    pub fn resolve_into(&self, film: &mut Film) {
        debug_assert_eq!(self.window, film.window);
        for (pixel, sums) in film.pixels.iter_mut().zip(&self.pixels) {
            *pixel = sums.mean();
        }
        let FilmAovs { light, coverage, noise, guides, centers: _ } = &mut film.aovs;
        if let (Some(pixels), Some(sums)) = (light, &self.light) {
            for ((passes, sums), pixel) in pixels.iter_mut().zip(sums).zip(&self.pixels) {
                *passes = mean_passes(sums, pixel.weight);
            }
        }
        if let (Some(pixels), Some(sums)) = (guides, &self.guides) {
            for ((guides, sums), pixel) in pixels.iter_mut().zip(sums).zip(&self.pixels) {
                *guides = mean_guides(sums, pixel.weight);
            }
        }
        if let (Some(pixels), Some(sums)) = (coverage, &self.coverage) {
            for ((shares, sums), pixel) in pixels.iter_mut().zip(sums).zip(&self.pixels) {
                *shares = mean_shares(sums, pixel.weight);
            }
        }
        if let (Some(pixels), Some(moments)) = (noise, &self.moments) {
            for ((noise, moments), sums) in pixels.iter_mut().zip(moments).zip(&self.pixels) {
                *noise = sums.noise(moments);
            }
        }
    }
}

impl PixelSums {
    fn mean(&self) -> [f32; 4] {
        let scale = scale(self.weight);
        clamp_lobes(self.light.map(|sum| (sum.to_f64() * scale) as f32))
    }

    /// The noise of the mean, whose samples have the filter's weights.
    fn noise(&self, moments: &PixelMoments) -> NoiseSample {
        if self.count < 2 || self.weight <= 0 {
            return NoiseSample { variance: [0.0; 3], samples: self.count };
        }
        let [red, green, blue, _] = moments.means_and_errors(self.count);
        // Negative weights make a mean noisier than one of as many equal weights.
        let ratio = f64::from(self.count) / f64::from(self.weight);
        let variance = |(_, error): (f64, f64)| (error * error * ratio * ratio) as f32;
        NoiseSample { variance: [red, green, blue].map(variance), samples: self.count }
    }
}

/// Factor that makes a mean of a sum of samples; 0 without samples.
fn scale(weight: i32) -> f64 {
    if weight > 0 { 1.0 / f64::from(weight) } else { 0.0 }
}

/// Light may be negative, so that the passes keep their sum.
fn mean_passes(sums: &LightSums, weight: i32) -> LightPasses {
    let scale = scale(weight);
    sums.map(|pass| pass.map(|sum| (sum.to_f64() * scale) as f32))
}

/// Negative lobes of a filter leave albedos from 0 to 1.
fn mean_guides(sums: &GuideSums, weight: i32) -> GuideSample {
    let scale = scale(weight);
    let [albedo, normal] = sums.map(|guide| Vec3::from_array(guide.map(|sum| (sum.to_f64() * scale) as f32)));
    GuideSample { albedo: albedo.clamp(Vec3::ZERO, Vec3::ONE), normal }
}

fn mean_shares(sums: &[(u32, ExactSum)], weight: i32) -> CoverageSample {
    let scale = scale(weight);
    let mut shares = CoverageSample::new();
    for &(instance, sum) in sums {
        add_share(&mut shares, instance, (sum.to_f64() * scale) as f32);
    }
    clamp_shares(&mut shares);
    shares
}
