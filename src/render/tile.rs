//! The tile renderer: traces the samples of a tile in coherent batches and takes their mean in every pixel.

use glam::Vec2;

use super::adaptive::SampleRange;
use super::filter::PixelSample;
use super::pixel_noise::{FIRST_PASS, PixelNoise};
use super::sample_plan::SamplePlan;
use super::screen_bounds::ScreenBounds;
use super::tile_aovs::TileAovs;
use super::tile_grid::pixels_in_morton_order;
use super::tile_pixels::{PixelGrid, PixelSum};
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, FilmAovs, PixelWindow};
use crate::integrator::whitted::{SampleAovFlags, SampleValue, Tracer};
use crate::integrator::{CameraRays, CameraSamples, IntegratorContext, IntegratorStatistics};

/// Samples in a batch: enough for full packets of every kind of ray, few enough for the cache.
const BATCH_SAMPLES: usize = 1024;

/// Pixels and AOVs of one tile, row by row, and the counters of its integrator.
pub(super) struct RenderedTile<'r> {
    pub(super) pixels: &'r [[f32; 4]],
    pub(super) aovs: FilmAovs,
    pub(super) statistics: IntegratorStatistics,
}

/// What tiles of an image have in common.
#[derive(Clone, Copy)]
pub(super) struct TileSettings<'w> {
    pub(super) camera: &'w CameraRays,
    pub(super) plan: &'w SamplePlan,
    /// Size of the whole image.
    pub(super) resolution: (u32, u32),
    /// Where surfaces may be seen.
    pub(super) screen: &'w ScreenBounds,
    /// The AOVs that are recorded, besides those of pixel centres.
    pub(super) aovs: AovFlags,
}

/// Renders tiles one after the other and keeps its buffers between them.
pub(super) struct TileRenderer<'w, 'a> {
    settings: TileSettings<'w>,
    tracer: Tracer<'w, 'a>,
    /// AOVs of the current tile.
    aovs: TileAovs,
    /// Columns and rows of the pixels of a batch.
    positions: Vec<(u32, u32)>,
    /// The pixels of the current tile, in the order of their samples.
    pixels: Vec<PixelSum>,
    /// The same, row by row.
    rows: Vec<[f32; 4]>,
}

