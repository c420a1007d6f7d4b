//! Compares two images: every measure with its value and its limit.

use super::cause::likely_cause;
use super::changes::scene_changes;
use super::channel_difference::{LayerDifference, ValueLimits, channel_difference};
use super::color_checks::{ColorMeasure, measure_colors};
use super::common_form::{in_form_of, is_light, is_statistic};
use super::comparison::{Check, Comparison, Mismatch};
use super::exact::are_identical;
use super::layer_limits::LayerLimits;
use super::matte_difference::matte_differences;
use super::non_finite::non_finite;
use super::presets::Limits;
use super::verdict::Verdict;
use super::{Channel, Image, Samples};
use crate::image::{ContentChange, is_cryptomatte};

/// Compares an image with its reference.
///
/// Where one image holds linear light and the other display values, both are compared in linear light. Alpha that is 1 everywhere equals
/// none, and whole numbers equal ids. Images whose sizes or windows differ are not compared further.
pub fn compare(actual: &Image, reference: &Image, limits: &Limits) -> Comparison {
    let [comparison] = compare_with_each(actual, reference, [limits]);
    comparison
}

/// [`compare`] with each of several limits; what does not depend on them, such as FLIP, is measured once.
pub fn compare_with_each<const N: usize>(
    actual: &Image,
    reference: &Image,
    limits: [&Limits; N],
) -> [Comparison; N] {
    if actual.encoding != reference.encoding {
        let [actual, reference] = [actual, reference].map(|image| image.clone().into_linear());
        return compare_with_each(&actual, &reference, limits).map(Comparison::of_light_and_display_values);
    }
    let [ours, theirs] = [in_form_of(reference, actual), in_form_of(actual, reference)];
    let (actual, reference) = (&*ours, &*theirs);
    let mut measured = Comparison { mismatches: mismatches(actual, reference), ..Comparison::default() };
    compare_content(&mut measured, actual, reference);
    if measured.mismatches.iter().any(|mismatch| matches!(mismatch, Mismatch::Size { .. })) {
        return limits.map(|_| measured.clone());
    }
    measured.is_identical = are_identical(actual, reference);
    measured.scene_changes = scene_changes(&actual.scene, &reference.scene, measured.is_identical);
    let colors = measure_colors(&mut measured, [actual, reference]);
    limits.map(|limits| limited(&measured, &colors, [actual, reference], limits))
}

/// The comparison of what was measured with its limits, and the cause of what is beyond them.
fn limited(
    measured: &Comparison,
    colors: &[ColorMeasure],
    [actual, reference]: [&Image; 2],
    limits: &Limits,
) -> Comparison {
    let mut comparison = measured.clone();
    compare_layers(&mut comparison, actual, reference, limits);
    comparison.checks.extend(colors.iter().map(|measure| measure.check(limits)));
    comparison.cause = match comparison.verdict() {
        Verdict::Identical => None,
        // No layer is beyond its limit.
        Verdict::Changed => likely_cause(actual, reference, &with_any_difference(&comparison.layers)),
        Verdict::Failed => {
            likely_cause(actual, reference, &beyond_limits(&comparison.layers, reference, limits))
        }
    };
    let window = reference.data_window;
    comparison.of_window_at((window.x0, window.y0))
}

/// Whether all values have the same bits, all are finite, and the files tell the same of their scenes.
pub(super) fn are_identical_and_finite(actual: &Image, reference: &Image) -> bool {
    are_identical(actual, reference)
        && actual.scene.content_changes(&reference.scene).is_empty()
        && scene_changes(&actual.scene, &reference.scene, true).is_empty()
        && mismatches(actual, reference).is_empty()
}

fn compare_content(comparison: &mut Comparison, actual: &Image, reference: &Image) {
    for change in actual.scene.content_changes(&reference.scene) {
        if change.is_lost {
            let ContentChange { kind, name, count, .. } = change;
            comparison.mismatches.push(Mismatch::Lost { content: kind, name, count });
        } else {
            comparison.new_content.push(change.to_string());
        }
    }
}

/// The layers, with no different pixels where the share of them is within the limits.
fn beyond_limits(layers: &[LayerDifference], reference: &Image, limits: &Limits) -> Vec<LayerDifference> {
    let pixels = reference.data_window.pixel_count() as f64;
    let limited = layers.iter().map(|layer| {
        let share = if is_light(&layer.layer, reference) { limits.light_share } else { limits.data_share };
        let passes = layer.different_pixels as f64 <= share * pixels;
        LayerDifference { different_pixels: if passes { 0 } else { layer.different_pixels }, ..layer.clone() }
    });
    limited.collect()
}

