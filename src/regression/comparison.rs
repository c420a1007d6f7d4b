//! Two pictures against limits: every measure, every verdict with its value and its limit.

use serde::Serialize;

use super::channel_difference::channel_difference;
use super::exact::are_identical;
use super::flip::{FlipMap, PIXELS_PER_DEGREE, flip_display, flip_light};
use super::non_finite::non_finite;
use super::pooling::pool;
use super::root_mean_square::root_mean_square;
use super::{
    Cause, ChannelDifference, ColorEncoding, Image, Limits, NonFinite, PooledErrors, RootMeanSquare,
    ValueLimits, likely_cause,
};
use crate::color::luminance;
use crate::output::Aov;

/// Why pictures cannot be compared by numbers, or fail whatever the limits are.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Mismatch {
    /// Sizes or windows differ: whole picture, first pixel held, pixels held.
    Size {
        /// Of the picture that is judged.
        actual: [(u32, u32); 3],
        /// Of the reference.
        reference: [(u32, u32); 3],
    },
    /// A channel that only one of them has.
    Channel {
        /// The channel.
        channel: String,
        /// Whether it is the reference that lacks it.
        missing_in_reference: bool,
    },
    /// Values that are infinite or not a number.
    NotFinite {
        /// Whether they are the reference's.
        in_reference: bool,
        /// What and where.
        values: NonFinite,
    },
}

/// One measure against its limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// What was measured, in words.
    pub measure: String,
    /// Its value.
    pub measured: f64,
    /// The largest value that passes.
    pub limit: f64,
    /// Column and row where it is worst, if it has a place.
    pub at: Option<(u32, u32)>,
    /// Whether it passes.
    pub passes: bool,
}

/// What the channels of one layer differ by.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LayerDifference {
    /// The layer.
    pub layer: String,
    /// Pixels with a value beyond the limits.
    pub different_pixels: usize,
    /// One by one.
    pub channels: Vec<ChannelDifference>,
}

/// All that is known about two pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Whether every bit is the same.
    pub is_identical: bool,
    /// What fails whatever the limits are.
    pub mismatches: Vec<Mismatch>,
    /// Measures with limits.
    pub checks: Vec<Check>,
    /// The differences by layer.
    pub layers: Vec<LayerDifference>,
    /// Of the colours.
    pub root_mean_square: Option<RootMeanSquare>,
    /// FLIP in numbers.
    pub flip: Option<PooledErrors>,
    /// FLIP of every pixel; `None` without colours or with other sizes.
    pub flip_map: Option<FlipMap>,
    /// Why they differ, as far as that can be told; `None` when they pass.
    pub cause: Option<Cause>,
}

impl Comparison {
    /// Whether the picture passes.
    pub fn passes(&self) -> bool {
        self.mismatches.is_empty() && self.checks.iter().all(|check| check.passes)
    }

    /// What fails, one line each.
    pub fn failures(&self) -> Vec<String> {
        let checks = self.checks.iter().filter(|check| !check.passes).map(ToString::to_string);
        self.mismatches.iter().map(ToString::to_string).chain(checks).collect()
    }
}

/// Judges a picture by its reference.
pub fn compare(actual: &Image, reference: &Image, limits: &Limits) -> Comparison {
    if actual.encoding != reference.encoding {
        let [actual, reference] = [actual, reference].map(|picture| picture.clone().into_linear());
        return compare(&actual, &reference, limits);
    }
    let mut comparison = Comparison { mismatches: mismatches(actual, reference), ..Comparison::default() };
    if comparison.mismatches.iter().any(|mismatch| matches!(mismatch, Mismatch::Size { .. })) {
        return comparison;
    }
    comparison.is_identical = are_identical(actual, reference);
    compare_layers(&mut comparison, actual, reference, limits);
    if let (Some(ours), Some(theirs)) = (actual.colors(), reference.colors()) {
        compare_colors(&mut comparison, (&ours, &theirs), reference, limits);
    }
    if !comparison.passes() {
        comparison.cause =
            likely_cause(actual, reference, &beyond_limits(&comparison.layers, reference, limits));
    }
    comparison
}

