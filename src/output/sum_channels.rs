//! Exact sums as image channels, so that samples rendered apart can be added: four unsigned 32-bit channels a sum.
//!
//! All channels are in the layer `sums`. The first of four words is the lowest one; together they are a fixed-point number as in
//! [`ExactSum`].

use crate::film::{ExactSum, GuideSums, LightPass, LightSums, PixelMoments, PixelSums, SampleSums, SumFlags};
use crate::image::{Channel, Image, Samples};
use crate::image_file::SUM_LAYER;

/// Names of the sums of guides.
const GUIDES: [[&str; 3]; 2] = [["albedo_R", "albedo_G", "albedo_B"], ["normal_X", "normal_Y", "normal_Z"]];
const RGBA: [&str; 4] = ["R", "G", "B", "A"];

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
        let most = coverage.iter().map(Vec::len).max().unwrap_or(0);
        for rank in 0..most {
            let at = |shares: &Vec<(u32, ExactSum)>| shares.get(rank).copied();
            // 0 is no instance.
            let instance = |shares| at(shares).map_or(0, |(instance, _)| instance + 1);
            channels.push(uint(&format!("instance{rank}"), coverage.iter().map(instance)));
            let share = |shares: &Vec<_>| at(shares).map_or(ExactSum::default(), |(_, share)| share);
            add_words(&mut channels, &format!("share{rank}_"), coverage, share);
        }
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
        for rank in 0.. {
            let Some(instances) = words(image, &format!("instance{rank}")) else { break };
            let mut shares = vec![ExactSum::default(); instances.len()];
            set_sums(&mut shares, image, &format!("share{rank}_"), |share| share)?;
            for ((pixel, &instance), share) in coverage.iter_mut().zip(instances).zip(shares) {
                pixel.extend(instance.checked_sub(1).map(|instance| (instance, share)));
            }
        }
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
    let word = |word: usize| words(image, &format!("{name}{word}"));
    let [w0, w1, w2, w3] = [word(0)?, word(1)?, word(2)?, word(3)?];
    for (pixel, (((&w0, &w1), &w2), &w3)) in pixels.iter_mut().zip(w0.iter().zip(w1).zip(w2).zip(w3)) {
        *sum(pixel) = ExactSum::from_words([w0, w1, w2, w3]);
    }
    Some(())
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
        let image = Image {
            display_window: PixelWindow::full(8, 8),
            data_window: window,
            encoding: ColorEncoding::Linear,
            scene: RenderedScene::default(),
            channels: sum_channels(&sums),
        };
        assert_eq!(sums_of_image(&image, flags), Some(sums));
        let names = image.channels.iter().map(|channel| channel.name.as_str());
        assert_eq!(sum_flags(names), Some(SumFlags { coverage: false, ..flags }));
        assert_eq!(sum_flags(["R", "G"].into_iter()), None);
    }
}
