//! Exact sums as image channels, so that samples rendered apart can be added: four unsigned 32-bit channels a sum.
//!
//! All channels are in the layer `sums`. The first of four words is the lowest one; together they are a fixed-point number as in
//! [`ExactSum`].
//!
//! Few pixels show many mesh instances. So the channel `instances` counts those of each pixel, and their indices and shares are one list over
//! all pixels, which fills the pixels of `instance0` and `share0_0` to `share0_3`, then those of `instance1` and so on. Behind its end are zeros.

use crate::film::{ExactSum, GuideSums, LightPass, LightSums, PixelMoments, PixelSums, SampleSums, SumFlags};
use crate::image::{Channel, Image, Samples};
use crate::image_file::SUM_LAYER;

/// Names of the sums of guides.
const GUIDES: [[&str; 3]; 2] = [["albedo_R", "albedo_G", "albedo_B"], ["normal_X", "normal_Y", "normal_Z"]];
const RGBA: [&str; 4] = ["R", "G", "B", "A"];

/// Shares of the instances of one pixel.
type Shares = Vec<(u32, ExactSum)>;

/// The channels of the sums of colours, and of light passes and moments where they are recorded.
pub fn sum_channels(sums: &SampleSums) -> Vec<Channel> {
    let mut channels = Vec::new();
    let pixels = &sums.pixels;
    channels.push(uint("weight", pixels.iter().map(|pixel| pixel.weight as u32)));
    channels.push(uint("count", pixels.iter().map(|pixel| pixel.count)));
    for (c, name) in RGBA.into_iter().enumerate() {
        add_words(&mut channels, name, pixels, |pixel| pixel.light[c]);
    }
    if let Some(moments) = &sums.moments {
        for (c, name) in RGBA.into_iter().enumerate() {
            add_words(&mut channels, &format!("first_{name}"), moments, |moments| moments.sums[c]);
            add_words(&mut channels, &format!("second_{name}"), moments, |moments| moments.squares[c]);
        }
    }
    if let Some(light) = &sums.light {
        for pass in LightPass::ALL {
            for (c, name) in RGBA[..3].iter().enumerate() {
                let name = format!("{}_{name}", pass.name());
                add_words(&mut channels, &name, light, |light| light[pass.index()][c]);
            }
        }
    }
    if let Some(guides) = &sums.guides {
        for (guide, names) in GUIDES.into_iter().enumerate() {
            for (c, name) in names.into_iter().enumerate() {
                add_words(&mut channels, name, guides, |guides| guides[guide][c]);
            }
        }
    }
    if let Some(coverage) = &sums.coverage {
        add_coverage(&mut channels, coverage);
    }
    channels
}

/// The sums in the channels of `image`: those of colours, and `flags` of the others. `None` where a channel is missing.
pub fn sums_of_image(image: &Image, flags: SumFlags) -> Option<SampleSums> {
    let mut sums = SampleSums::new(image.data_window, flags);
    set(&mut sums.pixels, words(image, "weight")?, |pixel, weight| pixel.weight = weight as i32);
    set(&mut sums.pixels, words(image, "count")?, |pixel: &mut PixelSums, count| pixel.count = count);
    for (c, name) in RGBA.into_iter().enumerate() {
        set_sums(&mut sums.pixels, image, name, |pixel| &mut pixel.light[c])?;
    }
    for (c, name) in RGBA.into_iter().enumerate() {
        let Some(moments) = &mut sums.moments else { break };
        set_sums(moments, image, &format!("first_{name}"), |moments: &mut PixelMoments| {
            &mut moments.sums[c]
        })?;
        set_sums(moments, image, &format!("second_{name}"), |moments| &mut moments.squares[c])?;
    }
    for pass in LightPass::ALL {
        let Some(light) = &mut sums.light else { break };
        for (c, name) in RGBA[..3].iter().enumerate() {
            let name = format!("{}_{name}", pass.name());
            set_sums(light, image, &name, |light: &mut LightSums| &mut light[pass.index()][c])?;
        }
    }
    for (guide, names) in GUIDES.into_iter().enumerate() {
        let Some(guides) = &mut sums.guides else { break };
        for (c, name) in names.into_iter().enumerate() {
            set_sums(guides, image, name, |guides: &mut GuideSums| &mut guides[guide][c])?;
        }
    }
    if let Some(coverage) = &mut sums.coverage {
        set_coverage(coverage, image)?;
    }
    Some(sums)
}

