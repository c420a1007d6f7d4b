//! Light in files of DWA compression, which stores halves and errs.

use exr::prelude::Compression;
use half::f16;

use crate::image::{Channel, Samples};

/// The greatest light of a channel that DWA's cosine transform takes.
///
/// Of light above 1 the transform stores `1 + ln(light) / 2.2`, of three colours by way of luma and chroma. What exceeds 6.041 is decoded as
/// infinity; the greatest half, 65504, is at 6.0408. At the level of this program, 45, an error of at most 0.116 is added:
///
/// - 0.020 in luma and 0.016 in chroma, the sums over all coefficients of a block of their tolerance times their share of a pixel;
/// - 0.023 in both by rounding the coefficients to halves: 2⁻¹¹ of each, whose squares sum to at most 64 · 5.92²;
/// - chroma counts 1.8556 times in blue, the colour in which it counts most.
///
/// This light is at 5.918, and the remaining 0.007 are for tables and arithmetic.
const MOST_LIGHT: f32 = 49984.0;

/// Clamps the light of a channel that `compression` would decode as infinity, if so. Other channels are kept: DWA stores them exactly.
pub(super) fn with_finite_light(mut channel: Channel, compression: Compression) -> Channel {
    let suffix = channel.name.rsplit('.').next().unwrap_or_default();
    if matches!(compression, Compression::DWAA(_) | Compression::DWAB(_)) && is_transformed(suffix) {
        match &mut channel.samples {
            Samples::Half(samples) => {
                let most = f16::from_f32(MOST_LIGHT);
                for sample in samples {
                    *sample = sample.clamp(-most, most);
                }
            }
            Samples::Float(samples) => {
                for sample in samples {
                    *sample = sample.clamp(-MOST_LIGHT, MOST_LIGHT);
                }
            }
            Samples::Uint(_) => {}
        }
    }
    channel
}

/// Whether the last part of a channel's name is one that DWA transforms. It takes no logarithm of a single one of a layer, such as `sky.Y`, which
/// this program does not write.
fn is_transformed(suffix: &str) -> bool {
    matches!(suffix, "R" | "G" | "B" | "Y" | "RY" | "BY")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::image::{ColorEncoding, Image, PixelWindow, RenderedScene, half_from_f32};
    use crate::image_file::{ExrCompression, FrameAttributes, decode_exr, encode_exr};

    const SIDE: u32 = 64;
    const NAMES: [&str; 4] = ["R", "G", "B", "Y"];

    /// The channels of `NAMES`, decoded from a file.
    fn decoded(
        compression: ExrCompression,
        is_half: bool,
        light: impl Fn(u32, usize) -> f32,
    ) -> Vec<Vec<f32>> {
        let channel = |(at, name): (usize, &str)| {
            let values = (0..SIDE * SIDE).map(|pixel| light(pixel, at));
            let samples = if is_half {
                Samples::Half(values.map(half_from_f32).collect())
            } else {
                Samples::Float(values.collect())
            };
            Channel { name: name.to_owned(), samples }
        };
        let image = Image {
            display_window: PixelWindow::full(SIDE, SIDE),
            data_window: PixelWindow::full(SIDE, SIDE),
            encoding: ColorEncoding::Linear,
            channels: NAMES.into_iter().enumerate().map(channel).collect(),
            scene: RenderedScene::default(),
        };
        let bytes = encode_exr(image, compression, &FrameAttributes::unknown()).unwrap();
        let read = decode_exr(Path::new("a.exr"), &bytes, 1 << 30).unwrap();
        let samples =
            |name| read.channels.iter().find(|channel| channel.name == name).unwrap().samples.floats();
        NAMES.into_iter().map(|name| samples(name).unwrap().into_owned()).collect()
    }

    /// Name, and light of a pixel and a channel.
    type Block<'b> = (&'b str, &'b dyn Fn(u32, usize) -> f32);

    /// A number that looks random.
    fn hash(pixel: u32, channel: usize) -> u32 {
        let mixed = (pixel * 4 + channel as u32).wrapping_mul(0x9e37_79b9);
        (mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca6b) >> 13
    }

    #[test]
    fn the_brightest_light_stays_finite() {
        let bright = |is_bright: bool| if is_bright { 200_000.0 } else { 0.0 };
        let blocks: [Block<'_>; 9] = [
            ("everywhere", &|_, _| 200_000.0),
            ("pixels at random", &|pixel, channel| bright(hash(pixel, channel).is_multiple_of(2))),
            ("few dark pixels", &|pixel, _| bright(!hash(pixel, 0).is_multiple_of(40))),
            ("few bright pixels", &|pixel, _| bright(hash(pixel, 0).is_multiple_of(40))),
            ("a chequerboard", &|pixel, channel| {
                bright((pixel % SIDE + pixel / SIDE + channel as u32).is_multiple_of(2))
            }),
            ("an edge", &|pixel, _| bright(pixel % SIDE * 3 > pixel / SIDE * 2)),
            ("one colour", &|pixel, channel| bright(channel == (pixel / 8 % 3) as usize)),
            ("of any brightness", &|pixel, channel| 65504.0 - (hash(pixel, channel) % 30_000) as f32),
            ("of both signs", &|pixel, channel| {
                f32::INFINITY.copysign((hash(pixel, channel) % 2) as f32 - 0.5)
            }),
        ];
        for compression in [ExrCompression::Dwaa, ExrCompression::Dwab] {
            for is_half in [true, false] {
                for (name, light) in blocks {
                    let channels = decoded(compression, is_half, light);
                    let is_finite = channels.iter().flatten().all(|value| value.is_finite());
                    assert!(is_finite, "{} {name}, half: {is_half}", compression.name());
                }
            }
        }
    }

    #[test]
    fn light_below_the_clamp_is_kept_within_the_error() {
        let light = |pixel: u32, _| 40_000.0 + 2.0 * pixel as f32;
        for channel in decoded(ExrCompression::Dwaa, true, light) {
            for (pixel, value) in (0..).zip(channel) {
                let expected = light(pixel, 0).min(MOST_LIGHT);
                assert!((value / expected - 1.0).abs() < 0.05, "{value} is not {expected}");
            }
        }
    }

    #[test]
    fn only_light_that_dwa_transforms_is_clamped() {
        let clamped = |name: &str, compression| {
            let channel = Channel { name: name.to_owned(), samples: Samples::Float(vec![1e10, -1e10, 7.0]) };
            with_finite_light(channel, compression).samples
        };
        let (kept, most) = (vec![1e10, -1e10, 7.0], vec![MOST_LIGHT, -MOST_LIGHT, 7.0]);
        assert_eq!(clamped("Z", Compression::DWAA(None)), Samples::Float(kept.clone()));
        assert_eq!(clamped("A", Compression::DWAB(None)), Samples::Float(kept.clone()));
        assert_eq!(clamped("R", Compression::ZIP16), Samples::Float(kept));
        for (name, compression) in [("R", Compression::DWAA(None)), ("direct.B", Compression::DWAB(None))] {
            assert_eq!(clamped(name, compression), Samples::Float(most.clone()));
        }
    }
}
