//! The film: pixels and AOVs of a frame while it is rendered.
//!
//! Tiles are rendered in any order and written into the film, so that its content does not depend on threads. Files are not
//! known here; [`crate::output`] makes them from a film.

mod aovs;
mod exact_sum;
mod resolve_sums;
mod sample_sums;

use std::borrow::Cow;
use std::sync::Arc;

use crate::image::{Plate, over};

pub use crate::image::PixelWindow;
pub use aovs::{
    AovFlags, CoverageSample, FilmAovs, GuideSample, LightPass, LightPasses, NoiseSample, PixelCenterSample,
    add_share,
};
pub use exact_sum::ExactSum;
pub use sample_sums::{GuideSums, LightSums, PixelMoments, PixelSums, SampleSums, SumFlags, add_exact_share};

/// Linear Rec.709 radiance with premultiplied coverage, and AOVs of the same pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Columns and rows of the whole image (OpenEXR's display window).
    pub resolution: (u32, u32),
    /// The pixels held here (OpenEXR's data window).
    pub window: PixelWindow,
    /// Row-major R, G, B, A of the window, top row first.
    pub pixels: Vec<[f32; 4]>,
    /// Filter weights of the pixels, where these, their light passes and coverage are sums of weighted samples until
    /// [`Film::resolve_mean`].
    pub weights: Option<Vec<f32>>,
    /// Further values of each pixel.
    pub aovs: FilmAovs,
    /// The plate behind the pixels, which do not contain it.
    pub plate: Option<Arc<Plate>>,
    /// The colours before they were denoised.
    pub noisy: Option<Vec<[f32; 3]>>,
    /// The sums of some of the samples, where others are rendered apart.
    pub sums: Option<Box<SampleSums>>,
}

impl Film {
    /// A film of transparent black without AOVs.
    pub fn new(resolution: (u32, u32), window: PixelWindow) -> Self {
        Self::with_aovs(resolution, window, AovFlags::NONE)
    }

    /// A film of transparent black with AOVs.
    pub fn with_aovs(resolution: (u32, u32), window: PixelWindow, flags: AovFlags) -> Self {
        let count = window.pixel_count();
        Self {
            resolution,
            window,
            pixels: vec![[0.0; 4]; count],
            weights: None,
            aovs: FilmAovs::new(count, flags),
            plate: None,
            noisy: None,
            sums: None,
        }
    }

    /// The pixels with the plate behind them.
    pub fn pixels_over_plate(&self) -> Cow<'_, [[f32; 4]]> {
        match &self.plate {
            Some(plate) => Cow::Owned(plate.under(&self.pixels)),
            None => Cow::Borrowed(&self.pixels),
        }
    }

    /// The colours before they were denoised, with the plate behind them as in [`Film::pixels_over_plate`].
    pub fn noisy_over_plate(&self) -> Option<Vec<[f32; 3]>> {
        let noisy = self.noisy.as_ref()?;
        let Some(plate) = &self.plate else { return Some(noisy.clone()) };
        let pixels = noisy.iter().zip(&self.pixels).zip(&plate.pixels);
        let over_plate = pixels.map(|((&[r, g, b], pixel), plate)| {
            let [r, g, b, _] = over([r, g, b, pixel[3]], *plate);
            [r, g, b]
        });
        Some(over_plate.collect())
    }

    /// Writes the pixels of a tile, which lies inside the window.
    pub fn write_tile(&mut self, tile: PixelWindow, pixels: &[[f32; 4]]) {
        copy_rows(self.window, &mut self.pixels, tile, pixels);
    }

    /// Writes the filter weights of a tile, where the film records them.
    pub fn write_weight_tile(&mut self, tile: PixelWindow, weights: &[f32]) {
        if let Some(all) = &mut self.weights {
            copy_rows(self.window, all, tile, weights);
        }
    }

    /// Writes the AOVs of a tile that both the film and `aovs` have.
    pub fn write_aov_tile(&mut self, tile: PixelWindow, aovs: &FilmAovs) {
        let window = self.window;
        if let (Some(all), Some(light)) = (&mut self.aovs.light, &aovs.light) {
            copy_rows(window, all, tile, light);
        }
        if let (Some(all), Some(centers)) = (&mut self.aovs.centers, &aovs.centers) {
            copy_rows(window, all, tile, centers);
        }
        if let (Some(all), Some(coverage)) = (&mut self.aovs.coverage, &aovs.coverage) {
            copy_rows(window, all, tile, coverage);
        }
    }

    /// Adds the pixels, their weights, light passes and coverage of a film of the same window.
    pub fn add(&mut self, other: &Self) {
        debug_assert_eq!(self.window, other.window);
        for (sum, pixel) in self.pixels.iter_mut().zip(&other.pixels) {
            for (sum, channel) in sum.iter_mut().zip(pixel) {
                *sum += channel;
            }
        }
        if let (Some(weights), Some(others)) = (&mut self.weights, &other.weights) {
            weights.iter_mut().zip(others).for_each(|(sum, weight)| *sum += weight);
        }
        self.aovs.add(&other.aovs);
    }

    /// Turns the sums of `count` films into their mean: of all weighted samples, where weights are recorded. Negative lobes of a filter
    /// leave neither negative colours nor a coverage outside 0 to 1.
    pub fn resolve_mean(&mut self, count: u32) {
        let Some(weights) = self.weights.take() else {
            let factor = 1.0 / count as f32;
            self.aovs.scale(factor);
            self.pixels.iter_mut().flatten().for_each(|channel| *channel *= factor);
            return;
        };
        for (index, (pixel, &weight)) in self.pixels.iter_mut().zip(&weights).enumerate() {
            let mean = |sum: f32| if weight > 0.0 { sum / weight } else { 0.0 };
            *pixel = clamp_lobes(pixel.map(mean));
            self.aovs.map_pixel(index, mean);
        }
    }

    /// Sets pixels with infinite or NaN channels and their light passes to transparent black. Returns their number.
    pub fn blacken_non_finite(&mut self) -> u64 {
        let mut count = 0;
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            if !pixel.iter().all(|channel| channel.is_finite()) {
                *pixel = [0.0; 4];
                if let Some(light) = &mut self.aovs.light {
                    light[index] = LightPasses::default();
                }
                count += 1;
            }
        }
        count
    }
}

