//! The tile renderer: traces the samples of a tile in coherent batches and sums them in every pixel.

use glam::Vec2;

use super::adaptive::SampleRange;
use super::filter::PixelSample;
use super::sample_plan::SamplePlan;
use super::sample_sink::{ExactSink, FloatSink, SampleSink};
use super::screen_bounds::ScreenBounds;
use super::tile_aovs::TileAovs;
use super::tile_grid::pixels_in_morton_order;
use super::tile_pixels::{PixelGrid, PixelSum};
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, FilmAovs, PixelWindow, SampleSums};
use crate::integrator::tracing::Tracer;
use crate::integrator::{CameraRays, CameraSamples, IntegratorContext, IntegratorStatistics, SampleAovFlags};

/// Samples in a batch: enough for full packets of every kind of ray, few enough for the cache.
const BATCH_SAMPLES: usize = 1024;

/// Pixels and AOVs of one tile, row by row, and the counters of its integrator.
pub(super) struct RenderedTile<'r> {
    pub(super) pixels: &'r [[f32; 4]],
    /// Filter weights of the pixels.
    pub(super) weights: &'r [f32],
    pub(super) aovs: FilmAovs,
    pub(super) statistics: IntegratorStatistics,
}

/// What tiles of an image have in common.
#[derive(Clone, Copy)]
pub(super) struct TileSettings<'w> {
    pub(super) camera: &'w CameraRays,
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
    /// The pixels of the current tile, in the order of their samples.
    pixels: Vec<PixelSum>,
    /// The same, row by row.
    rows: Vec<[f32; 4]>,
    /// Their filter weights, row by row.
    weights: Vec<f32>,
}

