//! Means of a built-in light under GGX lobes, and its irradiance.
//!
//! As in [`super::super::prefilter`], the view is assumed along the normal, and each direction is weighted by its cosine; roughness 1 has another view. A
//! sample of more solid angle takes the mean of the radiance over a wider square.

use std::f32::consts::PI;

use glam::Vec3;

use super::super::octahedral::OctahedralImage;
use super::super::prefilter::STEPS;
use crate::geometry::{GOLDEN_ANGLE, spiral_direction};

/// Directions around +Z with the squares that they stand for.
pub(super) struct Lobe {
    /// Cells an edge of an image that resolves the lobe.
    pub(super) cells: usize,
    samples: Vec<Sample>,
}

struct Sample {
    direction: Vec3,
    /// Share of the mean.
    weight: f32,
    /// Edge of the square, as an angle.
    width: f32,
}

impl Lobe {
    /// GGX lobe of a roughness of `step` eighths, below 1.
    pub(super) fn ggx(step: usize) -> Self {
        // Narrow lobes need more cells, wide ones more samples.
        let (cells, count) = match step {
            1 => (64, 16),
            2 => (48, 32),
            3 | 4 => (24, 64),
            _ => (16, 128),
        };
        let roughness = step as f32 / STEPS as f32;
        let alpha = roughness * roughness;
        let mut samples = Vec::new();
        for index in 0..count {
            // Half vectors with density D cos θ_h: tan² θ_h = α² ξ / (1 − ξ) (Walter et al. 2007, equation 35).
            let share = (index as f32 + 0.5) / count as f32;
            let tan_squared = alpha * alpha * share / (1.0 - share);
            let cos_half_squared = 1.0 / (1.0 + tan_squared);
            let cosine = 2.0 * cos_half_squared - 1.0;
            if cosine <= 0.0 {
                continue;
            }
            let slope = alpha * alpha * cos_half_squared + (1.0 - cos_half_squared);
            let density = alpha * alpha / (4.0 * PI * slope * slope);
            samples.push(sample(index, cosine, 1.0 / (count as f32 * density)));
        }
        Self::new(cells, samples)
    }

    fn new(cells: usize, mut samples: Vec<Sample>) -> Self {
        let total: f32 = samples.iter().map(|sample| sample.weight).sum();
        for sample in &mut samples {
            sample.weight /= total;
        }
        Self { cells, samples }
    }

    /// Mean under the lobe around an axis of a radiance that is asked for around a direction, over a square of a width.
    pub(super) fn mean(&self, axis: Vec3, radiance: impl Fn(Vec3, f32) -> Vec3) -> Vec3 {
        let (east, north) = axis.any_orthonormal_pair();
        let mut sum = Vec3::ZERO;
        for Sample { direction, weight, width } in &self.samples {
            let towards = east * direction.x + north * direction.y + axis * direction.z;
            sum += radiance(towards, *width) * *weight;
        }
        sum
    }
}

/// A sample at an angle from +Z of the given cosine.
fn sample(index: u32, cosine: f32, solid_angle: f32) -> Sample {
    let (sin_azimuth, cos_azimuth) = libm::sincosf(index as f32 * GOLDEN_ANGLE);
    let sine = (1.0 - cosine * cosine).sqrt();
    // Squares of the samples' own solid angles just touch; beyond one they would leave the tangent plane.
    let width = if solid_angle < 1.0 { solid_angle.sqrt() } else { 1.0 };
    let direction = Vec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine);
    Sample { direction, weight: cosine, width }
}

/// Means for all normals of a radiance that is asked for around a direction, over a square of a width: by a weight of the cosine, times `total`.
pub(super) fn mean_image(
    radiance: impl Fn(Vec3, f32) -> Vec3,
    weight: fn(f64) -> f64,
    total: f32,
) -> OctahedralImage {
    const CELLS: usize = 24;
    const COUNT: u32 = 1024;
    let width = (4.0 * PI / COUNT as f32).sqrt();
    let seen: Vec<(Vec3, Vec3)> = (0..COUNT)
        .map(|index| {
            let direction = spiral_direction(index, COUNT);
            (direction, radiance(direction, width))
        })
        .collect();
    OctahedralImage::new(CELLS, |normal| {
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for (direction, radiance) in &seen {
            let cosine = normal.dot(*direction);
            if cosine > 0.0 {
                let weight = weight(f64::from(cosine)) as f32;
                sum += *radiance * weight;
                weights += weight;
            }
        }
        // Uniform light is exact.
        sum * (total / weights)
    })
}