/// The layers, those that pass without a pixel that differs.
fn beyond_limits(layers: &[LayerDifference], reference: &Image, limits: &Limits) -> Vec<LayerDifference> {
    let pixels = reference.data_window.pixel_count() as f64;
    let settled = layers.iter().map(|layer| {
        let share = if is_light(&layer.layer, reference) { limits.light_share } else { limits.data_share };
        let passes = layer.different_pixels as f64 <= share * pixels;
        LayerDifference { different_pixels: if passes { 0 } else { layer.different_pixels }, ..layer.clone() }
    });
    settled.collect()
}

fn mismatches(actual: &Image, reference: &Image) -> Vec<Mismatch> {
    let windows = |image: &Image| {
        let data = image.data_window;
        [image.display_window.size(), (data.x0, data.y0), data.size()]
    };
    let [ours, theirs] = [actual, reference].map(windows);
    let mut mismatches = Vec::new();
    if ours != theirs {
        mismatches.push(Mismatch::Size { actual: ours, reference: theirs });
    }
    for (picture, other, is_reference) in [(actual, reference, false), (reference, actual, true)] {
        for channel in &picture.channels {
            if other.channel(&channel.name).is_none() {
                let channel = channel.name.clone();
                mismatches.push(Mismatch::Channel { channel, missing_in_reference: !is_reference });
            }
            if let Some(values) = non_finite(channel, picture.size().0) {
                mismatches.push(Mismatch::NotFinite { in_reference: is_reference, values });
            }
        }
    }
    mismatches
}

fn compare_layers(comparison: &mut Comparison, actual: &Image, reference: &Image, limits: &Limits) {
    let pixels = reference.data_window.pixel_count();
    for layer in reference.layers() {
        let (values, share) = if is_light(layer, reference) {
            (&limits.light, limits.light_share)
        } else {
            (&limits.data, limits.data_share)
        };
        let difference = layer_difference(layer, actual, reference, values);
        if share < f64::INFINITY {
            let measured = difference.different_pixels as f64 / pixels.max(1) as f64;
            let worst = difference.channels.iter().filter(|channel| channel.different > 0);
            let worst = worst.max_by(|a, b| a.largest.total_cmp(&b.largest));
            comparison.checks.push(Check {
                measure: format!(
                    "share of pixels with {layer} off by more than {} and {} %",
                    values.absolute,
                    values.relative * 100.0
                ),
                measured,
                limit: share,
                at: worst.map(|channel| channel.largest_at),
                passes: measured <= share,
            });
        }
        comparison.layers.push(difference);
    }
    let channels = comparison.layers.iter().flat_map(|layer| &layer.channels);
    let measured = channels.map(|channel| channel.different as f64).sum();
    let limit = limits.different_values;
    if limit < f64::INFINITY {
        let measure = "values whose bits differ".to_owned();
        comparison.checks.insert(0, Check { measure, measured, limit, at: None, passes: measured <= limit });
    }
}

fn layer_difference(layer: &str, actual: &Image, reference: &Image, limits: &ValueLimits) -> LayerDifference {
    let width = reference.size().0;
    let mut is_beyond = vec![false; reference.data_window.pixel_count()];
    let mut channels = Vec::new();
    for channel in reference.channels_of(layer) {
        if let Some(ours) = actual.channel(&channel.name) {
            let values = (&ours.samples, &channel.samples);
            channels.push(channel_difference(&channel.name, values, limits, width, &mut is_beyond));
        }
    }
    let different_pixels = is_beyond.iter().filter(|beyond| **beyond).count();
    LayerDifference { layer: layer.to_owned(), different_pixels, channels }
}

/// Layers of our own by what they are; colours of other programs are taken for light.
fn is_light(layer: &str, picture: &Image) -> bool {
    match Aov::ALL.into_iter().find(|known| known.name() == layer) {
        Some(known) => known.is_light(),
        None => picture.channels_of(layer).any(|channel| channel.name.strip_suffix(".R").is_some()),
    }
}

