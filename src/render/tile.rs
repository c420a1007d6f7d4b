//! The tile renderer: traces the samples of a tile in coherent batches and takes their mean in every pixel.

use glam::Vec2;

use super::filter::PixelSample;
use super::sample_plan::SamplePlan;
use super::tile_aovs::TileAovs;
use super::tile_grid::pixels_in_morton_order;
use super::tile_pixels::{PixelGrid, PixelSum};
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, FilmAovs, PixelWindow};
use crate::integrator::whitted::{SampleAovFlags, Tracer};
use crate::integrator::{CameraRays, IntegratorContext, IntegratorStatistics};

/// Samples in a batch: enough for full packets of every kind of ray, few enough for the cache.
const BATCH_SAMPLES: usize = 1024;

/// Pixels and AOVs of one tile, row by row, and the counters of its integrator.
pub(super) struct RenderedTile {
    pub(super) pixels: Vec<[f32; 4]>,
    pub(super) aovs: FilmAovs,
    pub(super) statistics: IntegratorStatistics,
}

/// Renders tiles one after the other and keeps its buffers between them.
pub(super) struct TileRenderer<'w, 'a> {
    context: &'w IntegratorContext<'a>,
    camera: &'w CameraRays,
    plan: &'w SamplePlan,
    /// Size of the whole image.
    resolution: (u32, u32),
    tracer: Tracer<'w, 'a>,
    /// The AOVs that are recorded.
    flags: AovFlags,
    /// AOVs of the current tile.
    aovs: TileAovs,
}

impl<'w, 'a> TileRenderer<'w, 'a> {
    pub(super) fn new(
        context: &'w IntegratorContext<'a>,
        camera: &'w CameraRays,
        plan: &'w SamplePlan,
        resolution: (u32, u32),
    ) -> Self {
        let (tracer, flags, aovs) = (Tracer::new(context), AovFlags::NONE, TileAovs::default());
        Self { context, camera, plan, resolution, tracer, flags, aovs }
    }

    /// The same renderer, which also records the light passes and the coverage of `flags`.
    pub(super) fn recording(self, flags: AovFlags) -> Self {
        let tracer = self.tracer.recording(SampleAovFlags { light: flags.light, coverage: flags.coverage });
        Self { tracer, flags: AovFlags { centers: false, ..flags }, ..self }
    }

    /// Renders `tile`. Each pixel is the weighted mean of its samples, summed in their order.
    pub(super) fn render(
        &mut self,
        tile: PixelWindow,
        cancel: &CancelFlag,
    ) -> Result<RenderedTile, Cancelled> {
        self.aovs = TileAovs::new(tile, self.flags);
        let mut pixels: Vec<PixelSum> = pixels_in_morton_order(tile).into_iter().map(PixelSum::new).collect();
        let inside = pixels.len();
        if self.plan.is_adaptive() {
            pixels.extend(self.border(tile).map(PixelSum::new));
        }
        self.add_samples(&mut pixels, &self.plan.base, 0, cancel)?;

        // Extra samples for pixels on edges
        if self.plan.is_adaptive() {
            let grid = PixelGrid::new(tile, &pixels);
            let (mut edges, indices): (Vec<PixelSum>, Vec<usize>) = (0..inside)
                .filter(|&index| grid.is_edge(&pixels, index, self.plan.threshold))
                .map(|index| (pixels[index], index))
                .unzip();
            self.add_samples(&mut edges, &self.plan.extra, self.plan.base.len() as u32, cancel)?;
            for (pixel, index) in edges.into_iter().zip(indices) {
                pixels[index] = pixel;
            }
        }

        // Means, row by row
        let mut rows = vec![[0.0; 4]; inside];
        for pixel in &pixels[..inside] {
            let (x, y) = pixel.position;
            rows[((y - tile.y0) * tile.width() + x - tile.x0) as usize] = pixel.mean();
            self.aovs.normalize(pixel.position, pixel.weight);
        }
        let aovs = std::mem::take(&mut self.aovs).finish();
        Ok(RenderedTile { pixels: rows, aovs, statistics: self.tracer.take_statistics() })
    }

    /// The pixels of the image next to a tile.
    fn border(&self, tile: PixelWindow) -> impl Iterator<Item = (u32, u32)> + use<> {
        let columns = tile.x0.saturating_sub(1)..self.resolution.0.min(tile.x1 + 1);
        let rows = tile.y0.saturating_sub(1)..self.resolution.1.min(tile.y1 + 1);
        let is_inside = move |x, y| (tile.x0..tile.x1).contains(&x) && (tile.y0..tile.y1).contains(&y);
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y))).filter(move |&(x, y)| !is_inside(x, y))
    }

    /// Adds a set of samples to every pixel, batch by batch. The samples of a pixel are neighbours in a batch.
    fn add_samples(
        &mut self,
        pixels: &mut [PixelSum],
        set: &[PixelSample],
        first_index: u32,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let samples = pixels.len() * set.len();
        for first in (0..samples).step_by(BATCH_SAMPLES) {
            cancel.check()?;
            let batch = first..samples.min(first + BATCH_SAMPLES);

            // Camera rays
            for (index_in_batch, sample) in batch.clone().enumerate() {
                let (x, y) = pixels[sample / set.len()].position;
                let index = self.plan.first_index + first_index + (sample % set.len()) as u32;
                let seed = self.camera.seed((x, y), index);
                let position = Vec2::new(x as f32, y as f32) + set[sample % set.len()].offset;
                let ray = self.camera.ray(position, seed);
                let media = self.context.media_around_start(&ray);
                let state = self.camera.ray_state(&ray, media, index_in_batch as u32, seed);
                self.tracer.push(ray, state);
            }

            // Values
            let values = self.tracer.trace(batch.len());
            for (sample, value) in batch.clone().zip(values) {
                let [red, green, blue] = value.radiance.to_array();
                let weight = set[sample % set.len()].weight;
                let value = [red, green, blue, value.coverage];
                let pixel = &mut pixels[sample / set.len()];
                pixel.add(value, weight);
                if self.plan.is_adaptive() {
                    pixel.range.add(value);
                }
            }

            // AOVs
            let position = |sample: usize| pixels[sample / set.len()].position;
            let weight = |sample: usize| set[sample % set.len()].weight;
            for (sample, light) in batch.zip(self.tracer.light_passes()) {
                self.aovs.add_light(position(sample), weight(sample), light);
            }
            for coverage in self.tracer.coverage() {
                let sample = first + coverage.sample as usize;
                self.aovs.add_coverage(position(sample), weight(sample), coverage);
            }
        }
        Ok(())
    }
}