/// A mean of weighted samples without the negative light, and the coverage outside 0 to 1, that negative lobes of a filter leave. NaN stays.
pub fn clamp_lobes([red, green, blue, coverage]: [f32; 4]) -> [f32; 4] {
    // Negative zero is zero.
    let positive = |x: f32| if x <= 0.0 { 0.0 } else { x };
    [positive(red), positive(green), positive(blue), if coverage > 1.0 { 1.0 } else { positive(coverage) }]
}

/// Copies the row-major values of a tile into those of a window.
fn copy_rows<T: Clone>(window: PixelWindow, all: &mut [T], tile: PixelWindow, values: &[T]) {
    let stride = window.width() as usize;
    let rows = values.chunks_exact(tile.width() as usize);
    for (y, row) in (tile.y0..tile.y1).zip(rows) {
        let start = (y - window.y0) as usize * stride + (tile.x0 - window.x0) as usize;
        all[start..start + row.len()].clone_from_slice(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_written_at_their_position_in_the_window() {
        let window = PixelWindow { x0: 2, y0: 1, x1: 5, y1: 3 };
        let mut film = Film::new((8, 8), window);
        film.write_tile(PixelWindow { x0: 4, y0: 1, x1: 5, y1: 3 }, &[[1.0; 4], [2.0; 4]]);
        let reds: Vec<f32> = film.pixels.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(reds, [0.0, 0.0, 1.0, 0.0, 0.0, 2.0]);
    }

    #[test]
    fn light_below_zero_and_coverage_beyond_one_are_clamped() {
        assert_eq!(clamp_lobes([-0.5, 0.25, 7.0, 1.5]), [0.0, 0.25, 7.0, 1.0]);
        assert_eq!(
            clamp_lobes([-0.0, f32::INFINITY, f32::NEG_INFINITY, -0.25]),
            [0.0, f32::INFINITY, 0.0, 0.0]
        );
        let [zero, nan, ..] = clamp_lobes([-0.0, f32::NAN, 1.0, 1.0]);
        assert!(zero.is_sign_positive() && nan.is_nan());
    }

    #[test]
    fn non_finite_pixels_become_black_and_are_counted() {
        let flags = AovFlags { light: true, ..AovFlags::NONE };
        let mut film = Film::with_aovs((3, 1), PixelWindow::full(3, 1), flags);
        film.aovs.light = Some(vec![[[f32::NAN; 3]; 6], [[0.5; 3]; 6], [[1.0; 3]; 6]]);
        film.pixels = vec![[f32::NAN, 1.0, 1.0, 1.0], [1.0; 4], [1.0, f32::INFINITY, 1.0, 1.0]];
        assert_eq!(film.blacken_non_finite(), 2);
        assert_eq!(film.pixels, [[0.0; 4], [1.0; 4], [0.0; 4]]);
        assert_eq!(film.aovs.light, Some(vec![[[0.0; 3]; 6], [[0.5; 3]; 6], [[0.0; 3]; 6]]));
    }
}
