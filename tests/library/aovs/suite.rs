//! AOVs of the scenes in `scenes/`: light passes sum to the colour, and AOVs depend only on what the colour depends on.

use std::path::Path;

use rayframe::cancel::CancelFlag;
use rayframe::film::{AovFlags, Film, LightPass, PixelWindow};
use rayframe::frame::Frame;
use rayframe::regression::suite::{Suite, discover};
use rayframe::render::{Adaptive, Aperture, Focus, Lens, PixelFilter, RenderSettings};
use rayframe::sequence::{SequenceJob, render_single_frame};
use rayframe::shot::{ShotRequest, shot_job};

const ALL: AovFlags = AovFlags { light: true, centers: true, coverage: true, ..AovFlags::NONE };

fn scenes() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// The job that `rayframe test` runs for a shot.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn job(path: &Path) -> SequenceJob {
    let suite = scenes().join("suite.toml");
    shot_job(&ShotRequest { path, suite: Some(&suite), overrides: &[] }).unwrap().sequence
}

/// Every image of the suite: name and job of its shot, and its time in seconds.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn images() -> impl Iterator<Item = (String, SequenceJob, f64)> {
    let shots = discover(&Suite::read(&scenes()).unwrap()).unwrap();
    shots.into_iter().flat_map(|shot| {
        let job = job(&shot.path);
        let times: Vec<f64> = job.frames.iter().map(|&frame| job.rate.time_seconds(frame)).collect();
        times.into_iter().map(move |time_seconds| (shot.name.clone(), job.clone(), time_seconds))
    })
}

/// The job of a scene without its shot file.
fn scene_job(name: &str) -> SequenceJob {
    job(&scenes().join(name).with_extension("gltf"))
}

fn settings(job: &SequenceJob, resolution: (u32, u32), samples: u32) -> RenderSettings {
    let window = PixelWindow::full(resolution.0, resolution.1);
    RenderSettings { resolution, window, samples, ..job.render.clone() }
}

#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
fn film(job: &SequenceJob, time_seconds: f64, settings: &RenderSettings) -> Film {
    let frame = Frame::at(&job.scene, &job.selection, time_seconds);
    render_single_frame(job, &frame, settings, &CancelFlag::new()).unwrap().0
}

/// The spacing of half floats around `value`: 11 significant bits, down to 2⁻²⁴.
fn half_ulp(value: f32) -> f32 {
    let exponent = (value.to_bits() >> 23 & 0xff) as i32 - 127;
    f32::from_bits(((exponent.clamp(-14, 100) - 10 + 127) as u32) << 23)
}

/// `value` rounded to a half float.
fn rounded(value: f32) -> f32 {
    let ulp = half_ulp(value);
    (value / ulp).round_ties_even() * ulp
}

/// The colour is the same with and without AOVs, light passes sum to it, and coverage is at most one.
///
/// The sum of light passes as half floats is off by less than two units. Of terms that are not negative, only one can have the
/// exponent of the colour (half a unit of rounding), up to three the exponent below (a quarter each); the colour is rounded, too.
#[test]
fn light_passes_sum_to_the_colour_on_all_scenes() {
    let mut largest = [0.0_f32; 6];
    for (name, job, time_seconds) in images() {
        let plain = settings(&job, (16, 9), 2);
        let layered = RenderSettings { aovs: ALL, ..plain.clone() };
        let (plain, layered) = (film(&job, time_seconds, &plain), film(&job, time_seconds, &layered));
        let bits =
            |film: &Film| -> Vec<u32> { film.pixels.as_flattened().iter().map(|c| c.to_bits()).collect() };
        assert!(bits(&plain) == bits(&layered), "{name}: layers change the colour");

        let (light, coverage) = (layered.aovs.light.unwrap(), layered.aovs.coverage.unwrap());
        for (pixel, parts) in layered.pixels.iter().zip(&light) {
            for channel in 0..3 {
                let sum: f32 = parts.iter().map(|part| part[channel]).sum();
                let difference = (sum - pixel[channel]).abs();
                assert!(difference <= 1e-5 * pixel[channel], "{name}: {parts:?} are not {pixel:?}");
                let stored: f32 = parts.iter().map(|part| rounded(part[channel])).sum();
                let difference = (stored - rounded(pixel[channel])).abs();
                let allowed = 2.0 * half_ulp(pixel[channel]);
                assert!(difference <= allowed, "{name}: {parts:?} are not {pixel:?}");
            }
            for (largest, part) in largest.iter_mut().zip(parts) {
                *largest = largest.max(part[0]);
            }
        }
        for (pixel, shares) in layered.pixels.iter().zip(&coverage) {
            assert!(shares.is_sorted_by(|a, b| a.0 < b.0), "{name}: {shares:?}");
            let sum: f32 = shares.iter().map(|&(_, share)| share).sum();
            assert!(sum <= pixel[3] + 1e-5, "{name}: {shares:?} cover {pixel:?}");
        }
    }
    // Each light pass occurs in some scene.
    for (part, largest) in LightPass::ALL.into_iter().zip(largest) {
        assert!(largest > 0.1, "{part:?}: {largest}");
    }
}

