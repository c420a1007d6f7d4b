//! Peaks of an environment image: its sun and its small lamps, which become directional lights with exact shadows.
//!
//! A peak is a connected region of texels, around the brightest one, with at least 1/16 of its luminance. It counts where it is smaller
//! than a disk 10° wide, no wider than about that, and brings at least 2 % of the image's light: tubes, rings and bright horizons have no
//! one direction. Its light beyond that of the texels around it is taken out of the image; the same irradiance comes from one direction instead.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::KeyLight;
use super::equirect::{EquirectImage, direction_from_uv};
use crate::color::luminance;

/// Most peaks of an image.
const MOST_PEAKS: usize = 8;
/// Regions that are looked at.
const MOST_REGIONS: usize = 32;
/// Least luminance in a region over that of its brightest texel.
const LEAST_SHARE: f32 = 1.0 / 16.0;
/// Largest solid angle of a peak, steradians: a disk of 10°.
const MOST_SOLID_ANGLE: f64 = 0.0239;
/// Least length of the mean direction of a peak's light: a disk of 10° has 0.998, a tube of 17° as little as this.
const LEAST_MEAN_DIRECTION: f64 = 0.996;
/// Least part of a peak in the light of the whole image.
const LEAST_LIGHT: f64 = 0.02;

/// The peaks of an image, brightest first, and the image without them where there are any.
pub(super) fn take_peaks(image: &EquirectImage) -> (Vec<KeyLight>, Option<EquirectImage>) {
    let grid = Grid::new(image);
    let least_light = LEAST_LIGHT * grid.light(image);
    let mut peaks = Vec::new();
    let mut without: Option<EquirectImage> = None;
    let mut seen = vec![false; image.pixels.len()];
    for _ in 0..MOST_REGIONS {
        // A halo that is left around a peak is looked at without it.
        let current = without.as_ref().unwrap_or(image);
        let Some((brightest, texel)) = grid.brightest(current, &seen) else { break };
        // No region that is left can bring enough light.
        if peaks.len() == MOST_PEAKS || f64::from(brightest) * MOST_SOLID_ANGLE <= least_light {
            break;
        }
        let region = grid.region(current, texel, &mut seen);
        if let Some(peak) = grid.peak(current, &region).filter(|peak| peak.light >= least_light) {
            let reduced = without.get_or_insert_with(|| image.clone());
            for &texel in &region.texels {
                let pixel = &mut reduced.pixels[texel as usize];
                *pixel = std::array::from_fn(|channel| pixel[channel].min(peak.around[channel]));
            }
            peaks.push(peak.key);
        }
    }
    (peaks, without)
}

/// Texels and their neighbours.
struct Grid {
    width: u32,
    height: u32,
}

/// Connected texels.
struct Region {
    texels: Vec<u32>,
    /// Texels next to them.
    border: BTreeSet<u32>,
    /// Whether it is no larger than a peak.
    is_small: bool,
}

/// A peak, and what the image shows in its place.
struct Peak {
    key: KeyLight,
    /// Luminance times solid angle.
    light: f64,
    /// Radiance of the texels around it.
    around: [f32; 3],
}

impl Grid {
    fn new(image: &EquirectImage) -> Self {
        Self { width: image.width as u32, height: image.height as u32 }
    }

    /// Luminance and index of the brightest texel that was not seen; of equal ones the first.
    fn brightest(&self, image: &EquirectImage, seen: &[bool]) -> Option<(f32, u32)> {
        let rows = image.pixels.par_chunks(image.width.max(1)).zip(0..self.height);
        let of_row = |(row, y): (&[[f32; 3]], u32)| {
            let mut best: Option<(f32, u32)> = None;
            for (&pixel, texel) in row.iter().zip(y * self.width..) {
                let light = luminance(Vec3::from(pixel));
                if best.is_none_or(|(most, _)| light > most) && !seen[texel as usize] {
                    best = Some((light, texel));
                }
            }
            best
        };
        let brightest: Vec<_> = rows.map(of_row).collect();
        brightest.into_iter().flatten().reduce(|best, other| if other.0 > best.0 { other } else { best })
    }

    /// Solid angle of a texel, steradians.
    fn solid_angle(&self, texel: u32) -> f64 {
        let edge = |row: u32| libm::cos(PI * f64::from(row) / f64::from(self.height));
        let row = texel / self.width;
        2.0 * PI / f64::from(self.width) * (edge(row) - edge(row + 1))
    }

