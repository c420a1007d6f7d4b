//! One tile: its samples in coherent batches through the integrator, and their mean in every pixel.

use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, FilmAovs, PixelWindow};
use crate::integrator::whitted::{SampleAovFlags, Tracer};
use crate::integrator::{CameraRays, IntegratorContext, IntegratorStatistics};
use glam::Vec2;

use super::adaptive::Spread;
use super::filter::PixelSample;
use super::plan::SamplePlan;
use super::tile_aovs::TileAovs;

/// Pixels along the side of a tile, a power of two.
pub(super) const TILE_SIZE: u32 = 32;

/// Samples traced together: enough for full packets of every kind of ray, few enough to stay in the cache.
const BATCH_SAMPLES: usize = 1024;

/// Pixels of one tile, row by row, and what was done for them.
pub(super) struct RenderedTile {
    pub(super) pixels: Vec<[f32; 4]>,
    pub(super) layers: FilmAovs,
    pub(super) statistics: IntegratorStatistics,
}

/// Renders tiles, one after the other in the same memory.
pub(super) struct TileRenderer<'w, 'a> {
    context: &'w IntegratorContext<'a>,
    camera: &'w CameraRays,
    plan: &'w SamplePlan,
    /// Of the whole picture.
    resolution: (u32, u32),
    tracer: Tracer<'w, 'a>,
    /// What is recorded of tiles.
    request: AovFlags,
    /// Of the tile at hand.
    layers: TileAovs,
}

/// A pixel while its samples come in.
#[derive(Clone, Copy)]
struct Pixel {
    at: (u32, u32),
    sum: [f32; 4],
    weight: f32,
    /// Kept only where edges are looked for.
    spread: Spread,
}

impl<'w, 'a> TileRenderer<'w, 'a> {
    pub(super) fn new(
        context: &'w IntegratorContext<'a>,
        camera: &'w CameraRays,
        plan: &'w SamplePlan,
        resolution: (u32, u32),
    ) -> Self {
        let (tracer, request, layers) = (Tracer::new(context), AovFlags::NONE, TileAovs::default());
        Self { context, camera, plan, resolution, tracer, request, layers }
    }

    /// The same, which also records light by parts and coverage where they are asked for.
    pub(super) fn recording(self, request: AovFlags) -> Self {
        let tracer =
            self.tracer.recording(SampleAovFlags { light: request.light, coverage: request.coverage });
        Self { tracer, request: AovFlags { centers: false, ..request }, ..self }
    }

    /// The pixels of `tile`: each is the weighted mean of its samples, summed in their order.
    pub(super) fn render(
        &mut self,
        tile: PixelWindow,
        cancel: &CancelFlag,
    ) -> Result<RenderedTile, Cancelled> {
        self.layers = TileAovs::new(tile, self.request);
        let mut pixels: Vec<Pixel> = pixels_in_z_order(tile).into_iter().map(Pixel::new).collect();
        let inside = pixels.len();
        if self.plan.looks_for_edges() {
            pixels.extend(self.around(tile).map(Pixel::new));
        }
        self.add_samples(&mut pixels, &self.plan.base, 0, cancel)?;

        // More where base samples differ
        if self.plan.looks_for_edges() {
            let region = Region::new(tile, &pixels);
            let (mut edges, places): (Vec<Pixel>, Vec<usize>) = (0..inside)
                .filter(|&place| region.is_edge(&pixels, place, self.plan.threshold))
                .map(|place| (pixels[place], place))
                .unzip();
            self.add_samples(&mut edges, &self.plan.extra, self.plan.base.len() as u32, cancel)?;
            for (pixel, place) in edges.into_iter().zip(places) {
                pixels[place] = pixel;
            }
        }

        let mut rows = vec![[0.0; 4]; inside];
        for pixel in &pixels[..inside] {
            let (x, y) = pixel.at;
            rows[((y - tile.y0) * tile.width() + x - tile.x0) as usize] = pixel.mean();
            self.layers.normalize(pixel.at, pixel.weight);
        }
        let layers = std::mem::take(&mut self.layers).finish();
        Ok(RenderedTile { pixels: rows, layers, statistics: self.tracer.take_statistics() })
    }

    /// The pixels of the picture next to a tile.
    fn around(&self, tile: PixelWindow) -> impl Iterator<Item = (u32, u32)> + use<> {
        let columns = tile.x0.saturating_sub(1)..self.resolution.0.min(tile.x1 + 1);
        let rows = tile.y0.saturating_sub(1)..self.resolution.1.min(tile.y1 + 1);
        let is_inside = move |x, y| (tile.x0..tile.x1).contains(&x) && (tile.y0..tile.y1).contains(&y);
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y))).filter(move |&(x, y)| !is_inside(x, y))
    }

    /// Adds a set of samples to every pixel, batch by batch; those of a pixel lie side by side.
    fn add_samples(
        &mut self,
        pixels: &mut [Pixel],
        set: &[PixelSample],
        first_index: u32,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let samples = pixels.len() * set.len();
        for first in (0..samples).step_by(BATCH_SAMPLES) {
            cancel.check()?;
            let batch = first..samples.min(first + BATCH_SAMPLES);
            for (subscript, sample) in batch.clone().enumerate() {
                let (x, y) = pixels[sample / set.len()].at;
                let index = self.plan.first_index + first_index + (sample % set.len()) as u32;
                let seed = self.camera.seed((x, y), index);
                let position = Vec2::new(x as f32, y as f32) + set[sample % set.len()].offset;
                let ray = self.camera.ray(position, seed);
                let media = self.context.media_around_start(&ray);
                let state = self.camera.ray_state(&ray, media, subscript as u32, seed);
                self.tracer.push(ray, state);
            }
            let values = self.tracer.trace(batch.len());
            for (sample, value) in batch.clone().zip(values) {
                let [red, green, blue] = value.radiance.to_array();
                let weight = set[sample % set.len()].weight;
                let value = [red, green, blue, value.coverage];
                let pixel = &mut pixels[sample / set.len()];
                pixel.add(value, weight);
                if self.plan.looks_for_edges() {
                    pixel.spread.add(value);
                }
            }

            // What is recorded besides
            let place = |sample: usize| (pixels[sample / set.len()].at, set[sample % set.len()].weight);
            for (sample, light) in batch.zip(self.tracer.light_passes()) {
                self.layers.add_light(place(sample), light);
            }
            for cover in self.tracer.coverage() {
                self.layers.add_cover(place(first + cover.sample as usize), cover);
            }
        }
        Ok(())
    }
}

