//! The exposures at which images of unbounded light are compared, and the tone curve.
//!
//! Source: P. Andersson et al., *Visualizing Errors in Rendered High Dynamic Range Images*, Eurographics 2021, section 3,
//! with the ACES curve of K. Narkowicz in units that the published tool (1.7) uses, and its rule for the median: the upper
//! one of two.
//!
//! Where most of an image is black, its median says nothing about what is in it: the published tool then compares at up to 23 stops more than
//! for what is lit, and residues of a millionth turn white. Here the last exposure is six stops beyond the one for what is lit, or the one for the
//! median of what is not black, if that is darker: beside a lamp, surfaces that it lights count as the rest does elsewhere. All other
//! images have the published exposures.
//!
//! A reference without light has no exposures of its own: the images are compared at those of the other one, at most five stops below white.
//!
//! The curve compresses the contrast of what is bright to a quarter. Where the brightest light is near the median, all exposures show both there, and
//! a soft shadow on white passes. [`Exposures::linear`] are exposures without a curve, as an image viewer shows linear light. One of them shows the
//! darker half of an image where all others show it black: beside a bright sky that is most of the image, an object in the shade may vanish.

use serde::Serialize;

/// Numerator and denominator of the tone curve, (a x² + b x + c) / (d x² + e x + f), light first scaled by 0.6.
const ACES: [f32; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];
/// Tone-mapped value of the brightest light at the first exposure, and of the median at the last.
const SHOWN: f32 = 0.85;
/// Most of an image is black where its median is under this share of the median of what is lit.
const BLACK_SHARE: f32 = 1.0 / 65536.0;
/// The luminance for the last exposure of such an image, as a share of the same.
const LEAST_SHARE: f32 = 1.0 / 64.0;
/// Share of what is lit that is not white at the first exposure without a curve. The rest is highlights.
const BELOW_WHITE: f64 = 0.98;
/// Linear value of the median of what is lit at the second one, and of the median of the darker half at the third one.
const LINEAR_MEDIAN: f32 = 0.4;
/// The darker half is hidden at the other exposures where its median is under this share of theirs: four stops.
const HIDDEN_SHARE: f32 = 1.0 / 16.0;

/// Largest luminance that counts as no light: under half a step of a display of 8 bits.
const NO_LIGHT: f32 = 1e-4;
/// The least luminance of which a reference without light is compared, five stops below white. Exposures for less would turn residues white.
pub(in crate::regression) const LEAST_LUMINANCE: f32 = 1.0 / 32.0;

/// Exposures from `start` to `stop`, in stops, with the tone curve, and others without it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exposures {
    /// The exposure for the brightest light of the reference.
    pub start: f32,
    /// The exposure for the median of the reference; where most of it is black, that for the median of the rest, but at least six stops beyond the one for what
    /// is lit.
    pub stop: f32,
    /// Number of exposures, evenly spaced, both ends included.
    pub count: u32,
    /// Factors on light of the exposures without the tone curve, at which what is beyond 1 is white: the first shows what is bright just
    /// below white; a second one shows the median where the first shows it dark, and a third one the median of the darker half where all others
    /// show it black. None for black images.
    pub linear: Vec<f32>,
}

impl Exposures {
    /// The exposures for `reference`, which is in linear light.
    pub fn of(reference: &[[f32; 3]]) -> Self {
        Self::of_sorted(&sorted_luminances(reference))
    }

    /// The exposures for comparing `test` with `reference`, both in linear light: those for the reference, or for the other image where the
    /// reference has no light.
    pub fn of_pair(reference: &[[f32; 3]], test: &[[f32; 3]]) -> Self {
        let luminances = sorted_luminances(reference);
        if is_lit(&luminances) {
            return Self::of_sorted(&luminances);
        }
        let least = |luminance: f32| if luminance > LEAST_LUMINANCE { luminance } else { LEAST_LUMINANCE };
        Self::of_sorted(&sorted_luminances(test).into_iter().map(least).collect::<Vec<_>>())
    }

