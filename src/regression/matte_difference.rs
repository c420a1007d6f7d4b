//! Differences between Cryptomattes (Friedman and Jones 2015): for each pixel, the ids of what covers it and their coverage, by falling coverage.
//!
//! An id is the hash of a name in the bits of a float, and no magnitude. Nearly equal coverages may change ranks. So the coverage of each id
//! is compared, whatever its rank.

use std::borrow::Cow;

use super::channel_difference::{ChannelDifference, ValueLimits};
use super::{Channel, Image};

/// One rank of a Cryptomatte.
struct Rank<'a> {
    /// Names of the channels of ids and of coverage.
    names: [&'a str; 2],
    ids: Cow<'a, [f32]>,
    coverage: Cow<'a, [f32]>,
}

/// Coverage of a pixel by one id.
struct Share {
    id: u32,
    /// First rank of the id, in the reference if it is there.
    rank: usize,
    actual: f64,
    reference: f64,
}

/// Compares the ranks of a Cryptomatte, and sets `is_beyond` for each pixel where the coverage of an id is beyond both limits. Differences
/// count for the coverage channel of the id's rank; channels of ids have counts of different bits alone.
///
/// Empty where the images have not the same ranks.
pub(super) fn matte_differences(
    layer: &str,
    images: [&Image; 2],
    limits: &ValueLimits,
    is_beyond: &mut [bool],
) -> Vec<ChannelDifference> {
    let [actual, reference] = images.map(|image| ranks(image, layer));
    if !actual.iter().map(|rank| rank.names).eq(reference.iter().map(|rank| rank.names)) {
        return Vec::new();
    }
    let width = images[1].size().0;
    let mut found: Vec<[ChannelDifference; 2]> =
        reference.iter().map(|rank| rank.names.map(ChannelDifference::named)).collect();
    let mut shares = Vec::new();
    for (at, is_beyond) in is_beyond.iter_mut().enumerate() {
        let mut differs = false;
        for ([ids, coverage], (ours, theirs)) in found.iter_mut().zip(actual.iter().zip(&reference)) {
            for (channel, ours, theirs) in
                [(ids, &ours.ids, &theirs.ids), (coverage, &ours.coverage, &theirs.coverage)]
            {
                let is_different = ours[at].to_bits() != theirs[at].to_bits();
                channel.different += usize::from(is_different);
                differs |= is_different;
            }
        }
        if !differs {
            continue;
        }
        shares.clear();
        add_shares(&mut shares, &reference, at, |share| &mut share.reference);
        add_shares(&mut shares, &actual, at, |share| &mut share.actual);
        for share in &shares {
            let difference = (share.actual - share.reference).abs();
            if difference.is_finite() {
                let coverage = &mut found[share.rank][1];
                *is_beyond |= coverage.count(difference, share.reference.abs(), limits, (at, width));
            }
        }
    }
    found.into_iter().flatten().collect()
}

