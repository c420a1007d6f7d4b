//! Image plates: images behind the scene, resampled to its pixels.

use rayon::prelude::*;

use super::{PixelWindow, RgbaImage};

/// Weights below this share of a pixel are rounding errors.
const LEAST_WEIGHT: f64 = 1e-6;

/// How a plate of another aspect ratio fills the image. It is always centred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlateFit {
    /// Covers the image; what reaches beyond is cut off.
    #[default]
    Fill,
    /// Lies inside the image; what is left is transparent.
    Fit,
    /// Takes the aspect ratio of the image.
    Stretch,
}

/// The pixels of a plate behind a window of the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// Row-major linear R, G, B, A of the window, premultiplied.
    pub pixels: Vec<[f32; 4]>,
    /// Whether the values are display-referred: neither exposure nor tone curve changes them.
    pub is_display_referred: bool,
}

impl Plate {
    /// Pixels over the plate.
    pub fn under(&self, pixels: &[[f32; 4]]) -> Vec<[f32; 4]> {
        debug_assert_eq!(self.pixels.len(), pixels.len());
        pixels.iter().zip(&self.pixels).map(|(pixel, plate)| over(*pixel, *plate)).collect()
    }
}

/// A premultiplied pixel over another one.
pub fn over(pixel: [f32; 4], behind: [f32; 4]) -> [f32; 4] {
    let left = 1.0 - pixel[3];
    std::array::from_fn(|channel| pixel[channel] + behind[channel] * left)
}

/// The pixels of `window` of an image of size `resolution` that shows `source`, whose pixels have the ratio `pixel_aspect` of width to
/// height, as `fit` says.
///
/// Reduced images take the mean over the area of each pixel, enlarged ones are interpolated linearly. A pixel does not depend on
/// the window.
pub fn resample(
    source: &RgbaImage,
    pixel_aspect: f64,
    resolution: (u32, u32),
    window: PixelWindow,
    fit: PlateFit,
) -> Vec<[f32; 4]> {
    let (width, height) = source.size;
    let scales = scales(source.size, pixel_aspect, resolution, fit);
    let columns = axis_weights(width, resolution.0, scales.0, window.x0..window.x1);
    let rows = axis_weights(height, resolution.1, scales.1, window.y0..window.y1);

    // Along the rows, for all rows of the source that are seen
    let first = rows.iter().filter_map(|row| Some(row.first()?.0)).min().unwrap_or(0);
    let end = rows.iter().filter_map(|row| Some(row.last()?.0 + 1)).max().unwrap_or(0);
    let across: Vec<Vec<[f32; 4]>> = (first..end)
        .into_par_iter()
        .map(|row| {
            let pixels = &source.pixels[row * width as usize..][..width as usize];
            columns.iter().map(|weights| weighted(weights, |column| pixels[column])).collect()
        })
        .collect();

    // Along the columns
    let resampled = rows.par_iter().map(|weights| {
        (0..columns.len()).map(|column| weighted(weights, |row| across[row - first][column])).collect()
    });
    resampled.collect::<Vec<Vec<_>>>().concat()
}

/// Pixels of the image a pixel of the source, along both axes.
fn scales(source: (u32, u32), pixel_aspect: f64, resolution: (u32, u32), fit: PlateFit) -> (f64, f64) {
    let x = f64::from(resolution.0) / f64::from(source.0);
    let y = f64::from(resolution.1) / f64::from(source.1);
    let height = match fit {
        PlateFit::Fill => y.max(x / pixel_aspect),
        PlateFit::Fit => y.min(x / pixel_aspect),
        PlateFit::Stretch => return (x, y),
    };
    (height * pixel_aspect, height)
}

/// For each pixel of `range` along one axis of the image, the pixels of the source that it shows, with weights whose sum is the
/// covered share of the pixel.
fn axis_weights(source: u32, image: u32, scale: f64, range: std::ops::Range<u32>) -> Vec<Vec<(usize, f32)>> {
    let length = f64::from(source) * scale;
    let start = (f64::from(image) - length) * 0.5;
    let last = f64::from(source) - 1.0;
    let weights = |pixel: u32| {
        let (low, high) = (f64::from(pixel), f64::from(pixel) + 1.0);
        let covered = high.min(start + length) - low.max(start);
        if covered < LEAST_WEIGHT {
            return Vec::new();
        }
        let shares: Vec<(f64, f64)> = if scale <= 1.0 {
            // Overlaps of the pixel's interval with the pixels of the source
            let from = ((low - start) / scale).max(0.0);
            let to = ((high - start) / scale).min(last + 1.0);
            let indices = (from.floor() as u32)..(to.ceil() as u32);
            indices.map(f64::from).map(|at| (at, ((at + 1.0).min(to) - at.max(from)) * scale)).collect()
        } else {
            let center = ((low + 0.5 - start) / scale - 0.5).clamp(0.0, last);
            let before = center.floor();
            vec![(before, 1.0 - (center - before)), (before + 1.0, center - before)]
        };
        normalized(&shares, if covered > 1.0 - LEAST_WEIGHT { 1.0 } else { covered })
    };
    range.map(weights).collect()
}

