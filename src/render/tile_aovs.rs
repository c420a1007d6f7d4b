//! AOVs of a tile while its samples are summed: light passes and coverage.
//!
//! Samples have the same weights as for the colour, so that the light passes of a pixel sum to it.

use crate::film::{AovFlags, FilmAovs, PixelWindow, add_share};
use crate::integrator::{InstanceCoverage, LightPasses};

/// AOV sums of one tile. Samples of pixels outside the tile are ignored.
#[derive(Clone, Debug)]
pub(super) struct TileAovs {
    tile: PixelWindow,
    sums: FilmAovs,
}

impl Default for TileAovs {
    /// An empty tile.
    fn default() -> Self {
        Self { tile: PixelWindow::full(0, 0), sums: FilmAovs::default() }
    }
}

impl TileAovs {
    pub(super) fn new(tile: PixelWindow, flags: AovFlags) -> Self {
        let count = tile.width() as usize * tile.height() as usize;
        Self { tile, sums: FilmAovs::new(count, flags) }
    }

    /// Index of a pixel in the tile; `None` outside.
    fn index(&self, (x, y): (u32, u32)) -> Option<usize> {
        let PixelWindow { x0, y0, x1, y1 } = self.tile;
        let is_inside = (x0..x1).contains(&x) && (y0..y1).contains(&y);
        is_inside.then(|| (y - y0) as usize * self.tile.width() as usize + (x - x0) as usize)
    }

    /// Adds the light passes of a sample to the pixel at `position`.
    pub(super) fn add_light(&mut self, position: (u32, u32), weight: f32, sample: &LightPasses) {
        let index = self.index(position);
        if let (Some(light), Some(index)) = (&mut self.sums.light, index) {
            let sums = light[index].as_flattened_mut();
            sums.iter_mut().zip(sample.as_flattened()).for_each(|(sum, channel)| *sum += channel * weight);
        }
    }

    /// Adds an instance that a sample sees to the pixel at `position`.
    pub(super) fn add_coverage(&mut self, position: (u32, u32), weight: f32, seen: &InstanceCoverage) {
        let index = self.index(position);
        if let (Some(coverage), Some(index)) = (&mut self.sums.coverage, index) {
            add_share(&mut coverage[index], seen.instance, seen.share * weight);
        }
    }

    /// Divides the sums of a pixel by the weight of its samples.
    pub(super) fn normalize(&mut self, position: (u32, u32), weight: f32) {
        let Some(index) = self.index(position) else { return };
        let scale = if weight > 0.0 { 1.0 / weight } else { 0.0 };
        self.sums.map_pixel(index, |sum| sum * scale);
    }

    /// Multiplies the sums of a pixel.
    pub(super) fn scale(&mut self, position: (u32, u32), factor: f32) {
        let Some(index) = self.index(position) else { return };
        self.sums.scale_pixel(index, factor);
    }

    /// The AOVs, row by row.
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
        let mut aovs = TileAovs::new(PixelWindow { x0: 4, y0: 2, x1: 6, y1: 3 }, COVERAGE);
        let seen = |instance, share| InstanceCoverage { sample: 0, instance, share };
        // Pixel (5, 2), three samples of weight 1, 1 and −1, sum 1: instance 3 has 1 + 1 = 2, instance 8 has −1/2.
        aovs.add_coverage((5, 2), 1.0, &seen(3, 1.0));
        aovs.add_coverage((5, 2), 1.0, &seen(3, 1.0));
        aovs.add_coverage((5, 2), -1.0, &seen(8, 0.5));
        // Outside the tile
        aovs.add_coverage((6, 2), 1.0, &seen(3, 1.0));
        aovs.normalize((4, 2), 1.0);
        aovs.normalize((5, 2), 1.0);
        assert_eq!(aovs.finish().coverage, Some(vec![vec![], vec![(3, 1.0)]]));
    }
}
