//! What is recorded of a tile besides colour while its samples come in: light by parts, and coverage.
//!
//! Samples count as they do for the colour, so that the parts of a pixel's light sum to it.

use crate::film::{AovFlags, FilmAovs, PixelWindow, add_share};
use crate::integrator::LightPasses;
use crate::integrator::whitted::InstanceCoverage;

/// Sums of one tile. Pixels around it are sampled, too, but not recorded.
#[derive(Clone, Debug)]
pub(super) struct TileAovs {
    tile: PixelWindow,
    sums: FilmAovs,
}

impl Default for TileAovs {
    /// Of no pixels.
    fn default() -> Self {
        Self { tile: PixelWindow::full(0, 0), sums: FilmAovs::default() }
    }
}

impl TileAovs {
    pub(super) fn new(tile: PixelWindow, request: AovFlags) -> Self {
        let count = tile.width() as usize * tile.height() as usize;
        Self { tile, sums: FilmAovs::new(count, request) }
    }

    /// Subscript of a pixel of the tile.
    fn subscript(&self, (x, y): (u32, u32)) -> Option<usize> {
        let PixelWindow { x0, y0, x1, y1 } = self.tile;
        let is_inside = (x0..x1).contains(&x) && (y0..y1).contains(&y);
        is_inside.then(|| (y - y0) as usize * self.tile.width() as usize + (x - x0) as usize)
    }

    /// Adds the light of a sample of the pixel `at` with its weight.
    pub(super) fn add_light(&mut self, (at, weight): ((u32, u32), f32), sample: &LightPasses) {
        let subscript = self.subscript(at);
        if let (Some(light), Some(subscript)) = (&mut self.sums.light, subscript) {
            let sums = light[subscript].as_flattened_mut();
            sums.iter_mut().zip(sample.as_flattened()).for_each(|(sum, channel)| *sum += channel * weight);
        }
    }

    /// Adds what a sample of the pixel `at` sees, with its weight.
    pub(super) fn add_cover(&mut self, (at, weight): ((u32, u32), f32), cover: &InstanceCoverage) {
        let subscript = self.subscript(at);
        if let (Some(coverage), Some(subscript)) = (&mut self.sums.coverage, subscript) {
            add_share(&mut coverage[subscript], cover.instance, cover.share * weight);
        }
    }

    /// Divides the sums of a pixel of the tile by the weight of its samples. A filter's negative lobes must leave no coverage
    /// below zero or beyond one; light may be negative, so that its parts keep their sum.
    pub(super) fn normalize(&mut self, at: (u32, u32), weight: f32) {
        let Some(subscript) = self.subscript(at) else { return };
        let scale = if weight > 0.0 { 1.0 / weight } else { 0.0 };
        if let Some(light) = &mut self.sums.light {
            light[subscript].as_flattened_mut().iter_mut().for_each(|channel| *channel *= scale);
        }
        if let Some(coverage) = &mut self.sums.coverage {
            coverage[subscript].retain_mut(|(_, share)| {
                *share = (*share * scale).clamp(0.0, 1.0);
                *share > 0.0
            });
        }
    }

    /// The layers, row by row.
    pub(super) fn finish(self) -> FilmAovs {
        self.sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COVERAGE: AovFlags = AovFlags { coverage: true, ..AovFlags::NONE };

    #[test]
    fn shares_are_weighted_and_clamped_by_pixel() {
        let mut layers = TileAovs::new(PixelWindow { x0: 4, y0: 2, x1: 6, y1: 3 }, COVERAGE);
        let cover = |instance, share| InstanceCoverage { sample: 0, instance, share };
        // Pixel (5, 2), three samples of weight 1, 1 and −1, one in sum: instance 3 has 1 + 1 = 2, instance 8 has −1/2.
        layers.add_cover(((5, 2), 1.0), &cover(3, 1.0));
        layers.add_cover(((5, 2), 1.0), &cover(3, 1.0));
        layers.add_cover(((5, 2), -1.0), &cover(8, 0.5));
        // Beside the tile.
        layers.add_cover(((6, 2), 1.0), &cover(3, 1.0));
        layers.normalize((4, 2), 1.0);
        layers.normalize((5, 2), 1.0);
        assert_eq!(layers.finish().coverage, Some(vec![vec![], vec![(3, 1.0)]]));
    }
}
