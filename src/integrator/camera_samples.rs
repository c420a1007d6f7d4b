//! Samples of the image that are traced together, and their camera rays.

use fearless_simd::Level;
use glam::Vec2;

use super::CameraRays;
use super::random::Seed;
use super::zsobol::{SampleSequence, ZSobol};
use crate::geometry::{Ray, vectorized};

/// Samples of some pixels at the same positions in each pixel. The samples of a pixel follow each other.
///
/// Neighbours on screen should be neighbours in the list of pixels.
#[derive(Clone, Copy, Debug)]
pub struct CameraSamples<'s> {
    /// Column and row of each pixel.
    pub pixels: &'s [(u32, u32)],
    /// Positions in each pixel, from its top left corner.
    pub offsets: &'s [Vec2],
    /// Index of the first position among all samples of a pixel.
    pub first_index: u32,
    /// Whether any ray may hit a surface. Otherwise none is traced.
    pub may_hit: bool,
}

impl CameraSamples<'_> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.pixels.len() * self.offsets.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The sample points of a path.
    pub(super) fn sequence(&self, points: &ZSobol, sample: u32) -> SampleSequence {
        let (pixel, index) = self.pixel_and_index(sample);
        points.sequence(pixel, index)
    }

    /// The seed of a sample.
    pub(super) fn seed(&self, camera: &CameraRays, sample: u32) -> Seed {
        let (pixel, index) = self.pixel_and_index(sample);
        camera.seed(pixel, index)
    }

    /// The pixel of a sample, and the sample's index in it.
    fn pixel_and_index(&self, sample: u32) -> ((u32, u32), u32) {
        // Divisions of 32 bits take a fraction of the time of those of 64.
        let per_pixel = self.offsets.len() as u32;
        let index = self.first_index.wrapping_add(sample % per_pixel);
        (self.pixels[(sample / per_pixel) as usize], index)
    }
}

/// The camera rays of a batch, one for each sample, and the memory of their positions.
#[derive(Debug, Default)]
pub(super) struct CameraRayBatch {
    rays: Vec<Ray>,
    /// Columns and rows in the image, pixels.
    positions: [Vec<f32>; 2],
}

impl CameraRayBatch {
    /// The rays, in the order of their samples.
    pub(super) fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// Replaces the rays, by the instruction set `level`.
    pub(super) fn fill(&mut self, level: Level, camera: &CameraRays, samples: &CameraSamples<'_>) {
        let Self { rays, positions: [columns, rows] } = self;
        columns.resize(samples.len(), 0.0);
        rows.resize(samples.len(), 0.0);
        let per_pixel = samples.offsets.len().max(1);
        let of_pixels = columns.chunks_exact_mut(per_pixel).zip(rows.chunks_exact_mut(per_pixel));
        for (&(x, y), (columns, rows)) in samples.pixels.iter().zip(of_pixels) {
            let corner = Vec2::new(x as f32, y as f32);
            for ((column, row), offset) in columns.iter_mut().zip(rows).zip(samples.offsets) {
                (*column, *row) = (corner.x + offset.x, corner.y + offset.y);
            }
        }
        if camera.is_pinhole() {
            vectorized!(level, camera.pinhole_rays([columns, rows], rays));
        } else {
            rays.clear();
            let positions = columns.iter().zip(&*rows).map(|(&x, &y)| Vec2::new(x, y));
            let seeded = (0..).zip(positions);
            rays.extend(seeded.map(|(sample, at)| camera.ray(at, samples.seed(camera, sample))));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Mat4, Quat, Vec3};

    use super::*;
    use crate::frame::PosedCamera;
    use crate::integrator::ThinLens;
    use crate::scene::Projection;

    #[test]
    fn rays_of_a_batch_are_those_of_single_samples() {
        let rotation = Quat::from_xyzw(0.0, 0.6, 0.0, 0.8);
        let world_from_camera = Mat4::from_rotation_translation(rotation, Vec3::new(1.0, -2.0, 0.3));
        let perspective = Projection::Perspective {
            fov_y_radians: 0.7,
            aspect_ratio: None,
            z_near: 0.1,
            z_far: Some(70.0),
        };
        let orthographic = Projection::Orthographic { x_mag: 2.0, y_mag: 1.0, z_near: 0.1, z_far: 9.0 };
        let lens = Some(ThinLens { radius: 0.1, focus_distance: 3.0 });
        let offsets = [Vec2::new(0.125, 0.25), Vec2::new(0.375, 0.75), Vec2::new(1.7, -0.4)];
        let pixels: Vec<(u32, u32)> = (0..11).map(|i| (i * 3, 17 - i)).collect();
        let samples = CameraSamples { pixels: &pixels, offsets: &offsets, first_index: 5, may_hit: true };
        for (projection, lens) in [(perspective, None), (perspective, lens), (orthographic, None)] {
            let camera = PosedCamera { world_from_camera, projection };
            let camera = CameraRays::new(&camera, (40, 20), 0.5, lens);
            let mut batch = CameraRayBatch::default();
            for level in [Level::fallback(), Level::new()] {
                batch.fill(level, &camera, &samples);
                assert_eq!(batch.rays().len(), samples.len());
                for (sample, ray) in batch.rays().iter().enumerate() {
                    let (x, y) = pixels[sample / 3];
                    let position = Vec2::new(x as f32, y as f32) + offsets[sample % 3];
                    let seed = camera.seed((x, y), 5 + sample as u32 % 3);
                    assert_eq!(*ray, camera.ray(position, seed), "{sample}");
                }
            }
        }
    }
}
