//! Sums over the samples of each pixel, exact, so that samples may be rendered apart and in any order.

use glam::Vec3;

use super::aovs::{CoverageSample, FilmAovs, GuideSample, LightPasses, NoiseSample, add_share};
use super::exact_sum::ExactSum;
use super::{Film, LightPass, PixelWindow};

/// Sums of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelSums {
    /// Red, green, blue and coverage, times filter weights.
    pub light: [ExactSum; 4],
    /// Sum of the filter weights, which are 1 or −1.
    pub weight: i32,
    /// Number of samples.
    pub count: u32,
}

/// Sums of one pixel without filter weights, from which its noise is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelMoments {
    /// Red, green, blue and coverage.
    pub sums: [ExactSum; 4],
    /// Their squares.
    pub squares: [ExactSum; 4],
}

/// Light passes times filter weights.
pub type LightSums = [[ExactSum; 3]; LightPass::ALL.len()];

/// Albedo and normal, times filter weights.
pub type GuideSums = [[ExactSum; 3]; 2];

/// Which sums are recorded besides those of colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a list of its own")]
pub struct SumFlags {
    /// [`SampleSums::moments`].
    pub moments: bool,
    /// [`SampleSums::light`].
    pub light: bool,
    /// [`SampleSums::coverage`].
    pub coverage: bool,
    /// [`SampleSums::guides`].
    pub guides: bool,
}

/// Sums of the pixels of a window, row-major.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampleSums {
    /// The pixels.
    pub window: PixelWindow,
    /// Colours.
    pub pixels: Vec<PixelSums>,
    /// Moments, for the noise.
    pub moments: Option<Vec<PixelMoments>>,
    /// Light passes.
    pub light: Option<Vec<LightSums>>,
    /// Shares of mesh instances: increasing indices with the sums of their shares times filter weights.
    pub coverage: Option<Vec<Vec<(u32, ExactSum)>>>,
    /// Guides of denoising.
    pub guides: Option<Vec<GuideSums>>,
}

impl PixelMoments {
    /// Mean and its standard error by channel, from `count` samples. One sample has no error.
    pub fn means_and_errors(&self, count: u32) -> [(f64, f64); 4] {
        let count = f64::from(count);
        std::array::from_fn(|channel| {
            let mean = self.sums[channel].to_f64() / count;
            let variance = (self.squares[channel].squares_to_f64() / count - mean * mean) / (count - 1.0);
            (mean, if variance > 0.0 { variance.sqrt() } else { 0.0 })
        })
    }
}

impl SampleSums {
    /// Sums of no samples.
    pub fn new(window: PixelWindow, flags: SumFlags) -> Self {
        let count = window.pixel_count();
        Self {
            window,
            pixels: vec![PixelSums::default(); count],
            moments: flags.moments.then(|| vec![PixelMoments::default(); count]),
            light: flags.light.then(|| vec![LightSums::default(); count]),
            coverage: flags.coverage.then(|| vec![Vec::new(); count]),
            guides: flags.guides.then(|| vec![GuideSums::default(); count]),
        }
    }

    /// Which sums are recorded.
    pub fn flags(&self) -> SumFlags {
        SumFlags {
            moments: self.moments.is_some(),
            light: self.light.is_some(),
            coverage: self.coverage.is_some(),
            guides: self.guides.is_some(),
        }
    }

    /// Index of a pixel of the window.
    pub fn index(&self, (x, y): (u32, u32)) -> usize {
        (y - self.window.y0) as usize * self.window.width() as usize + (x - self.window.x0) as usize
    }

    /// Adds the sums of a window inside this one. What either does not record is left out.
    pub fn merge(&mut self, part: &Self) {
        let width = (part.window.width() as usize).max(1);
        for row in 0..part.window.height() {
            let start = self.index((part.window.x0, part.window.y0 + row));
            let from = row as usize * width;
            let (to, from) = (start..start + width, from..from + width);
            for (sum, other) in self.pixels[to.clone()].iter_mut().zip(&part.pixels[from.clone()]) {
                sum.merge(other);
            }
            if let (Some(sums), Some(others)) = (&mut self.moments, &part.moments) {
                for (sum, other) in sums[to.clone()].iter_mut().zip(&others[from.clone()]) {
                    merge_all(&mut sum.sums, &other.sums);
                    merge_all(&mut sum.squares, &other.squares);
                }
            }
            if let (Some(sums), Some(others)) = (&mut self.light, &part.light) {
                merge_all(
                    sums[to.clone()].as_flattened_mut().as_flattened_mut(),
                    others[from.clone()].as_flattened().as_flattened(),
                );
            }
            if let (Some(sums), Some(others)) = (&mut self.guides, &part.guides) {
                merge_all(
                    sums[to.clone()].as_flattened_mut().as_flattened_mut(),
                    others[from.clone()].as_flattened().as_flattened(),
                );
            }
            if let (Some(sums), Some(others)) = (&mut self.coverage, &part.coverage) {
                for (sum, other) in sums[to.clone()].iter_mut().zip(&others[from.clone()]) {
                    for &(instance, share) in other {
                        add_exact_share(sum, instance, share);
                    }
                }
            }
        }
    }

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
    fn merge(&mut self, other: &Self) {
        merge_all(&mut self.light, &other.light);
        // Parts may come from damaged files.
        self.weight = self.weight.saturating_add(other.weight);
        self.count = self.count.saturating_add(other.count);
    }

    fn mean(&self) -> [f32; 4] {
        let scale = scale(self.weight);
        let [red, green, blue, coverage] = self.light.map(|sum| (sum.to_f64() * scale) as f32);
        let positive = |x: f32| if x > 0.0 { x } else { 0.0 };
        let coverage = positive(coverage);
        [positive(red), positive(green), positive(blue), if coverage > 1.0 { 1.0 } else { coverage }]
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

fn merge_all(sums: &mut [ExactSum], others: &[ExactSum]) {
    sums.iter_mut().zip(others).for_each(|(sum, &other)| sum.merge(other));
}

/// Adds to the share of one instance.
pub fn add_exact_share(shares: &mut Vec<(u32, ExactSum)>, instance: u32, share: ExactSum) {
    match shares.binary_search_by_key(&instance, |&(instance, _)| instance) {
        Ok(index) => shares[index].1.merge(share),
        Err(index) => shares.insert(index, (instance, share)),
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
        let share = ((sum.to_f64() * scale) as f32).clamp(0.0, 1.0);
        if share > 0.0 {
            add_share(&mut shares, instance, share);
        }
    }
    shares
}

#[cfg(test)]
mod tests;
