//! Prefiltered environment maps: means of an equirectangular image under GGX lobes of increasing roughness.
//!
//! Source: Karis, "Real Shading in Unreal Engine 4" (SIGGRAPH 2013 course), section "Pre-Filtered Environment Map". The
//! view is assumed along the normal, and each sample is weighted by its cosine; roughness 1 has another view ([`roughest_weight`]). A sample of more solid angle reads a coarser
//! pyramid level, which removes noise (Křivánek and Colbert, "Real-time Shading with Filtered Importance Sampling", 2008,
//! section 4). The sample points are a fixed Hammersley set, the same for every texel.

use std::f32::consts::PI;

use fearless_simd::Level;
use glam::Vec3;
use rayon::prelude::*;

use super::equirect::{EquirectImage, direction_from_uv, uvs_from_directions};
use super::irradiance::mean_image;
use super::lobe_level::{LobeLevel, LobeSums, RUN};
use crate::geometry::{ActiveLanes, LANES, Vec2Lanes, Vec3Lanes, vectorized};

/// Steps of roughness from 0 (the radiance itself, which is not stored here) to 1, for images and built-in lights.
pub(super) const STEPS: usize = 8;

/// Cosine of the view for which lobes of roughness 1 are averaged. Those have no direction but the normal, so that a common view can stand for all:
/// seen from farther aside, more of their light comes from near the horizon.
const ROUGHEST_VIEW: f64 = 0.6;

/// Weight of light in the lobe of roughness 1 by its cosine: facets face all ways alike, so that masking and shadowing alone shape it (Heitz 2014,
/// equation 99).
pub(super) fn roughest_weight(cosine: f64) -> f64 {
    cosine / (cosine + ROUGHEST_VIEW)
}

/// Image pyramid of power-of-two grids with an aspect ratio of 2:1, each half as wide as the one before.
pub(super) struct Pyramid {
    levels: Vec<EquirectImage>,
}

impl Pyramid {
    /// Starts at 1024 columns, or at the power of two below the image's width if that is less, but at no fewer than 64.
    pub(super) fn new(image: &EquirectImage) -> Self {
        let mut width = (image.width / 2 + 1).next_power_of_two().clamp(64, 1024);
        let mut levels = vec![image.resampled(width, width / 2)];
        while width > RUN {
            width /= 2;
            let next = levels[levels.len() - 1].resampled(width, width / 2);
            levels.push(next);
        }
        Self { levels }
    }

    /// The largest level that is at most `width` wide.
    pub(super) fn at_most(&self, width: usize) -> &EquirectImage {
        let last = &self.levels[self.levels.len() - 1];
        self.levels.iter().find(|level| level.width <= width).unwrap_or(last)
    }

    /// The level whose texels at the equator cover `solid_angle`.
    fn level_of(&self, solid_angle: f32) -> f32 {
        let finest = &self.levels[0];
        let texel = 2.0 * PI * PI / (finest.width * finest.height) as f32;
        let level = 0.5 * libm::log2f(solid_angle / texel);
        level.clamp(0.0, (self.levels.len() - 1) as f32)
    }
}

/// One direction of a lobe around +Z, with its weight in the mean and the pyramid level that covers its solid angle.
struct LobeSample {
    direction: Vec3,
    weight: f32,
    level: f32,
}

/// The directions of a lobe, and the width of the image of its means.
struct Lobe {
    width: usize,
    samples: Vec<LobeSample>,
}

/// Means of the image under lobes of roughness 1/8, 2/8, … 1.
pub(super) fn prefiltered_images(pyramid: &Pyramid) -> Vec<EquirectImage> {
    let lobes: Vec<Lobe> = (1..STEPS)
        .map(|step| {
            // Narrow lobes need more texels and fewer samples for the same quality.
            let (width, samples) = match step {
                1 => (256, 64),
                2 => (128, 256),
                _ => (64, 512),
            };
            let roughness = step as f32 / STEPS as f32;
            Lobe { width, samples: lobe_samples(pyramid, roughness * roughness, samples) }
        })
        .collect();
    // Large images have levels that are finer than any lobe needs.
    let samples = lobes.iter().flat_map(|lobe| &lobe.samples);
    let finest = samples.map(|sample| sample.level as usize).min().unwrap_or_default();
    let levels: Vec<LobeLevel> = pyramid.levels[finest..].iter().map(LobeLevel::new).collect();
    let narrow = lobes.iter().map(|lobe| lobe_image((&levels, finest), lobe, Level::new()));
    // Light at the horizon, where samples would be blurred, has much of the last one.
    narrow.chain([mean_image(pyramid.at_most(256), roughest_weight)]).collect()
}