/// Which sums the channels of an image hold, besides those of colours and coverage; `None` for an image without sums.
pub fn sum_flags<'n>(mut channels: impl Iterator<Item = &'n str> + Clone) -> Option<SumFlags> {
    let has = |name: &str| channels.clone().any(|channel| channel.strip_prefix(SUM_LAYER) == Some(name));
    let flags = SumFlags {
        moments: has("first_R0"),
        light: has("direct_R0"),
        guides: has("albedo_R0"),
        coverage: false,
    };
    channels.any(|channel| channel.starts_with(SUM_LAYER)).then_some(flags)
}

/// Adds the number of instances of each pixel, and the list of all.
fn add_coverage(channels: &mut Vec<Channel>, coverage: &[Shares]) {
    channels.push(uint("instances", coverage.iter().map(|shares| shares.len() as u32)));
    let pixels = coverage.len();
    let total: usize = coverage.iter().map(Vec::len).sum();
    let mut listed = coverage.iter().flatten();
    for layer in 0..total.div_ceil(pixels.max(1)) {
        let mut instances = vec![0; pixels];
        let mut words: [_; ExactSum::WORDS] = std::array::from_fn(|_| vec![0; pixels]);
        for (at, &(instance, share)) in listed.by_ref().take(pixels).enumerate() {
            instances[at] = instance;
            for (words, word) in words.iter_mut().zip(share.to_words()) {
                words[at] = word;
            }
        }
        let named = |name: String, samples| Channel { name, samples: Samples::Uint(samples) };
        channels.push(named(format!("{SUM_LAYER}instance{layer}"), instances));
        for (word, words) in words.into_iter().enumerate() {
            channels.push(named(format!("{SUM_LAYER}share{layer}_{word}"), words));
        }
    }
}

/// Sets the shares that [`add_coverage`] stored. `None` where a channel is missing, or the list is too short.
fn set_coverage(coverage: &mut [Shares], image: &Image) -> Option<()> {
    let mut layers = Vec::new();
    for layer in 0.. {
        let Some(instances) = words(image, &format!("instance{layer}")) else { break };
        layers.push((instances, sum_words(image, &format!("share{layer}_"))?));
    }
    let mut listed = layers.iter().flat_map(|&(instances, words)| instances.iter().copied().zip(sums(words)));
    for (shares, &count) in coverage.iter_mut().zip(words(image, "instances")?) {
        shares.extend(listed.by_ref().take(count as usize));
        if shares.len() != count as usize {
            return None;
        }
    }
    Some(())
}

fn uint(name: &str, values: impl Iterator<Item = u32>) -> Channel {
    Channel { name: format!("{SUM_LAYER}{name}"), samples: Samples::Uint(values.collect()) }
}

fn add_words<T>(channels: &mut Vec<Channel>, name: &str, pixels: &[T], sum: impl Fn(&T) -> ExactSum) {
    for word in 0..ExactSum::WORDS {
        channels.push(uint(&format!("{name}{word}"), pixels.iter().map(|pixel| sum(pixel).to_words()[word])));
    }
}

fn words<'i>(image: &'i Image, name: &str) -> Option<&'i [u32]> {
    match &image.channel(&format!("{SUM_LAYER}{name}"))?.samples {
        Samples::Uint(words) => Some(words),
        _ => None,
    }
}

fn set<T>(pixels: &mut [T], words: &[u32], set: impl Fn(&mut T, u32)) {
    pixels.iter_mut().zip(words).for_each(|(pixel, &word)| set(pixel, word));
}

