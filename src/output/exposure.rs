//! Automatic exposure from rendered films.

use glam::Vec3;

use crate::color::luminance;
use crate::film::{Film, LightPass};

/// Luminance of a photographic grey card: the target where no base colours are known.
const MIDDLE_GREY: f64 = 0.18;
/// Reflectance of a common dielectric, which is added to its base colour: the least target of a surface.
const REFLECTANCE: f64 = 0.04;

/// Lower bound of a pixel's value as a share of the mean. Black pixels tell nothing about the light.
const DARKEST_SHARE: f64 = 0.25;
/// Share of the lit surfaces that are brightest, and how many times their base colours they may reach.
const BRIGHTEST: (f64, f64) = (0.05, 1.5);
/// Share of its target from which on a surface counts as lit.
const LIT_SHARE: f64 = 1.0 / 16.0;
/// Coverage by surfaces above which the background is ignored.
const LEAST_COVERAGE: f64 = 0.01;

/// Bounds of automatic exposure, in stops. Files that give their lamps in physical units are up to 16 stops too bright. Weak
/// light is raised by two stops at most, so that dark scenes stay dark.
pub const AUTO_EXPOSURE_BOUNDS: [f32; 2] = [-16.0, 2.0];

/// Whether surfaces cover enough of the films to decide the exposure.
pub fn covers_enough(films: &[Film]) -> bool {
    let pixels = films.iter().flat_map(|film| &film.pixels);
    let (cover, count) =
        pixels.fold((0.0, 0_u64), |(cover, count), pixel| (cover + f64::from(pixel[3]), count + 1));
    cover >= LEAST_COVERAGE * count as f64 && cover > 0.0
}

/// Exposure, in stops, that brings the pixels' luminance to that of their base colours, or to middle grey where no pixel's centre shows
/// a surface.
///
/// Both enter by their geometric means, so a dark asset stays dark and a white one white: what is measured is the light on
/// them. Pixels that emit more light than they reflect are left out where the film has light passes. The others are weighted by
/// coverage. Values have a lower bound, or a few black pixels would lower the geometric mean without limit. Where base colours are
/// known, all but the brightest twentieth of what is lit stay below 1.5 times their own, so that a pool of light in the dark is not blown out.
/// Without any light the exposure is 0. The value stays within [`AUTO_EXPOSURE_BOUNDS`] and is rounded to hundredths, so that the
/// printed value can be passed as an option.
pub fn auto_exposure_ev(films: &[Film]) -> f32 {
    let pixels = metered_pixels(films);
    let light = mean_stops(&pixels, |pixel| pixel.luminance);
    let target = mean_stops(&pixels, |pixel| pixel.target);
    let (Some(light), Some(target)) = (light, target) else { return 0.0 };
    let has_base_colors = films.iter().any(|film| film.aovs.centers.is_some());
    let [least, most] = AUTO_EXPOSURE_BOUNDS;
    let ev = (target - light).min(f64::from(most));
    let most_for_highlights = if has_base_colors { highlight_limit_ev(pixels, ev) } else { f64::INFINITY };
    let ev = most_for_highlights.min(ev);
    // The sum with zero turns −0 into 0.
    ((libm::round(ev * 100.0) / 100.0) as f32).clamp(least, most) + 0.0
}

/// Exposure, in stops, at which all but the brightest twentieth of what emits light is at most white; 0 where it is at 0 already.
pub fn emission_ev(films: &[Film]) -> f32 {
    let mut emitters: Vec<_> = films.iter().flat_map(emitters).collect();
    emitters.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let brightest = BRIGHTEST.0 * emitters.iter().map(|(cover, _)| cover).sum::<f64>();
    let reached = reached(&emitters, |(cover, _)| *cover, brightest);
    let ev = reached.map_or(0.0, |(_, luminance)| -libm::log2(*luminance));
    let ev = (libm::round(ev * 100.0) / 100.0) as f32;
    ev.clamp(AUTO_EXPOSURE_BOUNDS[0], 0.0) + 0.0
}