/// Weights with the sum `total`, without those that are next to nothing.
fn normalized(shares: &[(f64, f64)], total: f64) -> Vec<(usize, f32)> {
    let kept = shares.iter().filter(|(_, share)| *share > LEAST_WEIGHT);
    let sum: f64 = kept.clone().map(|(_, share)| share).sum();
    kept.map(|&(index, share)| (index as usize, (share / sum * total) as f32)).collect()
}

fn weighted(weights: &[(usize, f32)], pixel: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
    let mut sum = [0.0; 4];
    for &(index, weight) in weights {
        let pixel = pixel(index);
        sum.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += channel * weight);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grey pixels whose values count up from 1.
    fn counted(width: u32, height: u32) -> RgbaImage {
        let pixel = |index: u32| {
            let value = (index + 1) as f32;
            [value, value, value, 1.0]
        };
        RgbaImage { size: (width, height), pixels: (0..width * height).map(pixel).collect() }
    }

    fn reds(source: &RgbaImage, resolution: (u32, u32), fit: PlateFit) -> Vec<f32> {
        let window = PixelWindow::full(resolution.0, resolution.1);
        resample(source, 1.0, resolution, window, fit).iter().map(|pixel| pixel[0]).collect()
    }

    #[test]
    fn an_image_of_the_same_size_is_copied() {
        for fit in [PlateFit::Fill, PlateFit::Fit, PlateFit::Stretch] {
            let source = counted(7, 5);
            assert_eq!(resample(&source, 1.0, (7, 5), PixelWindow::full(7, 5), fit), source.pixels);
        }
    }

    #[test]
    fn reduced_images_are_means_over_areas() {
        // Each pixel is the mean of 2 x 2: 1, 2, 5, 6 and so on.
        assert_eq!(reds(&counted(4, 4), (2, 2), PlateFit::Fill), [3.5, 5.5, 11.5, 13.5]);
        // Three pixels on two: (1 + 2/2) / 1.5 and (2/2 + 3) / 1.5.
        let two = reds(&counted(3, 1), (2, 1), PlateFit::Stretch);
        assert!((two[0] - 4.0 / 3.0).abs() < 1e-6 && (two[1] - 8.0 / 3.0).abs() < 1e-6, "{two:?}");
    }

    #[test]
    fn enlarged_images_are_interpolated() {
        assert_eq!(reds(&counted(2, 1), (4, 1), PlateFit::Stretch), [1.0, 1.25, 1.75, 2.0]);
    }

    #[test]
    fn plates_of_other_shapes_are_cut_framed_or_stretched() {
        // Four columns and two rows over two by two: the middle two columns.
        assert_eq!(reds(&counted(4, 2), (2, 2), PlateFit::Fill), [2.0, 3.0, 6.0, 7.0]);
        assert_eq!(reds(&counted(4, 2), (2, 2), PlateFit::Stretch), [1.5, 3.5, 5.5, 7.5]);
        // Inside: the first row covers half of the first row of the image. Half the mean of 1 and 2.
        let fitted = resample(&counted(4, 2), 1.0, (2, 2), PixelWindow::full(2, 2), PlateFit::Fit);
        assert_eq!(fitted[0], [0.75, 0.75, 0.75, 0.5]);
        assert_eq!(
            resample(&counted(1, 1), 1.0, (3, 1), PixelWindow::full(3, 1), PlateFit::Fit)[0],
            [0.0; 4]
        );
    }

    #[test]
    fn wide_pixels_are_shown_wide() {
        let wide = |resolution: (u32, u32), fit| {
            let window = PixelWindow::full(resolution.0, resolution.1);
            let pixels = resample(&counted(2, 2), 2.0, resolution, window, fit);
            pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>()
        };
        let whole = [1.0, 1.25, 1.75, 2.0, 3.0, 3.25, 3.75, 4.0];
        for fit in [PlateFit::Fill, PlateFit::Fit, PlateFit::Stretch] {
            assert_eq!(wide((4, 2), fit), whole);
        }
        assert_eq!(wide((2, 2), PlateFit::Fill), [1.25, 1.75, 3.25, 3.75]);
    }

    #[test]
    fn a_window_holds_the_pixels_of_the_whole() {
        let source = counted(37, 23);
        for resolution in [(19, 31), (80, 60), (5, 5)] {
            for fit in [PlateFit::Fill, PlateFit::Fit, PlateFit::Stretch] {
                let (width, height) = resolution;
                let whole = resample(&source, 1.0, resolution, PixelWindow::full(width, height), fit);
                let window = PixelWindow { x0: 1, y0: 2, x1: 4, y1: 5 };
                let part = resample(&source, 1.0, resolution, window, fit);
                for (index, pixel) in part.iter().enumerate() {
                    let (x, y) = (1 + index % 3, 2 + index / 3);
                    assert_eq!(*pixel, whole[y * width as usize + x]);
                }
            }
        }
    }

    #[test]
    fn pixels_cover_the_plate_by_their_alpha() {
        let plate = Plate { pixels: vec![[0.5, 0.5, 0.5, 1.0]], is_display_referred: false };
        assert_eq!(plate.under(&[[0.25, 0.0, 0.0, 0.5]]), [[0.5, 0.25, 0.25, 1.0]]);
    }
}
