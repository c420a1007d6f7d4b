//! Sums over the samples of each pixel, exact, so that samples may be rendered apart and in any order.

use super::aovs::LightPass;
use super::exact_sum::ExactSum;
use crate::image::PixelWindow;

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
}

impl PixelSums {
    fn merge(&mut self, other: &Self) {
        merge_all(&mut self.light, &other.light);
        // Parts may come from damaged files.
        self.weight = self.weight.saturating_add(other.weight);
        self.count = self.count.saturating_add(other.count);
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

#[cfg(test)]
mod tests;