impl<'w, 'a> TileRenderer<'w, 'a> {
    /// A renderer that has rendered nothing.
    pub(super) fn new(context: &'w IntegratorContext<'a>, settings: TileSettings<'w>) -> Self {
        let AovFlags { light, coverage, .. } = settings.aovs;
        Self {
            settings: TileSettings { aovs: AovFlags { light, coverage, centers: false }, ..settings },
            tracer: Tracer::new(context).recording(SampleAovFlags { light, coverage }),
            aovs: TileAovs::default(),
            positions: Vec::new(),
            pixels: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// Renders `tile`. Each pixel is the weighted mean of its samples, summed in their order.
    pub(super) fn render(
        &mut self,
        tile: PixelWindow,
        cancel: &CancelFlag,
    ) -> Result<RenderedTile<'_>, Cancelled> {
        let TileSettings { plan, aovs: flags, .. } = self.settings;
        self.aovs = TileAovs::new(tile, flags);
        let mut pixels = std::mem::take(&mut self.pixels);
        pixels.clear();
        pixels.extend(pixels_in_morton_order(tile).map(PixelSum::new));
        let inside = pixels.len();
        if let Some(noise) = plan.noise {
            self.add_samples_until_quiet(&mut pixels, noise, cancel)?;
        } else if plan.is_adaptive() {
            self.add_adaptive_samples(tile, &mut pixels, cancel)?;
        } else {
            self.add_samples(&mut pixels, &plan.base, 0, cancel, |_, _| ())?;
        }

        // Means, row by row
        self.rows.resize(inside, [0.0; 4]);
        for pixel in &pixels[..inside] {
            let (x, y) = pixel.position;
            self.rows[((y - tile.y0) * tile.width() + x - tile.x0) as usize] = pixel.mean();
        }
        if flags != AovFlags::NONE {
            pixels[..inside].iter().for_each(|pixel| self.aovs.normalize(pixel.position, pixel.weight));
        }
        self.pixels = pixels;
        let aovs = std::mem::take(&mut self.aovs).finish();
        Ok(RenderedTile { pixels: &self.rows, aovs, statistics: self.tracer.take_statistics() })
    }

    /// Adds base samples to the pixels of a tile, pass by pass, and leaves out those whose noise is low enough. The decision depends on a pixel's
    /// own samples alone, so crops decide alike.
    fn add_samples_until_quiet(
        &mut self,
        pixels: &mut [PixelSum],
        noise: f32,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let base = &self.settings.plan.base;
        let mut noisy: Vec<usize> = (0..pixels.len()).collect();
        let mut noises = vec![PixelNoise::default(); pixels.len()];
        let mut taken = 0;
        while taken < base.len() && !noisy.is_empty() {
            let end = base.len().min(FIRST_PASS.max(2 * taken));
            let mut sums: Vec<PixelSum> = noisy.iter().map(|&index| pixels[index]).collect();
            self.add_samples(&mut sums, &base[taken..end], taken as u32, cancel, |pixel, values| {
                noises[noisy[pixel]].add(values);
            })?;
            for (&index, sum) in noisy.iter().zip(sums) {
                pixels[index] = sum;
            }
            noisy.retain(|&index| noises[index].display_error() > noise);
            taken = end;
        }
        Ok(())
    }

    /// Adds the base samples to the pixels of a tile, and extra samples to those on edges.
    fn add_adaptive_samples(
        &mut self,
        tile: PixelWindow,
        pixels: &mut Vec<PixelSum>,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let plan = self.settings.plan;
        let inside = pixels.len();
        pixels.extend(self.border(tile).map(PixelSum::new));
        let mut ranges = vec![SampleRange::EMPTY; pixels.len()];
        self.add_samples(pixels, &plan.base, 0, cancel, |pixel, values| {
            for value in values {
                ranges[pixel].add(value.to_array());
            }
        })?;

        let grid = PixelGrid::new(tile, pixels);
        let (mut edges, indices): (Vec<PixelSum>, Vec<usize>) = (0..inside)
            .filter(|&index| grid.is_edge(pixels, index, ranges[index], plan.threshold))
            .map(|index| (pixels[index], index))
            .unzip();
        self.add_samples(&mut edges, &plan.extra, plan.base.len() as u32, cancel, |_, _| ())?;
        for (pixel, index) in edges.into_iter().zip(indices) {
            pixels[index] = pixel;
        }
        Ok(())
    }

    /// The pixels of the image next to a tile.
    fn border(&self, tile: PixelWindow) -> impl Iterator<Item = (u32, u32)> + use<> {
        let columns = tile.x0.saturating_sub(1)..self.settings.resolution.0.min(tile.x1 + 1);
        let rows = tile.y0.saturating_sub(1)..self.settings.resolution.1.min(tile.y1 + 1);
        let is_inside = move |x, y| (tile.x0..tile.x1).contains(&x) && (tile.y0..tile.y1).contains(&y);
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y))).filter(move |&(x, y)| !is_inside(x, y))
    }

    /// Adds a set of samples to every pixel, batch by batch. The samples of a pixel are neighbours in a batch. `visit` gets the index
    /// of each pixel and the values of some of its samples.
    fn add_samples(
        &mut self,
        pixels: &mut [PixelSum],
        set: &[PixelSample],
        first_index: u32,
        cancel: &CancelFlag,
        mut visit: impl FnMut(usize, &[SampleValue]),
    ) -> Result<(), Cancelled> {
        let TileSettings { camera, plan, screen, aovs: flags, .. } = self.settings;
        let offsets: Vec<Vec2> = set.iter().map(|sample| sample.offset).collect();
        // A pixel of very many samples has several batches of its own.
        let pixels_per_batch = (BATCH_SAMPLES / set.len()).max(1);
        for (batch, pixels) in pixels.chunks_mut(pixels_per_batch).enumerate() {
            self.positions.clear();
            self.positions.extend(pixels.iter().map(|pixel| pixel.position));
            let parts = set.chunks(BATCH_SAMPLES).zip(offsets.chunks(BATCH_SAMPLES));
            for (part, (set, offsets)) in parts.enumerate() {
                cancel.check()?;
                let first_index = plan.first_index + first_index + (part * BATCH_SAMPLES) as u32;
                let may_hit = screen.may_cover(&self.positions, offsets);
                let samples = CameraSamples { pixels: &self.positions, offsets, first_index, may_hit };
                let values = self.tracer.trace(camera, &samples);
                for (index, (pixel, values)) in
                    pixels.iter_mut().zip(values.chunks_exact(set.len())).enumerate()
                {
                    pixel.add(values, set);
                    visit(batch * pixels_per_batch + index, values);
                }
                if flags != AovFlags::NONE {
                    self.add_aovs(set);
                }
            }
        }
        Ok(())
    }

    /// Adds the AOVs of the last batch, which has the samples of `set` in each pixel.
    fn add_aovs(&mut self, set: &[PixelSample]) {
        let Self { positions, aovs, tracer, .. } = self;
        for (&position, light) in positions.iter().zip(tracer.light_passes().chunks_exact(set.len())) {
            for (sample, light) in set.iter().zip(light) {
                aovs.add_light(position, sample.weight, light);
            }
        }
        for coverage in tracer.coverage() {
            let sample = coverage.sample as usize;
            aovs.add_coverage(positions[sample / set.len()], set[sample % set.len()].weight, coverage);
        }
    }
}