    fn of_sorted(luminances: &[f32]) -> Self {
        let half = luminances.len() / 2;
        let largest = luminances.last().copied().unwrap_or_default();
        let median = luminances.get(half).copied().unwrap_or_default();
        let lit = quantile_of_lit(luminances, 0.5);
        let black = BLACK_SHARE * lit;
        let median = if median < black {
            let rest = &luminances[luminances.partition_point(|&luminance| luminance < black)..];
            let median = rest.get(rest.len() / 2).copied().unwrap_or_default();
            median.min(LEAST_SHARE * lit)
        } else {
            median
        };
        let stops = |luminance: f32| {
            let luminance = if luminance > f32::EPSILON { luminance } else { f32::EPSILON };
            libm::log2f(light_shown_as(SHOWN) / luminance)
        };
        let (start, stop) = (stops(largest), stops(median));
        // An image of uniform brightness needs one exposure; the published tool rejects it.
        let count = if stop > start { ((stop - start).ceil() as u32).max(2) } else { 1 };
        Self { start, stop, count, linear: linear_scales(luminances, median, lit) }
    }

    /// The factor on light of each exposure with the tone curve.
    pub fn scales(&self) -> Vec<f32> {
        let step = (self.stop - self.start) / (self.count.max(2) - 1) as f32;
        (0..self.count).map(|index| libm::exp2f(self.start + index as f32 * step)).collect()
    }
}

/// [`Exposures::linear`] of the sorted luminances of a reference, the one that its last exposure shows, and the median of what is lit.
fn linear_scales(luminances: &[f32], shown: f32, lit: f32) -> Vec<f32> {
    let bright = 1.0 / quantile_of_lit(luminances, BELOW_WHITE);
    let median = LINEAR_MEDIAN / lit;
    let dark = luminances.get(luminances.len() / 4).copied().unwrap_or_default();
    let is_hidden = dark >= BLACK_SHARE * lit && dark < HIDDEN_SHARE * shown.min(lit);
    let scales =
        [Some(bright), (median > 2.0 * bright).then_some(median), is_hidden.then_some(LINEAR_MEDIAN / dark)];
    scales.into_iter().flatten().filter(|scale| scale.is_finite()).collect()
}

/// Whether an image has any light that a display shows.
pub(in crate::regression) fn has_light(image: &[[f32; 3]]) -> bool {
    is_lit(&sorted_luminances(image))
}

/// Whether the largest of sorted luminances is light.
fn is_lit(luminances: &[f32]) -> bool {
    luminances.last().is_some_and(|&largest| largest > NO_LIGHT)
}

/// The finite luminances in ascending order. Negative light counts as none.
fn sorted_luminances(image: &[[f32; 3]]) -> Vec<f32> {
    let luminances = image.iter().map(|[r, g, b]| {
        0.2126 * at_least_zero(*r) + 0.7152 * at_least_zero(*g) + 0.0722 * at_least_zero(*b)
    });
    // No exposure shows what is infinite.
    let mut luminances: Vec<f32> = luminances.filter(|luminance| luminance.is_finite()).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    luminances
}

/// The luminance below which `share` of the sorted ones lie, each weighted by its fourth root: what is black hardly counts, and a few very bright
/// ones do not decide.
fn quantile_of_lit(luminances: &[f32], share: f64) -> f32 {
    let weight = |luminance: &f32| f64::from(luminance.sqrt().sqrt());
    let below = share * luminances.iter().map(weight).sum::<f64>();
    let mut sum = 0.0;
    let lit = luminances.iter().find(|luminance| {
        sum += weight(luminance);
        sum > below
    });
    lit.copied().unwrap_or_default()
}

/// The tone curve, clamped to the unit interval.
pub(super) fn tone_mapped(light: f32) -> f32 {
    let [a, b, c, d, e, f] = ACES;
    let light = at_least_zero(light);
    // The curve is 1 beyond this value; clamping keeps squares finite.
    let light = if light < 1e9 { light } else { 1e9 };
    (((a * light + b) * light + c) / ((d * light + e) * light + f)).clamp(0.0, 1.0)
}

