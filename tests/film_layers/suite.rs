//! Over the scenes in `scenes/`: parts of light sum to the colour, and layers depend on nothing that the colour does not.

use std::path::Path;

use rayframe::cancel::CancelFlag;
use rayframe::film::{Film, LayerRequest, LightPart, PixelWindow};
use rayframe::regression::{SceneRenderer, discover};
use rayframe::render::{Adaptive, Aperture, Focus, Lens, PixelFilter, RenderSettings};

const ALL: LayerRequest = LayerRequest { light: true, centres: true, coverage: true };

fn scenes() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

fn settings(resolution: (u32, u32), samples: u32) -> RenderSettings {
    let window = PixelWindow::full(resolution.0, resolution.1);
    RenderSettings { resolution, window, samples, ..RenderSettings::default() }
}

#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
fn film(scene: &SceneRenderer, time_seconds: f64, settings: &RenderSettings) -> Film {
    scene.render_film(time_seconds, settings, &CancelFlag::new()).unwrap().0
}

/// The distance of halves around `value`: 11 significant bits, down to 2⁻²⁴.
fn half_ulp(value: f32) -> f32 {
    let exponent = (value.to_bits() >> 23 & 0xff) as i32 - 127;
    f32::from_bits(((exponent.clamp(-14, 100) - 10 + 127) as u32) << 23)
}

/// As a half stores it, within its range.
fn rounded(value: f32) -> f32 {
    let ulp = half_ulp(value);
    (value / ulp).round_ties_even() * ulp
}

/// The colour is the same with and without layers, its parts sum to it, and coverage is at most whole.
///
/// Stored as halves the sum is off by less than two units: of parts that are not negative only one can have the colour's
/// exponent (half a unit of rounding), up to three the one below (a quarter each), and the colour is rounded, too.
#[test]
fn parts_sum_to_the_colour_on_all_scenes() {
    let plain = settings((16, 9), 2);
    let layered = RenderSettings { layers: ALL, ..plain.clone() };
    let mut largest = [0.0_f32; 6];
    for shot in discover(&scenes()).unwrap() {
        let scene = SceneRenderer::open(&shot.scene).unwrap();
        let time_seconds = f64::from(shot.frame) / 24.0;
        let (plain, layered) = (film(&scene, time_seconds, &plain), film(&scene, time_seconds, &layered));
        let bits =
            |film: &Film| -> Vec<u32> { film.pixels.as_flattened().iter().map(|c| c.to_bits()).collect() };
        assert!(bits(&plain) == bits(&layered), "{}: layers change the colour", shot.name);

        let (light, coverage) = (layered.layers.light.unwrap(), layered.layers.coverage.unwrap());
        for (pixel, parts) in layered.pixels.iter().zip(&light) {
            for channel in 0..3 {
                let sum: f32 = parts.iter().map(|part| part[channel]).sum();
                let difference = (sum - pixel[channel]).abs();
                assert!(difference <= 1e-5 * pixel[channel], "{}: {parts:?} are not {pixel:?}", shot.name);
                let stored: f32 = parts.iter().map(|part| rounded(part[channel])).sum();
                let difference = (stored - rounded(pixel[channel])).abs();
                let allowed = 2.0 * half_ulp(pixel[channel]);
                assert!(difference <= allowed, "{}: {parts:?} are not {pixel:?}", shot.name);
            }
            for (largest, part) in largest.iter_mut().zip(parts) {
                *largest = largest.max(part[0]);
            }
        }
        for (pixel, shares) in layered.pixels.iter().zip(&coverage) {
            assert!(shares.is_sorted_by(|a, b| a.0 < b.0), "{}: {shares:?}", shot.name);
            let sum: f32 = shares.iter().map(|&(_, share)| share).sum();
            assert!(sum <= pixel[3] + 1e-5, "{}: {shares:?} cover {pixel:?}", shot.name);
        }
    }
    // Each part is somewhere.
    for (part, largest) in LightPart::ALL.into_iter().zip(largest) {
        assert!(largest > 0.1, "{part:?}: {largest}");
    }
}

#[test]
fn without_a_background_shares_sum_to_the_coverage() {
    let layers = LayerRequest { coverage: true, ..LayerRequest::NONE };
    let settings = RenderSettings { layers, show_background: false, ..settings((32, 18), 4) };
    for name in ["material/alpha_blend_stack", "demo/whitted_1980", "light/point"] {
        let scene = SceneRenderer::open(&scenes().join(name).with_extension("gltf")).unwrap();
        let film = film(&scene, 0.0, &settings);
        for (pixel, shares) in film.pixels.iter().zip(film.layers.coverage.unwrap()) {
            // What is dropped of nearly covered samples, at most 1/1024, counts as covered.
            let sum: f32 = shares.iter().map(|&(_, share)| share).sum();
            assert!((sum - pixel[3]).abs() < 1.1 / 1024.0, "{name}: {shares:?} are not {pixel:?}");
        }
    }
}

/// Everything at once: samples beyond the tile, negative weights, a lens, rough mirrors.
fn elaborate() -> RenderSettings {
    RenderSettings {
        adaptive: Some(Adaptive { most_samples: 6, threshold: 0.05 }),
        filter: PixelFilter::Mitchell,
        lens: Some(Lens { aperture: Aperture::Radius(0.02), focus: Focus::Middle }),
        glossy_samples: 2,
        layers: ALL,
        ..settings((50, 40), 3)
    }
}

#[test]
fn crops_and_threads_leave_layers_as_they_are() {
    for (name, time_seconds) in [("demo/whitted_1980", 0.2), ("material/alpha_blend_stack", 0.0)] {
        let scene = SceneRenderer::open(&scenes().join(name).with_extension("gltf")).unwrap();
        let whole = film(&scene, time_seconds, &elaborate());
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| film(&scene, time_seconds, &elaborate())) == whole, "{name}: {threads}");
        }

        let window = PixelWindow { x0: 13, y0: 30, x1: 37, y1: 39 };
        let crop = film(&scene, time_seconds, &RenderSettings { window, ..elaborate() });
        let mut part = Film::with_layers(whole.resolution, window, ALL);
        for y in window.y0..window.y1 {
            for x in window.x0..window.x1 {
                let from = (y * 50 + x) as usize;
                let to = ((y - window.y0) * window.width() + x - window.x0) as usize;
                part.pixels[to] = whole.pixels[from];
                let (all, part) = (&whole.layers, &mut part.layers);
                part.light.as_mut().unwrap()[to] = all.light.as_ref().unwrap()[from];
                part.centres.as_mut().unwrap()[to] = all.centres.as_ref().unwrap()[from];
                part.coverage.as_mut().unwrap()[to] = all.coverage.as_ref().unwrap()[from].clone();
            }
        }
        assert!(crop == part, "{name}: a crop is not the same part of the whole");
    }
}

#[test]
fn parts_of_an_elaborate_picture_sum_to_it_where_nothing_is_clamped() {
    let scene = SceneRenderer::open(&scenes().join("demo/whitted_1980.gltf")).unwrap();
    let film = film(&scene, 0.2, &elaborate());
    let mut compared = 0;
    for (pixel, parts) in film.pixels.iter().zip(film.layers.light.unwrap()) {
        for channel in 0..3 {
            let sum: f32 = parts.iter().map(|part| part[channel]).sum();
            if pixel[channel] > 0.0 {
                assert!((sum - pixel[channel]).abs() <= 2.0 * half_ulp(pixel[channel]));
                compared += 1;
            } else {
                assert!(sum <= 1e-6, "{sum} was clamped");
            }
        }
    }
    assert!(compared > 5000, "{compared}");
}
