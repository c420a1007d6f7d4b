//! Automatic exposure of previews: one value for a whole animation.

use glam::Vec3;

use crate::color::luminance;
use crate::film::Film;

/// Luminance of the photographer's grey card, to which the geometric mean is brought.
const MIDDLE_GREY: f64 = 0.18;

/// The exposure, in stops, that brings the geometric mean of all pixels' luminance to middle grey.
///
/// Pixels that are black or transparent say nothing about the light and do not count; without any other the exposure is
/// 0. The value is rounded to hundredths, so that what is printed can be typed again.
pub fn auto_exposure_ev(films: &[Film]) -> f32 {
    let mut sum = 0.0;
    let mut count = 0_u32;
    for &[r, g, b, alpha] in films.iter().flat_map(|film| &film.pixels) {
        let value = f64::from(luminance(Vec3::new(r, g, b))) / f64::from(alpha);
        if alpha > 0.0 && value > 0.0 && value.is_finite() {
            sum += libm::log2(value);
            count += 1;
        }
    }
    if count == 0 {
        return 0.0;
    }
    let ev = libm::log2(MIDDLE_GREY) - sum / f64::from(count);
    (libm::round(ev * 100.0) / 100.0) as f32
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
    fn black_and_empty_pixels_do_not_count() {
        let black = [0.0, 0.0, 0.0, 1.0];
        let empty = [0.0; 4];
        // Half covered, premultiplied: the surface itself has 0.36.
        let half = [0.18, 0.18, 0.18, 0.5];
        assert_eq!(auto_exposure_ev(&[film(&[black, empty, half])]), -1.0);
        assert_eq!(auto_exposure_ev(&[film(&[black, empty])]), 0.0);
        assert_eq!(auto_exposure_ev(&[]), 0.0);
    }
}
