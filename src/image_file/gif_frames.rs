//! Frames of animated GIF files: one-bit alpha, palettes of 256 colours, and durations in hundredths of a second.

use std::collections::HashSet;

use color_quant::NeuQuant;

use super::frame_delays::rounded_delay;

/// Most frames a second: browsers show frames of less than two hundredths of a second for ten.
pub(super) const MAX_RATE: u32 = 50;
/// Side of the dither matrix.
const SIDE: usize = 8;
/// Colours of a palette.
const COLORS: usize = 256;

/// The frame with alpha 0 or 255, by an ordered dither (Bayer 1973), and black where it is transparent. `None` where alpha is so already.
///
/// The encoder would make every pixel that is not fully transparent opaque: faint shadows would be solid black.
pub(super) fn one_bit_alpha(pixels: &[[u8; 4]], width: u32) -> Option<Vec<[u8; 4]>> {
    if pixels.iter().all(|pixel| matches!(pixel[3], 0 | 255)) {
        return None;
    }
    let dithered = pixels.iter().enumerate().map(|(at, &[r, g, b, alpha])| {
        let (x, y) = (at % width as usize, at / width as usize);
        if usize::from(alpha) * 2 * SIDE * SIDE > 255 * (2 * bayer(x, y) + 1) {
            [r, g, b, 255]
        } else {
            [0; 4]
        }
    });
    Some(dithered.collect())
}

/// The threshold of a pixel, from 0 to 63: the bits of `x ^ y` and `y` in turn, the lowest first.
fn bayer(x: usize, y: usize) -> usize {
    let bits = [x ^ y, y, (x ^ y) >> 1, y >> 1, (x ^ y) >> 2, y >> 2];
    bits.into_iter().fold(0, |sum, bit| sum << 1 | bit & 1)
}

/// Of so many pixels at a time the palette learns from one, up to the 10 that look as good as 1 and take a fraction of the time. It takes
/// some 25,000 to learn the colours of small things.
pub(super) fn palette_speed(pixels: u64) -> i32 {
    (pixels / 25_000).clamp(1, 10) as i32
}

/// Reduces the opaque pixels of a frame that has transparent ones, too, to colours that leave one of the palette for transparency (NeuQuant,
/// Dekker 1994). Frames that are opaque or have few colours stay as they are.
///
/// The encoder's own palette learns no colour of few transparent pixels: the opaque pixels of the nearest colour would be transparent.
pub(super) fn reserve_transparent_color(pixels: &mut [[u8; 4]]) {
    pixels.iter_mut().filter(|pixel| pixel[3] == 0).for_each(|pixel| *pixel = [0; 4]);
    let opaque: Vec<[u8; 4]> = pixels.iter().filter(|pixel| pixel[3] != 0).copied().collect();
    if opaque.len() == pixels.len() || !has_more_colors(&opaque, COLORS - 1) {
        return;
    }
    let palette = NeuQuant::new(palette_speed(opaque.len() as u64), COLORS - 1, opaque.as_flattened());
    let colors = palette.color_map_rgb();
    let colors = colors.as_chunks::<3>().0;
    for pixel in pixels.iter_mut().filter(|pixel| pixel[3] != 0) {
        if let Some(&[r, g, b]) = colors.get(palette.index_of(pixel)) {
            *pixel = [r, g, b, 255];
        }
    }
}

/// Whether there are more than `count` colours.
fn has_more_colors(pixels: &[[u8; 4]], count: usize) -> bool {
    let mut found = HashSet::new();
    pixels.iter().any(|pixel| found.insert(pixel) && found.len() > count)
}

/// Duration of frame `index`, milliseconds; `None` for a frame that is left out, of more than [`MAX_RATE`] a second.
pub(super) fn delay_ms(index: u64, rate: (u32, u32)) -> Option<u32> {
    if !is_too_fast(rate) {
        return Some(rounded_delay(index, rate, 100).clamp(1, 65535) * 10);
    }
    let slot = |index: u64| {
        let exact = u128::from(MAX_RATE) * u128::from(index) * u128::from(rate.1);
        exact.div_ceil(u128::from(rate.0))
    };
    (slot(index + 1) > slot(index)).then_some(1000 / MAX_RATE)
}

