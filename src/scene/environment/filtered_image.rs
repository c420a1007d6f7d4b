//! Equirectangular image with mip levels, filtered over ray differentials.
//!
//! Lookups are anisotropic, as those of textures. The short axis of the ellipse that the differentials span selects the mip
//! levels; each level is half as wide and high as the one before, and the blend of two is linear over half of the interval
//! between them. Several probes along the long axis cover the rest. A texel of a level is the mean over its solid angle.
//! Widths are angles, compared with the height of a row.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::equirect::{EquirectImage, uv_from_direction};
use crate::scene::{MAX_PROBES, PROBE_SPACING, blended, level_of};

/// An equirectangular image with its mip levels.
#[derive(Debug)]
pub(super) struct FilteredImage {
    /// The full image is the first.
    levels: Vec<EquirectImage>,
}

impl FilteredImage {
    pub(super) fn new(image: EquirectImage) -> Self {
        let mut levels = vec![image];
        while let Some(last) = levels.last()
            && last.height > 1
            && last.width > 1
        {
            let smaller = last.resampled(last.width / 2, last.height / 2);
            levels.push(smaller);
        }
        Self { levels }
    }

    /// The full image.
    pub(super) fn image(&self) -> &EquirectImage {
        &self.levels[0]
    }

    /// Mean radiance over the parallelogram around a unit direction that the `differentials` span.
    pub(super) fn radiance(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        self.radiance_around(uv_from_direction(direction), direction, differentials)
    }

    /// [`FilteredImage::radiance`] around a direction whose image coordinates are known.
    #[inline]
    pub(super) fn radiance_around(&self, uv: Vec2, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        let full = self.image();
        let row = PI / full.height as f32;
        let [a, b] = differentials;
        let (aa, bb, ab) = (a.dot(a), b.dot(b), a.dot(b));
        // The squares of both axes of the ellipse have the same sum.
        if aa + bb <= row * row {
            return full.bilinear(uv);
        }
        let half_difference = (aa - bb) * 0.5;
        let root = libm::sqrtf(half_difference * half_difference + ab * ab);
        let long = libm::sqrtf((aa + bb) * 0.5 + root);
        // A half-space and more, or not a number.
        if !long.is_finite() || long >= PI {
            return self.trilinear(uv, f32::INFINITY);
        }
        let axis = if half_difference >= 0.0 {
            a * (half_difference + root) + b * ab
        } else {
            a * ab + b * (root - half_difference)
        };
        let short =
            larger(larger(a.cross(b).length() / long, long / (MAX_PROBES as f32 * PROBE_SPACING)), row);
        let count = libm::ceilf(long / (short * PROBE_SPACING) - 0.1);
        if count <= 1.0 {
            return self.trilinear(uv, short / row);
        }
        let along = axis.normalize_or_zero() * long;
        let mut sum = Vec3::ZERO;
        for index in 0..count as u32 {
            let towards = direction + along * ((index as f32 + 0.5) / count - 0.5);
            sum += self.trilinear(uv_from_direction(towards.normalize_or(direction)), short / row);
        }
        sum / count
    }

    /// Interpolates between the two levels whose row heights enclose `width`, in rows of the full image; at least one. In the outer quarters of the
    /// way from one level to the next it is one of them alone.
    fn trilinear(&self, uv: Vec2, width: f32) -> Vec3 {
        let (level, share) = level_of(width, self.levels.len() - 1);
        let (level, share) = blended(level, share);
        let sharper = self.levels[level].bilinear(uv);
        if share == 0.0 {
            return sharper;
        }
        sharper * (1.0 - share) + self.levels[level + 1].bilinear(uv) * share
    }
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(direction: Vec3, along: f32, across: f32) -> [Vec3; 2] {
        let (u, v) = direction.any_orthonormal_pair();
        // Neither differential lies on an axis of the ellipse.
        let (sin, cos) = libm::sincosf(0.4);
        [u * (along * cos) - v * (across * sin), u * (along * sin) + v * (across * cos)]
    }

    #[test]
    fn zero_differentials_read_the_full_image() {
        let filtered = FilteredImage::new(EquirectImage::of(64, |d| Vec3::new(1.0 + d.x, 1.0 + d.y, 2.0)));
        for direction in [Vec3::X, Vec3::new(0.48, 0.6, 0.64), Vec3::NEG_Y] {
            let plain = filtered.image().bilinear(uv_from_direction(direction));
            assert_eq!(filtered.radiance(direction, [Vec3::ZERO; 2]), plain);
        }
    }

    #[test]
    fn wide_differentials_agree_with_many_point_lookups() {
        // Noise: each texel differs from its neighbours, so that a single lookup says nothing about the mean.
        let mut image = EquirectImage::of(128, |_| Vec3::ZERO);
        for (index, pixel) in image.pixels.iter_mut().enumerate() {
            let noise = (index as u32).wrapping_mul(2654435761) >> 16 & 1;
            *pixel = [noise as f32 * 2.0, (index / 128) as f32 / 64.0, 1.0];
        }
        let filtered = FilteredImage::new(image);
        for direction in [Vec3::NEG_Z, Vec3::new(0.6, 0.48, 0.64), Vec3::new(0.0, -0.6, 0.8)] {
            for (along, across) in [(0.5, 0.5), (1.0, 0.1), (0.2, 0.4)] {
                let steps = span(direction, along, across);
                let mut mean = Vec3::ZERO;
                for index in 0..10_000 {
                    let offset = |index: i32| (index as f32 + 0.5) / 100.0 - 0.5;
                    let towards = direction + steps[0] * offset(index % 100) + steps[1] * offset(index / 100);
                    mean += filtered.image().bilinear(uv_from_direction(towards.normalize())) / 10_000.0;
                }
                let found = filtered.radiance(direction, steps);
                // Noise of standard deviation 1 over some 60 independent texels and more; tents are wider than boxes.
                assert!(
                    (found - mean).abs().max_element() < 0.2,
                    "{direction} {along} {across}: {found} {mean}"
                );
                assert!((found.y - mean.y).abs() < 0.02 && (found.z - 1.0).abs() < 1e-4, "{found} {mean}");
            }
        }
    }

    #[test]
    fn infinite_and_undefined_differentials_give_the_mean_of_all() {
        let filtered = FilteredImage::new(EquirectImage::of(64, |d| Vec3::splat(1.0 + d.y)));
        for length in [f32::INFINITY, f32::NAN, 1e30] {
            let seen = filtered.radiance(Vec3::X, [Vec3::splat(length), Vec3::Y]);
            assert!((seen - Vec3::ONE).abs().max_element() < 0.05, "{length}: {seen}");
        }
    }
}
