//! One form for images of two programs: alpha only where both have it or a pixel is not opaque, and ids as integers.

use std::borrow::Cow;

use super::{Channel, Image, Samples};
use crate::image::{is_cryptomatte, layer_of};
use crate::image_file::SUM_LAYER;
use crate::output::Aov;

/// The image as `other` holds it: without the alpha of a layer whose every pixel is opaque, where the other has that layer without alpha, and
/// with ids in place of whole numbers where the other has ids.
pub(super) fn in_form_of<'a>(other: &Image, image: &'a Image) -> Cow<'a, Image> {
    let mut common = Cow::Borrowed(image);
    for channel in &image.channels {
        let is_same = |kept: &Channel| kept.name == channel.name;
        if is_needless_alpha(channel, other) {
            common.to_mut().channels.retain(|kept| !is_same(kept));
        } else if let Some(ids) = ids_of(channel, other)
            && let Some(kept) = common.to_mut().channels.iter_mut().find(|kept| is_same(kept))
        {
            kept.samples = Samples::Uint(ids);
        }
    }
    common
}

/// Whether the channel is alpha that `other` lacks in the same layer, and 1 everywhere.
fn is_needless_alpha(channel: &Channel, other: &Image) -> bool {
    channel.name.rsplit('.').next() == Some("A")
        && is_light(layer_of(&channel.name), other)
        && other.channel(&channel.name).is_none()
        && channel.samples.floats().is_some_and(|alpha| alpha.iter().all(|&alpha| alpha == 1.0))
}

/// The ids that the channel holds as floats, where `other` has integers. `None` where a value is no id.
fn ids_of(channel: &Channel, other: &Image) -> Option<Vec<u32>> {
    let Samples::Uint(_) = other.channel(&channel.name)?.samples else { return None };
    let id = |value: &f32| Some(*value as u32).filter(|id| *id as f32 == *value);
    channel.samples.floats()?.iter().map(id).collect()
}

/// Whether a layer holds light, which an observer sees. Rayframe's own AOVs are known by name; any other layer with colours counts
/// as light, but for Cryptomattes.
pub(super) fn is_light(layer: &str, image: &Image) -> bool {
    let known = Aov::ALL.into_iter().find(|known| known.name() == layer);
    known.is_none_or(Aov::is_light) && image.has_colors(layer) && !is_cryptomatte(layer)
}

/// Whether integers of a layer are statistics of a render rather than ids: counts of samples, and sums of samples. They have no limit but where
/// every bit counts.
pub(super) fn is_statistic(layer: &str) -> bool {
    layer == Aov::SampleCount.name() || layer == SUM_LAYER.trim_end_matches('.')
}

/// Whether integers of a channel of statistics are numbers. Those of sums are words of longer numbers, but for the count.
pub(super) fn is_count(channel: &str) -> bool {
    channel == Aov::SampleCount.name() || channel.strip_prefix(SUM_LAYER) == Some("count")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{ColorEncoding, Preset, Verdict, compare};

    fn opaque() -> Image {
        Image::from_rgba((20, 20), ColorEncoding::Linear, &[[0.5, 0.5, 0.5, 1.0]; 400])
    }

    /// A grey image with these samples as the layer of objects.
    fn with_objects(samples: Samples) -> Image {
        let mut image = opaque();
        image.channels.push(Channel { name: "object_id".to_owned(), samples });
        image
    }

    #[test]
    fn ids_as_whole_numbers_are_ids() {
        let id = |at: u32| if at < 150 { 0 } else { at / 150 + 65_536 };
        let ids = with_objects(Samples::Uint((0..400).map(id).collect()));
        let numbers =
            |change: f32| with_objects(Samples::Float((0..400).map(|at| id(at) as f32 + change).collect()));
        let moved = with_objects(Samples::Float((0..400).map(|at| id(at + 100) as f32).collect()));
        for preset in [Preset::Exact, Preset::Visual] {
            let limits = preset.limits();
            for (actual, reference) in [(&ids, &numbers(0.0)), (&numbers(0.0), &ids)] {
                let comparison = compare(actual, reference, &limits);
                assert_eq!(comparison.verdict(), Verdict::Identical, "{:?}", comparison.failures());
            }
            let comparison = compare(&moved, &ids, &limits);
            let cause = comparison.cause.map(|cause| cause.to_string()).unwrap();
            assert!(cause.starts_with("geometry: object_id differs in "), "{cause}");
        }
        // Other numbers are no ids, and tell no cause.
        for broken in [0.5, -1.0] {
            let comparison = compare(&numbers(broken), &ids, &Preset::Visual.limits());
            assert_eq!(comparison.failures(), ["holds object_id as numbers, the reference as ids"]);
            assert_eq!(comparison.cause, None);
            let failures = compare(&ids, &numbers(broken), &Preset::Exact.limits()).failures();
            assert_eq!(failures, ["holds object_id as ids, the reference as numbers"]);
        }
    }

    #[test]
    fn alpha_of_opaque_images_equals_none() {
        let renamed = |mut image: Image| {
            image.channels.iter_mut().for_each(|channel| channel.name.insert_str(0, "view."));
            image
        };
        let with = opaque();
        let without = with.clone().without_alpha();
        let mut renamed_without = renamed(with.clone());
        renamed_without.channels.retain(|channel| channel.name != "view.A");
        for (with, without) in [(&with, &without), (&renamed(with.clone()), &renamed_without)] {
            for (actual, reference) in [(with, without), (without, with)] {
                let comparison = compare(actual, reference, &Preset::Exact.limits());
                assert_eq!(comparison.verdict(), Verdict::Identical, "{:?}", comparison.failures());
            }
        }
        let mut clear = with;
        match clear.channels.iter_mut().find(|channel| channel.name == "A").map(|alpha| &mut alpha.samples) {
            Some(Samples::Float(alpha)) => alpha[7] = 0.99,
            _ => panic!("no alpha"),
        }
        let limits = Preset::Noisy.limits();
        let failures = compare(&clear, &without, &limits).failures();
        assert_eq!(failures, ["has the channel A, which the reference lacks"]);
        assert_eq!(compare(&without, &clear, &limits).failures(), ["lacks the channel A of the reference"]);
    }
}