/// The inverse of the tone curve: the larger root of the quadratic equation.
fn light_shown_as(shown: f32) -> f32 {
    let [a, b, c, d, e, f] = ACES;
    let (a, b, c) = (shown * d - a, shown * e - b, shown * f - c);
    let root = (b * b - 4.0 * a * c).sqrt();
    let (one, other) = ((-b - root) / (2.0 * a), (-b + root) / (2.0 * a));
    if one > other { one } else { other }
}

fn at_least_zero(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{ColorEncoding, Image, Preset, compare};

    #[test]
    fn the_range_covers_the_brightest_light_and_the_median() {
        // Luminances 1, 2, 8, 64: the upper median is 8, three stops below 64.
        let reference = [1.0, 64.0, 8.0, 2.0].map(|value| [value; 3]);
        let range = Exposures::of(&reference);
        assert!((range.stop - range.start - 3.0).abs() < 1e-4 && (range.count == 3 || range.count == 4));
        let scales = range.scales();
        assert!((tone_mapped(64.0 * scales[0]) - SHOWN).abs() < 1e-4);
        assert!((tone_mapped(8.0 * scales[scales.len() - 1]) - SHOWN).abs() < 1e-4);
    }

    #[test]
    fn images_that_are_mostly_black_are_compared_at_exposures_of_what_is_lit() {
        // A third of the image is lit; the rest has light of a millionth, or none.
        let image = |dark: f32| (0..99).map(|i| [if i % 3 == 0 { 0.5 } else { dark }; 3]).collect::<Vec<_>>();
        for dark in [0.0, 1e-6] {
            let range = Exposures::of(&image(dark));
            assert!((range.stop - range.start - 6.0).abs() < 1e-4, "{dark}: {range:?}");
        }
        // Dark, but not black; dim interiors with windows; a sun; many fireflies
        let with_bright = |period: usize, dark: f32, bright: f32| {
            (0..1000).map(|i| [if i % period == 1 { bright } else { dark }; 3]).collect::<Vec<_>>()
        };
        for (image, ratio) in [
            (image(0.02), 25.0),
            (with_bright(10, 0.01, 100.0), 1e4),
            (with_bright(7, 0.1, 20.0), 200.0),
            (with_bright(1000, 1.0, 1e5), 1e5),
            (with_bright(200, 1.0, 65504.0), 65504.0),
        ] {
            let range = Exposures::of(&image);
            assert!((range.stop - range.start - libm::log2f(ratio)).abs() < 1e-3, "{ratio}: {range:?}");
        }
    }

    #[test]
    fn surfaces_beside_a_lamp_on_black_are_compared_at_their_own_exposure() {
        // A lamp of 60 pixels, 200 pixels that it lights, and black
        let image = |black: f32| {
            let value = |i: i32| {
                if i < 60 {
                    1e4
                } else if i < 260 {
                    1.0
                } else {
                    black
                }
            };
            (0..1000).map(|i| [value(i); 3]).collect::<Vec<_>>()
        };
        for black in [0.0, 1e-6] {
            let range = Exposures::of(&image(black));
            let last = range.scales()[range.count as usize - 1];
            assert!((tone_mapped(last) - SHOWN).abs() < 1e-3, "{range:?}");
        }
    }

    #[test]
    fn a_reference_without_light_has_the_exposures_of_the_other_image() {
        let image = |rest: f32, bright: f32| {
            (0..100).map(|i| [if i < 40 { bright } else { rest }; 3]).collect::<Vec<_>>()
        };
        for dark in [0.0, 1e-6, 5e-5] {
            let reference = image(dark, 0.0);
            assert!(!has_light(&reference));
            // What is hardly light is shown as on a display that is five stops brighter.
            for test in [image(0.0, 0.0), image(1e-6, 1e-5), image(0.0, 0.02)] {
                let range = Exposures::of_pair(&reference, &test);
                assert_eq!((range.count, &*range.linear), (1, &[32.0][..]), "{range:?}");
                assert!((tone_mapped(LEAST_LUMINANCE * range.scales()[0]) - SHOWN).abs() < 1e-4);
            }
            let range = Exposures::of_pair(&reference, &image(0.5, 8.0));
            assert_eq!(range, Exposures::of(&image(0.5, 8.0)));
        }
        // One pixel of light is enough for exposures of its own.
        let mut lit = image(0.0, 0.0);
        lit[7] = [0.01; 3];
        assert!(has_light(&lit));
        assert_eq!(Exposures::of_pair(&lit, &image(0.5, 8.0)), Exposures::of(&lit));
    }

    #[test]
    fn values_that_are_not_finite_have_no_exposure() {
        let finite = Exposures::of(&[[0.5; 3], [0.25; 3], [0.5; 3]]);
        for broken in [f32::INFINITY, f32::NAN] {
            let range = Exposures::of(&[[0.5; 3], [0.25; 3], [0.5; 3], [broken, 0.0, 0.0]]);
            assert!((1..20).contains(&range.count) && range.start == finite.start, "{broken}: {range:?}");
        }
    }

    #[test]
    fn exposures_without_a_curve_show_what_is_bright_and_a_dark_median() {
        // A white wall with a highlight, and a dark wall with a bright window
        let image = |share: usize, bright: f32, rest: f32| {
            (0..1000).map(|i| [if i % 1000 < share { bright } else { rest }; 3]).collect::<Vec<_>>()
        };
        let linear = |image: &[[f32; 3]]| Exposures::of(image).linear;
        for (image, expected) in
            [(image(5, 50.0, 0.5), &[2.0_f32][..]), (image(100, 8.0, 0.02), &[0.125, 20.0])]
        {
            let found = linear(&image);
            assert_eq!(found.len(), expected.len());
            assert!(found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-5), "{found:?}");
        }
        assert!(linear(&image(0, 0.0, 0.0)).is_empty());
    }

    #[test]
    fn a_dark_half_that_no_other_exposure_shows_has_one_of_its_own() {
        // A sky of six tenths, and ground
        let image = |sky: f32, ground: f32| {
            (0..1000).map(|i| [if i < 600 { sky } else { ground }; 3]).collect::<Vec<_>>()
        };
        for (sky, ground) in [(20.0, 0.02), (5.0, 0.2)] {
            let linear = Exposures::of(&image(sky, ground)).linear;
            let last = linear.last().copied().unwrap();
            assert!((last * ground / 0.4 - 1.0).abs() < 1e-5, "{linear:?}");
        }
        // Ordinary contrast, the other way round, and a black half have no more exposures than before.
        for (sky, ground) in [(2.0, 0.2), (0.02, 20.0), (20.0, 0.0), (20.0, 1e-5)] {
            let linear = Exposures::of(&image(sky, ground)).linear;
            assert!(linear.iter().all(|scale| scale * sky.max(ground) <= 1.0 + 1e-5), "{linear:?}");
        }
    }

    #[test]
    fn an_object_in_the_shade_below_a_bright_sky_may_not_vanish() {
        let image = |object: f32| {
            let light = |at: u32| match (at % 160, at / 160) {
                (_, ..54) => 20.0,
                (50..90, 58..88) => object,
                _ => 0.02,
            };
            let pixels: Vec<_> = (0..160 * 90).map(|at| [light(at), light(at), light(at), 1.0]).collect();
            Image::from_rgba((160, 90), ColorEncoding::Linear, &pixels)
        };
        let passes =
            |actual, reference| compare(&image(actual), &image(reference), &Preset::Visual.limits()).passes();
        assert!(!passes(0.02, 0.005) && !passes(0.005, 0.02));
        assert!(passes(0.0051, 0.005));
    }

    #[test]
    fn flat_and_black_images_have_one_exposure() {
        for value in [0.0, 1.0, -1.0] {
            let range = Exposures::of(&[[value; 3]; 9]);
            assert_eq!((range.count, range.scales().len()), (1, 1));
            assert!(range.start.is_finite());
        }
        assert_eq!(tone_mapped(f32::MAX), 1.0);
    }
}