#[test]
fn without_a_background_coverage_samples_sum_to_alpha() {
    let aovs = AovFlags { coverage: true, ..AovFlags::NONE };
    for name in ["material/alpha_blend_stack", "demo/whitted_1980", "light/point"] {
        let job = scene_job(name);
        let settings = RenderSettings { aovs, show_background: false, ..settings(&job, (32, 18), 4) };
        let film = film(&job, 0.0, &settings);
        for (pixel, shares) in film.pixels.iter().zip(film.aovs.coverage.unwrap()) {
            // Nearly covered samples count as covered: at most 1/1024 is dropped.
            let sum: f32 = shares.iter().map(|&(_, share)| share).sum();
            assert!((sum - pixel[3]).abs() < 1.1 / 1024.0, "{name}: {shares:?} are not {pixel:?}");
        }
    }
}

/// Settings with samples beyond the tile, negative filter weights, a lens and rough mirrors.
fn complex_settings(job: &SequenceJob) -> RenderSettings {
    RenderSettings {
        adaptive: Some(Adaptive { max_samples: 6, threshold: 0.05 }),
        filter: PixelFilter::Mitchell,
        lens: Some(Lens { aperture: Aperture::Radius(0.02), focus: Focus::Center }),
        glossy_samples: 2,
        aovs: ALL,
        ..settings(job, (50, 40), 3)
    }
}

#[test]
fn crops_and_threads_do_not_change_aovs() {
    for (name, time_seconds) in [("demo/whitted_1980", 0.2), ("material/alpha_blend_stack", 0.0)] {
        let job = scene_job(name);
        let whole = film(&job, time_seconds, &complex_settings(&job));
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(
                pool.install(|| film(&job, time_seconds, &complex_settings(&job))) == whole,
                "{name}: {threads}"
            );
        }

        let window = PixelWindow { x0: 13, y0: 30, x1: 37, y1: 39 };
        let crop = film(&job, time_seconds, &RenderSettings { window, ..complex_settings(&job) });
        let mut part = Film::with_aovs(whole.resolution, window, ALL);
        for y in window.y0..window.y1 {
            for x in window.x0..window.x1 {
                let from = (y * 50 + x) as usize;
                let to = ((y - window.y0) * window.width() + x - window.x0) as usize;
                part.pixels[to] = whole.pixels[from];
                let (all, part) = (&whole.aovs, &mut part.aovs);
                part.light.as_mut().unwrap()[to] = all.light.as_ref().unwrap()[from];
                part.centers.as_mut().unwrap()[to] = all.centers.as_ref().unwrap()[from];
                part.coverage.as_mut().unwrap()[to] = all.coverage.as_ref().unwrap()[from].clone();
            }
        }
        assert!(crop == part, "{name}: a crop is not the same part of the whole");
    }
}

#[test]
fn light_passes_with_complex_settings_sum_to_the_colour_where_nothing_is_clamped() {
    let job = scene_job("demo/whitted_1980");
    let film = film(&job, 0.2, &complex_settings(&job));
    let mut compared = 0;
    for (pixel, parts) in film.pixels.iter().zip(film.aovs.light.unwrap()) {
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
