//! The likely cause of a difference between two images, inferred from their layers, or from the colours alone.
//!
//! An estimate for people, by rules in this order: displacement of the whole image, layers of geometry, layers of materials, noise,
//! light. An object that moves alone before a uniform background is taken for a camera that moves.

use serde::Serialize;

use super::shift::best_shift;
use super::{Image, LayerDifference};
use crate::color::luminance;

/// Share of the squared differences that a displacement must explain.
const EXPLAINED_BY_SHIFT: f64 = 0.6;
/// Smallest displacement that counts as a camera move, pixels.
const LEAST_SHIFT: f64 = 0.05;
/// Share of the squared differences that a factor on light must explain.
const EXPLAINED_BY_LIGHT: f64 = 0.6;
/// Largest correlation of adjacent differences in noise.
const LARGEST_CORRELATION: f64 = 0.3;
/// Smallest share of pixels that differ through noise.
const LEAST_NOISE: f64 = 0.1;

/// Layers of geometry, the most telling first.
const GEOMETRY: [&str; 7] =
    ["object_id", "node_id", "depth", "position", "geometric_normal", "crypto_object", "motion"];
/// Layers of materials. Shading normals belong here because of normal maps; geometry is examined first.
const MATERIAL: [&str; 5] = ["material_id", "albedo", "normal", "uv", "crypto_material"];

/// The likely cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Cause {
    /// The whole image is displaced.
    Camera {
        /// Pixels to the right.
        right: f64,
        /// Pixels downwards.
        down: f64,
    },
    /// Objects moved, appeared, disappeared or changed shape.
    Geometry {
        /// The layer that differs.
        layer: String,
        /// Number of pixels that differ.
        pixels: usize,
    },
    /// Materials of surfaces changed.
    Material {
        /// The layer that differs.
        layer: String,
        /// Number of pixels that differ.
        pixels: usize,
    },
    /// Lighting changed, or reflection properties that no layer holds.
    Light {
        /// Factors on red, green and blue, where they explain the difference.
        factors: Option<[f64; 3]>,
    },
    /// Geometry is equal; without an albedo layer, colour and light cannot be told apart.
    MaterialOrLight,
    /// Unstructured differences.
    Noise,
    /// There are no layers from which to infer a cause.
    Unclear {
        /// Share of pixels whose brightness differs.
        share: f64,
    },
}

impl std::fmt::Display for Cause {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Camera { right, down } => {
                let (x, y) =
                    (if *right < 0.0 { "left" } else { "right" }, if *down < 0.0 { "up" } else { "down" });
                write!(
                    formatter,
                    "camera: the whole image moved {:.2} pixels to the {x} and {:.2} {y}",
                    right.abs(),
                    down.abs()
                )
            }
            Self::Geometry { layer, pixels } => {
                write!(formatter, "geometry: {layer} differs in {}", pixels_text(*pixels))
            }
            Self::Material { layer, pixels } => {
                write!(formatter, "material: {layer} differs in {}", pixels_text(*pixels))
            }
            Self::Light { factors: Some([r, g, b]) } => {
                write!(formatter, "light: red times {r:.3}, green times {g:.3}, blue times {b:.3}")
            }
            Self::Light { factors: None } => {
                write!(
                    formatter,
                    "light: geometry and albedo are equal; lights, environment, roughness, metalness, emission or transmission changed"
                )
            }
            Self::MaterialOrLight => write!(
                formatter,
                "material or light: geometry is equal; an albedo layer would tell material from light"
            ),
            Self::Noise => write!(formatter, "noise: the differences are unstructured"),
            Self::Unclear { share } => {
                let percent = share * 100.0;
                write!(
                    formatter,
                    "unclear: {percent:.2} % of pixels differ in brightness; layers object_id, material_id and albedo would tell the cause"
                )
            }
        }
    }
}

fn pixels_text(count: usize) -> String {
    format!("{count} pixel{}", if count == 1 { "" } else { "s" })
}