/// Whether a rate as numerator and denominator is more than [`MAX_RATE`].
pub(super) fn is_too_fast((numerator, denominator): (u32, u32)) -> bool {
    u64::from(numerator) > u64::from(MAX_RATE) * u64::from(denominator)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::AnimationDecoder as _;
    use image::codecs::gif::GifDecoder;

    use super::*;
    use crate::cancel::CancelFlag;
    use crate::image_file::{MovieFormat, MovieWriter};

    /// The pixels of a movie of one frame.
    fn shown(pixels: &[[u8; 4]], size: (u32, u32)) -> Vec<[u8; 4]> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gif");
        let mut movie =
            MovieWriter::begin(&path, MovieFormat::Gif, size, (24, 1), 1, &CancelFlag::new()).unwrap();
        movie.add(pixels).unwrap();
        movie.finish().unwrap();
        let bytes = std::fs::read(path).unwrap();
        let decoder = GifDecoder::new(Cursor::new(&bytes)).unwrap();
        let frame = decoder.into_frames().next().unwrap().unwrap();
        frame.buffer().pixels().map(|pixel| pixel.0).collect()
    }

    #[test]
    fn faint_shadows_are_dithered_and_not_black() {
        // 20 of 255 are 5 of 64; edges of a half are 32.
        for (alpha, opaque) in [(0, 0), (1, 0), (20, 5), (128, 32), (254, 64), (255, 64)] {
            let pixels = vec![[9, 0, 0, alpha]; SIDE * SIDE];
            let dithered = one_bit_alpha(&pixels, 8).unwrap_or(pixels);
            assert_eq!(dithered.iter().filter(|pixel| pixel[3] == 255).count(), opaque, "{alpha}");
            assert!(
                alpha == 0 || dithered.iter().all(|pixel| matches!(pixel, [9, 0, 0, 255] | [0, 0, 0, 0]))
            );
        }
        let mut thresholds: Vec<_> = (0..64).map(|at| bayer(at % 8, at / 8)).collect();
        thresholds.sort_unstable();
        assert!(thresholds.into_iter().eq(0..64));
    }

    #[test]
    fn gifs_keep_time_over_many_frames() {
        // A second's frames take a second, though at 24 fps each is shown for 40 or 50 ms.
        for rate in [(12, 1), (24, 1), (50, 1), (60, 1), (100, 1), (120, 1)] {
            let delays: Vec<_> = (0..u64::from(rate.0)).filter_map(|index| delay_ms(index, rate)).collect();
            assert_eq!(delays.iter().sum::<u32>(), 1000, "{rate:?}");
            assert!(delays.iter().all(|delay| *delay >= 20), "{rate:?}");
            assert_eq!(delays.len() as u32, rate.0.min(MAX_RATE), "{rate:?}");
        }
        assert!((0..24).all(|index| matches!(delay_ms(index, (24, 1)), Some(40 | 50))));
        assert_eq!(delay_ms(0, (1000, 1)), Some(20));
    }

    #[test]
    fn small_gifs_keep_the_colours_of_small_things() {
        // Grey from left to right, and a golden disk on a fortieth of the image.
        let gold = [194, 173, 114, 255];
        let is_gold = |at: usize| (at % 160).abs_diff(100).pow(2) + (at / 160).abs_diff(40).pow(2) < 11 * 11;
        let grey = |at: usize| 60 + (at % 160) as u8;
        let pixels: Vec<_> = (0..160 * 90)
            .map(|at| if is_gold(at) { gold } else { [grey(at), grey(at), grey(at) + 20, 255] })
            .collect();
        let shown = shown(&pixels, (160, 90))[40 * 160 + 100];
        assert!(shown.iter().zip(gold).all(|(shown, gold)| shown.abs_diff(gold) <= 6), "{shown:?}");
    }

    #[test]
    fn few_transparent_pixels_leave_the_others_opaque() {
        // Colours by the thousand over a black ground, of which some pixels are transparent.
        let (width, height) = (320, 240);
        for transparent in [0, 3, 9_000] {
            let alpha = |at: usize| if (7 * width..7 * width + transparent).contains(&at) { 0 } else { 255 };
            let color = |at: usize| match (at % width, at / width) {
                (_, 0..100) => [0, 0, 0, alpha(at)],
                (x, y) => [x as u8, y as u8, (x + y) as u8, 255],
            };
            let pixels: Vec<[u8; 4]> = (0..width * height).map(color).collect();
            let shown = shown(&pixels, (width as u32, height as u32));
            for (shown, pixel) in shown.iter().zip(&pixels) {
                assert_eq!(shown[3], pixel[3], "{transparent} transparent pixels");
                let is_near = |channel: usize| shown[channel].abs_diff(pixel[channel]) <= 96;
                assert!(pixel[3] == 0 || (0..3).all(is_near), "{shown:?} is not {pixel:?}");
            }
        }
    }

    #[test]
    fn transparent_pixels_of_few_colours_leave_the_colours_exact() {
        for colors in [1, 254, 255] {
            let mut pixels: Vec<[u8; 4]> = (0..colors).map(|at| [at as u8, 7, 200, 255]).collect();
            pixels.extend([[9, 9, 9, 0], [0, 7, 200, 0]]);
            let shown = shown(&pixels, (pixels.len() as u32, 1));
            assert_eq!(shown[..colors], pixels[..colors]);
            assert_eq!(shown[colors..].iter().map(|pixel| pixel[3]).max(), Some(0));
        }
    }

    #[test]
    fn frames_without_transparency_are_left_to_the_encoder() {
        let opaque: Vec<[u8; 4]> = (0..1000_u32).map(|at| [at as u8, (at >> 8) as u8, 7, 255]).collect();
        let mut reserved = opaque.clone();
        reserve_transparent_color(&mut reserved);
        assert_eq!(reserved, opaque);
        // Of all colours there are at most 255 with transparency.
        reserved[500] = [0; 4];
        reserve_transparent_color(&mut reserved);
        let colors: HashSet<_> = reserved.iter().filter(|pixel| pixel[3] != 0).collect();
        assert!(colors.len() < COLORS, "{}", colors.len());
        assert_eq!(reserved.iter().filter(|pixel| pixel[3] == 0).count(), 1);
    }

    #[test]
    fn movies_tell_what_they_lose() {
        let folder = tempfile::tempdir().unwrap();
        let warnings = |name: &str, alpha: u8, fps: u32| {
            let path = folder.path().join(name);
            let format = MovieFormat::of_path(&path).unwrap();
            let mut movie =
                MovieWriter::begin(&path, format, (8, 8), (fps, 1), 2, &CancelFlag::new()).unwrap();
            for _ in 0..2 {
                movie.add(&[[0, 0, 0, alpha]; 64]).unwrap();
            }
            let warnings = movie.warnings();
            movie.finish().unwrap();
            warnings.into_iter().map(|warning| warning.message).collect::<Vec<_>>().join("\n")
        };
        assert!(warnings("a.gif", 20, 50).contains("are dithered"));
        let bytes = std::fs::read(folder.path().join("a.gif")).unwrap();
        for frame in GifDecoder::new(Cursor::new(&bytes)).unwrap().into_frames() {
            let frame = frame.unwrap();
            assert_eq!(frame.buffer().pixels().filter(|pixel| pixel.0[3] == 255).count(), 5);
        }
        assert!(warnings("b.gif", 255, 60).contains("50 frames a second at most"));
        assert_eq!(warnings("c.gif", 255, 24), "");
        assert_eq!(warnings("a.webp", 20, 60), "");
        assert!(warnings("b.webp", 255, 2000).contains("b.webp: frames are shown for 1/1000 s at least"));
    }
}