impl<'w, 'a> TileRenderer<'w, 'a> {
    /// A renderer that has rendered nothing.
    pub(super) fn new(context: &'w IntegratorContext<'a>, settings: TileSettings<'w>) -> Self {
        let AovFlags { light, coverage, guides, .. } = settings.aovs;
        Self {
            settings: TileSettings {
                aovs: AovFlags { light, coverage, guides, ..AovFlags::NONE },
                ..settings
            },
            tracer: Tracer::new(context).recording(SampleAovFlags { light, coverage, guides }),
            aovs: TileAovs::default(),
            pixels: Vec::new(),
            rows: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// Renders `tile`. Each pixel is the weighted mean of its samples, summed in their order, or their sum, where the plan leaves sums.
    pub(super) fn render(
        &mut self,
        tile: PixelWindow,
        plan: &SamplePlan,
        cancel: &CancelFlag,
    ) -> Result<RenderedTile<'_>, Cancelled> {
        let flags = self.settings.aovs;
        self.aovs = TileAovs::new(tile, flags);
        let mut pixels = std::mem::take(&mut self.pixels);
        pixels.clear();
        pixels.extend(pixels_in_morton_order(tile).map(PixelSum::new));
        let inside = pixels.len();
        if plan.is_adaptive() {
            self.add_adaptive_samples(tile, plan, &mut pixels, cancel)?;
        } else {
            self.add_float_samples(&mut pixels, &plan.base, plan.first_index, None, cancel)?;
        }

        if plan.leaves_sums {
            self.store_sums(tile, &pixels[..inside], plan.most_samples());
        } else {
            self.store_means(tile, &pixels[..inside]);
        }
        self.pixels = pixels;
        let aovs = std::mem::take(&mut self.aovs).finish();
        let statistics = self.tracer.take_statistics();
        Ok(RenderedTile { pixels: &self.rows, weights: &self.weights, aovs, statistics })
    }

    /// Stores the means of the pixels of `tile`, row by row.
    fn store_means(&mut self, tile: PixelWindow, pixels: &[PixelSum]) {
        self.rows.resize(pixels.len(), [0.0; 4]);
        self.weights.clear();
        for pixel in pixels {
            self.rows[row_major_index(tile, pixel.position)] = pixel.mean();
            self.aovs.normalize(pixel.position, pixel.weight);
        }
    }

    /// Stores the sums and weights of the pixels of `tile`, row by row, all as if they had `most_samples`: shutter samples count alike,
    /// whether or not a pixel is on an edge at their time.
    fn store_sums(&mut self, tile: PixelWindow, pixels: &[PixelSum], most_samples: u32) {
        self.rows.resize(pixels.len(), [0.0; 4]);
        self.weights.resize(pixels.len(), 0.0);
        for pixel in pixels {
            let (index, share) = (row_major_index(tile, pixel.position), pixel.share(most_samples));
            self.rows[index] = pixel.sum().map(|sum| sum * share);
            self.weights[index] = pixel.weight * share;
            self.aovs.scale(pixel.position, share);
        }
    }

    /// Adds the samples of `set`, the first of which has the index `first_index`, to those pixels of the window of `sums` for which
    /// `is_active`. Returns the number of samples that were not finite and are left out.
    pub(super) fn add_exact_samples(
        &mut self,
        sums: &mut SampleSums,
        set: &[PixelSample],
        first_index: u32,
        is_active: impl Fn((u32, u32)) -> bool,
        cancel: &CancelFlag,
    ) -> Result<(u64, IntegratorStatistics), Cancelled> {
        let positions: Vec<_> =
            pixels_in_morton_order(sums.window).filter(|&pixel| is_active(pixel)).collect();
        let mut sink = ExactSink::new(sums);
        self.add_samples(&positions, set, first_index, &mut sink, cancel)?;
        Ok((sink.non_finite_samples, self.tracer.take_statistics()))
    }

    /// Adds the base samples to the pixels of a tile, and extra samples to those on edges.
    fn add_adaptive_samples(
        &mut self,
        tile: PixelWindow,
        plan: &SamplePlan,
        pixels: &mut Vec<PixelSum>,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let inside = pixels.len();
        pixels.extend(self.border(tile).map(PixelSum::new));
        let mut ranges = vec![SampleRange::EMPTY; pixels.len()];
        self.add_float_samples(pixels, &plan.base, plan.first_index, Some(&mut ranges), cancel)?;

        let grid = PixelGrid::new(tile, pixels);
        let (mut edges, indices): (Vec<PixelSum>, Vec<usize>) = (0..inside)
            .filter(|&index| grid.is_edge(pixels, index, ranges[index], plan.edges))
            .map(|index| (pixels[index], index))
            .unzip();
        let first_index = plan.first_index + plan.base.len() as u32;
        self.add_float_samples(&mut edges, &plan.extra, first_index, None, cancel)?;
        for (pixel, index) in edges.into_iter().zip(indices) {
            pixels[index] = pixel;
        }
        Ok(())
    }

    /// Adds a set of samples to every pixel and to the AOVs of the tile.
    fn add_float_samples(
        &mut self,
        pixels: &mut [PixelSum],
        set: &[PixelSample],
        first_index: u32,
        ranges: Option<&mut [SampleRange]>,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let positions: Vec<_> = pixels.iter().map(|pixel| pixel.position).collect();
        let mut aovs = std::mem::take(&mut self.aovs);
        let mut sink = FloatSink { pixels, ranges, aovs: &mut aovs };
        let added = self.add_samples(&positions, set, first_index, &mut sink, cancel);
        self.aovs = aovs;
        added
    }

    /// The pixels of the image next to a tile.
    fn border(&self, tile: PixelWindow) -> impl Iterator<Item = (u32, u32)> + use<> {
        let columns = tile.x0.saturating_sub(1)..self.settings.resolution.0.min(tile.x1 + 1);
        let rows = tile.y0.saturating_sub(1)..self.settings.resolution.1.min(tile.y1 + 1);
        let is_inside = move |x, y| (tile.x0..tile.x1).contains(&x) && (tile.y0..tile.y1).contains(&y);
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y))).filter(move |&(x, y)| !is_inside(x, y))
    }

    /// Traces a set of samples in every pixel, batch by batch, and passes them to `sink`. The samples of a pixel are neighbours in a
    /// batch.
    fn add_samples(
        &mut self,
        positions: &[(u32, u32)],
        set: &[PixelSample],
        first_index: u32,
        sink: &mut impl SampleSink,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let TileSettings { camera, screen, aovs: flags, .. } = self.settings;
        let offsets: Vec<Vec2> = set.iter().map(|sample| sample.offset).collect();
        // A pixel of very many samples has several batches of its own.
        let pixels_per_batch = (BATCH_SAMPLES / set.len().max(1)).max(1);
        for (batch, pixels) in positions.chunks(pixels_per_batch).enumerate() {
            let parts = set.chunks(BATCH_SAMPLES).zip(offsets.chunks(BATCH_SAMPLES));
            for (part, (set, offsets)) in parts.enumerate() {
                cancel.check()?;
                let first_index = first_index + (part * BATCH_SAMPLES) as u32;
                let may_hit = screen.may_cover(pixels, offsets);
                let samples = CameraSamples { pixels, offsets, first_index, may_hit };
                let values = self.tracer.trace(camera, &samples);
                for (index, values) in values.chunks_exact(set.len()).enumerate() {
                    sink.add(batch * pixels_per_batch + index, pixels[index], values, set);
                }
                if flags != AovFlags::NONE {
                    self.add_aovs(pixels, set, sink);
                }
            }
        }
        Ok(())
    }

    /// Passes on the AOVs of the last batch, which has the samples of `set` in each pixel.
    fn add_aovs(&mut self, positions: &[(u32, u32)], set: &[PixelSample], sink: &mut impl SampleSink) {
        let (per_pixel, values) = (set.len(), self.tracer.values());
        let place = |sample: usize| (positions[sample / per_pixel], set[sample % per_pixel].weight);
        for (sample, light) in self.tracer.light_passes().iter().enumerate() {
            let (position, weight) = place(sample);
            if sink.accepts(&values[sample]) {
                sink.add_light(position, weight, light);
            }
        }
        for (sample, guide) in self.tracer.guides().iter().enumerate() {
            let (position, weight) = place(sample);
            if sink.accepts(&values[sample]) {
                sink.add_guide(position, weight, guide);
            }
        }
        for coverage in self.tracer.coverage() {
            let sample = coverage.sample as usize;
            let (position, weight) = place(sample);
            if sink.accepts(&values[sample]) {
                sink.add_coverage(position, weight, coverage);
            }
        }
    }
}

/// Index of a pixel of `tile`.
fn row_major_index(tile: PixelWindow, (x, y): (u32, u32)) -> usize {
    ((y - tile.y0) * tile.width() + x - tile.x0) as usize
}
