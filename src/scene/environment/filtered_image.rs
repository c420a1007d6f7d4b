//! Equirectangular image with mip levels, filtered over ray differentials.
//!
//! Lookups are anisotropic, as those of textures. The short axis of the ellipse that the differentials span selects the mip
//! levels; each level is half as wide and high as the one before, and the blend of two is linear over half of the interval
//! between them. Several probes along the long axis cover the rest. A texel of a level is the mean over its solid angle.
//! Widths are angles, compared with the height of a row.

use std::f32::consts::PI;

use fearless_simd::Level;
use glam::{Vec2, Vec3};

use super::equirect::{EquirectImage, uv_from_direction, uvs_from_directions};
use super::lookup_lanes::LookupLanes;
use super::probe_line::{ProbeLine, ProbeLines};
use crate::geometry::{ActiveLanes, LANES, Vec2Lanes, Vec3Lanes, vectorized};
use crate::scene::{blended, level_of};

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

    /// Height of a row of the full image in radians.
    fn row(&self) -> f32 {
        PI / self.image().height as f32
    }

    /// Mean radiance over the parallelogram around a unit direction that the `differentials` span.
    pub(super) fn radiance(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        let probe_line = ProbeLine::new(self.row(), differentials);
        if probe_line.probes <= 1.0 {
            return self.trilinear(uv_from_direction(direction), probe_line.width);
        }
        let mut sum = Vec3::ZERO;
        for index in 0..probe_line.probes as u32 {
            let towards = probe_line.probe(direction, index).normalize_or(direction);
            sum += self.trilinear(uv_from_direction(towards), probe_line.width);
        }
        sum / probe_line.probes
    }

    /// [`FilteredImage::radiance`] of the directions of a block, whose image coordinates are known.
    pub(super) fn radiances(
        &self,
        lookups: &LookupLanes<'_>,
        uvs: &Vec2Lanes,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        let LookupLanes { level, directions, lanes } = *lookups;
        let mut lines = ProbeLines::default();
        lines.fill(level, self.row(), differentials);
        let mut probes = ProbeBlock::default();
        for lane in lanes {
            let probe_line = lines.get(lane);
            if probe_line.probes <= 1.0 {
                out.set(lane, self.trilinear(uvs.get(lane), probe_line.width));
                continue;
            }
            out.set(lane, Vec3::ZERO);
            for index in 0..probe_line.probes as u32 {
                if probes.count == LANES {
                    self.add_probes(level, &mut probes, &lines, out);
                }
                let direction = directions.get(lane);
                probes.push(lane, direction, probe_line.probe(direction, index));
            }
        }
        self.add_probes(level, &mut probes, &lines, out);
        for lane in lanes {
            let ProbeLine { probes, .. } = lines.get(lane);
            if probes > 1.0 {
                out.set(lane, out.get(lane) / probes);
            }
        }
    }

    /// Adds the radiance of probes to the sums of their lookups, and removes them.
    fn add_probes(&self, level: Level, probes: &mut ProbeBlock, lines: &ProbeLines, sums: &mut Vec3Lanes) {
        let ProbeBlock { lookups, centers, towards, count } = probes;
        let mut uvs = Vec2Lanes::default();
        vectorized!(level, {
            for lane in 0..LANES {
                towards.set(lane, towards.get(lane).normalize_or(centers.get(lane)));
            }
        });
        let lanes = ActiveLanes::first(*count);
        uvs_from_directions(level, towards, lanes, &mut uvs);
        for lane in lanes {
            let lookup = lookups[lane];
            let seen = self.trilinear(uvs.get(lane), lines.get(lookup).width);
            sums.set(lookup, sums.get(lookup) + seen);
        }
        *count = 0;
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

/// Probes of several lookups, in their order.
#[derive(Default)]
struct ProbeBlock {
    /// The lanes of their lookups.
    lookups: [usize; LANES],
    /// The directions of their lookups.
    centers: Vec3Lanes,
    /// Where they lie.
    towards: Vec3Lanes,
    count: usize,
}

impl ProbeBlock {
    #[inline(always)]
    fn push(&mut self, lookup: usize, center: Vec3, towards: Vec3) {
        self.lookups[self.count] = lookup;
        self.centers.set(self.count, center);
        self.towards.set(self.count, towards);
        self.count += 1;
    }
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