    /// Luminance of the image, integrated over all directions.
    fn light(&self, image: &EquirectImage) -> f64 {
        let rows = image.pixels.par_chunks_exact(image.width).zip(0..self.height);
        let lights: Vec<f64> = rows
            .map(|(row, y)| {
                let sum: f64 = row.iter().map(|&pixel| f64::from(luminance(Vec3::from(pixel)))).sum();
                sum * self.solid_angle(y * self.width)
            })
            .collect();
        lights.into_iter().sum()
    }

    /// Texels that share an edge with one. The left and the right edge of the image coincide.
    fn neighbours(&self, texel: u32) -> impl Iterator<Item = u32> {
        let (column, row) = (texel % self.width, texel / self.width);
        let left = row * self.width + (column + self.width - 1) % self.width;
        let right = row * self.width + (column + 1) % self.width;
        let above = (row > 0).then(|| texel - self.width);
        let below = (row + 1 < self.height).then(|| texel + self.width);
        [Some(left), Some(right), above, below].into_iter().flatten()
    }

    /// The region around its brightest texel, whose texels are marked as seen. Of one that is too large to be a peak the rest is only marked.
    fn region(&self, image: &EquirectImage, brightest: u32, seen: &mut [bool]) -> Region {
        let brightness = |texel: u32| luminance(Vec3::from(image.pixels[texel as usize]));
        let least = brightness(brightest) * LEAST_SHARE;
        let mut region = Region { texels: Vec::new(), border: BTreeSet::new(), is_small: true };
        let mut solid_angle = 0.0;
        let mut pending = vec![brightest];
        seen[brightest as usize] = true;
        while let Some(texel) = pending.pop() {
            solid_angle += self.solid_angle(texel);
            region.is_small = solid_angle <= MOST_SOLID_ANGLE;
            if region.is_small {
                region.texels.push(texel);
            }
            for neighbour in self.neighbours(texel) {
                if brightness(neighbour) >= least {
                    if !std::mem::replace(&mut seen[neighbour as usize], true) {
                        pending.push(neighbour);
                    }
                } else if region.is_small {
                    region.border.insert(neighbour);
                }
            }
        }
        // The order in which texels are summed
        region.texels.sort_unstable();
        region
    }