/// Coverage and luminance of the pixels that emit light.
fn emitters(film: &Film) -> impl Iterator<Item = (f64, f64)> {
    let passes = film.aovs.light.iter().flatten();
    let emission = passes.map(|passes| Vec3::from_array(passes[LightPass::Emission.index()]));
    film.pixels.iter().zip(emission).filter_map(|(pixel, emission)| {
        let cover = f64::from(pixel[3]);
        let luminance = f64::from(luminance(emission)) / cover;
        (cover > 0.0 && luminance > 0.0 && luminance.is_finite()).then_some((cover, luminance))
    })
}

/// The geometric mean of the luminance that [`auto_exposure_ev`] measures, in stops; `None` without any light.
pub fn measured_light_stops(films: &[Film]) -> Option<f64> {
    let pixels = metered_pixels(films);
    mean_stops(&pixels, |pixel| pixel.luminance)
}

/// A pixel that is at least partly covered, and not mainly by what emits light.
struct MeteredPixel {
    cover: f64,
    luminance: f64,
    /// Luminance that it should have.
    target: f64,
}

/// The pixels that decide the exposure. Where the centres of some show surfaces, those whose centres show none are left out: of what covers them, a silhouette or
/// a thin part, no base colour is known. Centres of pixels that are not metered, on lamps or where nothing covers, leave out none.
fn metered_pixels(films: &[Film]) -> Vec<MeteredPixel> {
    let (of_surfaces, others): (Vec<_>, Vec<_>) =
        films.iter().flat_map(metered_pixels_of).partition(|(_, shows_surface)| *shows_surface);
    let deciding = if of_surfaces.is_empty() { others } else { of_surfaces };
    deciding.into_iter().map(|(pixel, _)| pixel).collect()
}

/// The metered pixels of a film, each with whether its centre shows a surface.
fn metered_pixels_of(film: &Film) -> impl Iterator<Item = (MeteredPixel, bool)> {
    film.pixels.iter().enumerate().filter_map(|(index, &[r, g, b, alpha])| {
        let value = f64::from(luminance(Vec3::new(r, g, b))) / f64::from(alpha);
        let center = film.aovs.centers.as_ref().map(|centers| centers[index]);
        let surface = center.filter(|center| center.instance.is_some());
        let target = match surface {
            None => MIDDLE_GREY,
            Some(center) => f64::from(luminance(center.albedo)) + REFLECTANCE,
        };
        let passes = film.aovs.light.as_ref().map(|passes| passes[index][LightPass::Emission.index()]);
        let emitted = passes.map_or(0.0, |emission| f64::from(luminance(Vec3::from_array(emission))));
        let is_reflector = emitted <= value * f64::from(alpha) * 0.5;
        let is_metered = alpha > 0.0 && value.is_finite() && target.is_finite() && is_reflector;
        let pixel = MeteredPixel { cover: f64::from(alpha), luminance: value, target };
        is_metered.then_some((pixel, surface.is_some()))
    })
}

/// Exposure that brings the darkest of the brightest pixels to a multiple of its target. Pixels that are black at the exposure `ev` count less
/// among all: as far as they are darker than [`LIT_SHARE`] of their targets.
fn highlight_limit_ev(mut pixels: Vec<MeteredPixel>, ev: f64) -> f64 {
    let (share, multiple) = BRIGHTEST;
    let scale = libm::exp2(ev);
    let lit = |pixel: &MeteredPixel| (pixel.luminance * scale / (LIT_SHARE * pixel.target)).min(1.0);
    let brightness = |pixel: &MeteredPixel| pixel.luminance / pixel.target;
    pixels.sort_by(|a, b| brightness(b).total_cmp(&brightness(a)));
    let brightest = share * pixels.iter().map(|pixel| pixel.cover * lit(pixel)).sum::<f64>();
    match reached(&pixels, |pixel| pixel.cover, brightest).map(brightness) {
        Some(brightness) if brightness > 0.0 => libm::log2(multiple / brightness),
        _ => f64::INFINITY,
    }
}

/// The first item up to which the items cover `total`.
fn reached<T>(items: &[T], cover: impl Fn(&T) -> f64, total: f64) -> Option<&T> {
    let mut rest = total;
    items.iter().find(|item| {
        rest -= cover(item);
        rest <= 0.0
    })
}