fn compare_colors(
    comparison: &mut Comparison,
    (actual, reference): (&[[f32; 3]], &[[f32; 3]]),
    picture: &Image,
    limits: &Limits,
) {
    let is_display = picture.encoding == ColorEncoding::Srgb;
    comparison.root_mean_square = Some(root_mean_square(actual, reference, is_display.then_some(1.0)));
    let flip = if is_display { flip_display } else { flip_light };
    // Equal pictures have no error anywhere, without looking.
    let map = if actual == reference {
        FlipMap { size: picture.size(), errors: vec![0.0; actual.len()], exposures: None }
    } else {
        flip(reference, actual, picture.size(), PIXELS_PER_DEGREE)
    };
    let pooled = pool(&map);
    let brightness = brightness_difference(actual, reference);
    for (measure, measured, limit, at) in [
        ("mean FLIP", pooled.mean, limits.mean_flip, None),
        ("FLIP of the worst tile", pooled.tile, limits.tile_flip, Some(pooled.tile_at)),
        ("difference of mean brightness", brightness, limits.brightness, None),
    ] {
        let at = at.filter(|_| measured > 0.0);
        comparison.checks.push(Check {
            measure: measure.to_owned(),
            measured,
            limit,
            at,
            passes: measured <= limit,
        });
    }
    comparison.flip = Some(pooled);
    comparison.flip_map = Some(map);
}

/// How far the mean luminance is off, as a share of the reference's.
fn brightness_difference(actual: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let sum = |colors: &[[f32; 3]]| -> f64 {
        let light = colors.iter().map(|color| f64::from(luminance(glam::Vec3::from_array(*color))));
        light.filter(|light| light.is_finite()).sum()
    };
    let (ours, theirs) = (sum(actual), sum(reference));
    if ours == theirs { 0.0 } else { ((ours - theirs) / theirs).abs() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{Channel, Preset, Samples};

    fn flat(size: (u32, u32), value: f32) -> Image {
        let pixels = vec![[value, value, value, 1.0]; (size.0 * size.1) as usize];
        Image::from_rgba(size, ColorEncoding::Linear, &pixels)
    }

    fn red(picture: &mut Image) -> &mut Vec<f32> {
        let channel = picture.channels.iter_mut().find(|channel| channel.name == "R");
        match channel.map(|channel| &mut channel.samples) {
            Some(Samples::Float(values)) => values,
            _ => panic!("no red"),
        }
    }

    #[test]
    fn equal_pictures_pass_everything() {
        let picture = flat((20, 20), 0.5);
        for preset in Preset::ALL {
            let comparison = compare(&picture, &picture, &preset.limits());
            assert!(comparison.is_identical && comparison.passes() && comparison.cause.is_none());
        }
    }

    #[test]
    fn exact_fails_for_one_bit_and_tells_the_value_and_the_limit() {
        let (mut actual, reference) = (flat((20, 20), 0.5), flat((20, 20), 0.5));
        red(&mut actual)[47] = f32::from_bits(0.5_f32.to_bits() + 1);
        let comparison = compare(&actual, &reference, &Preset::Exact.limits());
        let told = comparison.failures().join("\n");
        assert!(
            told.contains("share of pixels with beauty off by more than 0 and 0 %: 0.0025 > 0"),
            "{told}"
        );
        assert!(told.contains("worst at column 7, row 2"), "{told}");
        assert!(!comparison.is_identical);
        assert!(compare(&actual, &reference, &Preset::Strict.limits()).passes());
    }

    #[test]
    fn nothing_forgives_what_is_not_finite() {
        let mut broken = flat((20, 20), 0.5);
        red(&mut broken)[21] = f32::NAN;
        for (actual, reference) in [(&broken, &broken), (&broken, &flat((20, 20), 0.5))] {
            let comparison = compare(actual, reference, &Preset::Noisy.limits());
            assert!(!comparison.passes());
            let told = comparison.failures().join("\n");
            assert!(
                told.contains("1 values of R are not a number and 0 infinite, the first at column 1, row 1")
            );
        }
    }

    #[test]
    fn sizes_and_channels_are_compared_before_values() {
        let limits = Preset::Noisy.limits();
        let told = compare(&flat((20, 20), 0.5), &flat((20, 10), 0.5), &limits).failures();
        assert_eq!(told, ["the size is 20x20, the reference's 20x10"]);
        let mut layered = flat((20, 20), 0.5);
        let ids = Samples::Uint(vec![1; 400]);
        layered.channels.push(Channel { name: "node_id".to_owned(), samples: ids });
        let told = compare(&flat((20, 20), 0.5), &layered, &limits).failures();
        assert_eq!(told, ["lacks the channel node_id of the reference"]);
        let told = compare(&layered, &flat((20, 20), 0.5), &limits).failures();
        assert_eq!(told, ["has the channel node_id, which the reference lacks"]);
    }
}
