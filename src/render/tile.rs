//! One tile: its samples in coherent batches through the integrator, and their mean in every pixel.

use glam::Vec2;

use crate::cancel::{CancelFlag, Cancelled};
use crate::film::PixelWindow;
use crate::integrator::whitted::Tracer;
use crate::integrator::{CameraRays, IntegratorStatistics, World};

/// Pixels along the side of a tile, a power of two.
pub(super) const TILE_SIZE: u32 = 32;

/// Samples traced together: enough for full packets of every kind of ray, few enough to stay in the cache.
const BATCH_SAMPLES: usize = 1024;

/// Pixels of one tile, row by row, and what was done for them.
pub(super) type RenderedTile = (Vec<[f32; 4]>, IntegratorStatistics);

/// Renders tiles, one after the other in the same memory.
pub(super) struct TileRenderer<'w, 'a> {
    world: &'w World<'a>,
    camera: &'w CameraRays,
    /// Where samples lie in a pixel.
    offsets: &'w [Vec2],
    tracer: Tracer<'w, 'a>,
}

impl<'w, 'a> TileRenderer<'w, 'a> {
    pub(super) fn new(world: &'w World<'a>, camera: &'w CameraRays, offsets: &'w [Vec2]) -> Self {
        Self { world, camera, offsets, tracer: Tracer::new(world) }
    }

    /// The pixels of `tile`: each is the mean of its samples, summed in their order.
    pub(super) fn render(
        &mut self,
        tile: PixelWindow,
        cancel: &CancelFlag,
    ) -> Result<RenderedTile, Cancelled> {
        let pixels = pixels_in_z_order(tile);
        let mut sums = vec![[0.0_f32; 4]; pixels.len()];
        let samples = pixels.len() * self.offsets.len();
        for first in (0..samples).step_by(BATCH_SAMPLES) {
            cancel.check()?;
            self.add_samples(first..samples.min(first + BATCH_SAMPLES), &pixels, &mut sums);
        }

        let scale = 1.0 / self.offsets.len() as f32;
        let mut rows = vec![[0.0; 4]; pixels.len()];
        for (&(x, y), sum) in pixels.iter().zip(&sums) {
            rows[((y - tile.y0) * tile.width() + x - tile.x0) as usize] = sum.map(|channel| channel * scale);
        }
        Ok((rows, self.tracer.take_statistics()))
    }

    /// Adds a batch of samples; they are counted through all pixels, those of a pixel side by side.
    fn add_samples(&mut self, samples: std::ops::Range<usize>, pixels: &[(u32, u32)], sums: &mut [[f32; 4]]) {
        let a_pixel = self.offsets.len();
        for (subscript, sample) in samples.clone().enumerate() {
            let (x, y) = pixels[sample / a_pixel];
            let ray = self.camera.ray(Vec2::new(x as f32, y as f32) + self.offsets[sample % a_pixel]);
            let path = self.camera.path(&ray, self.world.media_around_start(&ray), subscript as u32);
            self.tracer.push(ray, path);
        }
        let values = self.tracer.trace(samples.len());
        for (sample, value) in samples.zip(values) {
            let [red, green, blue] = value.radiance.to_array();
            let sum = &mut sums[sample / a_pixel];
            *sum = [sum[0] + red, sum[1] + green, sum[2] + blue, sum[3] + value.coverage];
        }
    }
}

/// The pixels of a tile along Morton's curve, which runs through aligned squares of every size one after the other.
fn pixels_in_z_order(tile: PixelWindow) -> Vec<(u32, u32)> {
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
