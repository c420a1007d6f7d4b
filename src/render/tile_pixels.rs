//! Pixels of a tile while their samples are summed, and the search for edges among them.

use super::adaptive::{EdgeThreshold, SampleRange};
use super::filter::PixelSample;
use crate::film::{PixelWindow, clamp_lobes};
use crate::integrator::tracing::SampleValue;

/// The sums of one pixel.
#[derive(Clone, Copy)]
pub(super) struct PixelSum {
    /// Column and row in the image.
    pub(super) position: (u32, u32),
    sum: [f32; 4],
    pub(super) weight: f32,
    /// Number of samples.
    count: u32,
}

impl PixelSum {
    pub(super) fn new(position: (u32, u32)) -> Self {
        Self { position, sum: [0.0; 4], weight: 0.0, count: 0 }
    }

    /// Adds the values of some samples of the pixel, in their order.
    #[inline]
    pub(super) fn add(&mut self, values: &[SampleValue], samples: &[PixelSample]) {
        let (mut sum, mut total) = (self.sum, self.weight);
        for (value, &PixelSample { weight, .. }) in values.iter().zip(samples) {
            for (sum, channel) in sum.iter_mut().zip(value.to_array()) {
                *sum += channel * weight;
            }
            total += weight;
        }
        (self.sum, self.weight) = (sum, total);
        self.count += samples.len() as u32;
    }

    /// The filtered value. Negative lobes of a filter leave neither negative light nor a coverage above one.
    pub(super) fn mean(&self) -> [f32; 4] {
        if self.weight <= 0.0 {
            return [0.0; 4];
        }
        self.ratio()
    }

    /// The same for the search for edges, also where most of a few weights are negative; `None` where they cancel out.
    fn compared_mean(&self) -> Option<[f32; 4]> {
        (self.weight != 0.0).then(|| self.ratio())
    }

    fn ratio(&self) -> [f32; 4] {
        let scale = 1.0 / self.weight;
        clamp_lobes(self.sum.map(|channel| channel * scale))
    }

    /// Factor by which the sums of this pixel count as much as those of one with `most_samples`.
    pub(super) fn share(&self, most_samples: u32) -> f32 {
        most_samples as f32 / self.count as f32
    }

    /// The sum of the weighted values.
    pub(super) fn sum(&self) -> [f32; 4] {
        self.sum
    }
}

/// Grid of indices into a list of pixels: a tile and the border of one pixel around it.
pub(super) struct PixelGrid {
    /// Column and row of the grid's first cell.
    corner: (i64, i64),
    stride: usize,
    indices: Vec<Option<usize>>,
}

impl PixelGrid {
    /// The grid of the tile and the border that `pixels` holds in any order.
    pub(super) fn new(tile: PixelWindow, pixels: &[PixelSum]) -> Self {
        let stride = tile.width() as usize + 2;
        let corner = (i64::from(tile.x0) - 1, i64::from(tile.y0) - 1);
        let mut grid = Self { corner, stride, indices: vec![None; stride * (tile.height() as usize + 2)] };
        for (index, pixel) in pixels.iter().enumerate() {
            let cell = grid.cell(pixel.position);
            grid.indices[cell] = Some(index);
        }
        grid
    }

    fn cell(&self, (x, y): (u32, u32)) -> usize {
        (i64::from(y) - self.corner.1) as usize * self.stride + (i64::from(x) - self.corner.0) as usize
    }

    /// Whether the samples of a pixel, whose values have the given range, differ from each other, or from the mean of one of its eight
    /// neighbours.
    pub(super) fn is_edge(
        &self,
        pixels: &[PixelSum],
        index: usize,
        mut range: SampleRange,
        threshold: EdgeThreshold,
    ) -> bool {
        let cell = self.cell(pixels[index].position);
        for row in [cell - self.stride, cell, cell + self.stride] {
            for neighbour in self.indices[row - 1..=row + 1].iter().flatten() {
                if let Some(mean) = pixels[*neighbour].compared_mean() {
                    range.add(mean);
                }
            }
        }
        range.exceeds(threshold)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn uniform_pixels_are_no_edges_whatever_the_weights_of_their_samples() {
        let value = SampleValue { radiance: Vec3::splat(0.75), coverage: 1.0 };
        for weights in [&[1.0][..], &[-1.0], &[1.0, -1.0], &[1.0, 1.0, -1.0]] {
            let sample = |&weight: &f32| PixelSample { offset: Vec2::ZERO, weight };
            let samples: Vec<_> = weights.iter().map(sample).collect();
            let tile = PixelWindow::full(3, 2);
            let mut pixels: Vec<_> = (0..6).map(|index| PixelSum::new((index % 3, index / 3))).collect();
            let mut range = SampleRange::EMPTY;
            range.add(value.to_array());
            for pixel in &mut pixels {
                pixel.add(&vec![value; samples.len()], &samples);
            }
            let grid = PixelGrid::new(tile, &pixels);
            let threshold = EdgeThreshold { difference: 0.0, exposure_scale: 1.0 };
            assert!((0..6).all(|index| !grid.is_edge(&pixels, index, range, threshold)), "{weights:?}");
        }
    }
}