fn set_sums<T>(
    pixels: &mut [T],
    image: &Image,
    name: &str,
    sum: impl Fn(&mut T) -> &mut ExactSum,
) -> Option<()> {
    let values = sums(sum_words(image, name)?);
    pixels.iter_mut().zip(values).for_each(|(pixel, value)| *sum(pixel) = value);
    Some(())
}

/// The words of the sums `name`, the lowest first.
fn sum_words<'i>(image: &'i Image, name: &str) -> Option<[&'i [u32]; ExactSum::WORDS]> {
    let word = |word: usize| words(image, &format!("{name}{word}"));
    Some([word(0)?, word(1)?, word(2)?, word(3)?])
}

/// The sums of such words.
fn sums([w0, w1, w2, w3]: [&[u32]; ExactSum::WORDS]) -> impl Iterator<Item = ExactSum> {
    let words = w0.iter().zip(w1).zip(w2).zip(w3);
    words.map(|(((&w0, &w1), &w2), &w3)| ExactSum::from_words([w0, w1, w2, w3]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PixelWindow, add_exact_share};
    use crate::image::{ColorEncoding, RenderedScene};

    fn exact(value: f32) -> ExactSum {
        let mut sum = ExactSum::default();
        sum.add(value);
        sum
    }

    fn image_of(sums: &SampleSums) -> Image {
        Image {
            display_window: PixelWindow::full(8, 8),
            data_window: sums.window,
            encoding: ColorEncoding::Linear,
            scene: RenderedScene::default(),
            channels: sum_channels(sums),
        }
    }

    #[test]
    fn channels_hold_every_sum() {
        let window = PixelWindow { x0: 3, y0: 1, x1: 5, y1: 2 };
        let flags = SumFlags { moments: true, light: true, coverage: true, guides: true };
        let mut sums = SampleSums::new(window, flags);
        let pixel = PixelSums { light: [1.5, -2e6, 1e-9, 3.0].map(exact), weight: -3, count: 7 };
        sums.pixels[1] = pixel;
        sums.moments.as_mut().unwrap()[0].squares[2] = exact(9e9);
        sums.light.as_mut().unwrap()[1][4][2] = exact(-0.25);
        add_exact_share(&mut sums.coverage.as_mut().unwrap()[0], 5, exact(2.0));
        add_exact_share(&mut sums.coverage.as_mut().unwrap()[0], 0, exact(1.0));
        let image = image_of(&sums);
        assert_eq!(sums_of_image(&image, flags), Some(sums));
        let names = image.channels.iter().map(|channel| channel.name.as_str());
        assert_eq!(sum_flags(names), Some(SumFlags { coverage: false, ..flags }));
        assert_eq!(sum_flags(["R", "G"].into_iter()), None);
    }

    #[test]
    fn coverage_takes_the_memory_of_what_covers() {
        let flags = SumFlags { coverage: true, ..SumFlags::default() };
        let mut sums = SampleSums::new(PixelWindow { x0: 2, y0: 1, x1: 7, y1: 5 }, flags);
        let channels = |sums: &SampleSums| sum_channels(sums).len();
        let without = channels(&sums);
        assert_eq!(sums_of_image(&image_of(&sums), flags), Some(sums.clone()));
        // Twenty shares of one pixel and one of another are more than one list over twenty pixels.
        for instance in 0..20 {
            let coverage = sums.coverage.as_mut().unwrap();
            add_exact_share(&mut coverage[7], 3 * instance, exact(instance as f32 - 4.5));
        }
        assert_eq!(channels(&sums), without + 5);
        assert_eq!(sums_of_image(&image_of(&sums), flags), Some(sums.clone()));
        add_exact_share(&mut sums.coverage.as_mut().unwrap()[19], 0, exact(1e9));
        assert_eq!(channels(&sums), without + 10);
        let mut image = image_of(&sums);
        assert_eq!(sums_of_image(&image, flags), Some(sums));
        image.channels.retain(|channel| !channel.name.ends_with("instance1"));
        assert_eq!(sums_of_image(&image, flags), None);
    }
}