/// Adds the coverage of each id of a pixel to its side of the shares.
fn add_shares(shares: &mut Vec<Share>, ranks: &[Rank<'_>], at: usize, side: impl Fn(&mut Share) -> &mut f64) {
    for (index, rank) in ranks.iter().enumerate() {
        let id = rank.ids[at].to_bits();
        let known = shares.iter().position(|share| share.id == id).unwrap_or_else(|| {
            shares.push(Share { id, rank: index, actual: 0.0, reference: 0.0 });
            shares.len() - 1
        });
        *side(&mut shares[known]) += f64::from(rank.coverage[at]);
    }
}

/// The ranks of a Cryptomatte by name: `00.R` and `00.G`, `00.B` and `00.A`, `01.R` and so on, also with `r` or `red` for `R`.
fn ranks<'a>(image: &'a Image, layer: &'a str) -> Vec<Rank<'a>> {
    let rank_of = |ids: &'a Channel| {
        let (pair, component) = ids.name.rsplit_once('.')?;
        let is_rank = pair.ends_with(|character: char| character.is_ascii_digit());
        let coverage = match component {
            "R" if is_rank => "G",
            "B" if is_rank => "A",
            "r" if is_rank => "g",
            "b" if is_rank => "a",
            "red" if is_rank => "green",
            "blue" if is_rank => "alpha",
            _ => return None,
        };
        let coverage = image.channel(&format!("{pair}.{coverage}"))?;
        let names = [ids, coverage].map(|channel| channel.name.as_str());
        Some(Rank { names, ids: ids.samples.floats()?, coverage: coverage.samples.floats()? })
    };
    let mut ranks: Vec<_> = image.channels_of(layer).filter_map(rank_of).collect();
    ranks.sort_unstable_by_key(|rank| rank.names);
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::PixelWindow;
    use crate::regression::{ColorEncoding, Preset, Samples, compare};

    const SIZE: (u32, u32) = (20, 20);
    /// Hashes of two names. As numbers they are 6e-20 and 2e-25.
    const IDS: [u32; 2] = [0x1f8e_5a31, 0x1678_90ab];

    /// A grey image whose pixels are covered by these ids and shares, under the names of channels of a program.
    fn covered(names: [&str; 4], shares: [(u32, f32); 2]) -> Image {
        let pixels = [[0.5, 0.5, 0.5, 1.0]; (SIZE.0 * SIZE.1) as usize];
        let mut image = Image::from_rgba(SIZE, ColorEncoding::Linear, &pixels);
        let values = shares.into_iter().flat_map(|(id, share)| [f32::from_bits(id), share]);
        let channels = names.into_iter().zip(values).map(|(name, value)| Channel {
            name: name.to_owned(),
            samples: Samples::Float(vec![value; pixels.len()]),
        });
        image.channels.extend(channels);
        image
    }

    const OWN: [&str; 4] =
        ["crypto_object00.R", "crypto_object00.G", "crypto_object00.B", "crypto_object00.A"];
    /// Two ranks of two layers.
    const BLENDER: [&str; 4] =
        ["V.CryptoObject00.b", "V.CryptoObject00.a", "V.CryptoObject01.r", "V.CryptoObject01.g"];

    /// Whole words, and no name of the type.
    const WORDS: [&str; 4] =
        ["cryptomatte00.red", "cryptomatte00.green", "cryptomatte00.blue", "cryptomatte00.alpha"];

    #[test]
    fn swapped_names_fail_though_their_hashes_are_tiny_numbers() {
        for names in [OWN, BLENDER, WORDS] {
            let reference = covered(names, [(IDS[0], 0.75), (IDS[1], 0.25)]);
            let swapped = covered(names, [(IDS[1], 0.75), (IDS[0], 0.25)]);
            for preset in Preset::ALL {
                let comparison = compare(&swapped, &reference, &preset.limits());
                assert!(!comparison.passes(), "{names:?} {}", preset.name());
            }
            let comparison = compare(&swapped, &reference, &Preset::Strict.limits());
            let failures = comparison.failures().join("\n");
            assert!(failures.contains("off by more than 0.001 and 0.1 %: 1 > 0.0001"), "{failures}");
            let largest = comparison.layers.iter().flat_map(|layer| &layer.channels);
            assert_eq!(largest.map(|channel| channel.largest).fold(0.0, f64::max), 0.5);
        }
    }

    #[test]
    fn coverages_that_change_ranks_are_no_difference() {
        for names in [OWN, BLENDER, WORDS] {
            let reference = covered(names, [(IDS[0], 0.5001), (IDS[1], 0.4999)]);
            let changed = covered(names, [(IDS[1], 0.5001), (IDS[0], 0.4999)]);
            let comparison = compare(&changed, &reference, &Preset::Strict.limits());
            assert!(comparison.passes(), "{:?}", comparison.failures());
            assert!(!comparison.is_identical);
            assert!(!compare(&changed, &reference, &Preset::Exact.limits()).passes());
        }
    }

    #[test]
    fn the_pixel_whose_names_are_swapped_is_told() {
        const AT: (u32, u32) = (13, 7);
        for names in [OWN, BLENDER, WORDS] {
            let cropped = |image: Image| Image {
                data_window: PixelWindow { x0: 100, y0: 50, x1: 100 + SIZE.0, y1: 50 + SIZE.1 },
                display_window: PixelWindow::full(200, 150),
                ..image
            };
            let reference = cropped(covered(names, [(IDS[0], 0.75), (IDS[1], 0.25)]));
            let mut actual = reference.clone();
            for (name, id) in [(names[0], IDS[1]), (names[2], IDS[0])] {
                let channel = actual.channels.iter_mut().find(|channel| channel.name == name).unwrap();
                let Samples::Float(values) = &mut channel.samples else { panic!("ids are floats") };
                values[(AT.1 * SIZE.0 + AT.0) as usize] = f32::from_bits(id);
            }
            let comparison = compare(&actual, &reference, &Preset::Strict.limits());
            let pixels: usize = comparison.layers.iter().map(|layer| layer.different_pixels).sum();
            let channels = comparison.layers.iter().flat_map(|layer| &layer.channels);
            let differing: Vec<_> = channels.filter(|channel| channel.largest > 0.0).collect();
            assert!(pixels > 0 && !differing.is_empty(), "{names:?}");
            for channel in differing {
                // In the whole image. One name gained half of the pixel, and the other lost it.
                assert_eq!((channel.largest, channel.largest_at), (0.5, (113, 57)), "{names:?}");
            }
            let failures = comparison.failures().join("\n");
            assert!(failures.contains("column 113, row 57"), "{failures}");
        }
    }

    #[test]
    fn an_id_that_appears_counts_by_its_coverage() {
        let reference = covered(OWN, [(IDS[0], 1.0), (0, 0.0)]);
        let of = |share: f32| {
            let actual = covered(OWN, [(IDS[0], 1.0 - share), (IDS[1], share)]);
            compare(&actual, &reference, &Preset::Visual.limits()).passes()
        };
        assert!(of(0.005) && !of(0.05));
    }
}
