//! Automatic exposure from rendered films.

use glam::Vec3;

use crate::color::luminance;
use crate::film::Film;

/// Luminance of a photographic grey card, the target of the geometric mean.
const MIDDLE_GREY: f64 = 0.18;

/// Lower bound of a pixel's luminance as a share of the mean. Black pixels tell nothing about the light.
const DARKEST_SHARE: f64 = 0.25;
/// Coverage by surfaces above which the background is ignored.
const LEAST_COVERAGE: f64 = 0.01;

/// Whether surfaces cover enough of the films to decide the exposure.
pub fn covers_enough(films: &[Film]) -> bool {
    let pixels = films.iter().flat_map(|film| &film.pixels);
    let (cover, count) =
        pixels.fold((0.0, 0_u64), |(cover, count), pixel| (cover + f64::from(pixel[3]), count + 1));
    cover >= LEAST_COVERAGE * count as f64 && cover > 0.0
}

/// Exposure, in stops, that brings the geometric mean of the pixels' luminance to middle grey.
///
/// Pixels are weighted by coverage. Their luminance has a lower bound, or a few black pixels would lower the geometric mean
/// without limit. Without any light the exposure is 0. The value is rounded to hundredths, so that the printed value can be
/// passed as an option.
pub fn auto_exposure_ev(films: &[Film]) -> f32 {
    let pixels = || films.iter().flat_map(|film| &film.pixels).filter_map(straight);
    let cover: f64 = pixels().map(|(_, cover)| cover).sum();
    let mean = pixels().map(|(value, cover)| value * cover).sum::<f64>() / cover;
    if cover <= 0.0 || mean <= 0.0 {
        return 0.0;
    }
    let darkest = mean * DARKEST_SHARE;
    let stops = |value: f64| libm::log2(if value > darkest { value } else { darkest });
    let sum: f64 = pixels().map(|(value, cover)| stops(value) * cover).sum();
    let ev = libm::log2(MIDDLE_GREY) - sum / cover;
    (libm::round(ev * 100.0) / 100.0) as f32
}

/// Luminance and coverage of a pixel; `None` without coverage.
fn straight(&[r, g, b, alpha]: &[f32; 4]) -> Option<(f64, f64)> {
    let value = f64::from(luminance(Vec3::new(r, g, b))) / f64::from(alpha);
    (alpha > 0.0 && value.is_finite()).then_some((value, f64::from(alpha)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PixelWindow;

    fn film(pixels: &[[f32; 4]]) -> Film {
        let size = (pixels.len() as u32, 1);
        let mut film = Film::new(size, PixelWindow::full(size.0, size.1));
        film.pixels = pixels.to_vec();
        film
    }

    #[test]
    fn grey_needs_no_exposure_and_a_stop_is_a_factor_of_two() {
        assert_eq!(auto_exposure_ev(&[film(&[[0.18, 0.18, 0.18, 1.0]])]), 0.0);
        assert_eq!(auto_exposure_ev(&[film(&[[0.36, 0.36, 0.36, 1.0]])]), -1.0);
        // The geometric mean of 0.09 and 0.36 is 0.18.
        let films = [film(&[[0.09, 0.09, 0.09, 1.0]]), film(&[[0.36, 0.36, 0.36, 1.0]])];
        assert_eq!(auto_exposure_ev(&films), 0.0);
    }

    #[test]
    fn pixels_are_weighted_by_coverage() {
        // Premultiplied: the surface itself has 0.36, and empty pixels do not count.
        let half = [0.18, 0.18, 0.18, 0.5];
        assert_eq!(auto_exposure_ev(&[film(&[[0.0; 4], half])]), -1.0);
        // Covers 1 and ½ with 0.18 and 0.18 · 2³: the mean in stops is 3 · ½ / 1.5 = 1.
        assert_eq!(auto_exposure_ev(&[film(&[[0.18, 0.18, 0.18, 1.0], [0.72, 0.72, 0.72, 0.5]])]), -1.0);
        assert_eq!(auto_exposure_ev(&[]), 0.0);
        assert_eq!(auto_exposure_ev(&[film(&[[0.0; 4]])]), 0.0);
        assert_eq!(auto_exposure_ev(&[film(&[[0.0, 0.0, 0.0, 1.0]])]), 0.0);
    }

    #[test]
    fn black_pixels_count_as_a_share_of_the_mean() {
        // Half is black and half 0.36: the mean is 0.18, the darkest counts 2⁻² of that; half of (1 − 2) stops.
        let grey = [0.36, 0.36, 0.36, 1.0];
        for dark in [0.0, 1e-30, 1e-6] {
            assert_eq!(auto_exposure_ev(&[film(&[grey, [dark, dark, dark, 1.0]])]), 0.5, "{dark}");
        }
        // However many: the mean itself is never raised beyond 2 stops above grey.
        let mut many = vec![[0.0, 0.0, 0.0, 1.0]; 9999];
        many.push([1800.0, 1800.0, 1800.0, 1.0]);
        assert_eq!(auto_exposure_ev(&[film(&many)]), 2.0);
    }

    #[test]
    fn a_hundredth_of_the_image_is_enough() {
        let covered = |cover| covers_enough(&[film(&[[0.0; 4], [0.0, 0.0, 0.0, cover]])]);
        assert!(covered(0.021) && covered(1.0) && !covered(0.019) && !covered(0.0) && !covers_enough(&[]));
    }
}