/// The likely cause of the differences between two images of one size. `layers` are the layers of both images, with the numbers of
/// pixels that differ beyond the limits.
pub fn likely_cause(actual: &Image, reference: &Image, layers: &[LayerDifference]) -> Option<Cause> {
    let greys = [actual, reference].map(|image| image.colors().map(|colors| tone_mapped(&colors)));
    let [actual_grey, reference_grey] = &greys;
    if let (Some(actual), Some(grey)) = (actual_grey, reference_grey)
        && let Some(shift) = best_shift(actual, grey, reference.size())
        && shift.explained >= EXPLAINED_BY_SHIFT
        && shift.right.abs() + shift.down.abs() >= LEAST_SHIFT
    {
        return Some(Cause::Camera { right: shift.right, down: shift.down });
    }
    let differing = |names: &[&str]| {
        let found = names
            .iter()
            .find_map(|name| layers.iter().find(|layer| layer.layer == *name && layer.different_pixels > 0));
        found.map(|layer| (layer.layer.clone(), layer.different_pixels))
    };
    if let Some((layer, pixels)) = differing(&GEOMETRY) {
        return Some(Cause::Geometry { layer, pixels });
    }
    if let Some((layer, pixels)) = differing(&MATERIAL) {
        return Some(Cause::Material { layer, pixels });
    }
    let (Some(actual_grey), Some(reference_grey)) = (actual_grey, reference_grey) else { return None };
    let differences: Vec<f64> =
        actual_grey.iter().zip(reference_grey).map(|(a, b)| f64::from(*a) - f64::from(*b)).collect();
    if differences.iter().all(|&difference| difference == 0.0) {
        return None;
    }
    if is_noise(&differences, reference.size().0 as usize) {
        return Some(Cause::Noise);
    }
    let factors =
        light_factors(&actual.clone().into_linear().colors()?, &reference.clone().into_linear().colors()?);
    let has = |names: &[&str]| layers.iter().any(|layer| names.contains(&layer.layer.as_str()));
    let has_surfaces = has(&GEOMETRY) || has(&MATERIAL);
    // One factor on all colours suggests a light; a factor on each may as well be a material, without an albedo layer.
    let is_grey = factors.is_some_and(|[r, g, b]| (r / g - 1.0).abs() < 0.02 && (b / g - 1.0).abs() < 0.02);
    if has_surfaces && !has(&["albedo"]) && !is_grey {
        return Some(Cause::MaterialOrLight);
    }
    if factors.is_some() || has(&GEOMETRY) {
        return Some(Cause::Light { factors });
    }
    let different = differences.iter().filter(|difference| **difference != 0.0).count();
    Some(Cause::Unclear { share: different as f64 / differences.len() as f64 })
}

/// Tone-mapped luminance between 0 and 1. Values that are not finite become 0.
fn tone_mapped(colors: &[[f32; 3]]) -> Vec<f32> {
    let grey = |color: &[f32; 3]| {
        let light = luminance(glam::Vec3::from_array(*color));
        if light.is_finite() && light > 0.0 { (light / (1.0 + light)).sqrt() } else { 0.0 }
    };
    colors.iter().map(grey).collect()
}

/// Whether differences spread over the image, centre on zero and do not correlate with their neighbours.
fn is_noise(differences: &[f64], width: usize) -> bool {
    let square: f64 = differences.iter().map(|difference| difference * difference).sum();
    let sum: f64 = differences.iter().sum();
    let different = differences.iter().filter(|difference| **difference != 0.0).count();
    let correlation = |step: usize| {
        let products = differences.iter().zip(differences.iter().skip(step)).map(|(a, b)| a * b);
        products.sum::<f64>() / square
    };
    let is_spread = different as f64 >= LEAST_NOISE * differences.len() as f64;
    let is_centred = sum * sum <= 0.05 * square * differences.len() as f64;
    is_spread
        && is_centred
        && correlation(1).abs() <= LARGEST_CORRELATION
        && correlation(width).abs() <= LARGEST_CORRELATION
}