    /// The light of a region beyond that of its border; `None` for one that is too large, too long or not brighter.
    fn peak(&self, image: &EquirectImage, region: &Region) -> Option<Peak> {
        if !region.is_small || region.border.is_empty() {
            return None;
        }
        let pixel = |texel: &u32| image.pixels[*texel as usize];
        let around: [f32; 3] = std::array::from_fn(|channel| {
            let sum: f64 = region.border.iter().map(|texel| f64::from(pixel(texel)[channel])).sum();
            (sum / region.border.len() as f64) as f32
        });
        let (mut irradiance, mut toward, mut light) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for texel in &region.texels {
            let beyond = Vec3::from(pixel(texel)) - Vec3::from(around);
            let beyond = beyond.max(Vec3::ZERO);
            let solid_angle = self.solid_angle(*texel);
            let texel_light = f64::from(luminance(beyond)) * solid_angle;
            let (column, row) = (*texel % self.width, *texel / self.width);
            let (width, height) = (self.width as f32, self.height as f32);
            let uv = Vec2::new((column as f32 + 0.5) / width, (row as f32 + 0.5) / height);
            irradiance += beyond.as_dvec3() * solid_angle;
            toward += direction_from_uv(uv).as_dvec3() * texel_light;
            light += texel_light;
        }
        if toward.length() < LEAST_MEAN_DIRECTION * light {
            return None;
        }
        let direction_to_light = toward.try_normalize()?.as_vec3().normalize();
        let key = KeyLight { direction_to_light, irradiance: irradiance.as_vec3() };
        Some(Peak { key, light, around })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(direction: Vec3) -> Vec3 {
        Vec3::new(0.2, 0.3, 0.5) * (1.0 + direction.y)
    }

    /// A sky with a disk of `radius_degrees` around `toward`.
    fn with_disk(toward: Vec3, radius_degrees: f32, radiance: f32) -> EquirectImage {
        let cosine = libm::cosf(radius_degrees.to_radians());
        EquirectImage::of(512, move |direction| {
            sky(direction) + if direction.dot(toward) > cosine { Vec3::splat(radiance) } else { Vec3::ZERO }
        })
    }

    #[test]
    fn a_sun_becomes_a_light_of_the_same_irradiance() {
        // Also over the edge of the image, +Z, and near a pole.
        for toward in [Vec3::new(0.36, 0.48, -0.8), Vec3::new(0.0, 0.6, 0.8), Vec3::new(0.0995, 0.99, 0.0995)]
        {
            let toward = toward.normalize();
            let image = with_disk(toward, 2.0, 5000.0);
            let before = Grid::new(&image).light(&image);
            let (peaks, without) = take_peaks(&image);
            let image = without.unwrap();
            assert_eq!(peaks.len(), 1, "{toward}");
            let peak = peaks[0];
            assert!(peak.direction_to_light.dot(toward) > libm::cosf(0.004), "{peak:?}");
            // 5000 over π sin² 2°, as far as texels 0.7° wide show a disk.
            assert!((peak.irradiance.x / 19.13 - 1.0).abs() < 0.06, "{peak:?}");
            let after = Grid::new(&image).light(&image) + f64::from(luminance(peak.irradiance));
            assert!((after / before - 1.0).abs() < 1e-4, "{before} {after}");
            let brightest = image.pixels.iter().flatten().copied().fold(0.0, f32::max);
            assert!(brightest <= 1.01, "{brightest}");
        }
    }

    #[test]
    fn a_sun_in_a_halo_counts_once() {
        let toward = Vec3::new(0.36, 0.48, -0.8);
        let image = EquirectImage::of(512, |direction| {
            let degrees = libm::acosf(direction.dot(toward).min(1.0)).to_degrees();
            // 100 times darker every degree beyond the disk
            let halo = 5000.0 * libm::powf(100.0, (1.0 - degrees).min(0.0));
            sky(direction) + Vec3::splat(halo)
        });
        let (peaks, without) = take_peaks(&image);
        let taken: f32 = peaks.iter().map(|peak| luminance(peak.irradiance)).sum();
        let grid = Grid::new(&image);
        let (before, after) = (grid.light(&image), grid.light(&without.unwrap()));
        assert!(((after + f64::from(taken)) / before - 1.0).abs() < 1e-4, "{before} {after} {taken}");
    }

    #[test]
    fn large_and_faint_lights_stay() {
        let up = Vec3::new(0.0, 0.6, 0.8);
        let dark = EquirectImage::of(16, |_| Vec3::ZERO);
        for image in [with_disk(up, 8.0, 5000.0), with_disk(up, 1.0, 10.0), EquirectImage::of(64, sky), dark]
        {
            let (peaks, without) = take_peaks(&image);
            assert!(peaks.is_empty() && without.is_none());
        }
    }

    #[test]
    fn long_thin_lights_stay() {
        // Tubes 0.7° thick and 120° or 20° long, a ring around the zenith, and a line around the horizon, whose directions cancel
        let tube = |d: Vec3, degrees: f32| {
            d.x.abs() < 0.006 && d.z < 0.0 && d.y.abs() < libm::sinf(degrees.to_radians())
        };
        let shapes: [&dyn Fn(Vec3) -> bool; 4] =
            [&|d| tube(d, 60.0), &|d| tube(d, 10.0), &|d| (d.y - 0.9).abs() < 0.002, &|d| d.y.abs() < 0.003];
        for (index, shape) in shapes.iter().enumerate() {
            let image = EquirectImage::of(1024, |d| if shape(d) { Vec3::splat(500.0) } else { sky(d) });
            let (peaks, without) = take_peaks(&image);
            assert!(peaks.is_empty() && without.is_none(), "{index}: {peaks:?}");
        }
    }

    #[test]
    fn several_lamps_become_lights_brightest_first() {
        let (first, second) = (Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.6, 0.64, 0.48));
        let disk = |direction: Vec3, toward: Vec3| direction.dot(toward) > libm::cosf(0.04);
        let image = EquirectImage::of(512, |direction| {
            let lamps = [(first, 900.0), (second, 500.0)];
            let light: f32 =
                lamps.iter().map(|&(toward, light)| if disk(direction, toward) { light } else { 0.0 }).sum();
            sky(direction) + Vec3::splat(light)
        });
        let (peaks, _) = take_peaks(&image);
        let found: Vec<_> = peaks.iter().map(|peak| peak.direction_to_light).collect();
        assert_eq!(found.len(), 2);
        assert!(found[0].dot(first) > 0.9999 && found[1].dot(second) > 0.9999, "{found:?}");
    }
}