fn lobe_samples(pyramid: &Pyramid, alpha: f32, count: u32) -> Vec<LobeSample> {
    let mut samples = Vec::new();
    for index in 0..count {
        // Half vectors with density D cos θ_h: tan² θ_h = α² ξ / (1 − ξ) (Walter et al. 2007, equation 35).
        let share = (index as f32 + 0.5) / count as f32;
        let tan_squared = alpha * alpha * share / (1.0 - share);
        let cos_half = 1.0 / (1.0 + tan_squared).sqrt();
        let sin_half = cos_half * tan_squared.sqrt();
        // Reflecting the view along +Z at the half vector gives this direction.
        let cosine = 2.0 * cos_half * cos_half - 1.0;
        if cosine <= 0.0 {
            continue;
        }
        let (sin_azimuth, cos_azimuth) = libm::sincosf(2.0 * PI * radical_inverse(index));
        let sine = 2.0 * cos_half * sin_half;
        let slope = alpha * alpha * cos_half * cos_half + sin_half * sin_half;
        let density = alpha * alpha / (4.0 * PI * slope * slope);
        samples.push(LobeSample {
            direction: Vec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine),
            weight: cosine,
            // Twice the width of the sample's own solid angle overlaps adjacent samples smoothly.
            level: pyramid.level_of(4.0 / (count as f32 * density)),
        });
    }
    let total: f32 = samples.iter().map(|sample| sample.weight).sum();
    for sample in &mut samples {
        sample.weight /= total;
    }
    samples
}

/// Van der Corput's sequence in base 2.
fn radical_inverse(index: u32) -> f32 {
    (index.reverse_bits() >> 8) as f32 / (1_u32 << 24) as f32
}

/// The means under a lobe around every direction. `levels` begin with the one of the number behind them.
fn lobe_image(levels: (&[LobeLevel], usize), lobe: &Lobe, simd: Level) -> EquirectImage {
    let width = lobe.width;
    let mut image = EquirectImage { width, height: width / 2, pixels: Vec::new() };
    image.pixels = (0..width / 2)
        .into_par_iter()
        .flat_map_iter(|row| {
            let direction = direction_from_uv(image.texel_uv(0, row));
            let mut sums = LobeSums::zeros(width);
            add_lobe(levels, direction, &lobe.samples, simd, &mut sums);
            sums.into_row()
        })
        .collect();
    image
}