impl Pixel {
    fn new(at: (u32, u32)) -> Self {
        Self { at, sum: [0.0; 4], weight: 0.0, spread: Spread::NONE }
    }

    fn add(&mut self, value: [f32; 4], weight: f32) {
        for (sum, value) in self.sum.iter_mut().zip(value) {
            *sum += value * weight;
        }
        self.weight += weight;
    }

    /// The filtered value. A filter's negative lobes must leave neither negative light nor a coverage beyond one.
    fn mean(&self) -> [f32; 4] {
        if self.weight <= 0.0 {
            return [0.0; 4];
        }
        let scale = 1.0 / self.weight;
        let [red, green, blue, coverage] = self.sum.map(|channel| channel * scale);
        let positive = |x: f32| if x < 0.0 { 0.0 } else { x };
        [
            positive(red),
            positive(green),
            positive(blue),
            if coverage > 1.0 { 1.0 } else { positive(coverage) },
        ]
    }
}

/// Where the pixels of a tile and those around it stand in a list.
struct Region {
    /// Of the column and row before the tile's first.
    corner: (i64, i64),
    stride: usize,
    places: Vec<Option<usize>>,
}

impl Region {
    fn new(tile: PixelWindow, pixels: &[Pixel]) -> Self {
        let stride = tile.width() as usize + 2;
        let corner = (i64::from(tile.x0) - 1, i64::from(tile.y0) - 1);
        let mut region = Self { corner, stride, places: vec![None; stride * (tile.height() as usize + 2)] };
        for (place, pixel) in pixels.iter().enumerate() {
            let cell = region.cell(pixel.at);
            region.places[cell] = Some(place);
        }
        region
    }

    fn cell(&self, (x, y): (u32, u32)) -> usize {
        (i64::from(y) - self.corner.1) as usize * self.stride + (i64::from(x) - self.corner.0) as usize
    }

    /// Whether a pixel of the tile differs in itself or from a neighbour.
    fn is_edge(&self, pixels: &[Pixel], place: usize, threshold: f32) -> bool {
        let mut spread = pixels[place].spread;
        let cell = self.cell(pixels[place].at);
        for row in [cell - self.stride, cell, cell + self.stride] {
            for neighbour in self.places[row - 1..=row + 1].iter().flatten() {
                spread.add(pixels[*neighbour].mean());
            }
        }
        spread.exceeds(threshold)
    }
}

/// The pixels of a tile along Morton's curve, which runs through aligned squares of every size one after the other.
pub(super) fn pixels_in_z_order(tile: PixelWindow) -> Vec<(u32, u32)> {
    let corner = (tile.x0 / TILE_SIZE * TILE_SIZE, tile.y0 / TILE_SIZE * TILE_SIZE);
    (0..TILE_SIZE * TILE_SIZE)
        .map(|code| (corner.0 + even_bits(code), corner.1 + even_bits(code >> 1)))
        .filter(|&(x, y)| (tile.x0..tile.x1).contains(&x) && (tile.y0..tile.y1).contains(&y))
        .collect()
}

/// The even bits of the low sixteen, moved together.
fn even_bits(code: u32) -> u32 {
    let pairs = code & 0x5555;
    let nibbles = (pairs | pairs >> 1) & 0x3333;
    let bytes = (nibbles | nibbles >> 2) & 0x0f0f;
    (bytes | bytes >> 4) & 0x00ff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_64_pixels_are_squares() {
        let pixels = pixels_in_z_order(PixelWindow { x0: 32, y0: 64, x1: 64, y1: 96 });
        assert_eq!(pixels.len(), 1024);
        for block in pixels.chunks(64) {
            let (left, top) = block[0];
            assert_eq!((left % 8, top % 8), (0, 0));
            assert!(block.iter().all(|&(x, y)| x / 8 == left / 8 && y / 8 == top / 8));
        }
        // And so are blocks of 16, which hold four samples a pixel.
        assert!(pixels[..16].iter().all(|&(x, y)| x < 36 && y < 68));
    }

    #[test]
    fn every_pixel_of_a_cut_tile_comes_once() {
        let tile = PixelWindow { x0: 35, y0: 31, x1: 61, y1: 32 };
        let mut pixels = pixels_in_z_order(tile);
        pixels.sort_unstable();
        assert_eq!(pixels, (35..61).map(|x| (x, 31)).collect::<Vec<_>>());
    }
}