/// The factor on each colour with the least squared error, if the factors explain most of the difference.
fn light_factors(actual: &[[f32; 3]], reference: &[[f32; 3]]) -> Option<[f64; 3]> {
    let (mut cross, mut square, mut before, mut actual_square) = ([0.0; 3], [0.0; 3], 0.0, [0.0; 3]);
    for (ours, theirs) in actual.iter().zip(reference) {
        for channel in 0..3 {
            let (ours, theirs) = (f64::from(ours[channel]), f64::from(theirs[channel]));
            if ours.is_finite() && theirs.is_finite() {
                cross[channel] += ours * theirs;
                square[channel] += theirs * theirs;
                actual_square[channel] += ours * ours;
                before += (ours - theirs) * (ours - theirs);
            }
        }
    }
    let factors =
        [0, 1, 2].map(|channel| if square[channel] > 0.0 { cross[channel] / square[channel] } else { 1.0 });
    let after: f64 = (0..3).map(|channel| actual_square[channel] - factors[channel] * cross[channel]).sum();
    (before > 0.0 && after <= (1.0 - EXPLAINED_BY_LIGHT) * before).then_some(factors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{ColorEncoding, Samples};

    const SIZE: (u32, u32) = (64, 48);

    /// A smooth pattern, changed by a function of light and position.
    fn image(change: impl Fn(f32, f32, f32) -> f32) -> Image {
        let pixel = |at: u32| {
            let (x, y) = ((at % SIZE.0) as f32, (at / SIZE.0) as f32);
            let light = 0.5 + 0.3 * libm::sinf(x * 0.3) * libm::cosf(y * 0.2);
            let value = change(light, x, y);
            [value, value * 0.5, value * 0.25, 1.0]
        };
        let pixels: Vec<_> = (0..SIZE.0 * SIZE.1).map(pixel).collect();
        Image::from_rgba(SIZE, ColorEncoding::Linear, &pixels)
    }

    fn differing(layer: &str, different_pixels: usize) -> LayerDifference {
        LayerDifference { layer: layer.to_owned(), different_pixels, ..LayerDifference::default() }
    }

    #[test]
    fn colours_alone_identify_camera_light_noise_and_unclear_causes() {
        let reference = image(|light, _, _| light);
        let cause = |actual: &Image| likely_cause(actual, &reference, &[]);
        let moved = image(|_, x, y| 0.5 + 0.3 * libm::sinf((x - 2.0) * 0.3) * libm::cosf((y + 1.0) * 0.2));
        let found = cause(&moved);
        let Some(Cause::Camera { right, down }) = found else { panic!("{found:?}") };
        assert!((right - 2.0).abs() < 0.05 && (down + 1.0).abs() < 0.05);
        let found = cause(&image(|light, _, _| light * 1.1));
        let Some(Cause::Light { factors: Some([red, ..]) }) = found else { panic!("{found:?}") };
        assert!((red - 1.1).abs() < 1e-4);
        // A hash of the position, between −0.01 and 0.01.
        let grain = |x: f32, y: f32| {
            let mixed = (x as u32).wrapping_mul(73_856_093) ^ (y as u32).wrapping_mul(19_349_663);
            let mixed = mixed.wrapping_mul(2_654_435_761);
            ((mixed >> 16) % 1000) as f32 / 50_000.0 - 0.01
        };
        assert_eq!(cause(&image(|light, x, y| light + grain(x, y))), Some(Cause::Noise));
        let part = image(|light, x, y| if x < 8.0 && y < 8.0 { 0.0 } else { light });
        assert_eq!(cause(&part), Some(Cause::Unclear { share: 64.0 / 3072.0 }));
        assert_eq!(cause(&reference), None);
    }

    #[test]
    fn layers_distinguish_geometry_material_and_light() {
        let reference = image(|light, _, _| light);
        let part = image(|light, x, y| if x < 8.0 && y < 8.0 { 0.0 } else { light });
        let cause = |layers: &[LayerDifference]| likely_cause(&part, &reference, layers).unwrap();
        let (depth, albedo) = (differing("depth", 64), differing("albedo", 60));
        assert!(matches!(cause(&[albedo.clone(), depth]), Cause::Geometry { pixels: 64, .. }));
        assert!(matches!(cause(&[differing("depth", 0), albedo]), Cause::Material { pixels: 60, .. }));
        assert_eq!(cause(&[differing("depth", 0), differing("albedo", 0)]), Cause::Light { factors: None });
        let ids = [differing("object_id", 0), differing("material_id", 0)];
        assert_eq!(cause(&ids), Cause::MaterialOrLight);
        // Twice the light, and another base colour.
        let of = |actual: &Image| likely_cause(actual, &reference, &ids).unwrap();
        assert!(matches!(of(&image(|light, _, _| light * 2.0)), Cause::Light { factors: Some(_) }));
        let mut painted = reference.clone();
        for channel in painted.channels.iter_mut().filter(|channel| channel.name == "R") {
            let Samples::Float(values) = &mut channel.samples else { continue };
            for value in values {
                *value *= 0.5;
            }
        }
        assert_eq!(of(&painted), Cause::MaterialOrLight);
    }
}