/// Adds the means under the lobes of a row, the first of which looks along `direction`.
fn add_lobe(
    (levels, finest): (&[LobeLevel], usize),
    direction: Vec3,
    samples: &[LobeSample],
    simd: Level,
    sums: &mut LobeSums,
) {
    // Texel centres are never at the poles; a frame that follows the grid leaves no seam elsewhere. It also gives all texels of a row the
    // same lobe, moved along the rows of the levels.
    let east = Vec3::new(-direction.z, 0.0, direction.x).normalize();
    let north = east.cross(direction);
    for samples in samples.chunks(LANES) {
        let (mut towards, mut uvs) = (Vec3Lanes::default(), Vec2Lanes::default());
        for (lane, LobeSample { direction: local, .. }) in samples.iter().enumerate() {
            towards.set(lane, east * local.x + north * local.y + direction * local.z);
        }
        uvs_from_directions(simd, &towards, ActiveLanes::first(samples.len()), &mut uvs);
        vectorized!(simd, {
            for (lane, sample) in samples.iter().enumerate() {
                let finer = sample.level as usize;
                let share = sample.level - finer as f32;
                let levels = &levels[finer - finest..];
                levels[0].add(uvs.get(lane), sample.weight * (1.0 - share), sums);
                if share > 0.0
                    && let Some(level) = levels.get(1)
                {
                    level.add(uvs.get(lane), sample.weight * share, sums);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference implementation: every texel of the image, weighted by D(h) cos θ_l and its solid angle. With the view along the
    /// normal the density of mirrored directions is D / 4, and cos² θ_h = (1 + cos θ_l) / 2.
    fn mean_by_quadrature(image: &EquirectImage, direction: Vec3, alpha: f32) -> Vec3 {
        let (mut sum, mut total) = (glam::DVec3::ZERO, 0.0_f64);
        for row in 0..image.height {
            let polar = |index: usize| index as f64 / image.height as f64 * std::f64::consts::PI;
            let band = libm::cos(polar(row)) - libm::cos(polar(row + 1));
            for column in 0..image.width {
                let towards = direction_from_uv(image.texel_uv(column, row)).as_dvec3();
                let cosine = towards.dot(direction.as_dvec3());
                if cosine <= 0.0 {
                    continue;
                }
                let cos_half_squared = f64::midpoint(1.0, cosine);
                let a2 = f64::from(alpha * alpha);
                let slope = cos_half_squared * (a2 - 1.0) + 1.0;
                let weight =
                    if alpha < 1.0 { a2 / (slope * slope) * cosine } else { roughest_weight(cosine) } * band;
                sum += glam::Vec3::from_array(image.pixels[row * image.width + column]).as_dvec3() * weight;
                total += weight;
            }
        }
        (sum / total).as_vec3()
    }

    #[test]
    fn images_do_not_depend_on_the_instruction_set() {
        let pyramid = Pyramid::new(&EquirectImage::of(128, |d| Vec3::new(1.0 + d.x, 1.0 + d.y * d.z, 2.0)));
        let levels: Vec<LobeLevel> = pyramid.levels.iter().map(LobeLevel::new).collect();
        for (width, samples) in [(64, 100), (256, 40)] {
            let lobe = Lobe { width, samples: lobe_samples(&pyramid, 0.2, samples) };
            let [plain, widest] =
                [Level::fallback(), Level::new()].map(|simd| lobe_image((&levels, 0), &lobe, simd).pixels);
            assert!(plain == widest, "{width}");
        }
    }

    #[test]
    fn uniform_light_is_unchanged() {
        let pyramid = Pyramid::new(&EquirectImage::of(64, |_| Vec3::new(1.0, 0.5, 0.0)));
        for image in prefiltered_images(&pyramid) {
            for pixel in &image.pixels {
                assert!((Vec3::from_array(*pixel) - Vec3::new(1.0, 0.5, 0.0)).abs().max_element() < 1e-5);
            }
        }
    }

    #[test]
    fn lobes_agree_with_quadrature() {
        let sun = Vec3::new(0.4, 0.7, -0.6).normalize();
        let source = EquirectImage::of(256, |d| {
            let glow = libm::expf(60.0 * (d.dot(sun) - 1.0)) * 20.0;
            Vec3::new(glow + 0.2, if d.y > 0.0 { 1.0 } else { 0.1 }, 1.0 + d.x)
        });
        let pyramid = Pyramid::new(&source);
        for (index, image) in prefiltered_images(&pyramid).iter().enumerate() {
            let roughness = (index + 1) as f32 / STEPS as f32;
            for texel in 0..40 {
                let (column, row) = (texel * 13 % image.width, (texel * 29 + 3) % image.height);
                let direction = direction_from_uv(image.texel_uv(column, row));
                let expected = mean_by_quadrature(&source, direction, roughness * roughness);
                let found = Vec3::from_array(image.pixels[row * image.width + column]);
                // Peaks: glow 20, horizon step 1, slope 1. The filter's own width shows most beside the step.
                let error = (found - expected).abs() / Vec3::new(20.0, 1.0, 1.0);
                assert!(error.max_element() < 0.03, "{roughness} {direction}: {found} for {expected}");
            }
        }
    }
}