/// The layers, with the number of pixels that differ at all. Other numbers of ids alone are no difference.
fn with_any_difference(layers: &[LayerDifference]) -> Vec<LayerDifference> {
    let counted = layers.iter().map(|layer| {
        // Of a Cryptomatte, coverage differs where ids have other bits.
        let differs = layer.channels.iter().any(|channel| channel.largest > 0.0);
        let different = layer.channels.iter().filter(|_| differs).map(|channel| channel.different);
        LayerDifference { different_pixels: different.max().unwrap_or(0), ..layer.clone() }
    });
    counted.collect()
}

fn mismatches(actual: &Image, reference: &Image) -> Vec<Mismatch> {
    let windows = |image: &Image| {
        let signed = |(width, height): (u32, u32)| (i64::from(width), i64::from(height));
        [signed(image.display_window.size()), image.position(), signed(image.size())]
    };
    let [ours, theirs] = [actual, reference].map(windows);
    let mut mismatches = Vec::new();
    if ours != theirs {
        mismatches.push(Mismatch::Size { actual: ours, reference: theirs });
    }
    for (image, other, is_reference) in [(actual, reference, false), (reference, actual, true)] {
        for channel in &image.channels {
            let name = || channel.name.clone();
            match other.channel(&channel.name) {
                None => mismatches
                    .push(Mismatch::Channel { channel: name(), missing_in_reference: !is_reference }),
                Some(theirs) if !is_reference && !have_one_type(&channel.samples, &theirs.samples) => {
                    let ids_in_reference = matches!(theirs.samples, Samples::Uint(_));
                    mismatches.push(Mismatch::SampleType { channel: name(), ids_in_reference });
                }
                Some(_) => {}
            }
            if let Some(mut values) = non_finite(channel, image.size().0) {
                let (x, y) = values.first_at;
                values.first_at = (x + image.data_window.x0, y + image.data_window.y0);
                mismatches.push(Mismatch::NotFinite { in_reference: is_reference, values });
            }
        }
    }
    mismatches
}

fn compare_layers(comparison: &mut Comparison, actual: &Image, reference: &Image, limits: &Limits) {
    for layer in reference.layers() {
        let images = [actual, reference];
        let is_light = is_light(layer, reference);
        let channels: Vec<_> = reference.channels_of(layer).collect();
        let layer_limits = if is_light {
            LayerLimits::of_light(limits)
        } else {
            LayerLimits::of_data(limits, layer, &channels)
        };
        let difference = layer_difference(layer, images, &layer_limits.values, |_| true);
        let holds_integers = || channels.iter().all(|channel| matches!(channel.samples, Samples::Uint(_)));
        if !(is_statistic(layer) && holds_integers()) {
            comparison.checks.extend(layer_limits.check(layer, &difference, reference));
        }
        comparison.layers.push(difference);
        if is_light {
            // Such as a depth beside the colours of a layer.
            let is_data = |channel: &Channel| !is_color(&channel.name);
            let channels: Vec<_> = channels.into_iter().filter(|channel| is_data(channel)).collect();
            let limits = LayerLimits::of_data(limits, layer, &channels);
            let difference = layer_difference(layer, images, &limits.values, is_data);
            let of_data = limits.check(&format!("data of {layer}"), &difference, reference);
            comparison.checks.extend(of_data.filter(|_| !difference.channels.is_empty()));
        }
    }
    let channels = comparison.layers.iter().flat_map(|layer| &layer.channels);
    let measured = channels.map(|channel| channel.different as f64).sum();
    let limit = limits.different_values;
    if limit < f64::INFINITY {
        let measure = "values whose bits differ".to_owned();
        comparison.checks.insert(0, Check { measure, measured, limit, at: None, passes: measured <= limit });
    }
}

/// Whether a channel of a layer of light is colour or coverage.
fn is_color(channel: &str) -> bool {
    let component = channel.rsplit('.').next().unwrap_or(channel);
    matches!(component, "R" | "G" | "B" | "A" | "Y" | "RY" | "BY")
}

/// Whether both hold ids or both hold numbers.
fn have_one_type(a: &Samples, b: &Samples) -> bool {
    matches!(a, Samples::Uint(_)) == matches!(b, Samples::Uint(_))
}