/// Mean of the binary logarithm of a value of the pixels; `None` without any light or coverage.
fn mean_stops(pixels: &[MeteredPixel], value: fn(&MeteredPixel) -> f64) -> Option<f64> {
    let cover: f64 = pixels.iter().map(|pixel| pixel.cover).sum();
    let mean = pixels.iter().map(|pixel| value(pixel) * pixel.cover).sum::<f64>() / cover;
    if cover <= 0.0 || mean <= 0.0 {
        return None;
    }
    let darkest = mean * DARKEST_SHARE;
    let stops = |value: f64| libm::log2(if value > darkest { value } else { darkest });
    Some(pixels.iter().map(|pixel| stops(value(pixel)) * pixel.cover).sum::<f64>() / cover)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PixelCenterSample, PixelWindow};

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

    /// A film whose pixels all show surfaces of the base colours `albedos`.
    fn film_of_surfaces(pixels: &[[f32; 4]], albedos: &[f32]) -> Film {
        let of = |&albedo: &f32| PixelCenterSample {
            instance: Some(0),
            albedo: Vec3::splat(albedo),
            ..PixelCenterSample::default()
        };
        let mut film = film(pixels);
        film.aovs.centers = Some(albedos.iter().map(of).collect());
        film
    }

    #[test]
    fn base_colours_decide_and_dark_assets_stay_dark() {
        // Under light of one a dielectric of base colour c reflects c + 0.04.
        for albedo in [0.0, 0.02, 0.18, 0.9] {
            let shown = albedo + 0.04;
            let lit = |light: f32| [[shown * light, shown * light, shown * light, 1.0]];
            assert_eq!(auto_exposure_ev(&[film_of_surfaces(&lit(1.0), &[albedo])]), 0.0, "{albedo}");
            assert_eq!(auto_exposure_ev(&[film_of_surfaces(&lit(8.0), &[albedo])]), -3.0, "{albedo}");
        }
        // A chequer of black and white.
        let chequer = [[0.04, 0.04, 0.04, 1.0], [0.94, 0.94, 0.94, 1.0]];
        assert_eq!(auto_exposure_ev(&[film_of_surfaces(&chequer, &[0.0, 0.9])]), 0.0);
    }

    #[test]
    fn silhouettes_do_not_decide_beside_surfaces() {
        // White in light of 1, and as much of it in pixels whose centres miss it
        let white = 0.94;
        let mut film = film_of_surfaces(&[[white, white, white, 1.0], [white, white, white, 1.0]], &[0.9; 2]);
        let centers = film.aovs.centers.as_mut().unwrap();
        centers[1] = PixelCenterSample::default();
        assert_eq!(auto_exposure_ev(&[film.clone()]), 0.0);
        // Where no centre shows a surface, all are taken for grey: 0.18 / 0.94 is −2.38 stops.
        film.aovs.centers.as_mut().unwrap()[0] = PixelCenterSample::default();
        assert_eq!(auto_exposure_ev(&[film.clone()]), -2.38);
        // One frame of a sequence may show some.
        let shown = film_of_surfaces(&[[white, white, white, 1.0]], &[0.9]);
        assert_eq!(auto_exposure_ev(&[film, shown]), 0.0);
    }

    #[test]
    fn centres_that_are_not_metered_leave_silhouettes_to_decide() {
        // A silhouette of twice grey, beside a pixel whose centre shows a surface that no sample found: one stop too bright
        let pixels = [[0.36, 0.36, 0.36, 1.0], [0.0; 4]];
        let mut film = film_of_surfaces(&pixels, &[0.9; 2]);
        film.aovs.centers.as_mut().unwrap()[0] = PixelCenterSample::default();
        assert_eq!(auto_exposure_ev(&[film.clone()]), -1.0);
        // Or beside a lamp.
        film.pixels[1] = [9.0, 9.0, 9.0, 1.0];
        let pass =
            |emitted: f32, direct: f32| [[emitted; 3], [direct; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]];
        film.aovs.light = Some(vec![pass(0.0, 0.36), pass(9.0, 0.0)]);
        assert_eq!(auto_exposure_ev(&[film]), -1.0);
    }

    #[test]
    fn pools_of_light_are_not_blown_out() {
        // A fifth has 8 times its base colour, the rest 1/64 of it: 1.5 times the base colour is log2(1.5 / 8) = −2.415 stops.
        let (shown, dark) = (0.22 * 8.0, 0.22 / 64.0);
        let pool = [[shown, shown, shown, 1.0]];
        let pixels = [&pool[..], &[[dark, dark, dark, 1.0]; 4]].concat();
        assert_eq!(auto_exposure_ev(&[film_of_surfaces(&pixels, &[0.18; 5])]), -2.42);
        // A fiftieth in the dark is a pool, too.
        let pixels = [&pool[..], &[[0.0, 0.0, 0.0, 1.0]; 49]].concat();
        assert_eq!(auto_exposure_ev(&[film_of_surfaces(&pixels, &[0.18; 50])]), -2.42);
        // Highlights over what is lit do not decide, however bright they are.
        for (count, brightness) in [(40, 100.0), (30, 150.0), (10, 400.0), (2, 1600.0)] {
            let shown = 0.22 * brightness;
            let pixels =
                [vec![[shown, shown, shown, 1.0]; count], vec![[0.22, 0.22, 0.22, 1.0]; 1000 - count]]
                    .concat();
            let ev = auto_exposure_ev(&[film_of_surfaces(&pixels, &[0.18; 1000])]);
            assert!((-0.7..=0.0).contains(&ev), "{count} {brightness}: {ev}");
        }
        // A highlight of a thirtieth does not decide.
        let pixels = [&pool[..], &[[0.22, 0.22, 0.22, 1.0]; 29]].concat();
        assert!(auto_exposure_ev(&[film_of_surfaces(&pixels, &[0.18; 30])]) > -0.2);
    }

    #[test]
    fn emitters_do_not_decide() {
        let mut film = film(&[[0.36, 0.36, 0.36, 1.0], [9.0, 9.0, 9.0, 1.0]]);
        let emission = |value: f32| [[value; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]];
        let direct = |value: f32| [[0.0; 3], [value; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]];
        film.aovs.light = Some(vec![direct(0.36), emission(8.0)]);
        assert_eq!(auto_exposure_ev(&[film.clone()]), -1.0);
        // An unlit scene shows its own colours.
        film.aovs.light = Some(vec![emission(0.36), emission(9.0)]);
        assert_eq!(auto_exposure_ev(&[film]), 0.0);
    }

    #[test]
    fn emitters_alone_are_at_most_white() {
        let pixels = |count: usize, value: f32| vec![[value, value, value, 1.0]; count];
        let of = |bright: usize, value: f32| {
            let mut film = film(&[pixels(bright, value), pixels(100 - bright, 0.5)].concat());
            let emission =
                |pixel: &[f32; 4]| [[pixel[0]; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]];
            film.aovs.light = Some(film.pixels.iter().map(emission).collect());
            emission_ev(&[film])
        };
        assert_eq!([of(50, 0.9), of(50, 4.0), of(50, 1e6), of(4, 4.0)], [0.0, -2.0, -16.0, 0.0]);
        assert_eq!(emission_ev(&[film(&pixels(1, 4.0))]), 0.0);
    }

    #[test]
    fn automatic_exposure_is_bounded() {
        let grey = |value: f32| auto_exposure_ev(&[film(&[[value, value, value, 1.0]])]);
        assert_eq!((grey(1e-4), grey(0.0448)), (2.0, 2.0));
        assert_eq!((grey(1e4), grey(1e6)), (-15.76, -16.0));
    }

    #[test]
    fn a_hundredth_of_the_image_is_enough() {
        let covered = |cover| covers_enough(&[film(&[[0.0; 4], [0.0, 0.0, 0.0, cover]])]);
        assert!(covered(0.021) && covered(1.0) && !covered(0.019) && !covered(0.0) && !covers_enough(&[]));
    }
}