/// The difference of those channels of a layer that `is_compared`.
fn layer_difference(
    layer: &str,
    [actual, reference]: [&Image; 2],
    limits: &ValueLimits,
    is_compared: impl Fn(&Channel) -> bool,
) -> LayerDifference {
    let width = reference.size().0;
    let mut is_beyond = vec![false; reference.data_window.pixel_count()];
    let mut channels = if is_cryptomatte(layer) {
        matte_differences(layer, [actual, reference], limits, &mut is_beyond)
    } else {
        Vec::new()
    };
    for channel in reference.channels_of(layer).filter(|channel| is_compared(channel)) {
        if channels.iter().any(|compared| compared.channel == channel.name) {
            continue;
        }
        let ours = actual.channel(&channel.name);
        if let Some(ours) = ours.filter(|ours| have_one_type(&ours.samples, &channel.samples)) {
            let values = (&ours.samples, &channel.samples);
            channels.push(channel_difference(&channel.name, values, limits, width, &mut is_beyond));
        }
    }
    let different_pixels = is_beyond.iter().filter(|beyond| **beyond).count();
    LayerDifference { layer: layer.to_owned(), different_pixels, channels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::PixelWindow;
    use crate::regression::color_checks::OBJECT_IDS;
    use crate::regression::{Cause, ColorEncoding, Preset};

    fn flat(size: (u32, u32), value: f32) -> Image {
        let pixels = vec![[value, value, value, 1.0]; (size.0 * size.1) as usize];
        Image::from_rgba(size, ColorEncoding::Linear, &pixels)
    }

    fn red(image: &mut Image) -> &mut Vec<f32> {
        let channel = image.channels.iter_mut().find(|channel| channel.name == "R");
        match channel.map(|channel| &mut channel.samples) {
            Some(Samples::Float(values)) => values,
            _ => panic!("no red"),
        }
    }

    #[test]
    fn equal_images_pass_every_preset() {
        let image = flat((20, 20), 0.5);
        for preset in Preset::ALL {
            let comparison = compare(&image, &image, &preset.limits());
            assert!(comparison.is_identical && comparison.passes() && comparison.cause.is_none());
        }
    }

    #[test]
    fn failures_of_light_against_display_values_tell_of_both() {
        let graded = Image::from_rgba((20, 20), ColorEncoding::Srgb, &vec![[0.9, 0.8, 0.7, 1.0]; 400]);
        for (actual, reference) in
            [(flat((20, 20), 0.1), graded.clone()), (graded.clone(), flat((20, 20), 0.1))]
        {
            let comparison = compare(&actual, &reference, &Preset::Visual.limits());
            assert_eq!(comparison.cause, Some(Cause::Encoding));
        }
        // Images of other sizes are not measured.
        let comparison = compare(&flat((9, 9), 0.1), &graded, &Preset::Visual.limits());
        assert!(!comparison.passes() && comparison.cause.is_none());
        // The same values need no explanation.
        let comparison = compare(&graded.clone().into_linear(), &graded, &Preset::Visual.limits());
        assert!(comparison.passes() && comparison.cause != Some(Cause::Encoding));
    }

    #[test]
    fn exact_fails_for_one_bit_and_reports_value_and_limit() {
        let (mut actual, reference) = (flat((20, 20), 0.5), flat((20, 20), 0.5));
        red(&mut actual)[47] = f32::from_bits(0.5_f32.to_bits() + 1);
        let comparison = compare(&actual, &reference, &Preset::Exact.limits());
        let failures = comparison.failures().join("\n");
        assert!(
            failures.contains("share of pixels with beauty off by more than 0 and 0 %: 0.0025 > 0"),
            "{failures}"
        );
        assert!(failures.contains("worst at column 7, row 2"), "{failures}");
        assert!(!comparison.is_identical);
        assert!(compare(&actual, &reference, &Preset::Strict.limits()).passes());
    }

    /// A grey wall, and before it an object of 48x48 pixels with id 2 whose light is 0.3 times `factor`.
    fn object_before_a_wall(factor: f32) -> Image {
        let is_object = |at: u32| (50..98).contains(&(at % 160)) && (20..68).contains(&(at / 160));
        let light = |at: u32| if is_object(at) { 0.3 * factor } else { 0.5 };
        let pixels: Vec<_> = (0..160 * 90).map(|at| [light(at), light(at), light(at), 1.0]).collect();
        let mut image = Image::from_rgba((160, 90), ColorEncoding::Linear, &pixels);
        let ids = (0..160 * 90).map(|at| if is_object(at) { 2 } else { 1 }).collect();
        image.channels.push(Channel { name: OBJECT_IDS.to_owned(), samples: Samples::Uint(ids) });
        image
    }

    #[test]
    fn a_slight_change_of_a_whole_object_fails_by_the_object_alone() {
        let limits = Preset::Visual.limits();
        let reference = object_before_a_wall(1.0);
        let comparison = compare(&object_before_a_wall(0.96), &reference, &limits);
        let [failure] = comparison.failures().try_into().unwrap();
        assert!(failure.starts_with("FLIP of the worst object: 0.0"), "{failure}");
        let worst = comparison.flip.and_then(|flip| flip.object).unwrap();
        assert_eq!((worst.id, worst.pixels), (2, 48 * 48));
        assert!(compare(&object_before_a_wall(0.98), &reference, &limits).passes());
        // Without ids in both images there are no objects.
        let mut without = object_before_a_wall(0.96);
        without.channels.retain(|channel| channel.name != OBJECT_IDS);
        assert_eq!(compare(&without, &reference, &limits).flip.and_then(|flip| flip.object), None);
    }

    #[test]
    fn an_object_that_vanishes_is_found_by_the_ids_of_the_reference() {
        let reference = object_before_a_wall(1.0);
        let mut gone = object_before_a_wall(5.0 / 3.0);
        for channel in &mut gone.channels {
            if let Samples::Uint(ids) = &mut channel.samples {
                ids.fill(1);
            }
        }
        let worst = compare(&gone, &reference, &Preset::Visual.limits()).flip.and_then(|flip| flip.object);
        assert_eq!(worst.map(|worst| worst.id), Some(2));
    }

    #[test]
    fn counts_of_samples_have_no_limit() {
        let with_count = |count: u32| {
            let mut image = flat((20, 20), 0.5);
            let samples = Samples::Uint((0..400).map(|at| count + at % 3).collect());
            image.channels.push(Channel { name: "sample_count".to_owned(), samples });
            image
        };
        for preset in [Preset::Strict, Preset::Visual, Preset::Noisy] {
            let comparison = compare(&with_count(16), &with_count(64), &preset.limits());
            assert_eq!(comparison.verdict(), Verdict::Changed, "{:?}", comparison.failures());
            let told = comparison.largest_measure().unwrap();
            assert!(told.starts_with("largest difference of sample_count: 48, at"), "{told}");
        }
        assert!(!compare(&with_count(16), &with_count(64), &Preset::Exact.limits()).passes());
    }

    #[test]
    fn positions_in_crops_are_those_of_the_whole_image() {
        let cropped = |change: f32| {
            let mut image = flat((31, 31), 0.5);
            red(&mut image)[10 * 31 + 20] += change;
            image.data_window = PixelWindow { x0: 100, y0: 50, x1: 131, y1: 81 };
            image.display_window = PixelWindow::full(200, 150);
            image
        };
        let comparison = compare(&cropped(0.5), &cropped(0.0), &Preset::Exact.limits());
        assert_eq!(
            comparison.layers[0].channels.iter().find(|c| c.channel == "R").unwrap().largest_at,
            (120, 60)
        );
        assert_eq!(comparison.flip.as_ref().unwrap().largest_at, (120, 60));
        let failures = comparison.failures().join("\n");
        assert!(failures.contains("worst at column 120, row 60"), "{failures}");
        let failures =
            compare(&cropped(f32::NAN), &cropped(0.0), &Preset::Noisy.limits()).failures().join("\n");
        assert!(failures.contains("the first at column 120, row 60"), "{failures}");
    }

    #[test]
    fn non_finite_values_fail_under_every_preset() {
        let mut broken = flat((20, 20), 0.5);
        red(&mut broken)[21] = f32::NAN;
        for (actual, reference) in [(&broken, &broken), (&broken, &flat((20, 20), 0.5))] {
            let comparison = compare(actual, reference, &Preset::Noisy.limits());
            assert!(!comparison.passes());
            let failures = comparison.failures().join("\n");
            assert!(
                failures.contains("1 value of R is not a number, the first at column 1, row 1"),
                "{failures}"
            );
        }
    }

    #[test]
    fn sizes_and_channels_are_compared_before_values() {
        let limits = Preset::Noisy.limits();
        let failures = compare(&flat((20, 20), 0.5), &flat((20, 10), 0.5), &limits).failures();
        assert_eq!(failures, ["the size is 20x20, the reference's 20x10"]);
        let mut layered = flat((20, 20), 0.5);
        let ids = Samples::Uint(vec![1; 400]);
        layered.channels.push(Channel { name: "node_id".to_owned(), samples: ids });
        let failures = compare(&flat((20, 20), 0.5), &layered, &limits).failures();
        assert_eq!(failures, ["lacks the channel node_id of the reference"]);
        let failures = compare(&layered, &flat((20, 20), 0.5), &limits).failures();
        assert_eq!(failures, ["has the channel node_id, which the reference lacks"]);
    }
}
